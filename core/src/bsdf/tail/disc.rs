//! Total scatter: the integral of a shape over the disc of the directions that there are, and draws from it.
//!
//! Directions are points `q` of a disc: index of the medium times direction cosines. Light goes to `q` in proportion to
//! the shape at the distance from the specular point `q0`. At one distance `x` the points that there are form an arc,
//! `|q0 + x e| < rim`, of half angle `arc(x)` about the way to the middle.

use core::f64::consts::PI;

use super::shape::Shape;
use crate::math::Real;
use crate::quadrature::EIGHT_POINTS;

/// A shape about a point of a disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    pub(super) shape: Shape<f64>,
    /// Distance of the specular point from the middle.
    pub(super) centre: f64,
    /// Radius of the disc: the index of the medium that the light goes to.
    pub(super) rim: f64,
}

/// A distance on a panel, and the width of the panel per parameter there. A smoothstep removes roots at both ends.
#[derive(Clone, Copy)]
struct Panel {
    from: f64,
    to: f64,
}

impl Panel {
    fn at(self, t: f64) -> [f64; 2] {
        let width = self.to - self.from;
        [self.from + width * t * t * (3.0 - 2.0 * t), width * 6.0 * t * (1.0 - t)]
    }
}

impl Disc {
    /// Half angle of the arc of points at a distance, rad.
    pub(super) fn arc(&self, x: f64) -> f64 {
        let (q, rim) = (self.centre, self.rim);
        if x + q <= rim {
            PI
        } else if x >= q + rim || q >= x + rim {
            0.0
        } else {
            let cos = (x * x + (q - rim) * (q + rim)) / (2.0 * x * q);
            Real::acos(Real::min(Real::max(cos, -1.0), 1.0))
        }
    }

    /// The shape over an arc, per distance.
    fn density(&self, x: f64) -> f64 {
        2.0 * x * self.arc(x) * self.shape.value(x * x)
    }

    /// The mean over an arc of the cosine of the directions.
    fn mean_cosine(&self, x: f64) -> f64 {
        let arc = self.arc(x);
        let cosine = |t: f64| {
            let (_, cos) = Real::sin_cos(arc * t * t * (3.0 - 2.0 * t));
            let q2 = x * x + self.centre * (self.centre - 2.0 * x * cos);
            Real::sqrt_positive(1.0 - q2 / (self.rim * self.rim)) * 6.0 * t * (1.0 - t)
        };
        EIGHT_POINTS.iter().map(|&(t, w)| w * cosine(t)).sum()
    }

    /// Panels in ascending order until `stop` says so.
    fn each_panel(&self, mut stop: impl FnMut(Panel) -> bool) {
        let last = self.centre + self.rim;
        let kink = Real::abs(self.rim - self.centre);
        let mut from = if self.centre > self.rim { kink } else { 0.0 };
        while from < last {
            let mut to = Real::min(self.shape.panel_end(from), last);
            if from < kink {
                to = Real::min(to, kink);
            } else {
                // the arc bends beyond the kink, the more the nearer
                to = Real::min(
                    to,
                    Real::max(2.5 * from - 1.5 * kink, 1.2 * kink + 1e-3 * self.shape.width()),
                );
            }
            if to <= from || stop(Panel { from, to }) {
                return;
            }
            from = to;
        }
    }

    fn integral(&self, panel: Panel, end: f64, cosines: bool) -> f64 {
        let part = |&(t, w): &(f64, f64)| {
            let [x, per] = panel.at(t * end);
            let cosine = if cosines { self.mean_cosine(x) } else { 1.0 };
            w * per * self.density(x) * cosine
        };
        EIGHT_POINTS.iter().map(part).sum::<f64>() * end
    }

    /// The share of the light that is scattered into the disc; with `cosines`, each weighted by that of its direction.
    pub(super) fn total(&self, cosines: bool) -> f64 {
        let mut sum = 0.0;
        self.each_panel(|panel| {
            sum += self.integral(panel, 1.0, cosines);
            false
        });
        sum
    }

    /// The distance below which a share from 0 to 1 of the light goes, cosines left aside.
    pub(super) fn distance(&self, share: f64) -> f64 {
        let mut left = share * self.total(false);
        let mut found = None;
        let mut end = self.centre + self.rim;
        self.each_panel(|panel| {
            let here = self.integral(panel, 1.0, false);
            if left < here {
                found = Some((panel, here));
                return true;
            }
            left -= here;
            end = panel.to;
            false
        });
        found.map_or(end, |(panel, here)| self.within(panel, left, here))
    }

    /// The distance in a panel below which `wanted` of its `whole` light goes.
    fn within(&self, panel: Panel, wanted: f64, whole: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        let mut t = wanted / whole;
        for _ in 0..40 {
            let error = self.integral(panel, t, false) - wanted;
            if error > 0.0 {
                high = t;
            } else {
                low = t;
            }
            if Real::abs(error) <= 1e-12 * whole {
                break;
            }
            let [x, per] = panel.at(t);
            let newton = t - error / (per * self.density(x));
            t = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        }
        panel.at(t)[0]
    }

    /// The point of the disc at a distance and a share from 0 to 1 of its arc: along the way from the middle to the
    /// specular point, and across it.
    pub(super) fn point(&self, x: f64, across: f64) -> [f64; 2] {
        let (sin, cos) = Real::sin_cos((2.0 * across - 1.0) * self.arc(x));
        [self.centre - x * cos, x * sin]
    }
}
