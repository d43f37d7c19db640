//! Light on the detector by Monte Carlo, in pieces that take a few milliseconds.
//!
//! The rays of an incidence depend on the seed and the incidence alone, and their light is added up in
//! their order. So the light at one angle is the same bits whether it is asked for alone or with others.

use asperity_core::bsdf::{Ggx, Normals, Scatter, Scattered, Smooth};
use asperity_core::direction::Direction;
use asperity_core::gonio::{Goniophotometer, incidence};
use asperity_core::math::Real;
use asperity_core::plate::Plate;
use asperity_core::protocol::{Microdegrees, Segment};
use asperity_core::quantity::{Alpha, RelativeIor};
use rand_pcg::Pcg32;

use crate::config::{Boundary, Config};

/// Most rays traced in one call.
pub(crate) const CHUNK: u32 = 256;

/// The rough face, ready to scatter: one type for all kinds, so that the plate is compiled once.
enum Face<'a> {
    Ggx(Ggx<f32>),
    Normals(&'a Normals<f32, 64>),
    Smooth(Smooth<f32>),
}

impl Scatter<f32> for Face<'_> {
    fn sample(
        &self,
        wi: Direction<f32>,
        uniform: &mut impl FnMut() -> f32,
    ) -> Option<Scattered<f32>> {
        match self {
            Self::Ggx(law) => law.sample(wi, uniform),
            Self::Normals(law) => law.sample(wi, uniform),
            Self::Smooth(law) => law.sample(wi, uniform),
        }
    }
}

/// `None` if a number is outside its domain.
fn plate(config: &Config) -> Option<Plate<Face<'_>, f32>> {
    let eta = RelativeIor::new(config.ior).ok()?;
    let face = match &config.boundary {
        Boundary::Ggx(alpha) => Face::Ggx(Ggx::new(Alpha::new(*alpha).ok()?, eta)),
        Boundary::Normals(law) => Face::Normals(law),
        Boundary::Smooth => Face::Smooth(Smooth { eta }),
    };
    Some(Plate::new(face, eta, config.rough_side))
}

/// The angles at which the detector receives a ray, in microdegrees, both ends included.
///
/// Whole numbers: a ray belongs to a point of a grid exactly if it belongs to the same angle alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reach {
    from: i32,
    to: i32,
}

impl Reach {
    fn new(from_deg: f32, to_deg: f32) -> Self {
        Self { from: -((-from_deg * 1e6).floor() as i32), to: (to_deg * 1e6).floor() as i32 }
    }

    /// Whether the detector at this angle receives the ray.
    pub(crate) fn holds(self, angle: i32) -> bool {
        self.from <= angle && angle <= self.to
    }

    /// The points of a grid that receive it, up to `count`.
    fn points(self, start: i32, step: i32, count: usize) -> core::ops::Range<usize> {
        let steps = |x: i32| i64::from(x) - i64::from(start);
        let step = i64::from(step.max(1));
        // the first point not below `from`, and the first above `to`
        let first = -(-steps(self.from)).div_euclid(step);
        let end = steps(self.to).div_euclid(step) + 1;
        let index = |k: i64| usize::try_from(k).unwrap_or(0).min(count);
        index(first)..index(end).max(index(first))
    }
}

/// The detector's angles during a scan: the grid, but for the first points while the arm hangs back.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Angles {
    pub(crate) segment: Segment,
    /// Where the arm is at the first point wanted, microdegrees; never below that point.
    pub(crate) first_arm: i32,
}

impl Angles {
    /// Encoder position of a point, microdegrees; the segment has been checked to lie on the axis.
    pub(crate) fn encoder(&self, index: u16) -> Microdegrees {
        let way = i64::from(self.segment.step.0) * i64::from(index);
        Microdegrees((i64::from(self.segment.start.0) + way) as i32)
    }

    /// Where the arm is at a point: the motor goes upwards and takes it along.
    pub(crate) fn arm(&self, index: u16) -> i32 {
        self.encoder(index).0.max(self.first_arm)
    }

