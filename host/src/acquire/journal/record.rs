//! The lines of a journal.

use std::fmt::Write;

use asperity_core::protocol::{Calibration, Microdegrees, RANGES, Reading, checksum};

/// First words of a journal: its format and the version of it.
const MAGIC: &str = "asperity-journal 1";

/// Whose journal it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) serial: u32,
    /// Of the plan's text.
    pub(super) hash: u32,
    pub(super) model: String,
}

/// A calibration, and when it was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredCalibration {
    /// Before the first new point of this incidence, counted from 0.
    pub sigma: usize,
    /// What was found.
    pub values: Calibration,
}

/// A point of an incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    /// Where the detector was by its encoder.
    pub theta: Microdegrees,
    /// What it read, nA.
    pub reading: Reading,
    /// Which calibration was in force, counted from 0.
    pub calibration: usize,
}

/// A line with its checksum.
fn line(text: &str) -> String {
    format!("{text} ~{:08x}\n", checksum(text.as_bytes()))
}

/// The text of a line without its line break, if its checksum is right.
pub(super) fn text(line: &[u8]) -> Option<&str> {
    let line = str::from_utf8(line).ok()?;
    let (text, sum) = line.rsplit_once(" ~")?;
    (sum == format!("{:08x}", checksum(text.as_bytes()))).then_some(text)
}

/// The lines that a journal begins with.
pub(super) fn header(header: &Header, plan: &str) -> String {
    let first = format!("{MAGIC} {} {:08x} {}", header.serial, header.hash, header.model);
    let plan = plan.lines().map(|text| line(&format!("plan {text}")));
    std::iter::once(line(&first)).chain(plan).collect()
}

/// The first line.
pub(super) fn read_header(text: &str) -> Option<Header> {
    let mut fields = text.strip_prefix(MAGIC)?.strip_prefix(' ')?.splitn(3, ' ');
    let (serial, hash) = (fields.next()?.parse().ok()?, hex(fields.next()?)?);
    Some(Header { serial, hash, model: fields.next()?.to_owned() })
}

pub(super) fn calibration(number: usize, stored: &StoredCalibration) -> String {
    let values = &stored.values;
    let mut text = format!(
        "calibration {number} {} {:08x} {} {:08x}",
        stored.sigma,
        values.id,
        values.range,
        values.reference.to_bits()
    );
    for dark in values.dark {
        // writing to a string cannot fail
        let _ = write!(text, " {:08x}", dark.to_bits());
    }
    line(&text)
}

/// The fields behind `calibration`: its number, and it.
pub(super) fn read_calibration(text: &str) -> Option<(usize, StoredCalibration)> {
    let mut fields = text.split(' ');
    let mut next = || fields.next();
    let (number, sigma) = (next()?.parse().ok()?, next()?.parse().ok()?);
    let (id, range) = (hex(next()?)?, range(next()?)?);
    let reference = current(next()?)?;
    let mut dark = [0.0; RANGES as usize];
    for slot in &mut dark {
        *slot = current(next()?)?;
    }
    let values = Calibration { id, dark, reference, range };
    next().is_none().then_some((number, StoredCalibration { sigma, values }))
}

pub(super) fn point(sigma: usize, index: usize, stored: &Stored) -> String {
    let Stored { theta, reading, calibration } = stored;
    line(&format!(
        "point {sigma} {index} {} {:08x} {:08x} {} {} {calibration}",
        theta.0,
        reading.signal.to_bits(),
        reading.dark.to_bits(),
        reading.range,
        u8::from(reading.over) + 2 * u8::from(reading.under),
    ))
}

/// The fields behind `point`: incidence, index, and it.
pub(super) fn read_point(text: &str) -> Option<(usize, usize, Stored)> {
    let mut fields = text.split(' ');
    let mut next = || fields.next();
    let (sigma, index) = (next()?.parse().ok()?, next()?.parse().ok()?);
    let theta = Microdegrees(next()?.parse().ok()?);
    let (signal, dark) = (current(next()?)?, current(next()?)?);
    let range = range(next()?)?;
    let flags = next()?.parse::<u8>().ok().filter(|flags| *flags < 4)?;
    let calibration = next()?.parse().ok()?;
    let reading = Reading { signal, dark, range, over: flags & 1 != 0, under: flags & 2 != 0 };
    next().is_none().then_some((sigma, index, Stored { theta, reading, calibration }))
}

fn hex(field: &str) -> Option<u32> {
    (field.len() == 8).then(|| u32::from_str_radix(field, 16).ok()).flatten()
}

/// A finite current.
fn current(field: &str) -> Option<f32> {
    hex(field).map(f32::from_bits).filter(|value| value.is_finite())
}

fn range(field: &str) -> Option<u8> {
    field.parse().ok().filter(|range| *range < RANGES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_survive_their_lines() {
        let reading = Reading { signal: 0.1, dark: -1e-9, range: 5, over: false, under: true };
        let stored = Stored { theta: Microdegrees(-89_900_000), reading, calibration: 3 };
        let written = point(2, 17, &stored);
        let text = text(written.trim_end().as_bytes()).unwrap();
        assert_eq!(read_point(text.strip_prefix("point ").unwrap()), Some((2, 17, stored)));
        let values = Calibration { id: 7, dark: [0.5; 6], reference: 900.0, range: 0 };
        let stored = StoredCalibration { sigma: 1, values };
        let written = calibration(4, &stored);
        let text = super::text(written.trim_end().as_bytes()).unwrap();
        assert_eq!(read_calibration(text.strip_prefix("calibration ").unwrap()), Some((4, stored)));
        let model = "GP-200 \"A\" 7".to_owned();
        let head = Header { serial: 9, hash: 1, model };
        let lines = header(&head, "a = 1\nb = \" ~\"\n");
        let lines: Vec<&str> =
            lines.lines().map(|line| super::text(line.as_bytes()).unwrap()).collect();
        assert_eq!(read_header(lines[0]), Some(head));
        assert_eq!(lines[1..], ["plan a = 1", "plan b = \" ~\""]);
    }

    #[test]
    fn a_changed_line_is_no_line() {
        let reading = Reading { signal: 0.1, dark: 0.0, range: 5, over: false, under: false };
        let stored = Stored { theta: Microdegrees(0), reading, calibration: 0 };
        let line = point(0, 0, &stored).trim_end().to_owned().into_bytes();
        for k in 0..line.len() {
            assert_eq!(text(&line[..k]), None);
            let mut changed = line.clone();
            changed[k] ^= 1;
            assert_eq!(text(&changed), None, "byte {k}");
        }
    }
}
