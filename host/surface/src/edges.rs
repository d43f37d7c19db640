//! The continuation of a map beyond its border: the map again, or its mirror image.

use asperity_fourier::Ends;

use crate::heightmap::HeightMap;

/// The continuation of a map beyond its borders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Edges {
    /// It begins again: the last column is followed by the first.
    Periodic,
    /// It is reflected at the border, half a pitch beyond the last column: `... b c | c b ...`.
    Mirrored,
}

impl From<Edges> for Ends {
    fn from(edges: Edges) -> Self {
        match edges {
            Edges::Periodic => Self::Periodic,
            Edges::Mirrored => Self::Mirrored,
        }
    }
}

impl Edges {
    /// Periodic if the map fits to itself across the seam, else mirrored.
    ///
    /// It fits if steps across the seam are at most 1.5 times as large as those inside, and second differences
    /// that reach over the seam at most twice as large as those inside; all are root mean squares in units of
    /// the inside of their direction, over both directions. Maps of fewer than 8 points in a direction are mirrored:
    /// they allow no decision. Missing points are left out.
    pub fn of(map: &HeightMap) -> Self {
        if map.nx() < 8 || map.ny() < 8 {
            return Self::Mirrored;
        }
        let range = map.points().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
            (low.min(p.2), high.max(p.2))
        });
        // what rounding may do to a direction without any step
        let floor = (1e-9 * (range.1 - range.0)).powi(2);
        let mut excess = [0.0_f64; 2];
        for along_x in [true, false] {
            let Some(ratios) = seam(map, along_x, floor) else { return Self::Mirrored };
            excess[0] += 0.5 * ratios[0];
            excess[1] += 0.5 * ratios[1];
        }
        if excess[0] <= MOST_STEP * MOST_STEP && excess[1] <= MOST_BEND * MOST_BEND {
            Self::Periodic
        } else {
            Self::Mirrored
        }
    }

    /// `periodic` or `mirrored`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Periodic => "periodic",
            Self::Mirrored => "mirrored",
        }
    }
}

/// Rms step across the seam, over that inside. The seam of a periodic map of few correlation lengths
/// scatters by some 20 %.
const MOST_STEP: f64 = 1.5;
/// The same of second differences.
const MOST_BEND: f64 = 2.0;

/// Mean squares of first and second differences over the seam, in units of those inside; `None` if there
/// are none to compare.
fn seam(map: &HeightMap, along_x: bool, floor: f64) -> Option<[f64; 2]> {
    let (length, lines) = if along_x { (map.nx(), map.ny()) } else { (map.ny(), map.nx()) };
    let at = |k: usize, line: usize| {
        let k = k % length;
        if along_x { map.height_um(k, line) } else { map.height_um(line, k) }
    };
    // [order][inside, seam]: sum of squares, count
    let mut sums = [[(0.0, 0_u64); 2]; 2];
    let mut add = |order: usize, over_seam: bool, difference: f64| {
        let (sum, count) = &mut sums[order][usize::from(over_seam)];
        *sum += difference * difference;
        *count += 1;
    };
    for line in 0..lines {
        for k in 0..length {
            let (Some(a), Some(b)) = (at(k, line), at(k + 1, line)) else { continue };
            add(0, k + 1 >= length, b - a);
            if let Some(c) = at(k + 2, line) {
                add(1, k + 2 >= length, a - 2.0 * b + c);
            }
        }
    }
    let mean = |(sum, count): (f64, u64)| (count > 0).then(|| sum / count as f64);
    let ratio = |[inside, seam]: [(f64, u64); 2]| {
        let (inside, seam) = (mean(inside)?, mean(seam)?);
        Some(if seam <= floor { 0.0 } else { seam / (inside + floor) })
    };
    Some([ratio(sums[0])?, ratio(sums[1])?])
}

#[cfg(test)]
mod tests {
    use super::Edges;
    use crate::synthetic::gaussian;
    use crate::{Crop, Form, HeightMap};

    #[test]
    fn a_periodic_map_is_known_however_few_its_correlation_lengths() {
        for seed in 0..20 {
            for correlation in [0.7, 3.0, 10.0, 20.0] {
                let map = gaussian((128, 96), (0.5, 0.6), correlation, seed);
                assert_eq!(Edges::of(&map), Edges::Periodic, "{correlation} {seed}");
            }
        }
        let flat = HeightMap::new((9, 9), (1.0, 1.0), vec![3.0; 81]).unwrap();
        assert_eq!(Edges::of(&flat), Edges::Periodic);
    }

    #[test]
    fn a_cut_out_of_a_larger_map_is_not_periodic() {
        for seed in 0..20 {
            for correlation in [5.0, 10.0, 30.0] {
                let whole = gaussian((256, 256), (0.5, 0.5), correlation, seed);
                let map = Crop::new(20..140, 30..130).unwrap().of(&whole).unwrap();
                for map in [Form::Plane.removed(&map), map] {
                    assert_eq!(Edges::of(&map), Edges::Mirrored, "{correlation} {seed}");
                }
            }
        }
    }

    #[test]
    fn tilts_bowls_and_tiny_maps_are_not_periodic() {
        let map = |height: fn(f64, f64) -> f64| {
            let heights = (0..1200).map(|k| height(f64::from(k % 40), f64::from(k / 40)));
            HeightMap::new((40, 30), (1.0, 1.0), heights.collect()).unwrap()
        };
        assert_eq!(Edges::of(&map(|x, y| 0.1 * x + 0.3 * y)), Edges::Mirrored);
        assert_eq!(Edges::of(&map(|x, _| 0.1 * x)), Edges::Mirrored);
        // its step over the seam is 0, its bend is not
        assert_eq!(Edges::of(&map(|x, _| (x - 19.5).powi(2))), Edges::Mirrored);
        let tiny = HeightMap::new((4, 4), (1.0, 1.0), vec![0.0; 16]).unwrap();
        assert_eq!(Edges::of(&tiny), Edges::Mirrored);
    }
}
