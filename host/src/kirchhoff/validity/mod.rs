//! Where waves may be trusted on a height map.
//!
//! `light` says which angles and phases are asked for, `margins` how far a facet is from failing, `facets` goes over the map once,
//! `conditions` are figures without a limit, `limits` the verdicts, `gaussian` the verdict in closed form, `warnings` the words.

mod light;
mod margins;
mod facets;
mod conditions;
mod limits;
mod gaussian;
mod warnings;

pub use gaussian::{GaussianLobe, GaussianVerdict};
pub use limits::{
    COS_RQ_OVER_ACL, CURVATURE_WAVELENGTHS, FEWEST_AREAS, FarField, LEAST_LENGTH, LEAST_MARGIN,
    LobeValidity, Loss, MOST_EXCESS, MOST_SHARE, MOST_VIOLATING, Margins, Validity, ValidityError,
    Violating,
};
