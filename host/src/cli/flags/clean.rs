//! Which readings are left out before a fit: the flags of `fit` and `compare`.

use std::path::Path;

use clap::ValueEnum;

use crate::cli::error::Failure;
use crate::cli::say;
use crate::fit::Objective;
use crate::measurement::clean::{Cleaning, Zeros};
use crate::measurement::{Measurement, Reading};

use super::scan::READING;

/// Readings that are no light, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum DropFlag {
    /// Every reading of exactly 0
    Zeros,
    /// Every negative reading
    Negative,
    /// Nothing, not even zeros with light beside them
    None,
}

/// On which side of the normal the mirror direction is, as a flag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum SignFlag {
    /// At theta = sigma
    #[default]
    Plus,
    /// At theta = -sigma
    Minus,
}

/// What is done to readings before they are used.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = READING)]
pub(in crate::cli) struct CleanFlags {
    /// Readings to leave out; without it zeros with light beside them; may be repeated
    #[arg(long, value_enum, hide_short_help = true, value_name = "WHICH")]
    drop: Vec<DropFlag>,
    /// The sign of theta where the mirrored or undeviated beam of sigma is [default: plus]
    #[arg(long, value_enum, hide_short_help = true, value_name = "SIGN")]
    theta_sign: Option<SignFlag>,
}

impl CleanFlags {
    /// The flags with whether they are given.
    pub(in crate::cli) fn given(&self) -> [(&'static str, bool); 2] {
        [("--drop", !self.drop.is_empty()), ("--theta-sign", self.theta_sign.is_some())]
    }

    /// The scan as it is used; says what is left out.
    pub(in crate::cli) fn apply(
        &self,
        scan: &Measurement,
        path: &Path,
        objective: Objective,
    ) -> Result<Measurement, Failure> {
        let asks = |flag| self.drop.contains(&flag);
        if asks(DropFlag::None) && self.drop.len() > 1 {
            return Err(Failure::bad("--drop none goes with no other --drop"));
        }
        // an error that is relative to no light has no meaning
        let is_relative = objective != Objective::Rmsd;
        let cleaning = Cleaning {
            zeros: match () {
                () if is_relative || asks(DropFlag::Zeros) => Zeros::All,
                () if asks(DropFlag::None) => Zeros::Kept,
                () => Zeros::InLight,
            },
            negative: is_relative || asks(DropFlag::Negative),
        };
        let cleaned = cleaning.apply(scan).ok_or_else(|| {
            Failure::bad(format!("{}: no reading is left; --drop leaves out all", path.display()))
        })?;
        for note in cleaned.notes() {
            say::note(format_args!("{}: {note}", path.display()));
        }
        if self.theta_sign != Some(SignFlag::Minus) {
            return Ok(cleaned.scan);
        }
        let turned = |r: &Reading| Reading { theta_deg: -r.theta_deg, ..*r };
        let readings = cleaned.scan.readings().iter().map(turned).collect();
        Measurement::new(cleaned.scan.meta, readings).map_err(Failure::bad)
    }
}
