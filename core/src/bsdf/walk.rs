//! All bounces of light on a rough boundary, by following its path from facet to facet.

use super::facet::{lit, straight};
use super::{Scatter, Scattered};
use crate::direction::{Direction, Side};
use crate::fresnel;
use crate::math::Real;
use crate::ndf::density::Density;
use crate::quantity::RelativeIor;
use crate::scope;

/// A random walk on the microsurface of Smith: the reference for all laws with several bounces
/// \[Heitz et al. 2016\].
///
/// A path is a direction and the share `C` of the surface that lies lower. Of the law of heights only `C` enters: light
/// on its way up passes from `C` to `C (1 - U)^(-1 / Lambda)`, and leaves above 1; on its way down, where Smith's
/// `Lambda` becomes `-1 - Lambda`, it falls to `C (1 - U)^(1 / (1 + Lambda))`. There it meets a facet visible from where
/// it comes, which reflects or refracts it by Fresnel's share. Light that passes the surface sees it from the other
/// side: `C` becomes `1 - C`, and up is down. Every ray has a weight of 1, so that R + T = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walk<T, D> {
    /// Density of the facets.
    pub density: D,
    /// Index of the dielectric over that of the air.
    pub eta: RelativeIor<T>,
}

/// What becomes of a ray between two facets.
enum Flight {
    /// It leaves the surface.
    Escapes,
    /// It meets a facet at this share of heights.
    Meets(f64),
}

impl<T: Real, D: Density<T>> Walk<T, D> {
    /// Facets a ray meets before it counts as lost. On facets of width 1.5 half of the light leaves at every one of
    /// them: nothing is left. Of the widest, 100, less than 1e-3 is.
    pub const MOST_EVENTS: usize = 4096;

    /// A boundary with given facets and index.
    pub fn new(density: D, eta: RelativeIor<T>) -> Self {
        Self { density, eta }
    }

    /// The index of the dielectric over that of the air.
    pub fn eta(&self) -> RelativeIor<T> {
        self.eta
    }

    /// The same boundary in another precision, each parameter rounded once.
    pub fn cast<U: Real>(&self) -> Walk<U, D::In<U>> {
        Walk { density: self.density.cast(), eta: self.eta.cast() }
    }

    /// From the share `lower` onwards, for light from `w`: down if `w` has z > 0.
    fn fly(&self, w: Direction<T>, lower: f64, u: T) -> Flight {
        let left = 1.0 - u.to_f64();
        let lambda = self.density.lambda(w).to_f64();
        if w.z() > T::ZERO {
            return Flight::Meets(lower * Real::pow(left, 1.0 / (1.0 + lambda)));
        }
        if lambda <= 0.0 {
            return Flight::Escapes;
        }
        let reached = lower * Real::pow(left, -1.0 / lambda);
        if reached < 1.0 { Flight::Meets(reached) } else { Flight::Escapes }
    }

    /// One path of light from `wi`, of media that are not matched; `None` after [`Self::MOST_EVENTS`] facets, or in
    /// the surface.
    pub fn walk(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Walked<T>> {
        // In the frame whose z points into the medium of the ray, against its way.
        let mut below = wi.side()? == Side::Dielectric;
        let mut w = over(wi, below);
        let mut lower = 1.0;
        for facets in 0..Self::MOST_EVENTS {
            lower = match self.fly(w, lower, uniform()) {
                Flight::Escapes => return Some(Walked { wo: over(w.opposite(), below), facets }),
                Flight::Meets(height) => Real::max(height, f64::MIN_POSITIVE),
            };
            let m = self.density.sample_facing(w, [uniform(), uniform()]);
            let eta = if below { self.eta.inverse() } else { self.eta.get() };
            let (reflected, through) = fresnel::facet(w, m, eta);
            let choice = uniform();
            w = match through.filter(|_| choice >= reflected) {
                Some(through) => {
                    below = !below;
                    lower = 1.0 - lower;
                    over(through, true).opposite()
                }
                None => w.reflect(m).opposite(),
            };
        }
        None
    }
}

/// Where a path ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walked<T: Real> {
    /// Direction of the ray that leaves, away from the surface.
    pub wo: Direction<T>,
    /// Facets it has met.
    pub facets: usize,
}

impl<T: Real, D: Density<T>> Scatter<T> for Walk<T, D> {
    /// Takes four uniforms for each facet, and one to escape.
    fn sample(&self, wi: Direction<T>, uniform: &mut impl FnMut() -> T) -> Option<Scattered<T>> {
        let side = lit(wi)?;
        if self.eta.is_matched() {
            return straight(wi);
        }
        let wo = self.walk(wi, uniform)?.wo;
        let mirrored = (wo.z() < T::ZERO) == (side == Side::Dielectric);
        scope::lobe(mirrored).then_some(Scattered { wo, weight: T::ONE })
    }
}

/// Mirrored at the mean surface, or not.
fn over<T: Real>(w: Direction<T>, mirror: bool) -> Direction<T> {
    let [x, y, z] = w.xyz();
    Direction::from_unit(x, y, if mirror { -z } else { z })
}
