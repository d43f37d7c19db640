//! One lobe of one side of a surface on a grid.

use crate::frame::{Frame, specular};
use crate::interpolation::Interpolation;

/// The side of the surface the light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// From the air.
    Air,
    /// From inside the material.
    Dielectric,
}

/// What becomes of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobe {
    /// It comes back.
    Reflection,
    /// It goes through.
    Transmission,
}

/// What the values do not depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// The surface may be turned, and left and right of the plane of incidence are equal.
    Isotropic,
    /// The surface may be turned, left and right differ.
    Rotational,
    /// The azimuth of the incidence matters.
    None,
}

/// The light of some values.
#[derive(Clone, Debug, PartialEq)]
pub enum Band {
    /// One wavelength, nm.
    Wavelength(f64),
    /// A named weighting, such as `Visible` or `X`.
    Named(String),
    /// The file does not say.
    Unknown,
}

/// A patch of outgoing directions with one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Absolute polar angle and azimuth of its centre.
    pub centre: [f64; 2],
    /// Integral of the cosine over its solid angle, sr.
    pub projected: f64,
}

/// A product grid of outgoing directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// What the two coordinates mean.
    pub frame: Frame,
    /// First coordinate, ascending.
    pub radii: Vec<f64>,
    /// Azimuths, ascending. Those of a mirrored grid run from 0 to pi; another grid goes round from the last to the first.
    pub azimuths: Vec<f64>,
    /// Whether values at -azimuth are those at azimuth.
    pub mirrored: bool,
}

/// The outgoing directions of an incidence.
#[derive(Clone, Debug, PartialEq)]
pub enum Nodes {
    /// A product grid; values have the radius as the fastest index.
    Grid(Grid),
    /// Single directions, absolute.
    Points(Vec<[f64; 2]>),
    /// Patches that share out the hemisphere.
    Patches(Vec<Patch>),
}

/// The values of one incidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Incidence {
    /// Polar angle, 0 to pi/2.
    pub theta: f64,
    /// Azimuth of the source; the rotation of the sample.
    pub phi: f64,
    /// Where the values are.
    pub nodes: Nodes,
    /// BSDF, 1/sr; band after band, each as long as there are nodes.
    pub values: Vec<f64>,
    /// Scattered fraction of the flux as the file states it, one a band; empty if it does not.
    pub stated: Vec<f64>,
}

/// One lobe of one side.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledBsdf {
    /// The side the light comes from.
    pub side: Side,
    /// What becomes of it.
    pub lobe: Lobe,
    /// Index of the dielectric over that of air; `None` if unknown, or of an opaque body.
    pub index: Option<f64>,
    /// Symmetry.
    pub symmetry: Symmetry,
    /// The light; at least one.
    pub bands: Vec<Band>,
    /// How its reader interpolates between the nodes.
    pub interpolation: Interpolation,
    /// Incidences, ascending by azimuth and then by polar angle.
    pub incidences: Vec<Incidence>,
    /// Whether the level is known: `false` if a file gives the shape alone.
    pub has_level: bool,
    /// What else the file says, line by line: sample, instrument, program.
    pub notes: Vec<String>,
}

impl Nodes {
    /// Number of directions.
    pub fn len(&self) -> usize {
        match self {
            Self::Grid(grid) => grid.radii.len() * grid.azimuths.len(),
            Self::Points(points) => points.len(),
            Self::Patches(patches) => patches.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Absolute polar angle and azimuth of every node, in the order of the values.
    pub fn directions(&self) -> Vec<[f64; 2]> {
        match self {
            Self::Grid(grid) => grid.directions(),
            Self::Points(points) => points.clone(),
            Self::Patches(patches) => patches.iter().map(|patch| patch.centre).collect(),
        }
    }
}

impl Grid {
    /// Absolute angles of every node, the radius fastest; polar angles beyond pi/2 are below the horizon.
    pub fn directions(&self) -> Vec<[f64; 2]> {
        let of_azimuth = |a: &f64| {
            let a = *a;
            self.radii.iter().map(move |r| self.frame.absolute([*r, a]))
        };
        self.azimuths.iter().flat_map(of_azimuth).collect()
    }
}

impl SampledBsdf {
    /// Index on the side of the incident light over that of the outgoing light; 1 where no index is known.
    pub fn ratio(&self) -> f64 {
        match (self.lobe, self.side, self.index) {
            (Lobe::Reflection, ..) | (_, _, None) => 1.0,
            (_, Side::Air, Some(n)) => 1.0 / n,
            (_, Side::Dielectric, Some(n)) => n,
        }
    }

    /// Polar angle of the specular or direct ray of an incidence; `None` beyond the critical angle.
    pub fn specular(&self, theta_i: f64) -> Option<f64> {
        specular(theta_i, self.ratio())
    }

    /// The values of a band of an incidence; empty if there is none.
    pub fn band(&self, incidence: usize, band: usize) -> &[f64] {
        let Some(at) = self.incidences.get(incidence) else { return &[] };
        let n = at.nodes.len();
        at.values.get(band * n..(band + 1) * n).unwrap_or(&[])
    }

    /// Largest value of a band of an incidence over the horizon.
    pub fn peak(&self, incidence: usize, band: usize) -> f64 {
        let Some(at) = self.incidences.get(incidence) else { return 0.0 };
        let over = |theta: f64| theta <= std::f64::consts::FRAC_PI_2 + 1e-9;
        let directions = at.nodes.directions();
        let values = self.band(incidence, band).iter().zip(&directions);
        values.filter(|(_, d)| over(d[0])).map(|(v, _)| *v).fold(0.0, f64::max)
    }
}

impl Side {
    /// The word in files and flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Air => "air",
            Self::Dielectric => "dielectric",
        }
    }
}

impl Lobe {
    /// The word in files and flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reflection => "reflection",
            Self::Transmission => "transmission",
        }
    }
}
