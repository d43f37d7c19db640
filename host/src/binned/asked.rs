//! The table of a boundary that cannot be evaluated as it is, for the directions that are asked for.

use asperity_core::bsdf::Scatter;
use asperity_core::direction::Direction;
use asperity_core::quantity::RelativeIor;

use super::{Azimuth, BinnedBsdf, Binning, BinningError, gather, gather_orders};
use crate::boundary::Boundary;
use crate::forward::Rays;
use crate::kirchhoff::{Speckle, WaveBoundary};
use crate::surface::spectrum::Anisotropy;
use crate::watch::Watch;

/// What is made of a boundary before it is evaluated.
#[derive(Debug)]
pub enum Asked {
    /// Nothing: it has a closed form, or is a table.
    AsItIs,
    /// A table, its incidences those that were asked for if they are few.
    Table(Box<BinnedBsdf>),
    /// Stopped before the table was made.
    Stopped,
}

impl Asked {
    /// The table for light from `wi`, with `rays` per incidence and azimuth.
    ///
    /// Rays of a traced boundary and of the mean law of waves are drawn, the orders of kept speckle summed. `watch` is told
    /// the rays, or the transforms.
    ///
    /// # Errors
    /// [`BinningError`].
    pub fn of(
        boundary: &Boundary,
        wi: &[Direction<f64>],
        rays: Rays,
        watch: Watch<'_>,
    ) -> Result<Self, BinningError> {
        let table = match boundary {
            Boundary::Traced(t) => traced(t, (t.eta(), t.anisotropy()), wi, rays, watch)?,
            Boundary::Hybrid(h) => traced(&**h, (h.eta(), h.anisotropy()), wi, rays, watch)?,
            Boundary::Walk(w) => traced(&**w, (w.eta, None), wi, rays, watch)?,
            Boundary::Wave(wave) => of_waves(wave, wi, rays, watch)?,
            Boundary::Ggx(_)
            | Boundary::Microfacet(_)
            | Boundary::AllGgx(_)
            | Boundary::AllMicrofacet(_)
            | Boundary::Normals(_)
            | Boundary::Opaque(_)
            | Boundary::Tail(_)
            | Boundary::Mix(_)
            | Boundary::Table(_) => {
                return Ok(Self::AsItIs);
            }
        };
        Ok(table.map_or(Self::Stopped, |table| Self::Table(Box::new(table))))
    }
}

fn traced<S: Scatter<f64> + Sync>(
    boundary: &S,
    (eta, anisotropy): (RelativeIor<f64>, Option<Anisotropy>),
    wi: &[Direction<f64>],
    rays: Rays,
    watch: Watch<'_>,
) -> Result<Option<BinnedBsdf>, BinningError> {
    let binning = Binning::new(eta, rays).with_azimuth(Azimuth::of(anisotropy))?;
    Ok(gather(boundary, &binning.for_directions(wi), watch))
}

fn of_waves(
    wave: &WaveBoundary,
    wi: &[Direction<f64>],
    rays: Rays,
    watch: Watch<'_>,
) -> Result<Option<BinnedBsdf>, BinningError> {
    let binning = Binning::new(wave.eta(), rays);
    if wave.speckle() == Speckle::Averaged {
        return Ok(gather(wave, &binning.for_directions(wi), watch));
    }
    let binning = binning.with_azimuth(Azimuth::directional())?.for_directions(wi);
    Ok(gather_orders(wave, &binning, watch))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use asperity_core::bsdf::Bsdf;
    use asperity_core::direction::{Direction, Side};
    use asperity_core::quantity::RelativeIor;

    use super::Asked;
    use crate::binned::{Azimuth, BinnedBsdf};
    use crate::boundary::Boundary;
    use crate::forward::Rays;
    use crate::raytrace::{Field, TracedBoundary};
    use crate::surface::{Edges, HeightMap};
    use crate::watch::Watch;

    /// The table of grooves along y, or of bumps.
    fn tabulated(grooves: bool, wi: &[Direction<f64>]) -> BinnedBsdf {
        let height = |k: u32| {
            let wave = |k: u32| (f64::from(k % 64) * std::f64::consts::TAU * 7.0 / 64.0).sin();
            0.3 * (wave(k) + if grooves { 0.0 } else { wave(k / 64) })
        };
        let map = HeightMap::new((64, 64), (1.0, 1.0), (0..64 * 64).map(height).collect()).unwrap();
        let field = Arc::new(Field::new(&map, Edges::Periodic).unwrap());
        let eta = RelativeIor::new(1.49).unwrap();
        let boundary = Boundary::Traced(TracedBoundary { field, eta });
        let rays = Rays { count: 20_000, seed: 1 };
        match Asked::of(&boundary, wi, rays, Watch::nobody()).unwrap() {
            Asked::Table(table) => *table,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_traced_boundary_is_tabulated_where_it_is_asked_for() {
        let pairs =
            [([-0.6, 0.0, 0.8], [0.4, 0.0, -0.916_515_1]), ([0.0, -0.6, 0.8], [0.0, 0.6, 0.8])];
        let pairs = pairs.map(|pair| {
            let direction = |[x, y, z]: [f64; 3]| Direction::new(x, y, z).unwrap();
            (direction(pair.0), direction(pair.1))
        });
        let wi = pairs.map(|pair| pair.0);
        let table = tabulated(false, &wi);
        assert_eq!(table.azimuth(), &Azimuth::Isotropic);
        let incidences = table.incidences_deg(Side::Air);
        assert!(incidences.len() == 1 && table.incidences_deg(Side::Dielectric).is_empty());
        for (wi, wo) in pairs {
            let (f, error) = (table.eval(wi, wo), table.std_error(wi, wo));
            assert!(error > 0.0 && error < f, "{f} {error}");
        }
        let table = tabulated(true, &wi);
        let Azimuth::Fixed(azimuths) = table.azimuth() else { panic!("{:?}", table.azimuth()) };
        assert!(azimuths.len() == 2 && (azimuths[1] - 90.0).abs() < 1e-9, "{azimuths:?}");
    }
}
