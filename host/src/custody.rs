//! The files that a run reads and writes: no file is both, and none is written twice.
//!
//! Files are read through `input` and written through `output`, and both ask here: a verb cannot forget it. A file is
//! known by its canonical path and, on Unix, by device and inode, so that links of both kinds are resolved. This
//! suits only a program that does one thing and ends; it is off until [`watch`].

use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

static RUN: Mutex<Option<Custody>> = Mutex::new(None);

/// From here on every file that is read or written counts, including the targets of stdin, stdout and stderr.
#[cfg(feature = "cli")]
pub(crate) fn watch() {
    let mut custody = Custody::default();
    custody.add_standard();
    *run() = Some(custody);
    crate::input::ask_first(reads);
}

/// A file is about to be read.
///
/// # Errors
/// Of a file that this run is to write; names it as it was named there.
#[cfg(feature = "cli")]
fn reads(path: &Path) -> std::io::Result<()> {
    run().as_mut().map_or(Ok(()), |custody| custody.read(path)).map_err(|output| {
        let what = format!("it is to be written too, as {}", output.display());
        std::io::Error::new(std::io::ErrorKind::ResourceBusy, what)
    })
}

/// A file is about to be written.
///
/// # Errors
/// [`Conflict`].
pub(crate) fn writes(path: &Path) -> Result<Claim, Conflict> {
    let id = run().as_mut().map_or(Ok(0), |custody| custody.claim(path))?;
    Ok(Claim { id })
}

fn run() -> MutexGuard<'static, Option<Custody>> {
    RUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Why a file may not be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Conflict {
    /// It is an input, named so.
    Input(PathBuf),
    /// It is another output, named so.
    Output(PathBuf),
}

/// The right to write a file, given back when it is dropped.
#[derive(Debug)]
pub(crate) struct Claim {
    /// 0 if nothing watches.
    id: u64,
}

impl Claim {
    /// The file is written: it may be read from now on, and not be written again.
    pub(crate) fn keep(self) {
        if let Some(custody) = run().as_mut() {
            custody.keep(self.id);
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        if let Some(custody) = run().as_mut() {
            custody.outputs.retain(|output| output.id != self.id || output.state == State::Written);
        }
    }
}

/// The identity of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Identity {
    /// Canonical; of a file that is not there yet its canonical folder and its name. Empty if nameless.
    path: PathBuf,
    inode: Option<(u64, u64)>,
}

impl Identity {
    fn of(path: &Path) -> Self {
        if is_device(path) {
            // it takes what comes, from whom it comes
            return Self { path: PathBuf::new(), inode: None };
        }
        let path = destination(path);
        Self { inode: std::fs::metadata(&path).ok().as_ref().and_then(inode), path: folded(path) }
    }

    fn is(&self, other: &Self) -> bool {
        let named = !self.path.as_os_str().is_empty() && self.path == other.path;
        named || self.inode.is_some_and(|inode| other.inode == Some(inode))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Claimed,
    Written,
}

#[derive(Debug)]
struct Output {
    id: u64,
    file: Identity,
    named: PathBuf,
    state: State,
}

#[derive(Debug, Default)]
struct Custody {
    inputs: Vec<(Identity, PathBuf)>,
    outputs: Vec<Output>,
    last_id: u64,
}

impl Custody {
    #[cfg(any(feature = "cli", test))]
    fn read(&mut self, path: &Path) -> Result<(), PathBuf> {
        let file = Identity::of(path);
        let claimed = |o: &&Output| o.state == State::Claimed && o.file.is(&file);
        if let Some(output) = self.outputs.iter().find(claimed) {
            return Err(output.named.clone());
        }
        // a pipe or a device is nothing that could be overwritten
        if path.is_file() && !self.inputs.iter().any(|(known, _)| *known == file) {
            self.inputs.push((file, path.to_owned()));
        }
        Ok(())
    }

    fn claim(&mut self, path: &Path) -> Result<u64, Conflict> {
        let file = Identity::of(path);
        if let Some((_, named)) = self.inputs.iter().find(|(input, _)| input.is(&file)) {
            return Err(Conflict::Input(named.clone()));
        }
        if let Some(other) = self.outputs.iter().find(|o| o.file.is(&file)) {
            return Err(Conflict::Output(other.named.clone()));
        }
        Ok(self.add(file, path.to_owned(), State::Claimed))
    }

    fn add(&mut self, file: Identity, named: PathBuf, state: State) -> u64 {
        self.last_id += 1;
        self.outputs.push(Output { id: self.last_id, file, named, state });
        self.last_id
    }

