//! The normalised autocorrelation of a map over lags in both directions, and how far it reaches.

use asperity_fourier::Fourier;

use crate::edges::Edges;
use crate::heightmap::HeightMap;

/// Points along a side of the squares that a larger map is cut into: their transforms take 300 MB at most.
const SIDE: usize = 2048;
/// Directions over half a turn in which the decay is sought.
const DIRECTIONS: usize = 720;
/// Steps within a pitch on the way.
const FINENESS: f64 = 4.0;

/// The mean product of heights about their mean, a lag apart, over their mean square; lags up to half of each side.
///
/// Of a periodic map all pairs count, also those across its borders; of others those within the map, each lag by the number of its
/// pairs.
#[derive(Clone, Debug, PartialEq)]
pub struct Autocorrelation {
    /// Largest lags along x and y, points.
    most: [usize; 2],
    pitches_um: [f64; 2],
    /// Row by row, lags along x from `-most` to `most`, along y from 0.
    values: Vec<f64>,
}

/// How far the autocorrelation stays above a level, um.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// In the direction of the fastest decay; `None` if it does not fall so far in any.
    pub least_um: Option<f64>,
    /// In that of the slowest; `None` if in some direction it does not fall so far within the lags.
    pub most_um: Option<f64>,
    /// The longest lag up to which it is known to stay above in some direction; that of the slowest decay where it falls.
    pub seen_um: f64,
}

/// A part of a map: where it begins, its size, and the stride of its points.
#[derive(Clone, Copy)]
struct Part {
    from: [usize; 2],
    size: [usize; 2],
    stride: [usize; 2],
}

impl Autocorrelation {
    /// Of a map about its mean; `None` of a flat one. A map of more than 2048 points along a side is cut into squares, for lags
    /// up to half of them.
    pub fn of(map: &HeightMap, edges: Edges) -> Option<Self> {
        let size = [map.nx(), map.ny()];
        if size.iter().all(|n| *n <= SIDE) {
            return Self::of_parts(map, &[Part { from: [0; 2], size, stride: [1; 2] }], edges);
        }
        let count = size.map(|n| n.div_ceil(SIDE));
        let side = [0, 1].map(|k| size[k] / count[k]);
        let parts: Vec<Part> = (0..count[0] * count[1])
            .map(|k| [k % count[0] * side[0], k / count[0] * side[1]])
            .map(|from| Part { from, size: side, stride: [1; 2] })
            .collect();
        Self::of_parts(map, &parts, Edges::Mirrored)
    }

    /// The same of a large map by every so many points, for lags up to half of its sides.
    pub fn coarse(map: &HeightMap, edges: Edges) -> Option<Self> {
        let size = [map.nx(), map.ny()];
        let stride = size.map(|n| n.div_ceil(SIDE));
        let part = Part { from: [0; 2], size: [0, 1].map(|k| size[k].div_ceil(stride[k])), stride };
        // a stride that is left over at a border breaks the period
        let fits = [0, 1].iter().all(|k| size[*k].is_multiple_of(stride[*k]));
        Self::of_parts(map, &[part], if fits { edges } else { Edges::Mirrored })
    }

    /// Of parts of equal size.
    fn of_parts(map: &HeightMap, parts: &[Part], edges: Edges) -> Option<Self> {
        let first = parts.first()?;
        let (mut sum, mut count) = (0.0, 0.0);
        map.points().for_each(|(_, _, h)| (sum, count) = (sum + h, count + 1.0));
        let mean = sum / count;
        let most = first.size.map(|n| n / 2);
        let lags = (2 * most[0] + 1) * (most[1] + 1);
        let (mut products, mut pairs) = (vec![0.0; lags], vec![0.0; lags]);
        for part in parts {
            let at = |i: usize, j: usize| {
                let [x, y] = [i, j].map(|k| k);
                let (x, y) = (part.from[0] + x * part.stride[0], part.from[1] + y * part.stride[1]);
                map.height_um(x, y).map(|h| h - mean)
            };
            add(&mut products, &lagged(part.size, most, edges, |i, j| at(i, j).unwrap_or(0.0)));
            let there = |i, j| f64::from(u8::from(at(i, j).is_some()));
            add(&mut pairs, &lagged(part.size, most, edges, there));
        }
        let zero = most[0];
        let square = products[zero] / pairs[zero];
        let value =
            |(product, pairs): (f64, f64)| if pairs > 0.5 { product / pairs / square } else { 0.0 };
        let values = products.into_iter().zip(pairs).map(value).collect();
        let pitches_um =
            [map.dx_um() * first.stride[0] as f64, map.dy_um() * first.stride[1] as f64];
        (square > 0.0 && square.is_finite()).then_some(Self { most, pitches_um, values })
    }

