//! Laws that can be sampled, and how finely.

use crate::interpolation::Interpolation;
use crate::sampled::{Band, Lobe, SampledBsdf, Side, Symmetry};

/// Values to be sampled: one lobe of one side.
pub trait Law: Sync {
    /// BSDF, 1/sr, at an incidence and an outgoing direction, absolute angles as of the crate.
    fn value(&self, incidence: [f64; 2], out: [f64; 2]) -> f64;

    /// Scattered fraction of the flux where it is known better than by a sum over the grid.
    fn flux(&self, incidence: [f64; 2]) -> Option<f64> {
        let _ = incidence;
        None
    }

    /// Whether values have the grain of counted rays: nodes are then means over the directions they stand for, scaled to the flux.
    fn has_grain(&self) -> bool {
        false
    }
}

/// What a law is the law of.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The side the light comes from.
    pub side: Side,
    /// What becomes of it.
    pub lobe: Lobe,
    /// Index of the dielectric over that of air; `None` of an opaque body.
    pub index: Option<f64>,
    /// Symmetry.
    pub symmetry: Symmetry,
    /// The light.
    pub band: Band,
    /// Lines of provenance.
    pub notes: Vec<String>,
    /// Coherent fraction of the flux at its largest incidence: formats of scatter alone cannot hold it.
    pub coherent: f64,
    /// The closed form, for programs that have it themselves.
    pub closed: Option<Closed>,
}

impl Subject {
    /// The lobe without incidences, for a reader that interpolates by a rule.
    pub(crate) fn empty(&self, interpolation: Interpolation) -> SampledBsdf {
        SampledBsdf {
            side: self.side,
            lobe: self.lobe,
            index: self.index,
            symmetry: self.symmetry,
            bands: vec![self.band.clone()],
            interpolation,
            incidences: Vec::new(),
            has_level: true,
            notes: self.notes.clone(),
        }
    }
}

/// A law that other programs know by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Closed {
    /// GGX facets of width alpha on a dielectric, separable masking.
    Ggx {
        /// Width.
        alpha: f64,
    },
}

/// How finely a law is sampled.
#[derive(Clone, Debug)]
pub struct Options {
    /// Incidences, polar angle and azimuth.
    pub incidences: Vec<[f64; 2]>,
    /// Largest error between nodes, of the peak of the incidence.
    pub tolerance: f64,
    /// Largest relative error of the flux.
    pub flux_tolerance: f64,
    /// Smallest distance of nodes, radians: that of the data behind the law, or 0.
    pub resolution: f64,
    /// Most nodes of all incidences.
    pub most_nodes: usize,
    /// Whether a lobe narrower than the patches of a fixed grid is written all the same.
    pub accept: bool,
}

impl Default for Options {
    fn default() -> Self {
        let steps = (0..=17).map(|k| [f64::from(5 * k).to_radians(), 0.0]);
        Self {
            incidences: steps.collect(),
            tolerance: 0.005,
            flux_tolerance: 0.001,
            resolution: 0.0,
            most_nodes: 4_000_000,
            accept: false,
        }
    }
}

/// Coordinates of a format's outgoing directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinates {
    /// Absolute angles.
    Absolute,
    /// About the specular or direct ray; incidences without one are left out.
    Specular,
    /// Differences of direction cosines to those of that ray; the same.
    Cosines,
}

/// A grid of a format.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Its coordinates.
    pub coordinates: Coordinates,
    /// Whether each incidence has a grid of its own.
    pub own_grids: bool,
    /// How the reader interpolates.
    pub interpolation: Interpolation,
}

/// A law as a table can hold it: towards grazing some laws without masking grow as 1 / cos, without end. Nearer to the horizon than 0.2
/// degrees a value is at most twice the one there.
#[derive(Clone, Copy)]
pub(crate) struct Capped<'a>(pub(crate) &'a dyn Law);

/// 89.8 degrees.
const GRAZING: f64 = std::f64::consts::FRAC_PI_2 - 0.2 * std::f64::consts::PI / 180.0;

impl Law for Capped<'_> {
    fn value(&self, incidence: [f64; 2], out: [f64; 2]) -> f64 {
        let is = self.0.value(incidence, out);
        if out[0] <= GRAZING {
            is
        } else {
            is.min(2.0 * self.0.value(incidence, [GRAZING, out[1]]))
        }
    }

    fn flux(&self, incidence: [f64; 2]) -> Option<f64> {
        self.0.flux(incidence)
    }

    fn has_grain(&self) -> bool {
        self.0.has_grain()
    }
}