    /// Adds a ray to the points that receive it.
    pub(crate) fn add(&self, reach: Reach, flux: f32, sums: &mut [f32]) {
        let Segment { start, step, count, first, .. } = self.segment;
        let (first, count) = (usize::from(first), usize::from(count));
        // points below `free` are read at `first_arm`
        let below = Reach { from: i32::MIN, to: self.first_arm };
        let free = below.points(start.0, step.0, count).end.max(first);
        let mut give = |points: core::ops::Range<usize>| {
            for sum in sums.get_mut(points).unwrap_or(&mut []) {
                *sum += flux;
            }
        };
        if reach.holds(self.first_arm) {
            give(first..free);
        }
        let points = reach.points(start.0, step.0, count);
        if points.end > free {
            give(points.start.max(free)..points.end);
        }
    }
}

/// The rays of one incidence, to be traced a chunk at a time.
#[derive(Clone, Debug)]
pub(crate) struct Tracing {
    generator: Pcg32,
    sigma: Microdegrees,
    aperture: Microdegrees,
    left: u32,
}

impl Tracing {
    pub(crate) fn new(config: &Config, sigma: Microdegrees, aperture: Microdegrees) -> Self {
        let generator = Pcg32::new(config.seed, u64::from(sigma.0.cast_unsigned()));
        Self { generator, sigma, aperture, left: config.rays }
    }

    /// Traces up to [`CHUNK`] rays; `receive` gets the reach and the share of the beam of each part that
    /// leaves the plate towards the detector's plane. True when all are done.
    pub(crate) fn chunk(&mut self, config: &Config, receive: &mut impl FnMut(Reach, f32)) -> bool {
        let Some(plate) = plate(config) else { return true };
        let aperture_deg = self.aperture.0 as f32 / 1e6;
        let cone = Goniophotometer { aperture_deg, geometry: config.geometry }.cone();
        let wi = incidence(self.sigma.0 as f32 / 1e6 * f32::PI / 180.0);
        let weight = 1.0 / config.rays.max(1) as f32;
        let now = self.left.min(CHUNK);
        for _ in 0..now {
            plate.trace(wi, &mut || f32::uniform(&mut self.generator), &mut |wo, flux| {
                if let Some((from, to)) = cone.angles(wo) {
                    receive(Reach::new(from, to), flux * weight);
                }
            });
        }
        self.left -= now;
        self.left == 0
    }
}

#[cfg(test)]
mod tests {
    use super::{Angles, Reach, Tracing};
    use crate::config::{Boundary, Config};
    use asperity_core::bsdf::Ggx;
    use asperity_core::gonio::{AngleGrid, Goniophotometer, Scan};
    use asperity_core::plate::{Plate, RoughSide};
    use asperity_core::protocol::{Microdegrees, Segment};
    use asperity_core::quantity::{Alpha, RelativeIor};
    use rand_pcg::Pcg32;
    use std::vec;
    use std::vec::Vec;

    fn segment(start: i32, step: i32, count: u16, first: u16) -> Segment {
        let (start, step) = (Microdegrees(start), Microdegrees(step));
        Segment { segment: 1, start, step, count, first, credit: 1 }
    }

    fn sums(config: &Config, sigma: i32, angles: &Angles) -> Vec<f32> {
        let mut sums = vec![0.0; usize::from(angles.segment.count)];
        let mut tracing = Tracing::new(config, Microdegrees(sigma), Microdegrees(600_000));
        while !tracing.chunk(config, &mut |reach, flux| angles.add(reach, flux, &mut sums)) {}
        sums
    }

    fn alone(config: &Config, sigma: i32, arm: i32) -> f32 {
        let mut sum = 0.0;
        let mut tracing = Tracing::new(config, Microdegrees(sigma), Microdegrees(600_000));
        while !tracing.chunk(config, &mut |reach, flux| {
            if reach.holds(arm) {
                sum += flux;
            }
        }) {}
        sum
    }

