//! Gaussian surfaces of correlation `exp(-r^2 / L^2)`: seeded periodic maps, and the closed form of what they scatter.

use std::f64::consts::{PI, TAU};

use asperity::kirchhoff::{
    Beam, BeamOrders, Fourier, Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths, orders,
};
use asperity::surface::{Edges, HeightMap};
use asperity::watch::Watch;
use asperity_core::bsdf::Lobe;
use asperity_core::direction::Direction;

use crate::common::{Random, dir, incidence, ior};

pub(super) const ETA: f64 = 1.49;
pub(super) const WAVELENGTH_UM: f64 = 0.55;
/// Wave number in air, 1/um.
pub(super) const K: f64 = TAU / WAVELENGTH_UM;
pub(super) const LOBES: [Lobe; 2] = [Lobe::Reflection, Lobe::Transmission];

/// Light of 0.55 um from an angle of incidence.
pub(super) fn beam(degrees: f64, air: bool, lobe: Lobe) -> Beam {
    Beam { wi: dir(incidence(degrees, air)), lobe, wavelength_um: WAVELENGTH_UM }
}

/// Orders of all beams.
pub(super) fn all(map: &HeightMap, edges: Edges, beams: &[Beam]) -> Vec<BeamOrders> {
    orders(map, edges, ior(ETA), beams, Watch::nobody()).unwrap().unwrap()
}

/// Light of 0.55 um, averaged.
pub(super) fn options(shadowing: bool) -> WaveOptions {
    let wavelengths = Wavelengths::single(1000.0 * WAVELENGTH_UM).unwrap();
    let shadowing = if shadowing { Shadowing::On } else { Shadowing::Off };
    WaveOptions { wavelengths, speckle: Speckle::Averaged, shadowing }
}

/// The mean law of a map at 0.55 um.
pub(super) fn boundary(map: &HeightMap, edges: Edges) -> WaveBoundary {
    WaveBoundary::of_map(map, edges, ior(ETA), &options(false)).unwrap()
}

/// Refractive index where a direction lies.
pub(super) fn index(w: Direction<f64>) -> f64 {
    if w.z() > 0.0 { 1.0 } else { ETA }
}

/// `|q_xy|` and `|q_z|` of a pair, 1/um.
pub(super) fn momentum(wi: Direction<f64>, wo: Direction<f64>) -> [f64; 2] {
    let (i, o) = (wi.xyz(), wo.xyz());
    let q = [0, 1, 2].map(|k| K * (index(wi) * i[k] + index(wo) * o[k]));
    [q[0].hypot(q[1]), q[2].abs()]
}

/// A Gaussian surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gaussian {
    pub(super) sigma_um: f64,
    pub(super) length_um: f64,
}

/// `ln n!`
fn ln_factorial(n: f64) -> f64 {
    let (mut x, mut moved) = (n + 1.0, 0.0);
    while x < 20.0 {
        moved -= x.ln();
        x += 1.0;
    }
    let i = 1.0 / x;
    moved + (x - 0.5) * x.ln() - x + 0.5 * TAU.ln() + i / 12.0 - i.powi(3) / 360.0
        + i.powi(5) / 1260.0
}

impl Gaussian {
    /// Mean square phase.
    pub(super) fn g(&self, q_z: f64) -> f64 {
        (q_z * self.sigma_um).powi(2)
    }

    /// Mean square of the slope, both axes together.
    pub(super) fn square_slope(&self) -> f64 {
        4.0 * (self.sigma_um / self.length_um).powi(2)
    }

    /// Share of the light that stays coherent.
    pub(super) fn coherent(&self, q_z: f64) -> f64 {
        (-self.g(q_z)).exp()
    }

    /// `D` in um^2: the series of \[Beckmann & Spizzichino 1963\].
    pub(super) fn density(&self, q: f64, q_z: f64) -> f64 {
        let (g, l2) = (self.g(q_z), self.length_um * self.length_um);
        // Poisson weights below the first are under 1e-20 of the largest
        let mut n = (g - 10.0 * g.sqrt() - 5.0).floor().max(1.0);
        let mut weight = n * g.ln() - g - ln_factorial(n);
        let (mut sum, mut last) = (0.0, 0.0);
        loop {
            let term = (weight - q * q * l2 / (4.0 * n)).exp() / n;
            sum += term;
            if n > g && term <= last && term < 1e-14 * sum || n > 4.0 * g + 1e4 {
                return sum * l2 / (4.0 * PI);
            }
            last = term;
            n += 1.0;
            weight += (g / n).ln();
        }
    }

