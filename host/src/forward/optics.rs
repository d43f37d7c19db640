//! The path in and the path out: from the beam to the rough face, and from it to the detector.

use asperity_core::bsdf::Smooth;
use asperity_core::direction::Direction;
use asperity_core::fresnel;
use asperity_core::gonio::{Geometry, incidence};
use asperity_core::plate::RoughSide;

use super::{Sample, Setup};

/// The beam as it arrives at the rough face for the first time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Where it comes from, in the rough face's frame.
    pub(super) w: Direction<f64>,
    /// Flux of it; 1 is the beam.
    pub(super) flux: f64,
    /// Flux mirrored by the smooth face before the light entered, if that goes to the detector's side.
    pub(super) mirrored: f64,
}

/// A direction of observation in the frame of the rough face.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// Where scattered light must go, in the rough face's frame.
    pub(super) towards: Direction<f64>,
    /// Flux per solid angle outside for unit flux per solid angle that leaves the rough face.
    pub(super) factor: f64,
}

/// The path of the light to the rough face, for an angle of incidence in radians.
pub(super) fn enter(setup: &Setup, sigma: f64) -> Entry {
    let wi = incidence(sigma);
    match setup.sample {
        Sample::Plate { eta, rough_side: RoughSide::Detector } => {
            let smooth = Smooth { eta };
            let f = smooth.fresnel(wi);
            let inside = smooth.refract(wi).unwrap_or(wi.opposite());
            let mirrored = if setup.geometry == Geometry::Reflection { f.reflected } else { 0.0 };
            Entry { w: inside.opposite().turned_over(), flux: f.transmitted, mirrored }
        }
        _ => Entry { w: wi, flux: 1.0, mirrored: 0.0 },
    }
}

/// The path from the rough face to a detector at `wo` (plate frame); `None` if no light arrives there.
///
/// Through the smooth face: `T(theta) cos(theta) / (n^2 cos(theta_t))`, Fresnel's transmittance times the
/// solid angle inside for one outside.
pub(super) fn look(setup: &Setup, wo: Direction<f64>) -> Option<View> {
    let (eta, rough_side) = match setup.sample {
        Sample::Opaque => {
            return (setup.geometry == Geometry::Reflection)
                .then_some(View { towards: wo, factor: 1.0 });
        }
        Sample::Plate { eta, rough_side } => (eta.get(), rough_side),
    };
    let in_rough_frame = |w: Direction<f64>| match rough_side {
        RoughSide::Source => w,
        RoughSide::Detector => w.turned_over(),
    };
    if setup.sees_rough_face() {
        return Some(View { towards: in_rough_frame(wo), factor: 1.0 });
    }
    let [x, y, z] = wo.xyz();
    let (x, y) = (x / eta, y / eta);
    let cos2 = 1.0 - x * x - y * y;
    if cos2 <= 0.0 || z.abs() <= 0.0 {
        return None;
    }
    let cos = cos2.sqrt();
    let transmitted = fresnel::dielectric(z.abs(), eta).transmitted;
    let inside = Direction::from_unit(x, y, cos.copysign(z));
    Some(View {
        towards: in_rough_frame(inside),
        factor: transmitted * z.abs() / (eta * eta * cos),
    })
}
