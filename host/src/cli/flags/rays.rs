//! The flags of rays, for verbs whose model may have to be traced.

use super::scan::parse_rays;
use crate::cli::say;
use crate::forward::Rays;

/// Rays, where a model cannot be evaluated without them.
#[derive(Clone, Debug, clap::Args)]
pub(in crate::cli) struct RayFlags {
    /// Rays per incidence, for a model whose rays must be traced [default: 1e6]
    #[arg(long, value_name = "N", value_parser = parse_rays)]
    rays: Option<u64>,
    /// Seed of these rays [default: 1]
    #[arg(long, value_name = "K")]
    seed: Option<u64>,
}

impl RayFlags {
    /// Rays per incidence where the user says nothing.
    const USUAL: u64 = 1_000_000;

    /// The rays.
    pub(in crate::cli) fn rays(&self) -> Rays {
        Rays { count: self.rays.unwrap_or(Self::USUAL), seed: self.seed.unwrap_or(1) }
    }

    /// The same; where none are traced it is said that the flags have no effect. They are no mistake there: one line serves
    /// models of all methods.
    pub(in crate::cli) fn noted(&self, are_traced: bool) -> Rays {
        for (flag, is_given) in [("--rays", self.rays.is_some()), ("--seed", self.seed.is_some())] {
            if is_given && !are_traced {
                say::note(format_args!(
                    "note: {flag} has no effect: this model is evaluated without rays"
                ));
            }
        }
        self.rays()
    }
}
