//! Temporary files and folders; none is left, however the program ends.
//!
//! Dropped values remove their files; a program that is ended by a signal calls [`remove_all`] first. What a program leaves that had no time for
//! that (SIGKILL, a power cut) the next one [`sweep`]s: a file in use is locked, one that is left is not.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tempfile::{Builder, NamedTempFile, PersistError};

static REGISTRY: Mutex<Registry> = Mutex::new(Registry::new());

#[derive(Debug)]
struct Registry {
    /// Whether the program is about to end.
    closed: bool,
    files: Vec<PathBuf>,
    /// Folders that were made, the outer one first.
    folders: Vec<PathBuf>,
}

impl Registry {
    const fn new() -> Self {
        Self { closed: false, files: Vec::new(), folders: Vec::new() }
    }
}

fn registry() -> MutexGuard<'static, Registry> {
    REGISTRY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files and the empty folders that were made, and allows no new ones. It waits for renames in
/// progress, so that files of one commit appear together.
#[cfg(feature = "cli")]
pub(crate) fn remove_all() {
    let mut registry = registry();
    registry.closed = true;
    for file in registry.files.drain(..) {
        let _ = std::fs::remove_file(file);
    }
    for folder in registry.folders.drain(..).rev() {
        let _ = std::fs::remove_dir(folder);
    }
}

/// A file without a lock may be one that was made a moment ago.
const LEFT: Duration = Duration::from_mins(1);

/// Removes the temporary files of names that start and end like this, which programs left that were killed.
pub(crate) fn sweep(folder: &Path, start: &OsStr, end: &str) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let start = start.as_encoded_bytes();
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_ours = name
            .as_encoded_bytes()
            .strip_prefix(start)
            .and_then(|rest| rest.strip_suffix(end.as_bytes()))
            .is_some_and(|middle| {
                !middle.is_empty() && middle.iter().all(u8::is_ascii_alphanumeric)
            });
        if is_ours && is_left(&entry.path()) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Whether nobody works on a file any more.
fn is_left(path: &Path) -> bool {
    let Ok(file) = File::options().write(true).open(path) else { return false };
    let age = file.metadata().and_then(|about| about.modified()).map(|at| at.elapsed());
    matches!(age, Ok(Ok(age)) if age > LEFT) && file.try_lock().is_ok()
}

fn ending() -> io::Error {
    io::Error::new(ErrorKind::Interrupted, "the program is being ended")
}

/// A temporary file.
#[derive(Debug)]
pub(crate) struct Scratch {
    /// `None` once it is renamed.
    file: Option<NamedTempFile>,
}

impl Scratch {
    /// A new file in a folder.
    ///
    /// # Errors
    /// Those of the system.
    pub(crate) fn create(builder: &Builder<'_, '_>, folder: &Path) -> io::Result<Self> {
        let mut registry = registry();
        if registry.closed {
            return Err(ending());
        }
        let file = builder.tempfile_in(folder)?;
        // where a file system has no locks, what is left of a killed program stays
        let _ = file.as_file().try_lock();
        registry.files.push(file.path().to_owned());
        Ok(Self { file: Some(file) })
    }

    /// The open file.
    ///
    /// # Errors
    /// None; a file that is renamed is gone from here.
    pub(crate) fn as_file(&self) -> io::Result<&File> {
        self.file.as_ref().map(NamedTempFile::as_file).ok_or_else(ending)
    }

    /// Its temporary name.
    #[cfg(feature = "cli")]
    pub(crate) fn path(&self) -> &Path {
        self.file.as_ref().map_or(Path::new(""), NamedTempFile::path)
    }

    /// Renames it, in place of nothing.
    ///
    /// # Errors
    /// Those of the system; [`ErrorKind::AlreadyExists`].
    pub(crate) fn persist_noclobber(self, target: &Path) -> io::Result<File> {
        self.renamed(&mut registry(), |file| file.persist_noclobber(target))
    }

    fn renamed(
        mut self,
        registry: &mut Registry,
        rename: impl FnOnce(NamedTempFile) -> Result<File, PersistError>,
    ) -> io::Result<File> {
        let Some(file) = self.file.take().filter(|_| !registry.closed) else {
            return Err(ending());
        };
        let path = file.path().to_owned();
        let renamed = rename(file).map_err(|failed| failed.error);
        registry.files.retain(|known| *known != path);
        renamed
    }
}

