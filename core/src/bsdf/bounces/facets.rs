//! A density of facets as some hundreds of them, and its masking as a table: for sums over bounces.

use core::f64::consts::PI;

use crate::fresnel;
use crate::math::Real;
use crate::ndf::density::Density;

/// Cells of the table of the excess.
const CELLS: usize = 128;

/// How many facets stand for all: a number of Fibonacci, and the one before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    pub(super) count: u32,
    pub(super) turn: u32,
}

/// A facet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    /// Components of its normal.
    x: f64,
    z: f64,
    /// Share of the facets, by area.
    area: f64,
}

/// What a facet makes of a ray.
pub(super) struct Sent {
    /// Share of the facets, by area that the ray sees.
    pub(super) area: f64,
    /// Fresnel's share.
    pub(super) reflected: f64,
    /// Heights of the directions it sends light to; z points to the medium of the ray.
    pub(super) up: f64,
    pub(super) down: Option<f64>,
}

/// Facets over the polar tangent and, in a direction of rest, over the azimuth.
pub(super) fn facets<D: Density<f64>>(
    density: &D,
    lattice: Lattice,
) -> impl Iterator<Item = Facet> + '_ {
    let power = density.tail();
    let count = f64::from(lattice.count);
    (0..lattice.count).map(move |k| {
        let x = (f64::from(k) + 0.5) / count;
        let turn = f64::from(k * lattice.turn % lattice.count) / count;
        // the share above the slope is y^k: dense at the steepest and at the flattest
        let y = x * x * (3.0 - 2.0 * x);
        let share = Real::pow(y, power);
        let slope = Real::min(density.slope_above(share), 1e12);
        let z = 1.0 / Real::sqrt(1.0 + slope * slope);
        let per = power * share / y * 6.0 * x * (1.0 - x);
        let cos = Real::sin_cos(2.0 * PI * turn).1;
        Facet { x: slope * z * cos, z, area: per / (z * count) }
    })
}

impl Facet {
    /// Light from a direction of height `z`, -1 to 1; `None` if the facet faces away.
    pub(super) fn send(&self, z: f64, eta: f64) -> Option<Sent> {
        let cos = Real::sqrt_positive((1.0 - z) * (1.0 + z)) * self.x + z * self.z;
        if cos <= 0.0 {
            return None;
        }
        let reflected = fresnel::dielectric(cos, eta).reflected;
        // the refracted ray travels along (cos - g) / eta m - w / eta
        let g2 = (eta - 1.0) * (eta + 1.0) + cos * cos;
        let down = (g2 > 0.0).then(|| ((cos - Real::sqrt(g2)) * self.z - z) / eta);
        Some(Sent { area: self.area * cos, reflected, up: 2.0 * cos * self.z - z, down })
    }
}

/// The mean excess of slopes, by cubics through values at even nodes of `mu / (mu + slope)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Excess {
    values: [f64; CELLS + 3],
    warp: f64,
}

impl Excess {
    pub(super) fn new<D: Density<f64>>(density: &D) -> Self {
        let warp = density.slope();
        let at = |k: usize| {
            let x = k as f64 / CELLS as f64;
            if k < CELLS { density.excess(warp * x / (1.0 - x)) } else { 0.0 }
        };
        let mut values = [0.0; CELLS + 3];
        for (k, value) in values.iter_mut().enumerate().skip(1).take(CELLS) {
            *value = at(k - 1);
        }
        // one more node on either side, where the cubic needs it
        let [first, a, b, c, ..] = &mut values;
        *first = 3.0 * *a - 3.0 * *b + *c;
        Self { values, warp }
    }

    /// Smith's `Lambda` of a direction of cosine `cos` above 0.
    pub(super) fn lambda(&self, cos: f64) -> f64 {
        let sin = Real::sqrt_positive((1.0 - cos) * (1.0 + cos));
        if sin <= 0.0 {
            return 0.0;
        }
        let mu = cos / sin;
        let position = mu / (mu + self.warp) * CELLS as f64;
        let k = position.to_index().min(CELLS - 1);
        let Some([p, a, b, n]) = self.values.get(k..k + 4).and_then(|v| v.first_chunk::<4>())
        else {
            return 0.0;
        };
        let s = position - k as f64;
        // Catmull and Rom
        let cubic = a + 0.5
            * s
            * (b - p + s * (2.0 * p - 5.0 * a + 4.0 * b - n + s * (3.0 * (a - b) + n - p)));
        Real::max(cubic, 0.0) / mu
    }
}
