//! What a scene says, checked.

use std::path::PathBuf;

/// A scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Its name: that in the file, or that of the file.
    pub name: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// The body with the rough face.
    pub body: Body,
    /// What is known of that face.
    pub surface: Surface,
    /// The light.
    pub source: Source,
    /// What is wanted.
    pub wanted: Wanted,
    /// What evaluates it.
    pub target: Target,
    /// Cuts of the map on which Maxwell's equations are solved for the true errors of rays and waves; the atlas is asked without it.
    pub rigorous: Option<usize>,
}

/// Kinds of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BodyKind {
    /// A sheet: rough on one face, smooth on the other, thinner than a beam is wide.
    Film,
    /// A plate with a rough and a smooth parallel face; all passes between them count.
    Plate,
    /// A plate that is lit at its edge; light travels in it by total reflection.
    LightGuide,
    /// As a plate, but light that is reflected inside does not come back to the rough face.
    Lens,
    /// The rough end of a fibre, which light leaves.
    FibreEnd,
    /// A thing to be rendered: what enters it is absorbed.
    Object,
}

/// A face of a flat body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Face {
    /// Towards the source; of a light guide the upper one.
    Source,
    /// Away from it; of a light guide the lower one.
    Detector,
}

/// What is behind a flat body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Behind {
    /// Air: the far face is a face.
    Air,
    /// Something black in optical contact: light that arrives there is gone.
    Black,
}

/// The body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Its kind.
    pub kind: BodyKind,
    /// Refractive index over that of air, at 587.6 nm where there is a dispersion.
    pub ior: f64,
    /// Abbe number; `None`: no dispersion.
    pub abbe: Option<f64>,
    /// The rough face.
    pub rough: Face,
    /// What is behind it.
    pub behind: Behind,
    /// Thickness of a light guide, mm.
    pub thickness_mm: f64,
    /// Length of a light guide, mm.
    pub length_mm: f64,
}

/// Statistics of a surface that is known by figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistics {
    /// Gaussian slopes: the law of Beckmann.
    Gaussian,
    /// Slopes with the tails of GGX.
    Ggx,
}

/// A surface by figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Rms height, um.
    pub rq_um: Option<f64>,
    /// 1/e autocorrelation length, um.
    pub correlation_um: Option<f64>,
    /// Width of the density of slopes: `sqrt(2)` times the rms slope along a line, for Gaussian slopes.
    pub alpha: f64,
    /// Their statistics.
    pub statistics: Statistics,
}

/// What is known of the rough face.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// Nothing: it has to be measured first.
    Unknown,
    /// Figures.
    Figures(Figures),
    /// A height map.
    Map {
        /// The file.
        file: PathBuf,
        /// Its pixel, where the file does not say it.
        pixel_um: Option<f64>,
    },
    /// A model made by `asperity model` or `asperity fit`.
    Model(PathBuf),
}

/// How directions of the light are spread.
#[derive(Clone, Debug, PartialEq)]
pub enum Emission {
    /// Between two angles of incidence in one plane, evenly; equal for a single beam.
    Collimated([f64; 2]),
    /// Every direction, with the cosine.
    Lambertian,
    /// About an axis at an angle of incidence; half the intensity at this half angle, nothing beyond 80 degrees.
    Cone {
        /// Of the axis, degrees.
        axis_deg: f64,
        /// Degrees.
        half_deg: f64,
    },
    /// Angles of incidence with weights: `[deg, weight]`.
    Histogram(Vec<[f64; 2]>),
}

/// The light.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Its directions; of a light guide about the normal of the edge, of a fibre about its axis, inside.
    pub emission: Emission,
    /// Whether it is a laser: its light keeps its phase over the whole beam.
    pub coherent: bool,
    /// Wavelengths, nm: ends of the band, equal for a line.
    pub wavelength_nm: [f64; 2],
}

/// What is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    /// Share of the light that leaves through a face, within a cone about its normal.
    Flux {
        /// The face.
        face: Face,
        /// Half angle of the cone, degrees; 90 for all.
        half_deg: f64,
    },
    /// Share of the transmitted light that leaves more than 2.5 degrees from its way (ASTM D1003).
    Haze,
    /// Light in a cone about a direction: glare, or the signal of a sensor.
    Cone(Grasp),
    /// Light in cones of 2 degrees at angles of observation from one to another: an image.
    Image {
        /// The face.
        face: Face,
        /// From, to: degrees from the normal, in the plane of incidence.
        observation_deg: [f64; 2],
    },
}

/// A cone that takes light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grasp {
    /// The face it looks at.
    pub face: Face,
    /// Angle of its axis from the normal, degrees.
    pub theta_deg: f64,
    /// Azimuth of its axis from the forward direction in the plane of incidence, degrees.
    pub azimuth_deg: f64,
    /// Half angle, degrees.
    pub half_deg: f64,
}

/// What is wanted, and how exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// The quantity.
    pub quantity: Quantity,
    /// The word for it in the file.
    pub word: &'static str,
    /// Largest error, % of the quantity.
    pub error_percent: f64,
}

/// Programs and devices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetKind {
    /// This library on a computer.
    Host,
    /// A microcontroller.
    CortexM4f,
    /// Zemax.
    Zemax,
    /// Radiance.
    Radiance,
    /// Mitsuba 3.
    Mitsuba,
}

impl TargetKind {
    /// The word in a scene.
    pub fn word(self) -> &'static str {
        match self {
            Self::Host => "host",
            Self::CortexM4f => "cortex-m4f",
            Self::Zemax => "zemax",
            Self::Radiance => "radiance",
            Self::Mitsuba => "mitsuba",
        }
    }

    /// The format of `export` for it.
    pub fn format(self) -> Option<&'static str> {
        match self {
            Self::Host | Self::CortexM4f => None,
            Self::Zemax => Some("zemax"),
            Self::Radiance => Some("tensortree3"),
            Self::Mitsuba => Some("mitsuba"),
        }
    }
}

/// What evaluates the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// Program or device.
    pub kind: TargetKind,
    /// Flash for code and table on a device, bytes.
    pub bytes: usize,
    /// Instructions for a value on a device.
    pub instructions: u32,
}