    /// The value at whole lags; `None` beyond the largest.
    pub fn at(&self, x: isize, y: isize) -> Option<f64> {
        // opposite lags are of the same pairs
        let (x, y) = if y < 0 { (-x, -y) } else { (x, y) };
        let column = usize::try_from(x + self.most[0] as isize).ok()?;
        let row = usize::try_from(y).ok()?;
        let inside = column <= 2 * self.most[0] && row <= self.most[1];
        inside.then(|| self.values.get(row * (2 * self.most[0] + 1) + column).copied()).flatten()
    }

    /// Between lags, linear in both; `None` beyond the largest.
    fn between(&self, x_um: f64, y_um: f64) -> Option<f64> {
        let [x, y] = [x_um / self.pitches_um[0], y_um / self.pitches_um[1]];
        let (i, j) = (x.floor(), y.floor());
        let corner = |a: f64, b: f64| {
            let weight = (1.0 - (x - i - a).abs()) * (1.0 - (y - j - b).abs());
            if weight <= 1e-12 {
                return Some(0.0);
            }
            Some(weight * self.at((i + a) as isize, (j + b) as isize)?)
        };
        Some(corner(0.0, 0.0)? + corner(1.0, 0.0)? + corner(0.0, 1.0)? + corner(1.0, 1.0)?)
    }

    /// How far it stays above `level` on the way out from lag 0, over all directions.
    pub fn reach(&self, level: f64) -> Reach {
        let mut reach = Reach { least_um: None, most_um: Some(0.0), seen_um: 0.0 };
        for k in 0..DIRECTIONS {
            let angle = std::f64::consts::PI * k as f64 / DIRECTIONS as f64;
            match self.decay(level, [angle.cos(), angle.sin()]) {
                Ok(lag) => {
                    reach.least_um = Some(reach.least_um.map_or(lag, |least| least.min(lag)));
                    reach.most_um = reach.most_um.map(|most| most.max(lag));
                    reach.seen_um = reach.seen_um.max(lag);
                }
                Err(seen) => {
                    reach.most_um = None;
                    reach.seen_um = reach.seen_um.max(seen);
                }
            }
        }
        reach
    }

    /// The lag in um at which it first falls to `level` in a direction, or the last lag if it does not.
    fn decay(&self, level: f64, [c, s]: [f64; 2]) -> Result<f64, f64> {
        let step = self.pitches_um[0].min(self.pitches_um[1]) / FINENESS;
        let (mut last, mut k) = (1.0, 1.0);
        loop {
            let lag = k * step;
            let Some(value) = self.between(lag * c, lag * s) else { return Err(lag - step) };
            if value <= level {
                let share = (last - level) / (last - value);
                return Ok(lag - step + share * step);
            }
            (last, k) = (value, k + 1.0);
        }
    }
}

fn add(sums: &mut [f64], terms: &[f64]) {
    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
}

/// The sums of products of numbers a lag apart, in the order of [`Autocorrelation::values`], by two transforms.
fn lagged(
    size: [usize; 2],
    most: [usize; 2],
    edges: Edges,
    value: impl Fn(usize, usize) -> f64 + Sync,
) -> Vec<f64> {
    // zeros beyond a border that is no period
    let [width, height] = match edges {
        Edges::Periodic => size,
        Edges::Mirrored => [0, 1].map(|k| smooth(size[k] + most[k])),
    };
    let transform = Fourier::<f64>::new((width, height), Edges::Periodic);
    let mut waves = transform.room();
    transform.transform(
        |row, line| {
            for (column, place) in line.iter_mut().enumerate() {
                let inside = column < size[0] && row < size[1];
                place.re = if inside { value(column, row) } else { 0.0 };
                place.im = 0.0;
            }
        },
        &mut waves,
    );
    let power: Vec<f64> = waves.values().iter().map(|w| w.re * w.re + w.im * w.im).collect();
    drop(waves);
    // orders along y lie together: they are the lines now
    let transform = Fourier::<f64>::new((height, width), Edges::Periodic);
    let mut sums = transform.room();
    transform.transform(
        |row, line| {
            let powers = power.get(row * height..).unwrap_or_default();
            for (place, power) in line.iter_mut().zip(powers) {
                (place.re, place.im) = (*power, 0.0);
            }
        },
        &mut sums,
    );
    let scale = (width * height) as f64 * (width * height) as f64;
    let rows = 0..=most[1] as isize;
    let columns = -(most[0] as isize)..=most[0] as isize;
    rows.flat_map(|y| columns.clone().map(move |x| (x, y)))
        .map(|(x, y)| scale * sums.at(y, x).re)
        .collect()
}

