//! The common part of the methods with a measured map: two parameters, vertical scale and cut-off wavelength.
//!
//! The fit scales the map vertically by `scale` and damps its waves shorter than `cutoff_um` as far as the scan
//! requires: profilometers err in height, and their noise adds false slopes.

use std::borrow::Cow;
use std::sync::Arc;

use super::kind::Lack;
use super::{BuildError, Parameter, Scale};
use crate::surface::modify::ModifyError;
use crate::surface::{Edges, HeightMap, Incomplete, LowPass};

/// A measured map and its parameters.
#[derive(Clone, Debug)]
pub(super) struct MeasuredMap {
    low_pass: Arc<LowPass>,
    /// The continuation of the map.
    pub(super) edges: Edges,
    /// The scale, and the cut-off if requested.
    pub(super) parameters: Vec<Parameter>,
}

/// The two parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knobs {
    /// Factor on the heights.
    pub(super) scale: f64,
    /// Cut-off wavelength in um; `None` or 0 for no filter.
    pub(super) cutoff_um: Option<f64>,
}

const SCALE: Parameter = Parameter::new("scale", "", (0.05, 20.0), Scale::Log, &[0.5, 1.0, 2.0]);

impl MeasuredMap {
    /// For a complete map; without a cut-off the heights are scaled only.
    pub(super) fn new(
        map: &HeightMap,
        edges: Edges,
        with_cutoff: bool,
    ) -> Result<Self, Incomplete> {
        let low_pass = Arc::new(LowPass::new(map, edges)?);
        let (dx, dy) = (map.dx_um(), map.dy_um());
        let side = (dx * map.nx() as f64).min(dy * map.ny() as f64);
        // From no effect on waves of two points, to all but the longest waves.
        let (least, most) = (0.5 * dx.min(dy), side.max(4.0 * dx.max(dy)));
        // a search near the pixel alone would not see a filter of many of them
        let starts = [2.0, 8.0, 32.0].map(|pixels| pixels * dx.max(dy));
        let starts = starts.into_iter().filter(|start| *start <= 0.5 * most).collect();
        let cutoff = Parameter {
            name: "cutoff_um",
            unit: "um",
            bounds: (least, most),
            scale: Scale::Log,
            starts: Cow::Owned(starts),
            none: Some(0.0),
            is_level: false,
            is_linear: false,
        };
        let parameters = if with_cutoff { vec![SCALE, cutoff] } else { vec![SCALE] };
        Ok(Self { low_pass, edges, parameters })
    }

    /// The values of the two parameters.
    pub(super) fn knobs(&self, values: &[f64]) -> Result<Knobs, BuildError> {
        let scale = *values.first().ok_or(BuildError::Missing("scale"))?;
        let cutoff_um = match (self.parameters.get(1), values.get(1)) {
            (None, _) => None,
            (Some(_), Some(cutoff)) => Some(*cutoff),
            (Some(p), None) => return Err(BuildError::Missing(p.name)),
        };
        if scale.abs() >= 1e-9 && scale.abs() <= 1e6 {
            Ok(Knobs { scale, cutoff_um })
        } else {
            Err(out_of_domain("scale", scale, (1e-9, 1e6), ""))
        }
    }

    /// The scaled and filtered map.
    pub(super) fn modified(&self, knobs: Knobs) -> Result<HeightMap, BuildError> {
        self.low_pass.apply(knobs.scale, knobs.cutoff_um).map_err(|e| match e {
            ModifyError::Cutoff(value) => out_of_domain("cutoff_um", value, (0.0, 1e9), "um"),
            other => BuildError::Map(other.to_string()),
        })
    }
}

fn out_of_domain(
    name: &'static str,
    value: f64,
    (least, most): (f64, f64),
    unit: &'static str,
) -> BuildError {
    BuildError::OutOfDomain { name, value, least, most, unit }
}

/// Why a map with holes makes no method.
pub(super) fn unusable(holes: Incomplete) -> Lack {
    BuildError::Map(holes.to_string()).into()
}

#[cfg(test)]
pub(super) mod tests {
    use crate::method::{Body, Method};
    use crate::surface::HeightMap;

    /// A small map.
    pub(in crate::method) fn map() -> HeightMap {
        let heights = (0..256).map(|k| f64::from(k % 7) * 0.1).collect();
        HeightMap::new((16, 16), (0.5, 0.5), heights).unwrap()
    }

    /// A map with a hole.
    pub(in crate::method) fn holed() -> HeightMap {
        HeightMap::new((2, 2), (1.0, 1.0), vec![0.0, f64::NAN, 1.0, 2.0]).unwrap()
    }

    /// Values outside the domain are refused by name.
    pub(in crate::method) fn check_domain(method: &dyn Method) {
        let clear = Body::Dielectric { ior: 1.49 };
        assert!(method.boundary(&[1.0, 2.0], clear).is_ok());
        assert!(method.boundary(&[-1.0, 0.0], clear).is_ok());
        for (values, name) in [
            (vec![], "scale"),
            (vec![1.0], "cutoff_um"),
            (vec![0.0, 1.0], "scale"),
            (vec![f64::NAN, 1.0], "scale"),
            (vec![1.0, f64::NAN], "cutoff_um"),
            (vec![1.0, -1.0], "cutoff_um"),
        ] {
            let text = method.boundary(&values, clear).unwrap_err().to_string();
            assert!(text.contains(name), "{text}");
        }
    }
}
