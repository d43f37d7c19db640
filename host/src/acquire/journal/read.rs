//! Reading a journal, and cutting off a line that was not finished.

use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;

use super::record::{self, Chain, Header, Stored, StoredCalibration};
use super::{Journal, JournalError, MAX_BYTES, io_error};
use crate::acquire::draft::Draft;
use crate::acquire::schedule::Schedule;
use crate::input::read_all;
use crate::message::excerpt;

/// Reads it all.
pub(super) fn read(path: &Path, file: File) -> Result<Journal, JournalError> {
    let failed = |source| io_error(path, "cannot be read", source);
    let damaged = |line: usize, good: usize, what: &str| JournalError::Damaged {
        path: path.to_owned(),
        line,
        what: what.to_owned(),
        good,
    };
    let bytes = read_all(&file, MAX_BYTES).map_err(|e| match e.kind() {
        ErrorKind::FileTooLarge => damaged(1, 0, "is larger than 256 MiB, no journal is"),
        _ => failed(e),
    })?;
    let mut lines = Lines::new(&bytes);
    let (header, chain) = lines
        .next()
        .ok()
        .flatten()
        .and_then(|text| record::read_header(text, lines.chain))
        .ok_or_else(|| damaged(1, 0, "is no journal of this or a former version of asperity"))?;
    lines.chain = chain;
    let mut schedule = String::new();
    let mut record = None;
    while let Some(text) = lines.next().map_err(|line| damaged(line, 0, BROKEN))? {
        let Some(line) = text.strip_prefix("plan ") else {
            record = Some(text);
            break;
        };
        schedule.push_str(line);
        schedule.push('\n');
    }
    let schedule = read_schedule(&schedule, &header, path)
        .ok_or_else(|| damaged(1, 0, "its schedule is none"))?;
    let points = vec![Vec::new(); schedule.sigmas().len()];
    let Header { model, serial, .. } = header;
    let (path, calibrations) = (path.to_owned(), Vec::new());
    let mut journal = Journal { path, file, chain, schedule, model, serial, calibrations, points };
    while let Some(text) = record {
        journal.take(text).map_err(|what| damaged(lines.count, lines.count - 1, &what))?;
        record = lines.next().map_err(|line| damaged(line, line - 1, BROKEN))?;
    }
    let whole = lines.whole;
    journal.chain = lines.chain;
    if whole < bytes.len() as u64 {
        journal.file.set_len(whole).and_then(|()| journal.file.sync_all()).map_err(failed)?;
    }
    Ok(journal)
}

const BROKEN: &str = "the checksum is wrong: the line is changed, or does not follow on the one before it (a line \
                      is lost, doubled, moved, or of another journal)";

/// The lines of a journal, one after another.
struct Lines<'a> {
    rest: &'a [u8],
    chain: Chain,
    /// Lines so far, and their length.
    count: usize,
    whole: u64,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, chain: Chain::NEW, count: 0, whole: 0 }
    }

    /// The next line; `None` at the end, and where the last one was not finished. Its number if it cannot be.
    fn next(&mut self) -> Result<Option<&'a str>, usize> {
        let Some(end) = self.rest.iter().position(|&byte| byte == b'\n') else { return Ok(None) };
        let (line, rest) = self.rest.split_at(end + 1);
        let text = self.chain.text(line.strip_suffix(b"\n").unwrap_or(line));
        let text = text.ok_or(self.count + 1)?;
        self.rest = rest;
        self.count += 1;
        self.whole += line.len() as u64;
        Ok(Some(text))
    }
}

fn read_schedule(text: &str, header: &Header, path: &Path) -> Option<Schedule> {
    let schedule = Draft::parse(text, path).ok()?.schedule().ok()?;
    (schedule.hash() == header.hash).then_some(schedule)
}

impl Journal {
    /// One record behind the header.
    fn take(&mut self, text: &str) -> Result<(), String> {
        let unknown = || format!("`{}` is no record", excerpt(text));
        let (kind, fields) = text.split_once(' ').ok_or_else(unknown)?;
        match kind {
            "calibration" => {
                let (number, stored) = record::read_calibration(fields).ok_or_else(unknown)?;
                self.take_calibration(number, stored)
            }
            "point" => {
                let (sigma, index, stored) = record::read_point(fields).ok_or_else(unknown)?;
                self.take_point(sigma, index, stored)
            }
            _ => Err(unknown()),
        }
    }

    fn take_calibration(&mut self, number: usize, stored: StoredCalibration) -> Result<(), String> {
        let expected = self.calibrations.len();
        if number != expected || stored.sigma >= self.points.len() {
            return Err(format!("calibration {number} where {expected} is expected"));
        }
        self.calibrations.push(stored);
        Ok(())
    }

    fn take_point(&mut self, sigma: usize, index: usize, stored: Stored) -> Result<(), String> {
        let expected = self.next().map(|(sigma, index)| (sigma, usize::from(index)));
        let calibrated = stored.calibration < self.calibrations.len();
        if expected != Some((sigma, index)) || !calibrated || stored.reading.over {
            let twice = self.points(sigma).len() > index;
            let why = if twice { "is there twice" } else { "does not follow on those before" };
            return Err(format!("point {index} of incidence {sigma} {why}"));
        }
        self.points.get_mut(sigma).ok_or("no such incidence")?.push(stored);
        Ok(())
    }
}
