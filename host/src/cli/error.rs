//! How a verb ends when it does not end well.

use std::fmt::Display;

/// The ways to fail, by exit status.
#[derive(Debug)]
pub(super) enum Failure {
    /// Exit 1: all went well and the answer is no.
    No(String),
    /// Exit 1: the instrument, or the way to it, fails; the text says what, where and what to do.
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

impl From<crate::output::OutputError> for Failure {
    fn from(e: crate::output::OutputError) -> Self {
        Self::bad(e)
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
