//! Reading a journal, and cutting off a line that was not finished.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::record::{self, Header, Stored, StoredCalibration};
use super::{Journal, JournalError, MAX_BYTES, io_error};
use crate::acquire::draft::Draft;
use crate::acquire::plan::Plan;
use crate::measurement::excerpt;

/// Reads it all.
pub(super) fn read(path: &Path, mut file: File) -> Result<Journal, JournalError> {
    let failed = |source| io_error(path, "cannot be read", source);
    let damaged = |line, what: &str| JournalError::Damaged {
        path: path.to_owned(),
        line,
        what: what.to_owned(),
    };
    let length = file.metadata().map_err(failed)?.len();
    if length > MAX_BYTES {
        return Err(damaged(1, "is larger than 256 MiB, no journal is"));
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(failed)?;
    let (lines, whole) = lines(&bytes).map_err(|line| damaged(line, "the checksum is wrong"))?;
    if whole < bytes.len() as u64 {
        file.set_len(whole).and_then(|()| file.sync_all()).map_err(failed)?;
    }
    let mut rest = lines.iter().copied().zip(1..).peekable();
    let header = rest.next().and_then(|(text, _)| record::read_header(text));
    let header = header.ok_or_else(|| damaged(1, "is no journal of this version of asperity"))?;
    let mut plan = String::new();
    while let Some((text, _)) = rest.next_if(|(text, _)| text.starts_with("plan ")) {
        plan.push_str(text.strip_prefix("plan ").unwrap_or(""));
        plan.push('\n');
    }
    let plan = read_plan(&plan, &header, path).ok_or_else(|| damaged(1, "its plan is none"))?;
    let points = vec![Vec::new(); plan.sigmas().len()];
    let Header { model, serial, .. } = header;
    let calibrations = Vec::new();
    let mut journal =
        Journal { path: path.to_owned(), file, plan, model, serial, calibrations, points };
    for (text, line) in rest {
        journal.take(text).map_err(|what| damaged(line, &what))?;
    }
    Ok(journal)
}

/// The lines and the length of them; the number of a line that cannot be, other than the last.
fn lines(bytes: &[u8]) -> Result<(Vec<&str>, u64), usize> {
    let (mut lines, mut whole) = (Vec::new(), 0);
    let mut rest = bytes.split_inclusive(|&byte| byte == b'\n').peekable();
    while let Some(line) = rest.next() {
        match line.strip_suffix(b"\n").and_then(record::text) {
            Some(text) => {
                lines.push(text);
                whole += line.len() as u64;
            }
            None if rest.peek().is_none() => break,
            None => return Err(lines.len() + 1),
        }
    }
    Ok((lines, whole))
}

fn read_plan(text: &str, header: &Header, path: &Path) -> Option<Plan> {
    let plan = Draft::parse(text, path).ok()?.plan().ok()?;
    (plan.hash() == header.hash).then_some(plan)
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
