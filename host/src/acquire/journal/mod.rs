//! The journal: the next points are requested only after the previous ones are on disk.
//!
//! A text file beside the scan file, one record per line, each with a CRC-32C of the checksum of the line
//! before it (8 hexadecimal digits; none in the first line) and its text:
//!
//! ```text
//! asperity-journal 2 <serial> <hash of the schedule> <number drawn for this journal> <model> ~<crc>
//! plan <one line of the schedule file> ~<crc>
//! calibration <number> <incidence> <id> <range> <reference> <six dark currents> ~<crc>
//! point <incidence> <index> <theta> <signal> <dark> <range> <flags> <calibration> ~<crc>
//! ```
//! Currents are the bits of their `f32`, hexadecimal; `theta` is microdegrees by the encoder. The file is created
//! complete with its header. Points are appended in order and synchronised with the disk before the instrument may
//! discard them. An incomplete last line is cut off on opening; any other fault is an error that names the line.
//! Journals of version 1, where a checksum is of its own line alone
//! and no number is drawn, are read and continued in their version.

mod record;
mod read;

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

use asperity_core::protocol::{Calibration, Ident};

use self::record::{Chain, Header};
pub use self::record::{Stored, StoredCalibration};
use super::schedule::Schedule;
use crate::output::folder_of;
use crate::scratch::Scratch;

/// Largest journal, bytes: a thousand incidences of 1801 points have 150 MB.
const MAX_BYTES: u64 = 256 << 20;

/// Trouble with a journal: the file, the line, and what to do.
#[derive(Debug, Error)]
pub enum JournalError {
    /// There is one already.
    #[error(
        "{}: an acquisition was begun and not finished; go on with --resume, or delete this file to \
         begin anew", path.display()
    )]
    Exists {
        /// The journal.
        path: PathBuf,
    },
    /// There is none.
    #[error("{}: there is no such journal, so there is nothing to resume; leave --resume out", path.display())]
    Missing {
        /// The journal.
        path: PathBuf,
    },
    /// Another program has it open.
    #[error("{}: another acquisition is writing it; wait for that one or end it", path.display())]
    Locked {
        /// The journal.
        path: PathBuf,
    },
    /// A line that cannot be.
    #[error(
        "{}:{line}: {what}; the journal is damaged: {}, or restore a copy", path.display(), remedy(*.good)
    )]
    Damaged {
        /// The journal.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The fault.
        what: String,
        /// Number of good lines at its beginning, enough to continue with; 0 if there are none.
        good: usize,
    },
    /// A folder, a pipe or a device.
    #[error("{}: is no file; choose another name for the scan", path.display())]
    NoFile {
        /// The journal.
        path: PathBuf,
    },
    /// The operating system refuses.
    #[error("{}: {what}: {source}; check the free space and the permissions", path.display())]
    Io {
        /// The journal.
        path: PathBuf,
        /// The attempt.
        what: &'static str,
        /// The operating system's answer.
        source: io::Error,
    },
}

fn remedy(good: usize) -> String {
    match good {
        0 => "delete it and measure again".to_owned(),
        good => format!(
            "keep its first {good} lines (`head -n {good}`), and --resume measures the rest again"
        ),
    }
}

/// An open journal, locked against other programs, with its content.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    chain: Chain,
    schedule: Schedule,
    model: String,
    serial: u32,
    calibrations: Vec<StoredCalibration>,
    /// Points of each incidence, complete from index 0.
    points: Vec<Vec<Stored>>,
}

impl Journal {
    /// Where the journal of a scan file is: `OUT.journal`.
    pub fn path_of(output: &Path) -> PathBuf {
        let mut name = OsString::from(output);
        name.push(".journal");
        PathBuf::from(name)
    }

    /// A new journal, on disk with its header.
    ///
    /// # Errors
    /// [`JournalError::Exists`], [`JournalError::Io`].
    pub fn create(path: PathBuf, schedule: &Schedule, ident: &Ident) -> Result<Self, JournalError> {
        let failed = |source| io_error(&path, "cannot be created", source);
        let folder = folder_of(&path);
        let mut builder = tempfile::Builder::new();
        builder.prefix(".journal.").suffix(".part").append(true);
        // those of an ordinary new file
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let mut file = Scratch::create(&builder, folder).map_err(failed)?;
        let model = ident.model.as_str().to_owned();
        let (serial, hash, nonce) = (ident.serial, schedule.hash(), Some(draw()));
        let header = Header { serial, hash, nonce, model: model.clone() };
        let mut chain = Chain::NEW;
        let lines = record::header(&mut chain, &header, &schedule.text());
        file.write_all(lines.as_bytes()).map_err(failed)?;
        file.as_file().and_then(std::fs::File::sync_all).map_err(failed)?;
        lock(file.as_file().map_err(failed)?, &path)?;
        let file = file.persist_noclobber(&path).map_err(|e| match e.kind() {
            io::ErrorKind::AlreadyExists => JournalError::Exists { path: path.clone() },
            _ => failed(e),
        })?;
        // the name itself; not every file system can do this
        if let Ok(folder) = File::open(folder) {
            let _ = folder.sync_all();
        }
        let points = vec![Vec::new(); schedule.sigmas().len()];
        let (schedule, calibrations) = (schedule.clone(), Vec::new());
        Ok(Self { path, file, chain, schedule, model, serial, calibrations, points })
    }