    /// The first order of the same in small `g`.
    pub(super) fn first_order(&self, q: f64, q_z: f64) -> f64 {
        let l2 = self.length_um * self.length_um;
        self.g(q_z) * (-0.25 * q * q * l2).exp() * l2 / (4.0 * PI)
    }

    /// `D` of the surface seen at the points of a square grid only: neighbouring periods of the spectrum added.
    pub(super) fn sampled(&self, q: f64, q_z: f64, pitch_um: f64) -> f64 {
        let period = TAU / pitch_um;
        let at = |x: f64, y: f64| self.density((q + x * period).hypot(y * period), q_z);
        at(0.0, 0.0) + at(-1.0, 0.0) + at(1.0, 0.0) + at(0.0, 1.0) + at(0.0, -1.0)
    }

    /// Seeded periodic maps of `size` times `size` points.
    ///
    /// Each is Gaussian with this spectrum. Over the maps the strength of every wave is stratified (Latin
    /// hypercube) and its mean exact, and with it the variance and the slopes of all of them together.
    pub(super) fn maps(
        &self,
        size: usize,
        pitch_um: f64,
        count: usize,
        seed: u128,
    ) -> Vec<HeightMap> {
        let mut random = Random::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15_f39c_c060_5ced_c835));
        let n = size as isize;
        let step = TAU / (size as f64 * pitch_um);
        // two real maps are the two parts of one complex field
        let mut waves = vec![vec![[0.0; 2]; size * size]; count.div_ceil(2)];
        let mut ranks: Vec<usize> = (0..count).collect();
        let half = (0..=n / 2).flat_map(|y| (1 - n / 2..=n / 2).map(move |x| (x, y)));
        for (x, y) in half.filter(|(x, y)| *y > 0 || *x > 0) {
            let q2 = ((x * x + y * y) as f64) * step * step;
            let strength = -0.25 * q2 * self.length_um * self.length_um;
            if strength < -40.0 || 2 * x == n || 2 * y == n {
                continue;
            }
            let area = self.length_um * self.length_um * step * step / (4.0 * PI);
            let amplitude = self.sigma_um * (strength.exp() * area).sqrt();
            for k in (1..count).rev() {
                ranks.swap(k, random.between(0.0, k as f64 + 1.0) as usize);
            }
            let powers: Vec<f64> = ranks
                .iter()
                .map(|rank| -(1.0 - (*rank as f64 + random.next::<f64>()) / count as f64).ln())
                .collect();
            let mean = powers.iter().sum::<f64>() / count as f64;
            for (k, power) in powers.iter().enumerate() {
                let size_of_wave = amplitude * (power / mean).sqrt() * (size * size) as f64;
                let (im, re) = random.between(0.0, TAU).sin_cos();
                let (re, im) = (size_of_wave * re, size_of_wave * im);
                let at = |x: isize, y: isize| (y.rem_euclid(n) * n + x.rem_euclid(n)) as usize;
                for (place, im) in [(at(x, y), im), (at(-x, -y), -im)] {
                    let wave = &mut waves[k / 2][place];
                    let part = if k % 2 == 0 { [re, im] } else { [-im, re] };
                    *wave = [wave[0] + part[0], wave[1] + part[1]];
                }
            }
        }
        let fourier = Fourier::<f64>::new((size, size), Edges::Periodic);
        let mut room = fourier.room();
        let mut maps = Vec::new();
        for field in &waves {
            fourier.transform(
                |y, row| {
                    for (u, [re, im]) in row.iter_mut().zip(&field[y * size..]) {
                        (u.re, u.im) = (*re, *im);
                    }
                },
                &mut room,
            );
            let (mut even, mut odd) = (vec![0.0; size * size], vec![0.0; size * size]);
            for x in 0..size {
                for (y, u) in room.column(x as isize).iter().enumerate() {
                    (even[y * size + x], odd[y * size + x]) = (u.re, u.im);
                }
            }
            for heights in [even, odd] {
                if maps.len() < count {
                    let pitch = (pitch_um, pitch_um);
                    maps.push(HeightMap::new((size, size), pitch, heights).unwrap());
                }
            }
        }
        maps
    }
}

