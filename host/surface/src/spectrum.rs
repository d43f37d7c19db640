//! Power spectral density of a map, its radial average, and whether the surface has a direction.

use crate::edges::Edges;
use crate::heightmap::{HeightMap, Incomplete};
use asperity_fourier::RealFourier;

/// Areal power spectral density of the heights about their mean.
///
/// The density `S` belongs to frequencies in periods per um and has the unit um^4: its integral over the
/// whole plane of frequencies, with both signs, is Rq^2. Without a window for periodic maps; a map that is
/// not periodic is faded out to all borders by a Hann window and the density scaled back to its Rq.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    waves: Vec<Wave>,
    /// Area of one frequency, 1/um^2.
    cell: f64,
    /// One period over the map, the longer of both directions, 1/um.
    step: f64,
    /// The lower of both Nyquist frequencies, 1/um.
    nyquist: f64,
    /// Neighbouring waves that the window makes one, in effect.
    alike: f64,
}

/// One frequency and, if it is another one, its opposite.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wave {
    fx: f64,
    fy: f64,
    density: f64,
    /// 1 or 2 frequencies.
    count: f64,
}

/// The density averaged over a ring of frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Mean frequency of the ring, 1/um.
    pub frequency_per_um: f64,
    /// Mean density, um^4.
    pub density_um4: f64,
}

/// The anisotropy of the slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anisotropy {
    /// From 0 (all directions alike) to 1 (parallel grooves).
    pub strength: f64,
    /// The rms strength that an isotropic surface with as many waves would show by chance.
    pub chance: f64,
    /// Direction of the grooves, degrees from x to y, -90 to 90; of no meaning if the strength is small.
    pub lay_deg: f64,
}

impl Anisotropy {
    /// True if a single scan plane does not describe the surface: the strength is above 0.2, which correlation
    /// lengths in a ratio of 1.25 make, and beyond chance (three times, one isotropic surface in 8000).
    pub fn is_directional(&self) -> bool {
        self.strength > 0.2 && self.strength > 3.0 * self.chance
    }
}

impl Spectrum {
    /// The spectrum of a complete map; remove its form first.
    ///
    /// # Errors
    /// [`Incomplete`] if points are missing.
    pub fn of(map: &HeightMap, edges: Edges) -> Result<Self, Incomplete> {
        let heights = map.need_complete()?;
        let (nx, ny) = (map.nx(), map.ny());
        let points = heights.len() as f64;
        let mean = heights.iter().sum::<f64>() / points;
        let variance = heights.iter().map(|h| (h - mean) * (h - mean)).sum::<f64>() / points;
        let window = |k: usize, n: usize| match edges {
            Edges::Mirrored if n > 2 => {
                (std::f64::consts::PI * (k as f64 + 0.5) / n as f64).sin().powi(2)
            }
            _ => 1.0,
        };
        let windows: Vec<f64> =
            (0..nx * ny).map(|k| window(k % nx, nx) * window(k / nx, ny)).collect();
        let weight: f64 = windows.iter().sum();
        let middle = heights.iter().zip(&windows).map(|(h, w)| h * w).sum::<f64>() / weight;
        let grid = heights.iter().zip(&windows).map(|(h, w)| w * (h - middle)).collect();
        let transform = RealFourier::new((nx, ny), Edges::Periodic);
        let coefficients = transform.forward(grid);
        let (width, height) = (nx as f64 * map.dx_um(), ny as f64 * map.dy_um());
        let mut spectrum = Self {
            waves: waves(&coefficients, (nx, ny), (width, height)),
            cell: 1.0 / (width * height),
            step: (1.0 / width).max(1.0 / height),
            nyquist: (0.5 / map.dx_um()).min(0.5 / map.dy_um()),
            alike: match edges {
                Edges::Periodic => 1.0,
                // the sum of squared correlations of a wave with all others, in each direction
                Edges::Mirrored => (35.0_f64 / 18.0).powi(2),
            },
        };
        let found = spectrum.variance_um2();
        let scale = if found > 0.0 && variance > 0.0 { variance / found } else { 0.0 };
        for wave in &mut spectrum.waves {
            wave.density *= scale;
        }
        Ok(spectrum)
    }

