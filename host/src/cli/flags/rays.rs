//! The flags of rays, for verbs whose model may have to be traced.

use super::scan::parse_rays;
use crate::cli::error::{Failure, without_effect};
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

    /// The same, refused where none are traced.
    ///
    /// # Errors
    /// The flags that are given.
    pub(in crate::cli) fn needed(&self, are_traced: bool) -> Result<Rays, Failure> {
        let given = |is: bool| is && !are_traced;
        let flags =
            [("--rays", given(self.rays.is_some())), ("--seed", given(self.seed.is_some()))];
        without_effect(&flags, "this model is evaluated without rays")?;
        Ok(self.rays())
    }
}
