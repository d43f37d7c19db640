//! Grids that several formats share.

use super::{Law, Options, Subject};
use crate::error::CannotHold;
use crate::interpolation::Interpolation;
use crate::law::{Coordinates, Layout};
use crate::plan::plan;
use crate::sampled::SampledBsdf;

/// One grid about the specular or direct ray for all incidences, linear between nodes.
pub(super) fn about_ray(
    format: &'static str,
    law: &dyn Law,
    subject: &Subject,
    options: &Options,
) -> Result<SampledBsdf, CannotHold> {
    let layout = Layout {
        coordinates: Coordinates::Specular,
        own_grids: false,
        interpolation: Interpolation::Linear,
    };
    let sampled = plan(law, subject, layout, options);
    if sampled.incidences.is_empty() {
        let what = "incidences beyond the critical angle, which have no direct ray".into();
        let remedy = "give smaller ones with --incidence".into();
        return Err(CannotHold { format, what, remedy });
    }
    Ok(sampled)
}

/// Grids of absolute angles, one for each incidence or the same for all, linear between nodes.
pub(super) fn absolute(
    own_grids: bool,
    law: &dyn Law,
    subject: &Subject,
    options: &Options,
) -> SampledBsdf {
    let layout = Layout {
        coordinates: Coordinates::Absolute,
        own_grids,
        interpolation: Interpolation::Linear,
    };
    plan(law, subject, layout, options)
}
