//! Azimuths of the light: a table has none, so a surface must look alike from all of them.
//!
//! A map is one piece of its surface, and its few facets differ by azimuth even where the surface does not. What tells the two
//! apart is the spectrum of the map: its harmonics over the directions are held against what chance alone would give them
//! ([`Spectrum::pattern`]). Only where these say that there is a direction, the lobes are looked at from several azimuths; if they
//! differ, no table is made.

use asperity_core::bsdf::LobeSet;

use super::bins;
use crate::boundary::Boundary;
use crate::forward::{Heeding, Rays};
use crate::surface::spectrum::Anisotropy;
use crate::surface::{Edges, HeightMap, Roughness, Spectrum};
use crate::watch::Watch;

/// Root mean square difference of a lobe at one azimuth from its mean, of the peak, below which it has none.
const ALIKE: f64 = 0.02;
/// Rms slope below which rays all leave in one direction for any instrument: 0.006 degrees.
const UNSEEN: f64 = 1e-4;
/// Most rays that tell it, per incidence.
const MOST_RAYS: u64 = 250_000;

/// The direction of the surface of a boundary, if it has one.
fn pattern(boundary: &Boundary) -> Option<Anisotropy> {
    let of = |map: &HeightMap, edges: Edges| Spectrum::of(map, edges).ok()?.pattern();
    let found = match boundary {
        Boundary::Traced(traced) => {
            let map = traced.field.map().ok()?;
            let Roughness { rms_slope_x, rms_slope_y, .. } = Roughness::of(&map);
            let slope = rms_slope_x.unwrap_or(0.0).hypot(rms_slope_y.unwrap_or(0.0));
            (slope > UNSEEN).then(|| of(&map, traced.field.edges()))?
        }
        Boundary::Wave(wave) => of(wave.map(), wave.edges()),
        Boundary::Hybrid(hybrid) => {
            let (map, edges) = hybrid.surface();
            of(map, edges)
        }
        Boundary::Ggx(_)
        | Boundary::Microfacet(_)
        | Boundary::AllGgx(_)
        | Boundary::AllMicrofacet(_)
        | Boundary::Walk(_)
        | Boundary::Normals(_)
        | Boundary::Opaque(_)
        | Boundary::Tail(_)
        | Boundary::Mix(_)
        | Boundary::Table(_) => None,
    };
    found.filter(Anisotropy::is_directional)
}

/// A surface whose lobes depend on the azimuth of the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directional {
    pub(super) anisotropy: Anisotropy,
    /// Largest root mean square difference of a wanted lobe from its mean over azimuths, % of its peak; `None` of waves,
    /// whose mean law such a surface does not scatter, whatever it looks like.
    pub(super) percent: Option<f64>,
}

/// Whether lobes depend on the azimuth of the light because the surface of a boundary has a direction; once it is stopped
/// what is found means nothing.
pub(super) fn directional(
    boundary: &Boundary,
    lobes: LobeSet,
    rays: Rays,
    watch: Watch<'_>,
) -> Option<Directional> {
    let anisotropy = pattern(boundary)?;
    let rays = Rays { count: rays.count.min(MOST_RAYS), ..rays };
    let beams = match boundary {
        Boundary::Traced(traced) => {
            bins::beams(&Heeding { boundary: traced, watch }, traced.eta().get(), None, rays)
        }
        Boundary::Hybrid(hybrid) => {
            bins::beams(&Heeding { boundary: &**hybrid, watch }, hybrid.eta().get(), None, rays)
        }
        _ => return Some(Directional { anisotropy, percent: None }),
    };
    let wanted = |beam: &&bins::Beam| lobes.contains(LobeSet::of(beam.side, beam.lobe));
    let worst = beams.iter().filter(wanted).map(|beam| beam.spread).fold(0.0, f64::max);
    (worst > ALIKE).then_some(Directional { anisotropy, percent: Some(100.0 * worst) })
}