/// The next number that has no factors but 2, 3 and 5.
fn smooth(n: usize) -> usize {
    let is_smooth = |n: &usize| {
        let mut rest = *n;
        for factor in [2, 3, 5] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    let n = n.max(1);
    // a power of two is one
    (n..=n.next_power_of_two()).find(is_smooth).unwrap_or(n)
}

#[cfg(test)]
mod tests {
    use super::Autocorrelation;
    use crate::synthetic::stretched;
    use crate::{Edges, HeightMap};

    /// The definition, pair by pair.
    fn slow(map: &HeightMap, edges: Edges, (x, y): (isize, isize)) -> f64 {
        let (nx, ny) = (map.nx() as isize, map.ny() as isize);
        let count = map.points().count() as f64;
        let mean = map.points().map(|p| p.2).sum::<f64>() / count;
        let square = map.points().map(|p| (p.2 - mean).powi(2)).sum::<f64>() / count;
        let (mut sum, mut pairs) = (0.0, 0.0);
        for (i, j, h) in map.points() {
            let (mut k, mut l) = (i as isize + x, j as isize + y);
            if edges == Edges::Periodic {
                (k, l) = (k.rem_euclid(nx), l.rem_euclid(ny));
            }
            let (Ok(k), Ok(l)) = (usize::try_from(k), usize::try_from(l)) else { continue };
            if let Some(other) = map.height_um(k, l) {
                sum += (h - mean) * (other - mean);
                pairs += 1.0;
            }
        }
        if pairs > 0.0 { sum / pairs / square } else { 0.0 }
    }

    #[test]
    fn it_is_that_of_the_definition_with_missing_points_and_any_size() {
        for (nx, ny) in [(12, 9), (7, 10), (1, 6), (5, 1)] {
            let heights = (0..nx * ny).map(|k| {
                if k % 11 == 5 {
                    f64::NAN
                } else {
                    (k as f64 * 1.37).sin() + 0.05 * (k % nx) as f64
                }
            });
            let map = HeightMap::new((nx, ny), (0.5, 0.7), heights.collect()).unwrap();
            for edges in [Edges::Periodic, Edges::Mirrored] {
                let found = Autocorrelation::of(&map, edges).unwrap();
                let (mx, my) = ((nx / 2) as isize, (ny / 2) as isize);
                for y in -my..=my {
                    for x in -mx..=mx {
                        let (a, b) = (found.at(x, y).unwrap(), slow(&map, edges, (x, y)));
                        assert!((a - b).abs() < 1e-12, "{nx} x {ny} {edges:?} {x} {y}: {a} {b}");
                    }
                }
                assert!(found.at(mx + 1, 0).is_none() && found.at(0, my + 1).is_none());
            }
        }
    }

    #[test]
    fn the_reach_of_a_gaussian_surface_follows_its_lengths() {
        // exp(-(x/lx)^2 - (y/ly)^2) = 0.2 at sqrt(ln 5) of the lengths
        let far = 5.0_f64.ln().sqrt();
        let map = stretched((512, 512), (0.5, 0.25), (6.0, 24.0), 3);
        for edges in [Edges::Periodic, Edges::Mirrored] {
            let reach = Autocorrelation::of(&map, edges).unwrap().reach(0.2);
            for (found, exact) in [(reach.least_um, far * 3.0), (reach.most_um, far * 6.0)] {
                assert!((found.unwrap() / exact - 1.0).abs() < 0.06, "{reach:?} {exact}");
            }
        }
    }

    #[test]
    fn a_large_map_in_squares_reads_as_the_whole() {
        // a wave of 10 points, longer than any transform
        let wave = |k: usize| (std::f64::consts::TAU * k as f64 / 10.0).sin();
        let map =
            HeightMap::new((4100, 4), (1.0, 1.0), (0..4100 * 4).map(|k| wave(k % 4100)).collect());
        let map = map.unwrap();
        let found = Autocorrelation::of(&map, Edges::Periodic).unwrap();
        for (x, exact) in [(5, -1.0), (10, 1.0)] {
            assert!((found.at(x, 0).unwrap() - exact).abs() < 2e-3, "{:?}", found.at(x, 0));
        }
        let coarse = Autocorrelation::coarse(&map, Edges::Mirrored).unwrap();
        assert!((coarse.at(10, 0).unwrap() - 1.0).abs() < 2e-3, "{:?}", coarse.at(10, 0));
        let flat = HeightMap::new((3, 3), (1.0, 1.0), vec![2.0; 9]).unwrap();
        assert!(Autocorrelation::of(&flat, Edges::Periodic).is_none());
    }
}
