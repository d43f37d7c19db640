//! Ten-point height `RzJIS` of JIS B 0601:2013, annex JA, of the profiles of a map.
//!
//! Over one sampling length: the mean height of the five highest profile peaks plus the mean depth of the five deepest
//! profile valleys. A peak is a portion above the mean line between two crossings of it, portions at the ends of the
//! sampling length included; a valley is one below (ISO 4287:1997, 3.2.4 to 3.2.7). The mean line is the mean of the
//! sampling length. No filter is applied and no small peak is left out: filter the map first if you need a cut-off.
//!
//! For a map: the mean over the sampling lengths of all its rows, and that of all its columns, whichever is larger; a
//! standard measures across the lay. A line holds five sampling lengths, the usual evaluation length. Where less than
//! half of them have five peaks and five valleys the whole line is one; where that has none either there is no figure.

use crate::heightmap::HeightMap;

/// The figure, and over which length it was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TenPoint {
    /// `RzJIS`, um.
    pub(super) height_um: f64,
    /// Sampling length, um.
    pub(super) length_um: f64,
}

/// Sampling lengths in a line, in the order in which they are tried.
const LENGTHS: [usize; 2] = [5, 1];
/// Peaks and valleys of a sampling length.
const FIVE: usize = 5;

/// `RzJIS` of a map; `None` if its lines have too few peaks.
pub(super) fn of(map: &HeightMap) -> Option<TenPoint> {
    let along_x = direction(map.nx(), map.ny(), map.dx_um(), |k, line| map.height_um(k, line));
    let along_y = direction(map.ny(), map.nx(), map.dy_um(), |k, line| map.height_um(line, k));
    let both = along_x.into_iter().chain(along_y);
    both.max_by(|a, b| a.height_um.total_cmp(&b.height_um))
}

/// The same of `lines` of `count` points.
fn direction(
    count: usize,
    lines: usize,
    pitch_um: f64,
    height: impl Fn(usize, usize) -> Option<f64>,
) -> Option<TenPoint> {
    LENGTHS.into_iter().find_map(|parts| {
        let points = count / parts;
        let (mut sum, mut found, mut all) = (0.0, 0_usize, 0_usize);
        let mut length = Vec::with_capacity(points);
        for line in 0..lines {
            for part in 0..parts {
                length.clear();
                length.extend((part * points..(part + 1) * points).filter_map(|k| height(k, line)));
                if length.len() < points {
                    continue;
                }
                all += 1;
                if let Some(one) = sampling_length(&length) {
                    sum += one;
                    found += 1;
                }
            }
        }
        let enough = found > 0 && 2 * found >= all;
        let length_um = points as f64 * pitch_um;
        enough.then(|| TenPoint { height_um: sum / found as f64, length_um })
    })
}

/// `RzJIS` of the heights over one sampling length.
fn sampling_length(heights: &[f64]) -> Option<f64> {
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    let (mut peaks, mut valleys) = (Vec::new(), Vec::new());
    for portion in heights.chunk_by(|a, b| (*a > mean) == (*b > mean)) {
        let most = portion.iter().map(|h| (h - mean).abs()).fold(0.0, f64::max);
        let above = portion.first().is_some_and(|h| *h > mean);
        if above { peaks.push(most) } else { valleys.push(most) }
    }
    let highest = |mut all: Vec<f64>| {
        all.sort_unstable_by(|a, b| b.total_cmp(a));
        Some(all.get(..FIVE)?.iter().sum::<f64>() / FIVE as f64)
    };
    Some(highest(peaks)? + highest(valleys)?)
}

#[cfg(test)]
mod tests {
    use super::{TenPoint, of};
    use crate::HeightMap;

    fn map(size: (usize, usize), height: impl Fn(usize, usize) -> f64) -> Option<TenPoint> {
        let heights = (0..size.0 * size.1).map(|k| height(k % size.0, k / size.0)).collect();
        of(&HeightMap::new(size, (0.5, 2.0), heights).unwrap())
    }

    #[test]
    fn five_peaks_and_five_valleys_of_every_sampling_length() {
        // 60 points a row, 12 a sampling length: six teeth of heights 1 to 6 in the first, twice that in the second ...
        let tooth = |k: usize| {
            let size = (k / 12 + 1) as f64 * ((k % 12) / 2 + 1) as f64;
            if k.is_multiple_of(2) { size } else { -size }
        };
        let found = map((60, 3), |x, _| tooth(x)).unwrap();
        // 2 (2 + 3 + 4 + 5 + 6) / 5 times the mean of 1 to 5
        assert!((found.height_um - 24.0).abs() < 1e-12, "{found:?}");
        assert!((found.length_um - 6.0).abs() < 1e-12);
        // the larger of both directions, with its own length
        let turned = map((3, 60), |_, y| 2.0 * tooth(y)).unwrap();
        assert!((turned.height_um - 48.0).abs() < 1e-12 && (turned.length_um - 24.0).abs() < 1e-12);
    }

    #[test]
    fn a_portion_has_one_peak_however_ragged_and_few_peaks_ask_for_the_whole_line() {
        // ten waves a row, two a fifth of it; each crest has two tips
        let ragged = |x: usize| [0.0, 3.0, 2.0, 3.0, 0.0, -3.0, -2.0, -3.0][x % 8];
        let found = map((80, 4), |x, _| ragged(x)).unwrap();
        assert!((found.height_um - 6.0).abs() < 1e-12 && (found.length_um - 40.0).abs() < 1e-12);
        assert_eq!(map((80, 4), |x, _| (0.05 * x as f64).sin()), None);
        assert_eq!(map((1, 1), |_, _| 3.0), None);
        assert_eq!(map((80, 4), |_, _| 3.0), None);
    }

    #[test]
    fn a_sampling_length_with_a_gap_does_not_count() {
        let tooth = |x: usize| if x.is_multiple_of(2) { 1.0 } else { -1.0 };
        let found = map((60, 2), |x, y| if x < 12 && y == 0 { f64::NAN } else { tooth(x) });
        assert!((found.unwrap().height_um - 2.0).abs() < 1e-12);
    }
}
