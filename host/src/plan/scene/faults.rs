//! Faults of a scene with their lines.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;

use super::draft::{OneOrTwo, Said};
use super::error::SceneError;
use crate::message::excerpt;

/// The text of a scene, to tell lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl Place<'_> {
    /// A fault at a place of the text.
    pub(super) fn fault(&self, span: Range<usize>, what: impl Into<String>) -> SceneError {
        let before = self.text.get(..span.start).unwrap_or("");
        self.line(before.matches('\n').count() + 1, what)
    }

    /// A fault in a line.
    pub(super) fn line(&self, line: usize, what: impl Into<String>) -> SceneError {
        SceneError::Line { path: self.path.to_owned(), line, what: what.into() }
    }

    /// A table that has to be there; a scene without it ends too early.
    pub(super) fn table<T>(
        &self,
        name: &str,
        said: Said<T>,
    ) -> Result<(Range<usize>, T), SceneError> {
        let Some(table) = said else {
            let what = format!("there is no [{name}]; add it, see `asperity plan --example plate`");
            return Err(self.line(self.text.lines().count().max(1), what));
        };
        let span = table.span();
        // `[name]`, or what stands between braces: the fault of a table is told at its beginning
        Ok((span, table.into_inner()))
    }

    /// A key that has to be there.
    pub(super) fn needed<T>(
        &self,
        table: &Range<usize>,
        key: &str,
        said: Said<T>,
    ) -> Result<Spanned<T>, SceneError> {
        said.ok_or_else(|| self.fault(table.clone(), format!("{key} is missing; add it")))
    }

    /// A number within limits; written so that NaN is refused too.
    pub(super) fn number(
        &self,
        key: &str,
        said: &Spanned<f64>,
        [least, most]: [f64; 2],
    ) -> Result<f64, SceneError> {
        let value = *said.as_ref();
        if value >= least && value <= most {
            return Ok(value);
        }
        let what = format!("{key} {value} is not usable; give {least} to {most}");
        Err(self.fault(said.span(), what))
    }

    /// Two ascending numbers within limits.
    pub(super) fn two(
        &self,
        key: &str,
        said: &Spanned<OneOrTwo>,
        limits: [f64; 2],
    ) -> Result<[f64; 2], SceneError> {
        let [from, to] = said.as_ref().ends();
        for value in [from, to] {
            self.number(key, &Spanned::new(said.span(), value), limits)?;
        }
        if from > to {
            let what = format!("{key} [{from}, {to}] falls; give the smaller number first");
            return Err(self.fault(said.span(), what));
        }
        Ok([from, to])
    }

    /// One of some words.
    pub(super) fn word<T: Copy>(
        &self,
        key: &str,
        said: &Spanned<String>,
        words: &[(&'static str, T)],
    ) -> Result<(&'static str, T), SceneError> {
        words.iter().find(|(word, _)| word == said.as_ref()).copied().ok_or_else(|| {
            let all: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
            let given = excerpt(said.as_ref());
            let what = format!("{key} {given:?} is not known; give one of {}", all.join(", "));
            self.fault(said.span(), what)
        })
    }

    /// A key that means nothing here.
    pub(super) fn without<T>(
        &self,
        key: &str,
        said: Option<&Spanned<T>>,
        why: &str,
    ) -> Result<(), SceneError> {
        match said {
            None => Ok(()),
            Some(given) => {
                Err(self.fault(given.span(), format!("{key} has no effect: {why}; leave it out")))
            }
        }
    }
}