/// Renames files one after the other, in place of older ones; a signal does not come between.
///
/// # Errors
/// The number of the first that cannot be renamed, and why; those after it are removed.
pub(crate) fn persist_all(files: Vec<(Scratch, PathBuf)>) -> Result<(), (usize, io::Error)> {
    let mut registry = registry();
    let mut files = files.into_iter().enumerate();
    let failed = files.find_map(|(k, (file, target))| {
        file.renamed(&mut registry, |file| file.persist(target)).err().map(|e| (k, e))
    });
    // the lock is needed to remove the others
    drop(registry);
    failed.map_or(Ok(()), Err)
}

impl Write for Scratch {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.as_file()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.as_file()?.flush()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            let mut registry = registry();
            registry.files.retain(|known| known != file.path());
            drop(file);
        }
    }
}

/// Folders that were made for results; those that are still empty are removed when this is dropped.
#[derive(Debug)]
pub(crate) struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    /// Makes a folder, and those above it that are missing.
    ///
    /// # Errors
    /// Those of the system; nothing is left then.
    pub(crate) fn create(folder: &Path) -> io::Result<Self> {
        let mut missing: Vec<&Path> =
            folder.ancestors().take_while(|f| !f.as_os_str().is_empty() && !f.exists()).collect();
        missing.reverse();
        let mut made = Self(Vec::new());
        for folder in missing {
            let mut registry = registry();
            if registry.closed {
                return Err(ending());
            }
            match std::fs::create_dir(folder) {
                Ok(()) => {
                    registry.folders.push(folder.to_owned());
                    made.0.push(folder.to_owned());
                }
                // `a/..` of a missing `a`, or another program was faster
                Err(_) if folder.is_dir() => {}
                Err(e) => {
                    drop(registry);
                    return Err(e);
                }
            }
        }
        if folder.is_dir() { Ok(made) } else { Err(ErrorKind::NotADirectory.into()) }
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        let mut registry = registry();
        for folder in self.0.drain(..).rev() {
            registry.folders.retain(|known| *known != folder);
            let _ = std::fs::remove_dir(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_that_stay_empty_are_removed() {
        let root = tempfile::tempdir().unwrap();
        let deep = root.path().join("a/b/c");
        drop(MadeFolders::create(&deep).unwrap());
        assert!(!root.path().join("a").exists());
        let made = MadeFolders::create(&deep).unwrap();
        std::fs::write(root.path().join("a/result"), "").unwrap();
        drop(made);
        assert!(root.path().join("a/result").exists() && !root.path().join("a/b").exists());
        assert!(MadeFolders::create(&root.path().join("a/result")).is_err());
        assert!(MadeFolders::create(&root.path().join("a/result/b")).is_err());
        // what was there before stays
        drop(MadeFolders::create(&root.path().join("a")).unwrap());
        assert!(root.path().join("a").exists());
    }

    #[test]
    fn what_a_killed_program_left_is_swept_and_nothing_else() {
        let root = tempfile::tempdir().unwrap();
        let long_ago = std::time::SystemTime::now() - 2 * LEFT;
        let made = |name: &str, modified| {
            let file = File::create(root.path().join(name)).unwrap();
            file.set_modified(modified).unwrap();
            file
        };
        for name in [".fit.json.a1B2c3.part", ".fit.json.x.y.part", ".fit.json..part", "fit.json"] {
            made(name, long_ago);
        }
        made(".fit.json.young1.part", std::time::SystemTime::now());
        let in_use = made(".fit.json.inuse1.part", long_ago);
        in_use.try_lock().unwrap();
        sweep(root.path(), OsStr::new(".fit.json."), ".part");
        let mut names: Vec<_> = std::fs::read_dir(root.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        let left = [
            ".fit.json..part",
            ".fit.json.inuse1.part",
            ".fit.json.x.y.part",
            ".fit.json.young1.part",
            "fit.json",
        ];
        assert_eq!(names, left);
    }

    #[test]
    fn files_are_removed_or_renamed_together() {
        let root = tempfile::tempdir().unwrap();
        let scratch = || Scratch::create(&Builder::new(), root.path()).unwrap();
        let names = || std::fs::read_dir(root.path()).unwrap().count();
        drop(scratch());
        assert_eq!(names(), 0);
        let [x, y] = ["x", "y"].map(|name| root.path().join(name));
        persist_all(vec![(scratch(), x.clone()), (scratch(), y.clone())]).unwrap();
        assert!(x.exists() && y.exists() && names() == 2);
        assert!(scratch().persist_noclobber(&x).is_err());
        let (k, _) = persist_all(vec![
            (scratch(), x.clone()),
            (scratch(), root.path().join("no/y")),
            (scratch(), y),
        ])
        .unwrap_err();
        assert_eq!((k, names()), (1, 2));
    }
}
