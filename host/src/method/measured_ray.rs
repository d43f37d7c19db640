//! Method `measured-ray`: the measured map, traced with all bounces \[Sokolov section 4\].
//!
//! The map is scaled vertically by `scale` and its waves shorter than `cutoff_um` are damped, as far as the
//! scan asks for it: profilometers err in height, and their noise makes slopes that are not there.

use std::borrow::Cow;
use std::sync::Arc;

use super::{BuildError, Method, Parameter, Scale, Surface};
use crate::boundary::Boundary;
use crate::raytrace::{Field, TracedBoundary};
use crate::surface::modify::ModifyError;
use crate::surface::{Edges, HeightMap, Incomplete, LowPass};

/// The method with its map.
#[derive(Clone, Debug)]
pub struct MeasuredRayMethod {
    low_pass: Arc<LowPass>,
    edges: Edges,
    parameters: Vec<Parameter>,
}

const SCALE: Parameter = Parameter::new("scale", "", (0.05, 20.0), Scale::Log, &[0.5, 1.0, 2.0]);

impl MeasuredRayMethod {
    /// For a complete map; without a cut-off the heights are scaled only.
    ///
    /// # Errors
    /// [`Incomplete`] if points are missing.
    pub fn new(map: &HeightMap, edges: Edges, with_cutoff: bool) -> Result<Self, Incomplete> {
        let low_pass = Arc::new(LowPass::new(map, edges)?);
        let (dx, dy) = (map.dx_um(), map.dy_um());
        let side = (dx * map.nx() as f64).min(dy * map.ny() as f64);
        // From no effect on waves of two points, to all but the longest waves.
        let (least, most) = (0.5 * dx.min(dy), side.max(4.0 * dx.max(dy)));
        let cutoff = Parameter {
            name: "cutoff_um",
            unit: "um",
            bounds: (least, most),
            scale: Scale::Log,
            starts: Cow::Owned(vec![2.0 * dx.max(dy)]),
            low_is_none: true,
        };
        let parameters = if with_cutoff { vec![SCALE, cutoff] } else { vec![SCALE] };
        Ok(Self { low_pass, edges, parameters })
    }
}

impl Method for MeasuredRayMethod {
    fn name(&self) -> &'static str {
        "measured-ray"
    }

    fn references(&self) -> &'static [&'static str] {
        &["Sokolov section 4", "ISO 16610-61"]
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn boundary(&self, values: &[f64], surface: Surface) -> Result<Boundary, BuildError> {
        let eta = surface.eta()?;
        let scale = *values.first().ok_or(BuildError::Missing("scale"))?;
        let cutoff_um = match (self.parameters.get(1), values.get(1)) {
            (None, _) => None,
            (Some(_), Some(cutoff)) => Some(*cutoff),
            (Some(p), None) => return Err(BuildError::Missing(p.name)),
        };
        let out = |name, value, least, most, unit| BuildError::OutOfDomain {
            name,
            value,
            least,
            most,
            unit,
        };
        if !(scale.abs() >= 1e-9 && scale.abs() <= 1e6) {
            return Err(out("scale", scale, 1e-9, 1e6, ""));
        }
        let map = self.low_pass.apply(scale, cutoff_um).map_err(|e| match e {
            ModifyError::Cutoff(value) => out("cutoff_um", value, 0.0, 1e9, "um"),
            other => BuildError::Map(other.to_string()),
        })?;
        let field = Field::new(&map, self.edges).map_err(|e| BuildError::Map(e.to_string()))?;
        Ok(Boundary::Traced(TracedBoundary { field: Arc::new(field), eta }))
    }

    fn is_traced(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::{MeasuredRayMethod, Method, Surface};
    use crate::surface::{Edges, HeightMap};

    #[test]
    fn values_outside_the_domain_are_refused_by_name() {
        let clear = Surface::Dielectric { ior: 1.49 };
        let heights = (0..256).map(|k| f64::from(k % 7) * 0.1).collect();
        let map = HeightMap::new((16, 16), (0.5, 0.5), heights).unwrap();
        let method = MeasuredRayMethod::new(&map, Edges::Mirrored, true).unwrap();
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
        let holed = HeightMap::new((2, 2), (1.0, 1.0), vec![0.0, f64::NAN, 1.0, 2.0]).unwrap();
        assert!(MeasuredRayMethod::new(&holed, Edges::Mirrored, true).is_err());
    }
}