    fn keep(&mut self, id: u64) {
        if let Some(output) = self.outputs.iter_mut().find(|o| o.id == id) {
            output.state = State::Written;
            // the name has another file now
            output.file.inode = None;
        }
    }

    /// Files that the shell has opened for the program.
    #[cfg(unix)]
    #[cfg(feature = "cli")]
    fn add_standard(&mut self) {
        use std::os::fd::AsFd;
        let nameless = |inode| Identity { path: PathBuf::new(), inode: Some(inode) };
        let of = |fd: std::os::fd::BorrowedFd<'_>| {
            let file = std::fs::File::from(fd.try_clone_to_owned().ok()?);
            file.metadata().ok().as_ref().and_then(inode)
        };
        if let Some(inode) = of(std::io::stdin().as_fd()) {
            self.inputs.push((nameless(inode), "stdin".into()));
        }
        let outputs =
            [("stdout", of(std::io::stdout().as_fd())), ("stderr", of(std::io::stderr().as_fd()))];
        for (name, inode) in outputs {
            if let Some(inode) = inode {
                self.add(nameless(inode), name.into(), State::Written);
            }
        }
    }

    #[cfg(not(unix))]
    fn add_standard(&mut self) {}
}

/// Whether this is a device, such as `/dev/null`.
#[cfg(unix)]
fn is_device(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let kind = std::fs::metadata(path).map(|found| found.file_type());
    kind.is_ok_and(|kind| kind.is_char_device() || kind.is_block_device())
}

#[cfg(not(unix))]
fn is_device(_: &Path) -> bool {
    false
}

/// Device and inode of an ordinary file.
#[cfg(unix)]
fn inode(found: &Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    found.is_file().then(|| (found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn inode(_: &Metadata) -> Option<(u64, u64)> {
    None
}

/// The name that is compared: where the system takes small and capital letters for the same, one of the two.
fn folded(path: PathBuf) -> PathBuf {
    if cfg!(any(windows, target_os = "macos")) {
        path.to_string_lossy().to_lowercase().into()
    } else {
        path
    }
}

/// Links that are followed one after the other at most.
const MOST_LINKS: usize = 40;

/// Where a file of this name is or would be: links are followed, also to what is not there yet.
pub(crate) fn destination(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        match std::fs::read_link(&path) {
            Ok(target) => path = folder_of(&path).join(target),
            Err(_) => break,
        }
    }
    if let Ok(path) = path.canonicalize() {
        return path;
    }
    match (folder_of(&path).canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path,
    }
}

/// The folder that a file is, or will be, in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_file_is_read_and_written_or_written_twice() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("scan.csv"), "1").unwrap();
        std::fs::create_dir(at("sub")).unwrap();
        let mut custody = Custody::default();
        custody.read(&at("scan.csv")).unwrap();
        for same in ["scan.csv", "./scan.csv", "sub/../scan.csv"] {
            assert_eq!(custody.claim(&at(same)), Err(Conflict::Input(at("scan.csv"))), "{same}");
        }
        let first = custody.claim(&at("new")).unwrap();
        for same in ["new", "./new", "sub/../new"] {
            assert_eq!(custody.claim(&at(same)), Err(Conflict::Output(at("new"))), "{same}");
        }
        assert_eq!(custody.read(&at("sub/../new")), Err(at("new")));
        custody.claim(&at("sub/new")).unwrap();
        // once written it may be read, as an input it may not be written again
        std::fs::write(at("new"), "2").unwrap();
        custody.keep(first);
        custody.read(&at("new")).unwrap();
        assert!(custody.claim(&at("new")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_seen_through() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("map"), "1").unwrap();
        std::fs::hard_link(at("map"), at("hard")).unwrap();
        symlink("map", at("soft")).unwrap();
        symlink("soft", at("softer")).unwrap();
        symlink("nowhere", at("dangling")).unwrap();
        symlink("round", at("round")).unwrap();
        for input in ["map", "hard", "soft"] {
            let mut custody = Custody::default();
            custody.read(&at(input)).unwrap();
            for output in ["map", "hard", "soft", "softer"] {
                assert!(custody.claim(&at(output)).is_err(), "{input} and {output}");
            }
            custody.claim(&at("nowhere")).unwrap();
            assert!(custody.claim(&at("dangling")).is_err());
            custody.claim(&at("round")).unwrap();
        }
        // devices take what comes
        let mut custody = Custody::default();
        custody.read(Path::new("/dev/null")).unwrap();
        custody.claim(Path::new("/dev/null")).unwrap();
        custody.claim(Path::new("/dev/null")).unwrap();
    }
}
