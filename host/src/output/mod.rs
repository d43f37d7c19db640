//! Output files that are complete or absent, and that never replace an input.
//!
//! A run of an hour must not end in "permission denied", leave half a file, or overwrite its input. An [`AtomicFile`]
//! is therefore opened before the work starts and renamed only when it is complete. Files that belong together are
//! renamed together ([`finish_all`]).

mod error;
pub mod internal;

pub use error::OutputError;

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Stdout, Write};
use std::path::{Path, PathBuf};

pub(crate) use crate::custody::folder_of;
use crate::custody::{self, Claim, Conflict, destination};
use crate::scratch::{MadeFolders, Scratch, persist_all, sweep};

/// A file under construction: written beside its destination under a temporary name.
///
/// [`commit`](AtomicFile::commit) renames it; without it, dropping leaves the destination as it was and no temporary
/// file. A destination that is not a regular file (a device, a named
/// pipe) is written in place; `-` and `/dev/stdout` are stdout. Writes are buffered.
///
/// ```
/// use std::io::Write;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("fit.json");
/// let mut file = asperity::output::AtomicFile::create(&path)?; // fails here, before the long run
/// file.write_all(b"{}")?;
/// assert!(!path.exists());
/// file.commit()?;
/// assert!(path.exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct AtomicFile {
    path: PathBuf,
    sink: Sink,
    claim: Claim,
}

#[derive(Debug)]
enum Sink {
    Temporary {
        file: BufWriter<Scratch>,
        target: PathBuf,
    },
    InPlace(BufWriter<File>),
    /// `None` once its reader has gone away, which is not a failure.
    Stdout(Option<BufWriter<Stdout>>),
}

impl AtomicFile {
    /// Opens a temporary file in the folder of `path`.
    ///
    /// A symbolic link is followed: its target is replaced, not the link.
    ///
    /// # Errors
    /// [`OutputError::Input`] and [`OutputError::Twice`] where the program's run has read the file or writes it
    /// already; [`OutputError::Folder`], [`OutputError::NoFolder`], [`OutputError::WriteProtected`] where the
    /// path cannot be a destination, [`OutputError::Create`] for any other refusal.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let path = path.as_ref().to_path_buf();
        let create = |source| OutputError::Create { path: path.clone(), source };
        let claim = || {
            let is_stdout = STDOUT.iter().any(|name| path == Path::new(name));
            let file = if is_stdout { Path::new(STDOUT[0]) } else { &path };
            custody::writes(file).map_err(|conflict| match conflict {
                Conflict::Input(input) => OutputError::Input { path: path.clone(), input },
                Conflict::Output(other) => OutputError::Twice { path: path.clone(), other },
            })
        };
        if STDOUT.iter().any(|name| path == Path::new(name)) {
            let claim = claim()?;
            return Ok(Self {
                path,
                sink: Sink::Stdout(Some(BufWriter::new(io::stdout()))),
                claim,
            });
        }
        let ends_as_folder = path.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
        let (Some(name), false) = (path.file_name(), ends_as_folder) else {
            return Err(OutputError::Folder { path });
        };
        if let Ok(existing) = fs::metadata(&path) {
            if existing.is_dir() {
                return Err(OutputError::Folder { path });
            }
            if existing.permissions().readonly() {
                return Err(OutputError::WriteProtected { path });
            }
            if !existing.is_file() {
                // a device takes what comes, a pipe has one writer
                let claim = claim()?;
                let file = File::options().write(true).open(&path).map_err(create)?;
                return Ok(Self { path, sink: Sink::InPlace(BufWriter::new(file)), claim });
            }
        }
        let claim = claim()?;
        let target = destination(&path);
        let folder = folder_of(&target);
        if !folder.is_dir() {
            return Err(OutputError::NoFolder { folder: folder.to_path_buf(), path });
        }
        let mut prefix = OsString::from(".");
        prefix.push(name);
        prefix.push(".");
        sweep(folder, &prefix, PART);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(PART);
        // The permissions of an ordinary new file; a temporary one would be private to its owner.
        #[cfg(unix)]
        let permissions: fs::Permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
        #[cfg(unix)]
        builder.permissions(permissions);
        let file = BufWriter::new(Scratch::create(&builder, folder).map_err(create)?);
        Ok(Self { path, sink: Sink::Temporary { file, target }, claim })
    }

    /// Writes all of the content and commits it.
    ///
    /// # Errors
    /// [`OutputError::Write`], or those of [`commit`](Self::commit); the target is then as it was.
    pub fn finish(self, content: &[u8]) -> Result<(), OutputError> {
        finish_all(vec![(self, content.to_vec())])
    }

    /// Adds to the content.
    ///
    /// # Errors
    /// [`OutputError::Write`].
    pub fn put(&mut self, content: &[u8]) -> Result<(), OutputError> {
        self.write_all(content).map_err(|source| self.failed(source))
    }

    /// The destination, as requested.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes everything to the disk and gives the file its name, replacing an older one.
    ///
    /// # Errors
    /// [`OutputError::Write`]; the destination is then as it was before.
    pub fn commit(self) -> Result<(), OutputError> {
        commit_all(vec![self])
    }

    /// Whether this is stdout.
    pub fn is_stdout(&self) -> bool {
        matches!(self.sink, Sink::Stdout(_))
    }

    /// Whether this is stdout without a reader.
    pub fn is_in_vain(&self) -> bool {
        matches!(self.sink, Sink::Stdout(None))
    }

    fn failed(&self, source: io::Error) -> OutputError {
        OutputError::Write { path: self.path.clone(), source }
    }

    /// Brings everything to the disk.
    fn complete(&mut self) -> io::Result<()> {
        self.flush()?;
        match &self.sink {
            Sink::Temporary { file, .. } => file.get_ref().as_file()?.sync_all(),
            Sink::InPlace(_) | Sink::Stdout(_) => Ok(()),
        }
    }
}