    /// Opens the journal of an acquisition that was not finished; a torn last line is cut off.
    ///
    /// # Errors
    /// [`JournalError::Missing`], [`JournalError::NoFile`], [`JournalError::Locked`],
    /// [`JournalError::Damaged`], [`JournalError::Io`].
    pub fn open(path: PathBuf) -> Result<Self, JournalError> {
        // opening a pipe might wait for ever, reading it would
        if fs::metadata(&path).is_ok_and(|found| !found.is_file()) {
            return Err(JournalError::NoFile { path });
        }
        let opened = File::options().read(true).append(true).open(&path);
        let file = opened.map_err(|e| match e.kind() {
            io::ErrorKind::NotFound => JournalError::Missing { path: path.clone() },
            _ => io_error(&path, "cannot be opened", e),
        })?;
        lock(&file, &path)?;
        if !path.exists() {
            // whoever had the lock has just finished
            return Err(JournalError::Missing { path });
        }
        read::read(&path, file)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The schedule that is measured.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// Model and serial number of the instrument.
    pub fn instrument(&self) -> (&str, u32) {
        (&self.model, self.serial)
    }

    /// The calibrations in the order in which they were made.
    pub fn calibrations(&self) -> &[StoredCalibration] {
        &self.calibrations
    }

    /// The points of an incidence, complete from index 0.
    pub fn points(&self, sigma: usize) -> &[Stored] {
        self.points.get(sigma).map_or(&[], Vec::as_slice)
    }

    /// The number of points.
    pub fn len(&self) -> u64 {
        self.points.iter().map(|points| points.len() as u64).sum()
    }

    /// Whether there is no point yet.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether every point of the schedule is there.
    pub fn is_complete(&self) -> bool {
        self.len() == self.schedule.points()
    }

    /// The first incidence with a missing point, and that point.
    pub fn next(&self) -> Option<(usize, u16)> {
        let short = |points: &Vec<Stored>| points.len() < usize::from(self.schedule.count());
        let sigma = self.points.iter().position(short)?;
        Some((sigma, self.points(sigma).len() as u16))
    }

    /// Adds a calibration, made before that incidence; it is on disk afterwards.
    ///
    /// # Errors
    /// [`JournalError::Io`].
    pub fn add_calibration(
        &mut self,
        sigma: usize,
        values: Calibration,
    ) -> Result<(), JournalError> {
        let stored = StoredCalibration { sigma, values };
        let mut chain = self.chain;
        let line = record::calibration(&mut chain, self.calibrations.len(), &stored);
        self.append(&line, chain)?;
        self.calibrations.push(stored);
        Ok(())
    }

    /// Adds points that follow those of an incidence; they are on disk afterwards.
    ///
    /// # Errors
    /// [`JournalError::Io`].
    pub fn add_points(&mut self, sigma: usize, new: &[Stored]) -> Result<(), JournalError> {
        if new.is_empty() {
            return Ok(());
        }
        let first = self.points(sigma).len();
        let (mut chain, mut lines) = (self.chain, String::new());
        for (k, point) in new.iter().enumerate() {
            lines.push_str(&record::point(&mut chain, sigma, first + k, point));
        }
        self.append(&lines, chain)?;
        if let Some(points) = self.points.get_mut(sigma) {
            points.extend_from_slice(new);
        }
        Ok(())
    }

    /// Deletes the file: the scan is written.
    ///
    /// # Errors
    /// [`JournalError::Io`].
    pub fn delete(self) -> Result<(), JournalError> {
        fs::remove_file(&self.path).map_err(|e| io_error(&self.path, "cannot be deleted", e))
    }

    /// Writes lines; `chain` is where they lead to.
    fn append(&mut self, lines: &str, chain: Chain) -> Result<(), JournalError> {
        let done = self.file.write_all(lines.as_bytes()).and_then(|()| self.file.sync_data());
        done.map_err(|e| io_error(&self.path, "cannot be written", e))?;
        self.chain = chain;
        Ok(())
    }
}

/// A number that no other journal has, from the keys that the operating system draws for hash tables.
fn draw() -> u64 {
    RandomState::new().hash_one(std::process::id())
}

fn io_error(path: &Path, what: &'static str, source: io::Error) -> JournalError {
    JournalError::Io { path: path.to_owned(), what, source }
}

/// Tries for a second: a program that has just ended, or is just starting another, releases the lock soon.
fn lock(file: &File, path: &Path) -> Result<(), JournalError> {
    const TRIES: u32 = 20;
    for k in 0..TRIES {
        match file.try_lock() {
            Ok(()) => return Ok(()),
            Err(TryLockError::WouldBlock) if k + 1 < TRIES => {
                std::thread::sleep(std::time::Duration::from_millis(50));
            }
            Err(TryLockError::WouldBlock) => break,
            Err(TryLockError::Error(source)) => {
                return Err(io_error(path, "cannot be locked", source));
            }
        }
    }
    Err(JournalError::Locked { path: path.to_owned() })
}
