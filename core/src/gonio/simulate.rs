//! The virtual instrument by Monte Carlo.

use rand_core::Rng;

use super::{AngleGrid, Geometry, Scan, incidence};
use crate::bsdf::Scatter;
use crate::direction::{Direction, Side};
use crate::math::Real;
use crate::plate::{Outcome, Plate};

/// A goniophotometer with a parallel beam and a detector cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goniophotometer<T> {
    /// FULL angle of the detector's cone, degrees.
    pub aperture_deg: T,
    /// Side of the detector.
    pub geometry: Geometry,
}

impl<T: Real> Goniophotometer<T> {
    /// The cone of the detector.
    pub fn cone(&self) -> Cone<T> {
        let side = match self.geometry {
            Geometry::Transmission => Side::Dielectric,
            Geometry::Reflection => Side::Air,
        };
        let half = self.aperture_deg * T::PI / T::from_f64(360.0);
        let sine = half.sin_cos().0;
        Cone { side, sin2: sine * sine }
    }

    /// Adds the readings of `rays` rays, each weighted `1 / rays`, to `readings` (one per grid angle).
    ///
    /// Returns the shares of the flux that were reflected, transmitted and lost, averaged over the rays. `sigma_deg`
    /// is the angle of incidence.
    pub fn simulate<S: Scatter<T>, G: Rng + ?Sized>(
        &self,
        plate: &Plate<S, T>,
        sigma_deg: T,
        grid: &AngleGrid<T>,
        rays: u32,
        generator: &mut G,
        readings: &mut [T],
    ) -> Outcome<T> {
        let (wi, cone) = (incidence(sigma_deg * T::PI / T::from_f64(180.0)), self.cone());
        let weight = T::ONE / T::from_f64(f64::from(rays.max(1)));
        let mut mean = Outcome { reflected: T::ZERO, transmitted: T::ZERO, lost: T::ZERO };
        for _ in 0..rays {
            let one = plate.trace(wi, &mut || T::uniform(generator), &mut |wo, flux| {
                let Some((from, to)) = cone.angles(wo) else { return };
                for reading in readings.get_mut(grid.within(from, to)).unwrap_or(&mut []) {
                    *reading = *reading + flux * weight;
                }
            });
            mean.reflected = mean.reflected + one.reflected * weight;
            mean.transmitted = mean.transmitted + one.transmitted * weight;
            mean.lost = mean.lost + one.lost * weight;
        }
        mean
    }

    /// One incidence of a scan: `rays` rays from a given generator, into storage of a fixed capacity.
    pub fn scan<S: Scatter<T>, G: Rng + ?Sized, const N: usize>(
        &self,
        plate: &Plate<S, T>,
        sigma_deg: T,
        grid: AngleGrid<T>,
        rays: u32,
        generator: &mut G,
    ) -> Scan<T, N> {
        let mut scan = Scan::new(sigma_deg, self.geometry, grid);
        let grid = *scan.grid();
        self.simulate(plate, sigma_deg, &grid, rays, generator, scan.readings_mut());
        scan
    }
}

/// The detector's cone, ready to receive rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone<T> {
    side: Side,
    /// Square of the sine of half the aperture: it keeps the digits that cosines of small angles lose.
    sin2: T,
}

