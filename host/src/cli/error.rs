//! How a verb ends when it does not end well.

use std::fmt::Display;

use super::say;
use crate::method::{Lack, in_words};

/// The ways to fail, by exit status.
#[derive(Debug)]
pub(super) enum Failure {
    /// Exit 1: all went well and the answer is no.
    No(String),
    /// Exit 1: the instrument, the way to it, or the disk fails; the text says what, where and what to do.
    Trouble(String),
    /// Exit 2: bad usage or bad input; the text says what, where and what to do.
    Bad(String),
}

impl Failure {
    /// Bad usage or input, from any error.
    pub(super) fn bad(what: impl Display) -> Self {
        Self::Bad(what.to_string())
    }
}

/// Refuses flags that are given though they have no effect: each with whether it is given; `why` says where they have one.
pub(super) fn without_effect(flags: &[(&str, bool)], why: &str) -> Result<(), Failure> {
    let given: Vec<&str> = flags.iter().filter(|(_, is)| *is).map(|(flag, _)| *flag).collect();
    let (has, it) = match given.len() {
        0 => return Ok(()),
        1 => ("has", "it"),
        _ => ("have", "them"),
    };
    Err(Failure::Bad(format!("{} {has} no effect: {why}; leave {it} out", in_words(&given))))
}

/// All of these were done, whether the others failed or not: the first failure ends the verb, the others are said.
pub(super) fn all(done: impl IntoIterator<Item = Result<(), Failure>>) -> Result<(), Failure> {
    let mut failures = done.into_iter().filter_map(Result::err);
    let first = failures.next().map_or(Ok(()), Err);
    for Failure::No(what) | Failure::Trouble(what) | Failure::Bad(what) in failures {
        say::error(format_args!("error: {what}"));
    }
    first
}

impl From<crate::output::OutputError> for Failure {
    fn from(e: crate::output::OutputError) -> Self {
        if e.is_trouble() { Self::Trouble(e.to_string()) } else { Self::bad(e) }
    }
}
impl From<crate::report::FigureError> for Failure {
    fn from(e: crate::report::FigureError) -> Self {
        match e {
            crate::report::FigureError::Output(e) => e.into(),
            e @ crate::report::FigureError::Plot(_) => Self::Trouble(e.to_string()),
        }
    }
}
/// What a method lacks, and the flag that gives it.
pub(super) fn remedy(lack: &Lack) -> String {
    match lack {
        Lack::Map(_) => format!("{lack}; give --map FILE"),
        Lack::Lobe(_) => format!("{lack}; give --lobe reflection or --lobe transmission"),
        Lack::NoParts => format!("{lack}; give --of A or --of A,B"),
        Lack::NotMixed(_) => format!("{lack}; leave --of out"),
        Lack::Wavelength(_) => format!("{lack}; give --wavelength-nm in nm"),
        _ => lack.to_string(),
    }
}

impl From<Lack> for Failure {
    fn from(lack: Lack) -> Self {
        Self::Bad(remedy(&lack))
    }
}
impl From<crate::measurement::ScanError> for Failure {
    fn from(e: crate::measurement::ScanError) -> Self {
        Self::bad(e)
    }
}
impl From<crate::model::ModelError> for Failure {
    fn from(e: crate::model::ModelError) -> Self {
        Self::bad(e)
    }
}
impl From<crate::law_file::LawError> for Failure {
    fn from(e: crate::law_file::LawError) -> Self {
        Self::bad(e)
    }
}
