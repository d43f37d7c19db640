//! A height map whose long waves are traced and whose short ones diffract.

use std::sync::Arc;

use asperity_core::bsdf::{Scatter, Scattered};
use asperity_core::direction::Direction;
use asperity_core::quantity::RelativeIor;

use super::scales::{Scales, cutoff_um};
use crate::kirchhoff::{ByFlux, Speckle, WaveBoundary, WaveOptions, Wavelengths};
use crate::raytrace::{Facet, Field, FieldError, TracedBoundary, Turned};
use crate::surface::spectrum::Anisotropy;
use crate::surface::split::split;
use crate::surface::{Edges, HeightMap, Roughness, Spectrum};

/// The boundary. One split, by the `q_z` of transmission, serves all lobes. Its speckle is always averaged: the short waves are known to it by their statistics.
#[derive(Clone, Debug)]
pub struct HybridBoundary {
    parts: Parts,
    scales: Scales,
    map: Arc<HeightMap>,
    edges: Edges,
    eta: RelativeIor<f64>,
    wavelengths: Wavelengths,
}

/// What there is of the two.
#[derive(Clone, Debug)]
enum Parts {
    /// No short waves.
    Rays(TracedBoundary),
    /// No long waves.
    Waves(Box<ByFlux>),
    /// The long map, and the law of its facets.
    Both(Arc<Field>, Box<ByFlux>),
}

/// `(q_z sigma)^2` of what does nothing to light: a part in a thousand of it.
const NOTHING: f64 = 1e-3;

impl HybridBoundary {
    /// Splits a map where its own heights and the light say.
    ///
    /// # Errors
    /// [`FieldError`] if points are missing or the map cannot be traced.
    pub fn of_map(
        map: &HeightMap,
        edges: Edges,
        eta: RelativeIor<f64>,
        options: &WaveOptions,
    ) -> Result<Self, FieldError> {
        let cutoff = cutoff_um(map, edges, eta, &options.wavelengths);
        let cutoff = cutoff.map_err(|_| missing(map))?;
        Self::with_cutoff(map, edges, eta, options, cutoff)
    }

    /// Splits a map at a given wavelength in um: all is short without one, all is long with 0.
    ///
    /// # Errors
    /// [`FieldError`] if points are missing or the map cannot be traced.
    pub fn with_cutoff(
        map: &HeightMap,
        edges: Edges,
        eta: RelativeIor<f64>,
        options: &WaveOptions,
        cutoff_um: Option<f64>,
    ) -> Result<Self, FieldError> {
        let incomplete = |_| missing(map);
        let options = WaveOptions { speckle: Speckle::Averaged, ..options.clone() };
        let waves = |map: &HeightMap| {
            let law = WaveBoundary::of_map(map, edges, eta, &options).map_err(incomplete)?;
            Ok::<_, FieldError>(Box::new(ByFlux::new(law)))
        };
        let most =
            2.0 * eta.get().max(1.0) * std::f64::consts::TAU / options.wavelengths.shortest_um();
        let matters = |rq_um: f64| (most * rq_um).powi(2) > NOTHING;
        let rq = |map: &HeightMap| Roughness::of(map).rq_um;
        let (parts, scales) = match cutoff_um {
            None => {
                let scales = Scales { cutoff_um, long_um: 0.0, short_um: rq(map) };
                (Parts::Waves(waves(map)?), scales)
            }
            Some(cutoff) => {
                let (long, short) = split(map, edges, cutoff).map_err(incomplete)?;
                let (long_um, short_um) = (rq(&long), rq(&short));
                if !matters(short_um) {
                    let field = Arc::new(Field::new(map, edges)?);
                    let scales = Scales { cutoff_um, long_um: rq(map), short_um: 0.0 };
                    (Parts::Rays(TracedBoundary { field, eta }), scales)
                } else if matters(long_um) {
                    let field = Arc::new(Field::new(&long, edges)?);
                    (Parts::Both(field, waves(&short)?), Scales { cutoff_um, long_um, short_um })
                } else {
                    let scales = Scales { cutoff_um: None, long_um: 0.0, short_um: rq(map) };
                    (Parts::Waves(waves(map)?), scales)
                }
            }
        };
        let (map, wavelengths) = (Arc::new(map.clone()), options.wavelengths);
        Ok(Self { parts, scales, map, edges, eta, wavelengths })
    }

    /// Where the map is split.
    pub fn scales(&self) -> &Scales {
        &self.scales
    }

    /// Index of the dielectric over that of air.
    pub fn eta(&self) -> RelativeIor<f64> {
        self.eta
    }

    /// The light.
    pub fn wavelengths(&self) -> &Wavelengths {
        &self.wavelengths
    }

    /// The anisotropy of the slopes of its surface; `None` without slopes.
    pub fn anisotropy(&self) -> Option<Anisotropy> {
        Spectrum::of(&self.map, self.edges).ok()?.anisotropy()
    }

    /// The whole map, and how it goes on.
    pub fn surface(&self) -> (&HeightMap, Edges) {
        (&self.map, self.edges)
    }

    /// The split of the map, and where the law of its short waves does not hold.
    pub fn warnings(&self, incidences_deg: &[f64]) -> Vec<String> {
        let short = match &self.parts {
            Parts::Rays(_) => None,
            Parts::Waves(short) | Parts::Both(_, short) => {
                short.law().validity(incidences_deg).ok()
            }
        };
        let words = short.map(|v| v.warnings()).unwrap_or_default();
        std::iter::once(self.scales.text()).chain(words).collect()
    }
}

fn missing(map: &HeightMap) -> FieldError {
    FieldError::Missing(100.0 * map.missing_fraction())
}

/// A facet with short waves on it.
struct Rough<'a>(&'a ByFlux);

impl Facet for Rough<'_> {
    fn turn(
        &self,
        from: Direction<f32>,
        m: Direction<f32>,
        above: bool,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Turned> {
        let [x, y, z] = m.xyz().map(f64::from);
        let [fx, fy, fz] = from.xyz().map(f64::from);
        // two tangents of an upward normal; all azimuths of the law are alike
        let a = 1.0 / (1.0 + z);
        let (s, t) = ([1.0 - x * x * a, -x * y * a, -x], [-x * y * a, 1.0 - y * y * a, -y]);
        let dot = |v: [f64; 3]| fx * v[0] + fy * v[1] + fz * v[2];
        let wi = Direction::new(dot(s), dot(t), dot([x, y, z]))?;
        if (wi.z() > 0.0) != above {
            // along the facet, as far as rounding can tell
            return None;
        }
        let Scattered { wo, weight } = self.0.sample(wi, uniform)?;
        let [p, q, r] = wo.xyz();
        let out = |k: usize, m: f64| p * s[k] + q * t[k] + r * m;
        let to = Direction::new(out(0, x) as f32, out(1, y) as f32, out(2, z) as f32)?;
        Some(Turned { to, above: r > 0.0, weight })
    }
}

impl Scatter<f64> for HybridBoundary {
    /// Takes two uniforms for the place on the map and three for each bounce, or what rays or waves alone take. Weights
    /// of the bounces are multiplied and may exceed 1; their mean does not.
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        match &self.parts {
            Parts::Rays(rays) => rays.sample(wi, uniform),
            Parts::Waves(waves) => waves.sample(wi, uniform),
            Parts::Both(field, short) => field.scatter(wi, &Rough(short), uniform),
        }
    }
}
