//! Output files that exist complete or not at all.
//!
//! A run of an hour must not end in "permission denied", nor leave half a file behind: an
//! [`AtomicFile`] is opened before the work starts, and takes its name only when it is complete.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;
use thiserror::Error;

/// Why an output file could not be opened or completed. Each names the path and the remedy.
#[derive(Debug, Error)]
pub enum OutputError {
    /// The path is a folder, or ends in `/` or `..`.
    #[error("{}: is a folder, not a file; add a file name", path.display())]
    Folder {
        /// The path asked for.
        path: PathBuf,
    },
    /// The folder that should hold the file is missing.
    #[error("{}: there is no folder {}; create it or choose another place", path.display(), folder.display())]
    NoFolder {
        /// The path asked for.
        path: PathBuf,
        /// The missing folder.
        folder: PathBuf,
    },
    /// The file exists and is write-protected.
    #[error("{}: exists and is write-protected; choose another name or lift the protection", path.display())]
    WriteProtected {
        /// The path asked for.
        path: PathBuf,
    },
    /// The operating system refuses to create the file.
    #[error("{}: cannot be created: {source}; check the permissions of the folder", path.display())]
    Create {
        /// The path asked for.
        path: PathBuf,
        /// The operating system's answer.
        source: io::Error,
    },
    /// The content could not be written, or the finished file not renamed.
    #[error("{}: cannot be written: {source}; check the free space and the permissions", path.display())]
    Write {
        /// The path asked for.
        path: PathBuf,
        /// The operating system's answer.
        source: io::Error,
    },
}

/// A file under construction: written beside its destination under a temporary name.
///
/// [`commit`](AtomicFile::commit) gives it its name; dropping it without leaves the destination as
/// it was and no temporary file. A destination that is not a regular file (`/dev/stdout`, a named
/// pipe) is written in place. Writes are buffered.
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
}

#[derive(Debug)]
enum Sink {
    Temporary { file: BufWriter<NamedTempFile>, target: PathBuf },
    InPlace(BufWriter<File>),
}

impl AtomicFile {
    /// Opens a temporary file in the folder of `path`.
    ///
    /// A symbolic link is followed: its target is replaced, not the link.
    ///
    /// # Errors
    /// [`OutputError::Folder`], [`OutputError::NoFolder`], [`OutputError::WriteProtected`] where the
    /// path cannot be a destination, [`OutputError::Create`] for any other refusal.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, OutputError> {
        let path = path.as_ref().to_path_buf();
        let create = |source| OutputError::Create { path: path.clone(), source };
        let ends_as_folder = path.as_os_str().to_string_lossy().ends_with(std::path::is_separator);
        let (Some(name), false) = (path.file_name(), ends_as_folder) else {
            return Err(OutputError::Folder { path });
        };
        let mut target = path.clone();
        if let Ok(existing) = fs::metadata(&path) {
            if existing.is_dir() {
                return Err(OutputError::Folder { path });
            }
            if existing.permissions().readonly() {
                return Err(OutputError::WriteProtected { path });
            }
            if !existing.is_file() {
                let file = File::options().write(true).open(&path).map_err(create)?;
                return Ok(Self { path, sink: Sink::InPlace(BufWriter::new(file)) });
            }
            target = fs::canonicalize(&path).map_err(create)?;
        }
        let folder = folder_of(&target);
        if !folder.is_dir() {
            return Err(OutputError::NoFolder { folder: folder.to_path_buf(), path });
        }
        let mut prefix = OsString::from(".");
        prefix.push(name);
        prefix.push(".");
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(".part");
        // The permissions of an ordinary new file; a temporary one would be private to its owner.
        #[cfg(unix)]
        let permissions: fs::Permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
        #[cfg(unix)]
        builder.permissions(permissions);
        let file = BufWriter::new(builder.tempfile_in(folder).map_err(create)?);
        Ok(Self { path, sink: Sink::Temporary { file, target } })
    }

    /// Writes all of the content and commits it.
    ///
    /// # Errors
    /// [`OutputError::Write`], or those of [`commit`](Self::commit); the target is then as it was.
    pub fn finish(mut self, content: &[u8]) -> Result<(), OutputError> {
        let path = self.path().to_owned();
        self.write_all(content).map_err(|source| OutputError::Write { path, source })?;
        self.commit()
    }

    /// The destination, as it was asked for.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes everything to the disk and gives the file its name, replacing an older one.
    ///
    /// # Errors
    /// [`OutputError::Write`]; the destination is then as it was before.
    pub fn commit(self) -> Result<(), OutputError> {
        let Self { path, sink } = self;
        let result = match sink {
            Sink::InPlace(mut file) => file.flush(),
            Sink::Temporary { file, target } => publish(file, &target),
        };
        result.map_err(|source| OutputError::Write { path, source })
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.sink {
            Sink::Temporary { file, .. } => file.write(bytes),
            Sink::InPlace(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            Sink::Temporary { file, .. } => file.flush(),
            Sink::InPlace(file) => file.flush(),
        }
    }
}

/// Writes a whole text file at once, complete or not at all.
///
/// # Errors
/// Those of [`AtomicFile::create`] and [`AtomicFile::commit`].
pub fn write_text(path: impl AsRef<Path>, text: &str) -> Result<(), OutputError> {
    let mut file = AtomicFile::create(path)?;
    file.write_all(text.as_bytes())
        .map_err(|source| OutputError::Write { path: file.path.clone(), source })?;
    file.commit()
}

/// The folder that a file is, or will be, in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn publish(file: BufWriter<NamedTempFile>, target: &Path) -> io::Result<()> {
    let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.as_file().sync_all()?;
    file.persist(target).map_err(|error| error.error)?;
    // The new name itself reaches the disk with its folder; not every file system can do this, and
    // the file is complete either way.
    if let Ok(folder) = File::open(folder_of(target)) {
        let _ = folder.sync_all();
    }
    Ok(())
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
