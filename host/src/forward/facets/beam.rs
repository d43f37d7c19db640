//! The light that first meets the rough face, and what the detectors see of it after a single facet.

use asperity_core::direction::{Direction, Side};
use asperity_core::gonio::{Geometry, incidence};
use asperity_core::plate::{Plate, RoughSide};

use crate::forward::{Sample, Setup};
use crate::raytrace::{Smooth, Spot, TracedBoundary, to_double};

/// A beam where it first meets the rough face of a plate.
///
/// Behind a facet light is refracted or reflected; with the rough face in front or behind, and a detector on either side, only
/// one of the two can be seen without a second facet: the refracted light in transmission, the reflected in reflection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam<'a> {
    plate: Plate<&'a TracedBoundary, f64>,
    facets: Smooth,
    /// Where it comes from, seen from the rough face.
    pub(super) wi: Direction<f32>,
    /// Whether that is the air.
    pub(super) above: bool,
    /// Its flux.
    pub(super) flux: f64,
    /// What a smooth face in front reflects: its direction and its flux.
    pub(super) mirrored: Option<(Direction<f64>, f64)>,
    /// Whether the refracted light is seen, else the reflected.
    pub(super) sees_refracted: bool,
}

/// Light that leaves a facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Branch {
    /// Where it goes, seen from the rough face.
    pub(super) to: Direction<f32>,
    /// Whether it is in the air then.
    pub(super) above: bool,
    /// Its share of the light.
    pub(super) share: f64,
}

/// Light that has reached the smooth face from inside, or has left at the rough one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parted {
    /// The part that leaves: its direction in the frame of the plate, and its share.
    pub(super) gone: Option<(Direction<f64>, f64)>,
    /// The part that comes back to the rough face: whence, and its share.
    pub(super) back: Option<(Direction<f64>, f64)>,
}

impl<'a> Beam<'a> {
    /// The beam of an incidence; `None` if it does not reach the rough face of a plate.
    pub(super) fn of(boundary: &'a TracedBoundary, setup: &Setup, sigma_deg: f64) -> Option<Self> {
        let Sample::Plate { eta, rough_side } = setup.sample else { return None };
        let plate = Plate::new(boundary, eta, rough_side);
        let wi = incidence(sigma_deg.to_radians());
        let (from, flux, mirrored) = match rough_side {
            RoughSide::Source => (wi, 1.0, None),
            RoughSide::Detector => {
                let f = plate.smooth.fresnel(wi);
                let inside = plate.smooth.refract(wi)?;
                let mirrored = (plate.smooth.reflect(wi), f.reflected);
                (inside.opposite().turned_over(), f.transmitted, Some(mirrored))
            }
        };
        let above = from.side()? == Side::Air;
        let [x, y, z] = from.xyz().map(|c| c as f32);
        let wi = Direction::from_unit(x, y, z);
        wi.side()?;
        let sees_refracted = setup.geometry == Geometry::Transmission;
        let facets = Smooth::new(boundary.eta());
        Some(Self { plate, facets, wi, above, flux, mirrored, sees_refracted })
    }

    /// A direction of the rough face's frame in that of the plate, and back.
    fn turned(&self, w: Direction<f64>) -> Direction<f64> {
        match self.plate.rough_side {
            RoughSide::Source => w,
            RoughSide::Detector => w.turned_over(),
        }
    }

    /// A horizontal direction of the plate's frame in that of the rough face.
    pub(super) fn across(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [x, y, _] = self.turned(Direction::from_unit(x, y, 0.0)).xyz();
        [x, y]
    }

    /// The refracted and the reflected light of a facet that the beam meets on its own side.
    #[inline]
    pub(super) fn branches(&self, m: Direction<f32>) -> [Option<Branch>; 2] {
        let (reflected, through) = self.facets.split(self.wi, m, self.above);
        let reflected = f64::from(reflected);
        let refracted = |to| Branch { to, above: !self.above, share: 1.0 - reflected };
        let to = self.wi.reflect(m);
        [through.map(refracted), Some(Branch { to, above: self.above, share: reflected })]
    }

    /// Light that goes along `wo` from the rough face.
    #[inline]
    pub(super) fn part(&self, wo: Direction<f64>) -> Parted {
        if wo.side() == Some(Side::Air) {
            return Parted { gone: Some((self.turned(wo), 1.0)), back: None };
        }
        let arriving = self.turned(wo).opposite();
        let (share, gone) = self.plate.through_the_smooth_face(arriving);
        let [x, y, z] = arriving.xyz();
        let back = self.turned(Direction::from_unit(-x, -y, z).opposite());
        Parted { gone: gone.map(|w| (w, share)), back: Some((back, 1.0 - share)) }
    }

    /// Where the light that detectors may see leaves the plate after one facet alone, and its share: as if nothing else of the
    /// surface were in its way.
    #[inline]
    pub(super) fn seen(&self, spot: &Spot) -> Option<(Direction<f64>, f64)> {
        let branch = self.branches(spot.normal())[usize::from(!self.sees_refracted)]?;
        let is_above = branch.to.side()? == Side::Air;
        if is_above != branch.above {
            return None;
        }
        let (wo, share) = self.part(to_double(branch.to)).gone?;
        Some((wo, share * branch.share))
    }

    /// How much of the beam a facet takes up for its area in the plane; negative if it looks away.
    #[inline]
    pub(super) fn taken_up(&self, slope: [f32; 2]) -> f64 {
        let [x, y, z] = self.wi.xyz().map(f64::from);
        let [gx, gy] = slope.map(f64::from);
        1.0 - (x * gx + y * gy) / z
    }

    /// What facets do to light.
    pub(super) fn facets(&self) -> &Smooth {
        &self.facets
    }

    pub(super) fn plate(&self) -> &Plate<&'a TracedBoundary, f64> {
        &self.plate
    }
}