    /// Integral of the density: Rq^2, um^2.
    pub fn variance_um2(&self) -> f64 {
        self.waves.iter().map(|w| w.density * w.count).sum::<f64>() * self.cell
    }

    /// The density averaged over rings as wide as one period over the map, from the first to the lower of both
    /// Nyquist frequencies.
    pub fn radial(&self) -> Vec<Ring> {
        let rings = (self.nyquist / self.step + 1e-9) as usize;
        let mut sums = vec![[0.0; 3]; rings + 1];
        for w in &self.waves {
            let f = w.fx.hypot(w.fy);
            let ring = self.ring(f);
            if let (true, Some(sum)) = (f <= self.nyquist * (1.0 + 1e-9), sums.get_mut(ring)) {
                for (sum, term) in sum.iter_mut().zip([1.0, f, w.density]) {
                    *sum += w.count * term;
                }
            }
        }
        let filled = sums.into_iter().skip(1).filter(|s| s[0] > 0.0);
        filled.map(|[n, f, s]| Ring { frequency_per_um: f / n, density_um4: s / n }).collect()
    }

    /// The ring of a frequency.
    fn ring(&self, frequency: f64) -> usize {
        (frequency / self.step).round() as usize
    }

    /// Second harmonic of the directions of slopes: `|sum f^2 S exp(2 i phi)| / sum f^2 S`, over frequencies from
    /// two periods over the shorter side of the map to the lower Nyquist frequency.
    ///
    /// `None` if the map has no such frequencies or is flat at them.
    pub fn anisotropy(&self) -> Option<Anisotropy> {
        self.harmonic(1)
    }

    /// The strongest of the second, fourth and sixth harmonic that is directional, else the second: crossed grooves have no
    /// second harmonic, and yet what they scatter is a cross.
    ///
    /// `None` as of [`Self::anisotropy`].
    pub fn pattern(&self) -> Option<Anisotropy> {
        let second = self.harmonic(1)?;
        let higher = [2, 3].into_iter().filter_map(|pairs| self.harmonic(pairs));
        let found = std::iter::once(second).chain(higher).filter(Anisotropy::is_directional);
        Some(found.max_by(|a, b| a.strength.total_cmp(&b.strength)).unwrap_or(second))
    }

    /// `|sum f^2 S exp(2 i n phi)| / sum f^2 S` for `n` pairs of directions.
    fn harmonic(&self, pairs: u16) -> Option<Anisotropy> {
        let (mut all, mut even, mut odd) = (0.0, 0.0, 0.0);
        // slope power and number of waves of each ring
        let mut rings = vec![(0.0, 0.0); self.ring(self.nyquist) + 1];
        for w in &self.waves {
            let f2 = w.fx * w.fx + w.fy * w.fy;
            let f = f2.sqrt();
            if f > 2.0 * self.step * (1.0 - 1e-9) && f < self.nyquist * (1.0 - 1e-9) {
                all += w.count * w.density * f2;
                // f^2 cos 2 n phi and f^2 sin 2 n phi
                let (c, s) = (w.fx * w.fx - w.fy * w.fy, 2.0 * w.fx * w.fy);
                let (mut re, mut im) = (c, s);
                for _ in 1..pairs {
                    (re, im) = ((re * c - im * s) / f2, (re * s + im * c) / f2);
                }
                even += w.count * w.density * re;
                odd += w.count * w.density * im;
                if let Some((power, waves)) = rings.get_mut(self.ring(f)) {
                    *power += w.count * w.density * f2;
                    *waves += 0.5 * w.count;
                }
            }
        }
        // An isotropic wave has the mean power of its ring with an exponential distribution.
        let filled = rings.iter().filter(|r| r.1 > 0.0);
        let scatter: f64 = filled.map(|(power, waves)| power * power / waves).sum();
        (all > 0.0).then(|| {
            let across = odd.atan2(even).to_degrees() / (2.0 * f64::from(pairs));
            Anisotropy {
                strength: even.hypot(odd) / all,
                chance: (self.alike * scatter).sqrt() / all,
                lay_deg: if across > 0.0 { across - 90.0 } else { across + 90.0 },
            }
        })
    }
}