    #[test]
    fn a_grid_and_single_angles_agree_on_every_membership() {
        let (start, step, count) = (-70, 10, 15);
        for from in -90..90 {
            for to in from - 2..90 {
                let reach = Reach { from, to };
                let points = reach.points(start, step, count);
                for k in 0..count {
                    let angle = start + step * k as i32;
                    assert_eq!(points.contains(&k), reach.holds(angle), "{from} {to} {k}");
                }
            }
        }
    }

    #[test]
    fn a_point_is_the_same_bits_alone_and_in_any_grid() {
        let config = Config { rays: 10_000, ..Config::demo() };
        let whole = segment(-90_000_000, 500_000, 361, 0);
        let all = sums(&config, 30_000_000, &Angles { segment: whole, first_arm: -90_000_000 });
        assert!(all.iter().filter(|&&x| x > 0.0).count() > 50);
        for (k, x) in all.iter().enumerate().step_by(7) {
            let arm = -90_000_000 + 500_000 * k as i32;
            assert_eq!(x.to_bits(), alone(&config, 30_000_000, arm).to_bits(), "{k}");
        }
        let rest = Segment { first: 200, ..whole };
        let part = sums(&config, 30_000_000, &Angles { segment: rest, first_arm: 10_000_000 });
        assert!(part[..200].iter().all(|x| x.to_bits() == 0) && part[200..] == all[200..]);
    }

    #[test]
    fn while_the_arm_hangs_back_points_see_where_it_is() {
        let config = Config { rays: 3000, ..Config::demo() };
        let grid = segment(28_000_000, 20_000, 100, 3);
        // the arm is two and a half steps above the first point
        let angles = Angles { segment: grid, first_arm: 28_110_000 };
        let got = sums(&config, 30_000_000, &angles);
        for k in 3..100_u16 {
            let arm = (28_000_000 + 20_000 * i32::from(k)).max(28_110_000);
            assert_eq!(angles.arm(k), arm);
            let expected = alone(&config, 30_000_000, arm);
            assert_eq!(got[usize::from(k)].to_bits(), expected.to_bits(), "{k}");
        }
    }

    #[test]
    fn it_is_the_instrument_of_core() {
        let config = Config { rays: 4000, ..Config::demo() };
        let segment = segment(-90_000_000, 1_000_000, 181, 0);
        let got = sums(&config, 30_000_000, &Angles { segment, first_arm: -90_000_000 });
        let eta = RelativeIor::new(1.49_f32).unwrap();
        let plate = Plate::new(Ggx::new(Alpha::new(0.2).unwrap(), eta), eta, RoughSide::Source);
        let grid = AngleGrid { start_deg: -90.0, step_deg: 1.0, count: 181 };
        let mut rays = Pcg32::new(config.seed, 30_000_000);
        let scan: Scan<f32, 181> =
            Goniophotometer::gp200().scan(&plate, 30.0, grid, 4000, &mut rays);
        // a ray on the very rim may fall on either side of it
        for (a, b) in got.iter().zip(scan.readings()) {
            assert!((a - b).abs() < 1.5 / 4000.0, "{a} {b}");
        }
        assert!(
            got.iter().zip(scan.readings()).filter(|(a, b)| a.to_bits() != b.to_bits()).count() < 5
        );
    }

    #[test]
    fn every_kind_of_face_scatters_and_a_wild_one_is_black() {
        use asperity_core::ndf::law::{Law, Profile};
        let config = Config { rays: 2000, ..Config::demo() };
        let law = Law::new(Profile::Gauss, 0.1, 2.0, 0.0).unwrap();
        let smooth = Config { boundary: Boundary::Smooth, ..config };
        assert!(alone(&smooth, 0, 0) > 0.9 && alone(&smooth, 0, 301_000).to_bits() == 0);
        assert!(alone(&config.with_normals(law).unwrap(), 0, 0) > 1e-3);
        assert!(alone(&config, 0, 0) > 1e-4);
        let wild = Config { boundary: Boundary::Ggx(-1.0), ..config };
        assert!(alone(&wild, 0, 0).to_bits() == 0);
        assert!(Config { ior: 99.0, ..config }.with_normals(law).is_none());
    }
}
