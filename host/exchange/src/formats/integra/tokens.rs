//! Words of a file with their lines.

use crate::error::Fault;
use crate::text::{Lines, excerpt};

/// The words of a text without comments.
#[derive(Debug)]
pub(super) struct Tokens<'a> {
    /// Name of the format.
    pub(super) format: &'static str,
    words: Vec<(&'a str, usize)>,
    at: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(format: &'static str, text: &'a str) -> Self {
        let mut lines = Lines::new(format, text);
        let mut words = Vec::new();
        while let Some(line) = lines.next_raw() {
            let code = line.split_once(";;").map_or(line, |(code, _)| code);
            words.extend(code.split_whitespace().map(|word| (word, lines.number())));
        }
        Self { format, words, at: 0 }
    }

    /// The next word, which stays.
    pub(super) fn peek(&self) -> Option<&'a str> {
        self.words.get(self.at).map(|(word, _)| *word)
    }

    /// The next word.
    pub(super) fn next(&mut self) -> Option<&'a str> {
        let word = self.peek()?;
        self.at += 1;
        Some(word)
    }

    /// The next word in small letters.
    pub(super) fn word(&mut self, what: &str) -> Result<String, Fault> {
        let word = self.next().ok_or_else(|| self.ends(what))?;
        Ok(word.to_ascii_lowercase())
    }

    /// Number of words that are left.
    pub(super) fn left(&self) -> usize {
        self.words.len() - self.at
    }

    /// A fault of the word that was read last.
    pub(super) fn fault(&self, what: impl Into<String>) -> Fault {
        let line = self.words.get(self.at.saturating_sub(1)).map_or(1, |(_, line)| *line);
        Fault::Line { format: self.format, line, what: what.into() }
    }

    fn ends(&self, what: &str) -> Fault {
        self.fault(format!("the file ends where {what} is expected"))
    }

    pub(super) fn number(&mut self, what: &str) -> Result<f64, Fault> {
        let word = self.next().ok_or_else(|| self.ends(what))?;
        let value = word.parse::<f64>().ok().filter(|v| v.is_finite());
        value.ok_or_else(|| self.fault(format!("{what} is not a number: '{}'", excerpt(word))))
    }

    /// A count of at least 1 and at most a million.
    pub(super) fn count(&mut self, what: &str) -> Result<usize, Fault> {
        let word = self.next().ok_or_else(|| self.ends(what))?;
        let value = word.parse::<usize>().ok().filter(|n| (1..=1_000_000).contains(n));
        value.ok_or_else(|| {
            self.fault(format!(
                "the number of {what} is not one from 1 to 1000000: '{}'",
                excerpt(word)
            ))
        })
    }

    /// Exactly `n` numbers that are not below `least`; room is made for no more than there are words.
    pub(super) fn exactly(&mut self, n: usize, what: &str, least: f64) -> Result<Vec<f64>, Fault> {
        if n > self.left() {
            let left = self.left();
            return Err(self.fault(format!("{n} {what} are expected, and {left} words are left")));
        }
        let mut all = Vec::with_capacity(n);
        for _ in 0..n {
            let v = self.number(what)?;
            if v < least {
                return Err(self.fault(format!("{what} below {least}: {v}")));
            }
            all.push(v);
        }
        Ok(all)
    }

    /// All numbers up to the next word that is none.
    pub(super) fn numbers(&mut self) -> Vec<f64> {
        let mut all = Vec::new();
        while let Some(v) = self.peek().and_then(|word| word.parse::<f64>().ok()) {
            all.push(v);
            self.at += 1;
        }
        all
    }
}