/// Where the facets of a map are: the density of its slopes, averaged over azimuths.
///
/// Short waves see the facets of the very map, few of which lead to any one direction: the larger part of what
/// single maps differ by. Sums over maps are freed of it by the known ratio of the two densities.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    surface: Gaussian,
    /// By the square of the slope.
    density: Vec<f64>,
    width: f64,
}

impl Slopes {
    pub(super) fn new(surface: Gaussian, map: &HeightMap) -> Self {
        let (nx, ny) = (map.nx(), map.ny());
        let heights = map.complete().unwrap();
        let square = surface.square_slope();
        let mut this = Self { surface, density: vec![0.0; 600], width: square / 50.0 };
        let share = 1.0 / ((nx * ny) as f64 * PI * this.width);
        // five points: exact to the fourth order
        let slope = |back2: f64, back: f64, next: f64, next2: f64, pitch: f64| {
            (8.0 * (next - back) - (next2 - back2)) / (12.0 * pitch)
        };
        for y in 0..ny {
            let row = |d: usize| (y + ny + d - 2) % ny * nx;
            for x in 0..nx {
                let column = |d: usize| (x + nx + d - 2) % nx;
                let [a, b, c, d] = [0, 1, 3, 4].map(|k| heights[row(2) + column(k)]);
                let along = slope(a, b, c, d, map.dx_um());
                let [a, b, c, d] = [0, 1, 3, 4].map(|k| heights[row(k) + x]);
                let across = slope(a, b, c, d, map.dy_um());
                let bin = ((along * along + across * across) / this.width) as usize;
                if let Some(density) = this.density.get_mut(bin) {
                    *density += share;
                }
            }
        }
        this
    }

    pub(super) fn surface(&self) -> &Gaussian {
        &self.surface
    }

    /// Densities of the slope that a pair needs: of the surface, and of the map.
    pub(super) fn at(&self, [q, q_z]: [f64; 2]) -> [f64; 2] {
        let (t2, square) = ((q / q_z).powi(2), self.surface.square_slope());
        let law = (-t2 / square).exp() / (PI * square);
        let map = self.density.get((t2 / self.width) as usize).copied().unwrap_or(0.0);
        [law / (q_z * q_z), map / (q_z * q_z)]
    }
}

/// A ring of momenta about a row of a table, wide enough for some orders of a map to lie in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    from: f64,
    to: f64,
}

impl Ring {
    /// About `q`, of `orders` orders at a distance of `step` 1/um.
    pub(super) fn new(q: f64, orders: f64, step: f64) -> Self {
        let area = orders * step * step / PI;
        // pi (b^2 - a^2) with a = q - d, b = q + d, or b alone
        let d = area / (4.0 * q.max(1e-9));
        if d < q { Self { from: q - d, to: q + d } } else { Self { from: 0.0, to: area.sqrt() } }
    }

    pub(super) fn holds(&self, q: f64) -> bool {
        (self.from..self.to).contains(&q)
    }

    /// Momenta in the ring, at even shares of its area.
    pub(super) fn momenta(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { from, to } = *self;
        (0..24).map(move |k| {
            let share = (f64::from(k) + 0.5) / 24.0;
            (from * from + share * (to * to - from * from)).sqrt()
        })
    }

    /// Directions in the plane of incidence whose momenta lie in the ring; `air` is their side.
    pub(super) fn directions(
        &self,
        wi: Direction<f64>,
        air: bool,
    ) -> impl Iterator<Item = Direction<f64>> + use<> {
        let n_o = if air { 1.0 } else { ETA };
        self.momenta().flat_map(|q| [q, -q]).filter_map(move |q| {
            let x = (q / K - index(wi) * wi.x()) / n_o;
            let z = (x.abs() < 1.0).then(|| ((1.0 - x) * (1.0 + x)).sqrt())?;
            Some(Direction::from_unit(x, 0.0, if air { z } else { -z }))
        })
    }
}
