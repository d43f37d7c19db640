//! What a fit minimises, with how much effort, and what counts as described: the flags of `fit`, `compare` and `trade`.

use clap::ValueEnum;

use super::scan::{number, parse_rays};
use crate::cli::error::{Failure, without_effect};
use crate::fit::{FitOptions, FitRays, MISFIT_PERCENT, Objective};
use crate::method::{Body, Kind, in_words};

/// What is minimised, as a flag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum ObjectiveFlag {
    /// Eq. (18): rms deviation over the largest reading
    #[default]
    Rmsd,
    /// Rms relative deviation
    Relative,
    /// Rms deviation of the logarithms
    Log,
}

impl From<ObjectiveFlag> for Objective {
    fn from(flag: ObjectiveFlag) -> Self {
        match flag {
            ObjectiveFlag::Rmsd => Self::Rmsd,
            ObjectiveFlag::Relative => Self::Relative,
            ObjectiveFlag::Log => Self::Log,
        }
    }
}

/// What is minimised, with how much effort, and what counts as described.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct EffortFlags {
    /// What is minimised; eq. (18) is always printed
    #[arg(long, value_enum, default_value = "rmsd")]
    objective: ObjectiveFlag,
    /// Rays per incidence for the final figures of a traced method; without it as many as bring their noise below 0.2 %
    #[arg(long, value_name = "N", value_parser = parse_rays)]
    rays: Option<u64>,
    /// Rays per incidence while a traced method is fitted; without it as many as bring their noise to 1.3 %
    #[arg(long, value_name = "N", value_parser = parse_rays)]
    fit_rays: Option<u64>,
    /// Seed of traced methods [default: 1]
    #[arg(long, value_name = "K")]
    seed: Option<u64>,
    /// Evaluations of the forward model at most
    #[arg(long, hide_short_help = true, value_name = "N", default_value_t = 4000)]
    max_evaluations: u64,
    /// Largest error of a single incidence that counts as described, in % of its largest reading
    #[arg(long, value_name = "PERCENT", default_value_t = MISFIT_PERCENT, value_parser = number)]
    pub(in crate::cli) max_misfit: f64,
}

impl EffortFlags {
    /// What is minimised.
    pub(in crate::cli) fn objective(&self) -> Objective {
        self.objective.into()
    }

    /// Refuses what would leave nothing to do.
    pub(in crate::cli) fn check(&self) -> Result<(), Failure> {
        if self.max_misfit.is_nan() || self.max_misfit <= 0.0 || self.max_evaluations == 0 {
            return Err(Failure::bad("--max-misfit and --max-evaluations must be positive"));
        }
        Ok(())
    }

    /// Refuses the flags of rays where none are traced.
    ///
    /// # Errors
    /// The flags that are given.
    pub(in crate::cli) fn need_rays(&self, are_traced: bool) -> Result<(), Failure> {
        let given = |is: bool| is && !are_traced;
        let flags = [
            ("--rays", given(self.rays.is_some())),
            ("--fit-rays", given(self.fit_rays.is_some())),
            ("--seed", given(self.seed.is_some())),
        ];
        let methods = in_words(&Kind::names(|kind| kind.traced));
        without_effect(&flags, &format!("rays are traced by the methods {methods}"))
    }

    /// The options of a fit to a body, with nothing free but the method's own parameters.
    pub(in crate::cli) fn options(&self, body: Body) -> FitOptions {
        FitOptions {
            objective: self.objective.into(),
            max_evaluations: self.max_evaluations,
            rays: FitRays {
                fit: self.fit_rays,
                last: self.rays,
                seed: self.seed.unwrap_or(1),
                ..FitRays::default()
            },
            ..FitOptions::new(body)
        }
    }
}
