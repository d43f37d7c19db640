//! The random numbers of a simulation: a grid of strata, one stream per ray.
//!
//! The first two numbers of a ray say where it starts (or which facet it meets first). They are spread evenly: the unit
//! square is cut into as many squares as there are rays, and each ray starts somewhere in its own, so
//! that every part of a height map gets its share of rays and only the rest of its path is left to chance.
//! Squares are visited tile by tile, which keeps neighbours together in memory. Each ray has its own
//! stream, so that a ray that takes more numbers than before does not disturb the others: simulations of
//! slightly different surfaces differ slightly.

use asperity_core::math::Real;
use rand_pcg::Pcg64Mcg;

use super::Effort;

/// Number and seed of rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rays {
    /// Rays per incidence; rounded up to a square of whole tiles.
    pub count: u64,
    /// The seed; every ray has a stream of its own.
    pub seed: u64,
}

/// Largest side of a tile, in rays; even, for the error is found from pairs.
const MOST_SIDE: u32 = 128;

/// Rays of a draft where all light is left to them.
const DRAFT: u64 = 100_000;

impl Rays {
    /// As many, but in a draft enough to tell one law from another if all light is left to them.
    pub(super) fn for_draft(self, effort: Effort) -> Self {
        let least = if effort == Effort::Draft { DRAFT } else { 0 };
        Self { count: self.count.max(least), ..self }
    }

    /// The tiles of an incidence.
    pub(crate) fn tiles(self, sigma_deg: f64) -> Tiles {
        let side = (self.count.max(1) as f64).sqrt().ceil().min(f64::from(1 << 24)) as u32;
        let tile = side.div_ceil(8).next_multiple_of(2).min(MOST_SIDE);
        let tiles = side.div_ceil(tile);
        Tiles { key: mix(mix(0, self.seed), sigma_deg.to_bits()), tile, along: tiles }
    }
}

/// A square of tiles, each a square of rays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tiles {
    key: u64,
    /// Rays along the side of a tile.
    tile: u32,
    /// Tiles along a side.
    along: u32,
}

impl Tiles {
    /// Number of tiles.
    pub(crate) fn count(self) -> u64 {
        u64::from(self.along) * u64::from(self.along)
    }

    /// Rays in a tile: an even number.
    pub(crate) fn rays_each(self) -> u32 {
        self.tile * self.tile
    }

    /// The random numbers of a ray of a tile; an even and the odd number after it are neighbours.
    #[inline]
    pub(crate) fn ray(self, tile: u64, number: u32) -> Uniforms {
        let a = mix(mix(self.key, tile), u64::from(number));
        let mut generator = Pcg64Mcg::new((u128::from(a) << 64) | u128::from(mix(a, 1)));
        let width = 1.0 / (f64::from(self.along) * f64::from(self.tile));
        let tiles = u64::from(self.along);
        let corner = [tile % tiles, tile / tiles].map(|t| t as f64 * f64::from(self.tile));
        let square = [number % self.tile, number / self.tile].map(f64::from);
        let mut within = |k: usize| {
            let place = (corner[k] + square[k] + f64::uniform(&mut generator)) * width;
            place.min(1.0 - f64::EPSILON)
        };
        let first = [within(0), within(1)];
        Uniforms { first, taken: 0, generator }
    }
}

/// The random numbers of one ray.
pub(crate) struct Uniforms {
    first: [f64; 2],
    taken: usize,
    generator: Pcg64Mcg,
}

impl Uniforms {
    #[inline]
    pub(crate) fn next(&mut self) -> f64 {
        let taken = self.taken;
        self.taken = taken + 1;
        match self.first.get(taken) {
            Some(u) => *u,
            None => f64::uniform(&mut self.generator),
        }
    }
}

/// Avalanches a word into a state (splitmix64).
pub(crate) fn mix(state: u64, word: u64) -> u64 {
    let mut z = (state ^ word).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::{Rays, Uniforms};

    #[test]
    fn one_ray_starts_in_every_square() {
        for count in [1, 50, 1000, 100_000] {
            let tiles = Rays { count, seed: 3 }.tiles(30.0);
            let side = (tiles.tile * tiles.along) as usize;
            assert!((side * side) as u64 >= count && tiles.rays_each().is_multiple_of(2));
            let mut seen = vec![0_u32; side * side];
            for tile in 0..tiles.count() {
                for k in 0..tiles.rays_each() {
                    let mut u = tiles.ray(tile, k);
                    let [x, y] = [u.next(), u.next()].map(|u| (u * side as f64) as usize);
                    seen[y * side + x] += 1;
                    assert!((0.0..1.0).contains(&u.next()));
                }
            }
            assert!(seen.iter().all(|n| *n == 1), "{count}");
        }
        // a round number is not much exceeded
        let tiles = Rays { count: 10_000_000, seed: 1 }.tiles(0.0);
        assert!(tiles.count() * u64::from(tiles.rays_each()) < 10_500_000);
    }

    #[test]
    fn seeds_incidences_tiles_and_rays_have_streams_of_their_own() {
        let tiles = |seed, sigma| Rays { count: 1000, seed }.tiles(sigma);
        let third = |mut u: Uniforms| (u.next(), u.next(), u.next()).2;
        let all = [
            third(tiles(1, 0.0).ray(0, 0)),
            third(tiles(2, 0.0).ray(0, 0)),
            third(tiles(1, 1.0).ray(0, 0)),
            third(tiles(1, 0.0).ray(1, 0)),
            third(tiles(1, 0.0).ray(0, 1)),
        ];
        for (k, a) in all.iter().enumerate() {
            assert!(all[..k].iter().all(|b| (a - b).abs() > 1e-9), "{all:?}");
        }
    }
}