impl<T: Real> Cone<T> {
    /// The first and the last angle of observation, in degrees, whose cone receives a ray leaving
    /// along `wo`; `None` if no angle's cone does.
    ///
    /// With `psi` the ray's angle out of the plane of incidence and `t` its angle in the plane, it is
    /// inside the cone of half angle `a` about `theta` if `cos psi cos(t - theta) >= cos a`.
    #[inline]
    pub fn angles(&self, wo: Direction<T>) -> Option<(T, T)> {
        let [x, y, z] = wo.xyz();
        let y2 = y * y;
        if wo.side() != Some(self.side) || y2 > self.sin2 {
            return None;
        }
        let degrees = T::from_f64(180.0) / T::PI;
        let theta = x.atan2(z.abs()) * degrees;
        // tan^2 delta = (sin^2 a - sin^2 psi) / cos^2 a
        let tan2 = (self.sin2 - y2) / (T::ONE - self.sin2);
        let reach = tan2.sqrt_positive().atan2(T::ONE) * degrees;
        // the rim counts, also where rounding puts an undeviated beam just outside of it
        let reach = reach + reach * T::EPSILON * T::from_f64(1024.0);
        Some((theta - reach, theta + reach))
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]
mod tests {
    use super::Goniophotometer;
    use crate::bsdf::{Ggx, Smooth};
    use crate::gonio::{AngleGrid, Geometry, Scan, observation};
    use crate::plate::{Plate, RoughSide};
    use crate::quantity::{Alpha, RelativeIor};
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn a_smooth_plate_is_seen_at_sigma_with_the_textbook_transmittance() {
        let eta = RelativeIor::new(1.49_f64).unwrap();
        let mut generator = Pcg64Mcg::new(7);
        for side in [RoughSide::Source, RoughSide::Detector] {
            for sigma in [0.0, 30.0, 60.0] {
                let plate = Plate::new(Smooth { eta }, eta, side);
                let scan: Scan<f64, 1801> = Goniophotometer::gp200().scan(
                    &plate,
                    sigma,
                    AngleGrid::gp200(),
                    40_000,
                    &mut generator,
                );
                let f = crate::fresnel::dielectric(sigma.to_radians().cos(), 1.49).reflected;
                // all internal passes of an incoherent plate: (1 - F) / (1 + F)
                let exact = (1.0 - f) / (1.0 + f);
                for (k, &reading) in scan.readings().iter().enumerate() {
                    let away = (scan.grid().degrees(k) - sigma).abs();
                    if away < 0.299 {
                        assert!(
                            (reading - exact).abs() < 4e-3,
                            "{side:?} {sigma} {reading} {exact}"
                        );
                    } else if away > 0.301 {
                        assert!(reading.abs() < 1e-12, "{side:?} {sigma} {k} {reading}");
                    }
                }
            }
        }
    }

    #[test]
    fn every_ray_is_accounted_for_in_both_precisions() {
        let mut generator = Pcg64Mcg::new(11);
        for sigma in [0.0, 45.0, 80.0] {
            for side in [RoughSide::Source, RoughSide::Detector] {
                let eta = RelativeIor::new(1.49_f64).unwrap();
                let plate = Plate::new(Ggx::new(Alpha::new(0.5).unwrap(), eta), eta, side);
                let grid = AngleGrid::gp200();
                let out = Goniophotometer::gp200().simulate(
                    &plate,
                    sigma,
                    &grid,
                    2000,
                    &mut generator,
                    &mut [0.0; 1801],
                );
                assert!((out.reflected + out.transmitted + out.lost - 1.0).abs() < 1e-10);
                assert!(out.transmitted > 0.1 && out.lost > 0.0 && out.lost < 0.7, "{out:?}");
            }
        }
        let eta = RelativeIor::new(1.49_f32).unwrap();
        let plate = Plate::new(Ggx::new(Alpha::new(0.5).unwrap(), eta), eta, RoughSide::Source);
        let grid = AngleGrid::gp200();
        let out = Goniophotometer::gp200().simulate(
            &plate,
            30.0,
            &grid,
            2000,
            &mut generator,
            &mut [0.0; 1801],
        );
        assert!((out.reflected + out.transmitted + out.lost - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_ray_enters_every_cone_it_lies_in_and_no_other() {
        let gonio = Goniophotometer { aperture_deg: 0.6, geometry: Geometry::Reflection };
        let grid = AngleGrid::gp200();
        for (theta, psi) in [(10.04_f64, 0.0_f64), (10.04, 0.2), (-89.95, 0.1), (0.0, 0.31)] {
            let wo = observation(Geometry::Reflection, theta.to_radians(), psi.to_radians());
            let got = gonio.cone().angles(wo).map_or(0..0, |(a, b)| grid.within(a, b));
            for k in 0..grid.count {
                let axis = observation(Geometry::Reflection, grid.degrees(k).to_radians(), 0.0);
                let inside = wo.dot(axis) >= 0.3_f64.to_radians().cos();
                assert_eq!(got.contains(&k), inside, "{theta} {psi} {k}");
            }
        }
    }
}
