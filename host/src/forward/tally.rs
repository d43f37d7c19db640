//! What the detectors of one incidence count of rays, and how far it scatters.

use asperity_core::direction::Direction;
use asperity_core::gonio::{Cone, Goniophotometer};

use super::{Incidence, Setup, solid_angle};
use crate::measurement::Quantity;

/// The detectors of one incidence.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detectors<'a> {
    cone: Cone<f64>,
    pub(super) angles: &'a Incidence,
    /// The first angle, and how many there are to a degree.
    start: f64,
    per_degree: f64,
}

impl<'a> Detectors<'a> {
    pub(super) fn of(setup: &Setup, angles: &'a Incidence) -> Self {
        let gonio = Goniophotometer { aperture_deg: setup.aperture_deg, geometry: setup.geometry };
        let theta = &angles.theta_deg;
        let (start, end) = theta.first().zip(theta.last()).map_or((0.0, 0.0), |(a, b)| (*a, *b));
        let steps = theta.len().saturating_sub(1) as f64;
        let per_degree = if end > start { steps / (end - start) } else { 0.0 };
        Self { cone: gonio.cone(), angles, start, per_degree }
    }

    /// The detectors that light leaving along `wo` reaches.
    #[inline]
    pub(super) fn reached(&self, wo: Direction<f64>) -> std::ops::Range<usize> {
        let Some((from, to)) = self.cone.angles(self.angles.turned_back(wo)) else { return 0..0 };
        let theta = &self.angles.theta_deg[..];
        let first = self.first_from(from);
        first..first + theta[first..].iter().take_while(|t| **t <= to).count()
    }

    /// The first detector at or beyond an angle: where evenly spaced ones have it, else by halving.
    #[inline]
    fn first_from(&self, from: f64) -> usize {
        let theta = &self.angles.theta_deg[..];
        let guess = ((from - self.start) * self.per_degree).ceil().clamp(0.0, theta.len() as f64);
        for guess in [guess as usize, guess as usize + 1] {
            let is_beyond = theta.get(guess).is_none_or(|t| *t >= from);
            if is_beyond && (guess == 0 || theta.get(guess - 1).is_some_and(|t| *t < from)) {
                return guess;
            }
        }
        theta.partition_point(|t| *t < from)
    }

    /// Readings of relative flux in the aperture as the setup states them; 0 where the cosine vanishes.
    pub(super) fn read(&self, setup: &Setup, flux: impl Iterator<Item = f64>) -> Vec<f64> {
        let scale = |theta_deg: f64| match setup.quantity {
            Quantity::Flux => 1.0,
            Quantity::Bsdf => {
                let cosine = theta_deg.to_radians().cos();
                if cosine > 1e-9 { 1.0 / (solid_angle(setup.aperture_deg) * cosine) } else { 0.0 }
            }
        };
        flux.zip(&self.angles.theta_deg).map(|(flux, theta)| flux * scale(*theta)).collect()
    }
}

/// Sums of the flux of rays, one number per detector.
#[derive(Clone, Debug)]
pub(super) struct Sums {
    /// Of either half of the rays: every other pair of neighbours.
    pub(super) flux: [Vec<f64>; 2],
    /// Squares of the differences of neighbouring rays.
    pub(super) variance: Vec<f64>,
}

impl Sums {
    pub(super) fn none(count: usize) -> Self {
        Self { flux: [vec![0.0; count], vec![0.0; count]], variance: vec![0.0; count] }
    }

    pub(super) fn add(&mut self, other: &Self) {
        let add = |to: &mut [f64], from: &[f64]| {
            for (a, b) in to.iter_mut().zip(from) {
                *a += b;
            }
        };
        for (half, more) in self.flux.iter_mut().zip(&other.flux) {
            add(half, more);
        }
        add(&mut self.variance, &other.variance);
    }
}

impl Sums {
    /// Readings of so many rays on top of light that is known, relative flux a detector.
    pub(super) fn read(
        &self,
        (detectors, setup): (&Detectors<'_>, &Setup),
        known: &[f64],
        rays: f64,
    ) -> OfRays {
        let [a, b] = &self.flux;
        let of = |flux: &mut dyn Iterator<Item = f64>, rays: f64| {
            detectors.read(setup, flux.zip(known).map(|(flux, known)| known + flux / rays))
        };
        // what rays take away of what is known may by chance be more than there is
        let values = of(&mut a.iter().zip(b).map(|(a, b)| a + b), rays);
        OfRays {
            values: values.into_iter().map(|value| value.max(0.0)).collect(),
            halves: [a, b].map(|half| of(&mut half.iter().copied(), 0.5 * rays)),
            std_errors: detectors.read(setup, self.variance.iter().map(|v| v.sqrt() / rays)),
        }
    }
}

/// Readings of rays.
#[derive(Clone, Debug)]
pub(super) struct OfRays {
    pub(super) values: Vec<f64>,
    /// Of either half of the rays.
    pub(super) halves: [Vec<f64>; 2],
    pub(super) std_errors: Vec<f64>,
}

/// Counts rays, in pairs of neighbours.
#[derive(Debug)]
pub(super) struct Tally<'a> {
    detectors: &'a Detectors<'a>,
    pub(super) sums: Sums,
    /// What a pair of neighbours gave: the difference at every detector one of them reached.
    pair: Vec<(usize, f64)>,
    is_second: bool,
    half: usize,
}

impl<'a> Tally<'a> {
    pub(super) fn new(detectors: &'a Detectors<'a>) -> Self {
        let sums = Sums::none(detectors.angles.theta_deg.len());
        Self { detectors, sums, pair: Vec::new(), is_second: false, half: 0 }
    }

    /// Counts a part of a ray that leaves along `wo`.
    #[inline]
    pub(super) fn receive(&mut self, wo: Direction<f64>, flux: f64) {
        let signed = if self.is_second { -flux } else { flux };
        for at in self.detectors.reached(wo) {
            self.sums.flux[self.half][at] += flux;
            match self.pair.iter_mut().find(|entry| entry.0 == at) {
                Some(entry) => entry.1 += signed,
                None => self.pair.push((at, signed)),
            }
        }
    }

    /// The ray has given all.
    #[inline]
    pub(super) fn end_ray(&mut self) {
        if self.is_second {
            for (at, difference) in self.pair.drain(..) {
                self.sums.variance[at] += difference * difference;
            }
            self.half = 1 - self.half;
        }
        self.is_second = !self.is_second;
    }
}