/// The end of temporary names.
const PART: &str = ".part";
/// Names of the standard output.
const STDOUT: [&str; 4] = ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.sink {
            Sink::Temporary { file, .. } => file.write(bytes),
            Sink::InPlace(file) => file.write(bytes),
            Sink::Stdout(file) => unless_gone(file, bytes.len(), |file| file.write(bytes)),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Temporary { file, .. } => file.flush(),
            Sink::InPlace(file) => file.flush(),
            Sink::Stdout(file) => unless_gone(file, (), Write::flush),
        }
    }
}

/// Writes to stdout; `done` if it has no reader.
fn unless_gone<T>(
    stdout: &mut Option<BufWriter<Stdout>>,
    done: T,
    write: impl FnOnce(&mut BufWriter<Stdout>) -> io::Result<T>,
) -> io::Result<T> {
    match stdout.as_mut().map(write) {
        Some(Err(e)) if e.kind() == ErrorKind::BrokenPipe => {
            if let Some(file) = stdout.take() {
                // what is in the buffer has no reader
                drop(file.into_parts());
            }
            Ok(done)
        }
        Some(result) => result,
        None => Ok(done),
    }
}

/// Writes the contents of files and commits them together.
///
/// # Errors
/// Those of [`commit_all`].
pub fn finish_all(files: Vec<(AtomicFile, Vec<u8>)>) -> Result<(), OutputError> {
    let write = |(mut file, content): (AtomicFile, Vec<u8>)| file.put(&content).map(|()| file);
    commit_all(files.into_iter().map(write).collect::<Result<_, _>>()?)
}

