//! The random numbers of a path.

use asperity_core::math::Real;
use rand_pcg::Pcg64Mcg;

/// Avalanches a word into a state (splitmix64).
pub(crate) fn mix(state: u64, word: u64) -> u64 {
    let mut z = (state ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A stream of its own for a path, by its key.
pub(crate) fn stream(key: u64) -> Pcg64Mcg {
    Pcg64Mcg::new((u128::from(key) << 64) | u128::from(mix(key, 1)))
}

/// Points of the unit square, evenly spread however many there are: the additive sequence of the plastic number
/// \[Roberts 2018\], shifted by chance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EvenPoints {
    shift: [f64; 2],
}

/// Reciprocals of the plastic number and of its square.
const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

impl EvenPoints {
    /// Shifted by the stream of a key.
    pub(crate) fn new(key: u64) -> Self {
        let mut numbers = stream(mix(key, 0x5eed));
        Self { shift: [f64::uniform(&mut numbers), f64::uniform(&mut numbers)] }
    }

    /// The point of a number.
    pub(crate) fn at(&self, number: u64) -> [f64; 2] {
        [0, 1].map(|k| {
            let x = self.shift[k] + number as f64 * STEP[k];
            x - x.floor()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::EvenPoints;

    #[test]
    fn points_are_spread_evenly() {
        let points = EvenPoints::new(7);
        for count in [64_u64, 1000, 4096] {
            let mut cells = [0_u32; 64];
            for k in 0..count {
                let [x, y] = points.at(k).map(|u| {
                    assert!((0.0..1.0).contains(&u));
                    (8.0 * u) as usize
                });
                cells[8 * y + x] += 1;
            }
            let mean = count as f64 / 64.0;
            for cell in cells {
                assert!((f64::from(cell) - mean).abs() <= 3.0 + 0.1 * mean, "{count}: {cells:?}");
            }
        }
    }
}