/// Densities, not yet scaled, from the real coefficients of a periodic grid.
fn waves(c: &[f64], (nx, ny): (usize, usize), (width, height): (f64, f64)) -> Vec<Wave> {
    // Cosine and sine coefficients of k periods of n points; at both ends there is no sine.
    let places = |k: usize, n: usize| {
        let inner = k > 0 && 2 * k < n;
        (if k == 0 { 0 } else { 2 * k - 1 }, inner.then_some(2 * k))
    };
    let at = |i: Option<usize>, j: Option<usize>| match (i, j) {
        (Some(i), Some(j)) => c[i * ny + j],
        _ => 0.0,
    };
    let mut waves = Vec::with_capacity(nx * ny / 2 + nx + ny);
    for kx in 0..=nx / 2 {
        let (ic, is) = places(kx, nx);
        let count = if is.is_some() { 2.0 } else { 1.0 };
        for ky in 0..=ny / 2 {
            let (jc, js) = places(ky, ny);
            let (cc, ss) = (at(Some(ic), Some(jc)), at(is, js));
            let (sc, cs) = (at(is, Some(jc)), at(Some(ic), js));
            let (fx, fy) = (kx as f64 / width, ky as f64 / height);
            let mut push = |fy: f64, re: f64, im: f64| {
                waves.push(Wave { fx, fy, density: re * re + im * im, count });
            };
            push(fy, cc - ss, sc + cs);
            if js.is_some() {
                push(-fy, cc + ss, sc - cs);
            }
        }
    }
    waves
}

#[cfg(test)]
mod tests {
    use super::Spectrum;
    use crate::synthetic::{gaussian, stretched};
    use crate::{Crop, Edges, Form, HeightMap, Roughness};

    const SIZES: [(usize, usize); 5] = [(64, 48), (63, 50), (40, 41), (1, 16), (9, 2)];

    #[test]
    fn its_integral_is_the_square_of_rq() {
        for size in SIZES {
            let map = gaussian(size, (0.5, 0.7), 2.0, 3);
            let rq = Roughness::of(&map).rq_um;
            for edges in [Edges::Periodic, Edges::Mirrored] {
                let spectrum = Spectrum::of(&map, edges).unwrap();
                assert!((spectrum.variance_um2() / (rq * rq) - 1.0).abs() < 1e-12, "{size:?}");
                let frequencies: f64 = spectrum.waves.iter().map(|w| w.count).sum();
                assert!((frequencies - (size.0 * size.1) as f64).abs() < 0.5);
            }
        }
        let flat = HeightMap::new((9, 9), (1.0, 1.0), vec![2.0; 81]).unwrap();
        let flat = Spectrum::of(&flat, Edges::Mirrored).unwrap();
        assert!(flat.variance_um2().abs() < 1e-30 && flat.anisotropy().is_none());
    }

    #[test]
    fn the_radial_density_is_that_of_a_gaussian_autocorrelation() {
        // S = pi l^2 Rq^2 exp(-(pi l f)^2)
        let (l, pi) = (4.0 * 0.5, std::f64::consts::PI);
        let exact = |f: f64| pi * l * l * (-(pi * l * f).powi(2)).exp();
        let map = gaussian((512, 512), (0.5, 0.5), 4.0, 5);
        let cut = Crop::new(30..430, 30..480).unwrap().of(&map).unwrap();
        let spectra = [Spectrum::of(&map, Edges::Periodic), Spectrum::of(&cut, Edges::Mirrored)];
        for spectrum in spectra {
            let rings = spectrum.unwrap().radial();
            for ring in rings.iter().skip(8).take(80).filter(|r| r.frequency_per_um < 0.35) {
                let ratio = ring.density_um4 / exact(ring.frequency_per_um);
                assert!((ratio - 1.0).abs() < 0.45, "{ring:?} {ratio}");
            }
            let near = rings.iter().filter(|r| (0.05..0.3).contains(&r.frequency_per_um));
            let ratios: Vec<f64> =
                near.map(|r| r.density_um4 / exact(r.frequency_per_um)).collect();
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            assert!((mean - 1.0).abs() < 0.06, "{mean}");
        }
    }