/// Writes everything of these files to the disk, and only when that is done gives them their names, replacing older ones.
///
/// # Errors
/// [`OutputError::Write`]; all destinations are then as they were before, unless a name itself cannot be given:
/// then those before it have theirs.
pub fn commit_all(mut files: Vec<AtomicFile>) -> Result<(), OutputError> {
    for file in &mut files {
        file.complete().map_err(|source| file.failed(source))?;
    }
    let (mut scratch, mut paths, mut claims) = (Vec::new(), Vec::new(), Vec::new());
    for AtomicFile { path, sink, claim } in files {
        if let Sink::Temporary { file, target } = sink {
            let file = file
                .into_inner()
                .map_err(|e| OutputError::Write { path: path.clone(), source: e.into_error() })?;
            scratch.push((file, target));
            paths.push(path);
            claims.push(claim);
        }
    }
    let folders: Vec<PathBuf> = scratch.iter().map(|(_, t)| folder_of(t).to_owned()).collect();
    persist_all(scratch)
        .map_err(|(k, source)| OutputError::Write { path: paths.swap_remove(k), source })?;
    claims.into_iter().for_each(Claim::keep);
    for (k, folder) in folders.iter().enumerate() {
        // The new name itself reaches the disk with its folder; not every file system can do this, and
        // the file is complete either way.
        if let (false, Ok(folder)) = (folders[..k].contains(folder), File::open(folder)) {
            let _ = folder.sync_all();
        }
    }
    Ok(())
}

/// Writes a whole text file at once, complete or not at all.
///
/// # Errors
/// Those of [`AtomicFile::create`] and [`AtomicFile::commit`].
pub fn write_text(path: impl AsRef<Path>, text: &str) -> Result<(), OutputError> {
    AtomicFile::create(path)?.finish(text.as_bytes())
}

/// Checks before the long work that all these can be written later, and that none is another output or an input.
///
/// # Errors
/// Those of [`AtomicFile::create`].
pub fn check_all(paths: impl IntoIterator<Item = PathBuf>) -> Result<(), OutputError> {
    // the claims are kept until the last one is checked, files are not: there may be thousands
    let claim = |path| AtomicFile::create(path).map(|file| file.claim);
    let claims = paths.into_iter().map(claim).collect::<Result<Vec<_>, _>>()?;
    drop(claims);
    Ok(())
}

/// A folder for results; if it was made for them and stays empty, it is removed again when this is dropped.
#[derive(Debug)]
pub struct ResultFolder(#[expect(dead_code, reason = "it is there to be dropped")] MadeFolders);

impl ResultFolder {
    /// Makes the folder, and those above it, where they are missing.
    ///
    /// # Errors
    /// [`OutputError::NotMade`].
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let not_made = |source| OutputError::NotMade { path: path.to_owned(), source };
        MadeFolders::create(path).map(Self).map_err(not_made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> Vec<String> {
        let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        names.map(|name| name.to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_committed_file_is_the_only_one_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scan.csv");
        fs::write(&path, "old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        file.flush().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        file.commit().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(entries(folder.path()), ["scan.csv"]);
    }

    #[test]
    fn a_dropped_file_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = AtomicFile::create(folder.path().join("scan.csv")).unwrap();
        file.write_all(&vec![0; 100_000]).unwrap();
        assert_eq!(entries(folder.path()).len(), 1);
        drop(file);
        assert!(entries(folder.path()).is_empty());
    }

    #[test]
    fn a_bad_destination_is_refused_before_anything_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let message = |path: &Path| AtomicFile::create(path).unwrap_err().to_string();
        assert!(message(folder.path()).contains("add a file name"));
        assert!(message(&folder.path().join("new/")).contains("add a file name"));
        assert!(message(Path::new("")).contains("add a file name"));
        let nowhere = message(&folder.path().join("missing/scan.csv"));
        assert!(nowhere.contains("missing/scan.csv") && nowhere.contains("create it"), "{nowhere}");
        let protected = folder.path().join("protected.csv");
        fs::write(&protected, "").unwrap();
        let mut permissions = fs::metadata(&protected).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&protected, permissions).unwrap();
        assert!(message(&protected).contains("write-protected"));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_devices_kept_and_permissions_ordinary() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real.csv"), folder.path().join("link.csv"));
        write_text(&real, "1").unwrap();
        fs::write(folder.path().join("plain"), "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&real), mode(&folder.path().join("plain")));
        std::os::unix::fs::symlink(&real, &link).unwrap();
        write_text(&link, "2").unwrap();
        assert_eq!(fs::read_to_string(&real).unwrap(), "2");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        write_text("/dev/null", "3").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
