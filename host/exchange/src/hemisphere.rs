//! The scattered flux of a law at an incidence, by cubature that knows nothing of the grid of a file.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::frame::Frame;
use crate::law::Law;

/// Relative error at which the cubature ends, by an estimate that is far above the error itself.
const RELATIVE: f64 = 1e-4;
/// Most regions per incidence; each costs 17 values.
const MOST_REGIONS: usize = 6_000;
/// Each ring about the ray is this much wider than the one within.
const GROWTH: f64 = 2.5;
/// Rings about the ray at the beginning.
const RINGS: i32 = 10;

/// Scattered fraction of the flux. `ray` is the polar angle of the specular or direct ray, where the lobe is looked for first; of a
/// `mirrored` law one half is looked at.
pub(crate) fn flux(law: &dyn Law, incidence: [f64; 2], ray: Option<f64>, mirrored: bool) -> f64 {
    let theta = ray.unwrap_or(0.0).min(FRAC_PI_2 - 1e-6);
    let frame = Frame::Specular { theta };
    // shares of the way from the ray to the horizon, so that no region straddles it, and azimuths about the ray
    let f = |[share, azimuth]: [f64; 2]| {
        let horizon = theta.cos().atan2(-theta.sin() * azimuth.cos());
        let radius = share * horizon;
        let out = frame.absolute([radius, azimuth]);
        let cos = out[0].cos();
        if cos <= 0.0 {
            return 0.0;
        }
        law.value(incidence, out).max(0.0) * cos * radius.sin() * horizon
    };
    let turn = if mirrored { PI } else { TAU };
    let parts = if mirrored { 4 } else { 8 };
    let mut open = Vec::new();
    for ring in 0..=RINGS {
        let outer = GROWTH.powi(-ring);
        let inner = if ring == RINGS { 0.0 } else { outer / GROWTH };
        for k in 0..parts {
            let edge = |k: i32| turn * f64::from(k) / f64::from(parts);
            open.push(Region::new([inner, edge(k)], [outer, edge(k + 1)], &f));
        }
    }
    let whole = settled(open, &f);
    if mirrored { 2.0 * whole } else { whole }
}

/// Halves the regions with the largest errors until what is left does not count.
fn settled(mut open: Vec<Region>, f: &dyn Fn([f64; 2]) -> f64) -> f64 {
    let mut count = open.len();
    let (mut done, mut left) = (0.0, 0.0);
    loop {
        let whole: f64 = done + open.iter().map(|r| r.value).sum::<f64>();
        let mut error: f64 = left + open.iter().map(|r| r.error).sum::<f64>();
        let most = RELATIVE * whole;
        if error <= most || count > MOST_REGIONS {
            return whole;
        }
        open.sort_by(|a, b| b.error.total_cmp(&a.error));
        let mut next = Vec::new();
        for region in open {
            if error > 0.5 * most {
                error -= region.error;
                next.extend(region.halves(f));
            } else {
                done += region.value;
                left += region.error;
            }
        }
        count += next.len();
        open = next;
    }
}

/// A rectangle with its integral.
struct Region {
    low: [f64; 2],
    high: [f64; 2],
    value: f64,
    error: f64,
    /// The axis along which the function is least like a cubic.
    axis: usize,
}

impl Region {
    /// By the rule of degree 7 of A. C. Genz and A. A. Malik, Journal of Computational and Applied Mathematics 6 (1980) 295; the error is the distance from their rule of degree 5.
    fn new(low: [f64; 2], high: [f64; 2], f: &dyn Fn([f64; 2]) -> f64) -> Self {
        let middle = [0, 1].map(|k| f64::midpoint(low[k], high[k]));
        let half = [0, 1].map(|k| (high[k] - low[k]) / 2.0);
        let at = |x: f64, y: f64| f([middle[0] + x * half[0], middle[1] + y * half[1]]);
        let (near, far, corner) =
            ((9.0_f64 / 70.0).sqrt(), 0.9_f64.sqrt(), (9.0_f64 / 19.0).sqrt());
        let centre = at(0.0, 0.0);
        let close = [at(near, 0.0) + at(-near, 0.0), at(0.0, near) + at(0.0, -near)];
        let wide = [at(far, 0.0) + at(-far, 0.0), at(0.0, far) + at(0.0, -far)];
        let diagonal = at(far, far) + at(far, -far) + at(-far, far) + at(-far, -far);
        let corners =
            at(corner, corner) + at(corner, -corner) + at(-corner, corner) + at(-corner, -corner);
        let (inner, outer) = (close[0] + close[1], wide[0] + wide[1]);
        let area = 4.0 * half[0] * half[1];
        let seventh = area
            * (-3_816.0 * centre
                + 2_940.0 * inner
                + 1_020.0 * outer
                + 200.0 * diagonal
                + 6_859.0 / 4.0 * corners)
            / 19_683.0;
        let fifth = area
            * (-971.0 / 729.0 * centre
                + 245.0 / 486.0 * inner
                + 65.0 / 1_458.0 * outer
                + 25.0 / 729.0 * diagonal);
        let fourth =
            [0, 1].map(|k: usize| (close[k] - 2.0 * centre - (wide[k] - 2.0 * centre) / 7.0).abs());
        let axis = usize::from(fourth[1] > fourth[0]);
        Self { low, high, value: seventh, error: (seventh - fifth).abs(), axis }
    }

    fn halves(&self, f: &dyn Fn([f64; 2]) -> f64) -> [Self; 2] {
        let middle = f64::midpoint(self.low[self.axis], self.high[self.axis]);
        let (mut low, mut high) = (self.low, self.high);
        high[self.axis] = middle;
        low[self.axis] = middle;
        [Self::new(self.low, high, f), Self::new(low, self.high, f)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::direction;

    /// A lobe about a ray whose flux is known: exp(k (cos - 1)) over the cosine of the normal, without its part below the horizon.
    struct Known {
        ray: f64,
        sharpness: f64,
    }

    impl Law for Known {
        fn value(&self, _: [f64; 2], out: [f64; 2]) -> f64 {
            let cos = direction(out).dot(direction([self.ray, 0.0]));
            (self.sharpness * (cos - 1.0)).exp() / out[0].cos()
        }
    }

    #[test]
    fn the_flux_is_that_of_the_closed_form() {
        for sharpness in [30.0, 3e3, 3e5] {
            // a lobe that ends before the horizon: 2 pi (1 - exp(-2 k)) / k
            let law = Known { ray: 0.4, sharpness };
            let ought = TAU / sharpness;
            for mirrored in [true, false] {
                let is = flux(&law, [0.4, 0.0], Some(0.4), mirrored);
                let allowed = if sharpness < 100.0 { 1e-4 } else { 2e-5 };
                assert!((is / ought - 1.0).abs() < allowed, "{sharpness}: {is} {ought}");
            }
        }
    }

    #[test]
    fn a_jump_costs_no_more_than_is_allowed() {
        struct Step;
        impl Law for Step {
            fn value(&self, _: [f64; 2], out: [f64; 2]) -> f64 {
                f64::from(u8::from(direction(out).x > 0.3))
            }
        }
        // the part of the disc of direction cosines beyond a chord
        let ought = 0.3_f64.acos() - 0.3 * (1.0_f64 - 0.09).sqrt();
        let is = flux(&Step, [0.9, 0.0], Some(0.9), true);
        assert!((is / ought - 1.0).abs() < 3e-4, "{is} {ought}");
    }
}
