//! Lines and numbers of text files.

use crate::error::Fault;

/// The lines of a text of any line end, with what is at fault named by its number.
#[derive(Clone, Debug)]
pub struct Lines<'a> {
    format: &'static str,
    all: Vec<&'a str>,
    /// Index of the next line.
    at: usize,
}

/// Characters of a text that a message shows.
const SHOWN: usize = 40;

/// A text of UTF-8, of UTF-16 with its byte-order mark, or of one byte a character; the mark is left out.
pub fn decode(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.as_chunks().0.iter().map(|pair| unit(*pair)).collect();
        String::from_utf16_lossy(&units).into()
    };
    let bytes = match bytes {
        [0xff, 0xfe, rest @ ..] => return wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => return wide(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => rest,
        _ => bytes,
    };
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|b| char::from(*b)).collect::<String>().into(),
    }
}

/// A text as a message shows it: one line, not too long.
pub fn excerpt(text: &str) -> String {
    let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    let clean = clean.trim();
    if clean.chars().count() <= SHOWN {
        return clean.to_owned();
    }
    clean.chars().take(SHOWN).chain("...".chars()).collect()
}

impl<'a> Lines<'a> {
    /// The lines of `text`, which may end with CR LF, LF or CR.
    pub fn new(format: &'static str, text: &'a str) -> Self {
        let mut lines = Vec::new();
        for line in text.split('\n') {
            let line = line.strip_suffix('\r').unwrap_or(line);
            lines.extend(line.split('\r'));
        }
        Self { format, all: lines, at: 0 }
    }

    /// Number of the line that was read last.
    pub fn number(&self) -> usize {
        self.at
    }

    /// The next line, whatever it is.
    pub fn next_raw(&mut self) -> Option<&'a str> {
        let line = self.all.get(self.at).copied();
        self.at += usize::from(line.is_some());
        line
    }

    /// The next line that holds something, its ends trimmed.
    pub fn next_filled(&mut self) -> Option<&'a str> {
        loop {
            let line = self.next_raw()?.trim();
            if !line.is_empty() {
                return Some(line);
            }
        }
    }

    /// The next line that holds something.
    ///
    /// # Errors
    /// [`Fault::Line`] with what was expected at the end of the file.
    pub fn expect(&mut self, what: &str) -> Result<&'a str, Fault> {
        self.next_filled()
            .ok_or_else(|| self.fault(format!("the file ends where {what} is expected")))
    }

    /// Goes back by a line.
    pub fn back(&mut self) {
        self.at = self.at.saturating_sub(1);
    }

    /// A fault of the line that was read last.
    pub fn fault(&self, what: impl Into<String>) -> Fault {
        Fault::Line { format: self.format, line: self.at.max(1), what: what.into() }
    }

    /// A finite number.
    ///
    /// # Errors
    /// [`Fault::Line`].
    pub fn number_of(&self, field: &str, what: &str) -> Result<f64, Fault> {
        let value = field.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        value.ok_or_else(|| self.fault(format!("{what} is not a number: '{}'", excerpt(field))))
    }

    /// The numbers of a line, separated by blanks, tabs, commas or semicolons; separators at its ends mean nothing.
    ///
    /// # Errors
    /// [`Fault::Line`].
    pub fn numbers(&self, line: &str, what: &str) -> Result<Vec<f64>, Fault> {
        fields(line).map(|field| self.number_of(field, what)).collect()
    }

    /// Exactly `n` numbers, over as many lines as they need.
    ///
    /// # Errors
    /// [`Fault::Line`].
    pub fn exactly(&mut self, n: usize, what: &str) -> Result<Vec<f64>, Fault> {
        let mut all = Vec::with_capacity(n.min(1 << 16));
        while all.len() < n {
            let line = self.expect(what)?;
            all.extend(self.numbers(line, what)?);
        }
        if all.len() > n {
            return Err(
                self.fault(format!("{} numbers of {what} where {n} are expected", all.len()))
            );
        }
        Ok(all)
    }

    /// Checks that angles ascend.
    ///
    /// # Errors
    /// [`Fault::Line`].
    pub fn ascending(&self, angles: &[f64], what: &str) -> Result<(), Fault> {
        match angles.windows(2).find(|w| w[1] <= w[0]) {
            Some(w) => Err(self.fault(format!("{what} do not ascend: {} after {}", w[1], w[0]))),
            None => Ok(()),
        }
    }

    /// A count of at least 1 and at most a million.
    ///
    /// # Errors
    /// [`Fault::Line`].
    pub fn count(&self, field: &str, what: &str) -> Result<usize, Fault> {
        let value = field.trim().parse::<usize>().ok().filter(|n| (1..=1_000_000).contains(n));
        value.ok_or_else(|| {
            self.fault(format!(
                "the number of {what} is not one from 1 to 1000000: '{}'",
                excerpt(field)
            ))
        })
    }
}

/// Fields between blanks, tabs, commas and semicolons.
pub fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.split([' ', '\t', ',', ';']).filter(|field| !field.is_empty())
}

/// Degrees as they are written: no digits that double precision does not have, and none that only rounding made.
pub fn degrees(radians: f64) -> String {
    let rounded = (radians.to_degrees() * 1e11).round() / 1e11;
    format!("{rounded}")
}