    #[test]
    fn isotropic_maps_are_not_directional_and_grooves_are() {
        // squares of strength and of chance, by correlation length and edges
        let mut squares = [[[0.0; 2]; 2]; 3];
        for seed in 0..16 {
            for (sums, correlation) in squares.iter_mut().zip([0.8, 4.0, 12.0]) {
                let whole = gaussian((192, 192), (0.5, 0.5), correlation, seed);
                let cut = Crop::new(10..170, 10..150).unwrap().of(&whole).unwrap();
                let maps = [(whole, Edges::Periodic), (Form::Plane.removed(&cut), Edges::Mirrored)];
                for (sums, (map, edges)) in sums.iter_mut().zip(maps) {
                    let found = Spectrum::of(&map, edges).unwrap().anisotropy().unwrap();
                    assert!(!found.is_directional(), "{correlation} {seed}: {found:?}");
                    sums[0] += found.strength * found.strength;
                    sums[1] += found.chance * found.chance;
                }
            }
            // isotropic in um, with unequal pitches
            let map = stretched((200, 100), (0.5, 1.0), (6.0, 3.0), seed);
            let found = Spectrum::of(&map, Edges::Periodic).unwrap().anisotropy().unwrap();
            assert!(!found.is_directional(), "unequal pitches {seed}: {found:?}");
            let lengths = stretched((192, 192), (0.5, 0.5), (3.0, 9.0), seed);
            let found = Spectrum::of(&lengths, Edges::Periodic).unwrap().anisotropy().unwrap();
            // slope power 1/l^2 in each direction: (9 - 1) / (9 + 1)
            assert!((found.strength - 0.8).abs() < 0.05, "{found:?}");
            assert!(found.is_directional() && found.lay_deg.abs() > 80.0, "{found:?}");
        }
        // the mean of 16 exponential numbers is known to a quarter
        for [strength, chance] in squares.into_iter().flatten() {
            let ratio: f64 = strength / chance;
            assert!((0.4..1.9).contains(&ratio), "{ratio} {squares:?}");
        }
    }

    #[test]
    fn crossed_grooves_have_a_pattern_without_a_second_harmonic() {
        let n = 128;
        let wave = |k: usize| (std::f64::consts::TAU * 9.0 * k as f64 / n as f64).sin();
        let heights = (0..n * n).map(|k| wave(k % n) + wave(k / n)).collect();
        let map = HeightMap::new((n, n), (0.5, 0.5), heights).unwrap();
        let spectrum = Spectrum::of(&map, Edges::Periodic).unwrap();
        assert!(spectrum.anisotropy().unwrap().strength < 1e-6);
        let found = spectrum.pattern().unwrap();
        assert!(found.strength > 0.99 && found.is_directional(), "{found:?}");
        for seed in 0..16 {
            for correlation in [0.8, 4.0, 12.0] {
                let map = gaussian((192, 192), (0.5, 0.5), correlation, seed);
                let found = Spectrum::of(&map, Edges::Periodic).unwrap().pattern().unwrap();
                assert!(!found.is_directional(), "{correlation} {seed}: {found:?}");
            }
        }
    }

    #[test]
    fn the_lay_is_along_the_grooves() {
        let (nx, ny) = (120, 90);
        for lay in [-60.0_f64, -20.0, 0.0, 35.0, 80.0] {
            let (s, c) = lay.to_radians().sin_cos();
            let heights = (0..nx * ny).map(|k| {
                let (x, y) = (0.4 * (k % nx) as f64, 0.5 * (k / nx) as f64);
                (1.9 * (y * c - x * s)).sin()
            });
            let map = HeightMap::new((nx, ny), (0.4, 0.5), heights.collect()).unwrap();
            let found = Spectrum::of(&map, Edges::Mirrored).unwrap().anisotropy().unwrap();
            let off = (found.lay_deg - lay + 270.0).rem_euclid(180.0) - 90.0;
            assert!(found.strength > 0.9 && off.abs() < 2.0, "{lay}: {found:?}");
        }
    }
}
