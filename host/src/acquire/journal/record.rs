//! The lines of a journal.

use std::fmt::Write;

use asperity_core::protocol::{Calibration, Microdegrees, RANGES, Reading, checksum};

/// First word of a journal; the version of its format follows.
const MAGIC: &str = "asperity-journal";

/// The chain of the lines of a journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Chain {
    /// Version 1: each line has a checksum of its own.
    Loose,
    /// Version 2: each line's checksum covers that of the line before too, so that a line that is lost,
    /// doubled, moved or of another journal is found. `None` before the first line.
    Linked(Option<u32>),
}

impl Chain {
    /// That of a new journal, before its first line.
    pub(super) const NEW: Self = Self::Linked(None);

    fn sum(self, text: &str) -> u32 {
        match self {
            Self::Loose | Self::Linked(None) => checksum(text.as_bytes()),
            Self::Linked(Some(before)) => checksum(format!("{before:08x}{text}").as_bytes()),
        }
    }

    fn pass(&mut self, sum: u32) {
        if let Self::Linked(before) = self {
            *before = Some(sum);
        }
    }

    /// A line with its checksum, and its break; the next one follows on it.
    pub(super) fn line(&mut self, text: &str) -> String {
        let sum = self.sum(text);
        self.pass(sum);
        format!("{text} ~{sum:08x}\n")
    }

    /// The text of a line without its line break, if its checksum is right; the next one follows on it.
    pub(super) fn text<'a>(&mut self, line: &'a [u8]) -> Option<&'a str> {
        let line = str::from_utf8(line).ok()?;
        let (text, sum) = line.rsplit_once(" ~")?;
        let right = self.sum(text);
        (sum == format!("{right:08x}")).then(|| {
            self.pass(right);
            text
        })
    }
}

/// Whose journal it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) serial: u32,
    /// Of the schedule's text.
    pub(super) hash: u32,
    /// Drawn for this journal; `None` in version 1.
    pub(super) nonce: Option<u64>,
    pub(super) model: String,
}

/// A calibration, and when it was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredCalibration {
    /// Before the first new point of this incidence, counted from 0.
    pub sigma: usize,
    /// Its values.
    pub values: Calibration,
}

/// A point of an incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    /// Where the detector was by its encoder.
    pub theta: Microdegrees,
    /// The reading, nA.
    pub reading: Reading,
    /// Which calibration was in force, counted from 0.
    pub calibration: usize,
}

/// The lines that a new journal begins with.
pub(super) fn header(chain: &mut Chain, header: &Header, schedule: &str) -> String {
    let Header { serial, hash, nonce, model } = header;
    let first = match nonce {
        Some(nonce) => format!("{MAGIC} 2 {serial} {hash:08x} {nonce:016x} {model}"),
        None => format!("{MAGIC} 1 {serial} {hash:08x} {model}"),
    };
    let mut text = chain.line(&first);
    for line in schedule.lines() {
        text.push_str(&chain.line(&format!("plan {line}")));
    }
    text
}

/// The first line, and how the lines hang together; `chain` has taken it.
pub(super) fn read_header(text: &str, chain: Chain) -> Option<(Header, Chain)> {
    let (version, fields) = text.strip_prefix(MAGIC)?.strip_prefix(' ')?.split_once(' ')?;
    let (serial, fields) = fields.split_once(' ')?;
    let (hash, rest) = fields.split_once(' ')?;
    let (serial, hash) = (serial.parse().ok()?, hex(hash)?);
    match version {
        "1" => Some((Header { serial, hash, nonce: None, model: rest.to_owned() }, Chain::Loose)),
        "2" => {
            let (nonce, model) = rest.split_once(' ')?;
            let nonce =
                (nonce.len() == 16).then(|| u64::from_str_radix(nonce, 16).ok()).flatten()?;
            Some((Header { serial, hash, nonce: Some(nonce), model: model.to_owned() }, chain))
        }
        _ => None,
    }
}

pub(super) fn calibration(chain: &mut Chain, number: usize, stored: &StoredCalibration) -> String {
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
    chain.line(&text)
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

pub(super) fn point(chain: &mut Chain, sigma: usize, index: usize, stored: &Stored) -> String {
    let Stored { theta, reading, calibration } = stored;
    chain.line(&format!(
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

    const READING: Reading =
        Reading { signal: 0.1, dark: -1e-9, range: 5, over: false, under: true };
    const POINT: Stored =
        Stored { theta: Microdegrees(-89_900_000), reading: READING, calibration: 3 };

    #[test]
    fn records_survive_their_lines() {
        for nonce in [None, Some(u64::MAX)] {
            let model = "GP-200 \"A\" 7".to_owned();
            let head = Header { serial: 9, hash: 1, nonce, model };
            let begun = if nonce.is_some() { Chain::NEW } else { Chain::Loose };
            let mut chain = begun;
            let mut written = header(&mut chain, &head, "a = 1\nb = \" ~\"\n");
            written += &point(&mut chain, 2, 17, &POINT);
            let values = Calibration { id: 7, dark: [0.5; 6], reference: 900.0, range: 0 };
            let stored = StoredCalibration { sigma: 1, values };
            written += &calibration(&mut chain, 4, &stored);
            let mut lines = written.lines();
            let mut chain = Chain::NEW;
            let first = chain.text(lines.next().unwrap().as_bytes()).unwrap();
            let (found, mut chain) = read_header(first, chain).unwrap();
            assert_eq!((found, chain == Chain::Loose), (head, nonce.is_none()));
            let lines: Vec<&str> = lines.map(|line| chain.text(line.as_bytes()).unwrap()).collect();
            assert_eq!(lines[..2], ["plan a = 1", "plan b = \" ~\""]);
            let fields = |line: &str, kind| line.strip_prefix(kind).unwrap().to_owned();
            assert_eq!(read_point(&fields(lines[2], "point ")), Some((2, 17, POINT)));
            let found = read_calibration(&fields(lines[3], "calibration "));
            assert_eq!(found, Some((4, stored)));
        }
    }

    #[test]
    fn a_changed_line_is_no_line() {
        let line = point(&mut Chain::Linked(Some(5)), 0, 0, &POINT).trim_end().to_owned();
        let line = line.into_bytes();
        let text = |line: &[u8]| Chain::Linked(Some(5)).text(line).is_some();
        assert!(text(&line) && Chain::Linked(Some(4)).text(&line).is_none());
        for k in 0..line.len() {
            assert!(!text(&line[..k]));
            let mut changed = line.clone();
            changed[k] ^= 1;
            assert!(!text(&changed), "byte {k}");
        }
    }
}
