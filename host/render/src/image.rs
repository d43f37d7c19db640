//! An image in tiles that are rendered in passes.
//!
//! Every path has a stream of random numbers by its pixel and its number, and every tile adds up its paths in their order: the
//! image has the same bits with any number of threads, in one run or in several, on one machine or in shares of the tiles.

use std::ops::ControlFlow;

use rayon::prelude::*;

use crate::colour;
use crate::numbers::{EvenPoints, mix, stream};
use crate::path::Tracer;
use crate::tally::{BodySum, PixelSum};

/// Pixels of the side of a tile.
const TILE: u32 = 32;
/// Paths that a pixel is given in one pass.
pub const PASS: u32 = 16;

/// When a tile is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Paths per pixel at most; rounded up to whole passes.
    pub paths: u32,
    /// Noise at which a tile is done: the rms standard error of its pixels over their mean.
    pub until: Option<f64>,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// One of several machines that share the tiles: number 0 to `of` - 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Which.
    pub part: usize,
    /// Of how many.
    pub of: usize,
}

impl Share {
    /// All of the tiles.
    pub const ALL: Self = Self { part: 0, of: 1 };
}

/// A tile as far as it is rendered.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tile {
    /// Passes done.
    pub passes: u32,
    /// Its pixels, row by row; none before the first pass.
    pub pixels: Vec<PixelSum>,
    /// The bodies seen in it.
    pub bodies: Vec<BodySum>,
}

/// An image as far as it is rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels across and down.
    pub pixels: [u32; 2],
    /// Its tiles, row by row.
    pub tiles: Vec<Tile>,
}

/// The pixels of a tile.
struct Place {
    from: [u32; 2],
    to: [u32; 2],
}

impl Image {
    /// Nothing rendered yet.
    pub fn new(pixels: [u32; 2]) -> Self {
        let [across, down] = pixels.map(|n| n.div_ceil(TILE) as usize);
        Self { pixels, tiles: vec![Tile::default(); across * down] }
    }

    fn place(&self, tile: usize) -> Place {
        let across = self.pixels[0].div_ceil(TILE) as usize;
        let from = [(tile % across) as u32 * TILE, (tile / across) as u32 * TILE];
        let to = [0, 1].map(|k| (from[k] + TILE).min(self.pixels[k]));
        Place { from, to }
    }

    /// Pixels of a tile across and down.
    pub fn tile_pixels(&self, tile: usize) -> [u32; 2] {
        let Place { from, to } = self.place(tile);
        [to[0] - from[0], to[1] - from[1]]
    }

    /// Renders pass after pass until the share's tiles are done. `tell` hears the share of the work that is done and says whether
    /// to go on; an image that is stopped is whole as far as it is, and can be continued.
    pub fn render(
        &mut self,
        tracer: &Tracer<'_>,
        effort: Effort,
        share: Share,
        tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) {
        let weights = colour::weights(tracer.scene().bands());
        let mine = |tile: usize| tile % share.of == share.part;
        loop {
            let numbers = (0..self.tiles.len()).filter(|t| mine(*t));
            let shares: Vec<(usize, f64)> =
                numbers.map(|t| (t, self.tiles[t].done(effort))).collect();
            let sum: f64 = shares.iter().map(|(_, done)| done).sum();
            let wanting: Vec<usize> =
                shares.iter().filter(|(_, done)| *done < 1.0).map(|(t, _)| *t).collect();
            if tell(sum / shares.len().max(1) as f64).is_break() || wanting.is_empty() {
                return;
            }
            let grown: Vec<(usize, Tile)> = wanting
                .into_par_iter()
                .map(|t| (t, self.grown(t, tracer, effort.seed, &weights)))
                .collect();
            for (t, tile) in grown {
                self.tiles[t] = tile;
            }
        }
    }

    /// A tile after one more pass.
    fn grown(&self, number: usize, tracer: &Tracer<'_>, seed: u64, weights: &[[f64; 3]]) -> Tile {
        let scene = tracer.scene();
        let mut tile = self.tiles[number].clone();
        let Place { from, to } = self.place(number);
        let [across, down] = [to[0] - from[0], to[1] - from[1]];
        tile.pixels.resize((across * down) as usize, PixelSum::default());
        tile.bodies.resize(scene.bodies.len(), BodySum::default());
        for y in from[1]..to[1] {
            for x in from[0]..to[0] {
                let pixel = u64::from(y) * u64::from(self.pixels[0]) + u64::from(x);
                let key = mix(mix(0x1ce, seed), pixel);
                let points = EvenPoints::new(key);
                let sum = &mut tile.pixels[((y - from[1]) * across + x - from[0]) as usize];
                for k in 0..PASS {
                    let path = u64::from(tile.passes * PASS + k);
                    let [u, v] = points.at(path);
                    let band = path as usize % weights.len();
                    let ray = scene.camera.ray([f64::from(x) + u, f64::from(y) + v]);
                    let seen = tracer.follow(ray, band, &mut stream(mix(key, path)));
                    sum.add(&seen, weights[band]);
                    if let Some(first) = &seen.first {
                        tile.bodies[first.body].add(seen.radiance, first.cosine);
                    }
                }
            }
        }
        tile.passes += 1;
        tile
    }

    /// The pixel in a column and a row.
    pub fn pixel(&self, x: u32, y: u32) -> PixelSum {
        let across = self.pixels[0].div_ceil(TILE);
        let number = ((y / TILE) * across + x / TILE) as usize;
        let Place { from, to } = self.place(number);
        let at = ((y - from[1]) * (to[0] - from[0]) + x - from[0]) as usize;
        self.tiles[number].pixels.get(at).copied().unwrap_or_default()
    }

    /// What is seen of a body, over all tiles.
    pub fn body(&self, number: usize) -> BodySum {
        let mut sum = BodySum::default();
        for tile in &self.tiles {
            if let Some(part) = tile.bodies.get(number) {
                sum.merge(part);
            }
        }
        sum
    }

    /// Noise: the rms standard error of the pixels over their mean radiance; `None` before the second path of any.
    pub fn noise(&self) -> Option<f64> {
        let sums = self.tiles.iter().map(Tile::noise_sums);
        let (squares, radiance, count) =
            sums.fold((0.0, 0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
        (count > 0.0 && radiance > 0.0).then(|| (squares / count).sqrt() / (radiance / count))
    }

    /// Paths in all.
    pub fn paths(&self) -> f64 {
        self.tiles.iter().flat_map(|tile| &tile.pixels).map(|pixel| pixel.count).sum()
    }
}

impl Tile {
    /// Whether nothing is left to be rendered of it.
    pub fn is_done(&self, effort: Effort) -> bool {
        self.done(effort) >= 1.0
    }

    /// Sums of squared standard errors and of radiances of its pixels, and their number.
    fn noise_sums(&self) -> (f64, f64, f64) {
        let (mut squares, mut radiance) = (0.0, 0.0);
        for pixel in &self.pixels {
            squares += pixel.std_error() * pixel.std_error();
            radiance += pixel.radiance / pixel.count.max(1.0);
        }
        (squares, radiance, self.pixels.len() as f64)
    }

    /// How far it is, 0 to 1.
    fn done(&self, effort: Effort) -> f64 {
        let passes = effort.paths.div_ceil(PASS).max(1);
        let by_paths = f64::from(self.passes) / f64::from(passes);
        let Some(until) = effort.until else { return by_paths.min(1.0) };
        // two passes at least, for an error that can be believed
        if self.passes < 2 {
            return 0.0;
        }
        let (squares, radiance, count) = self.noise_sums();
        let (noise, wanted) = ((squares / count).sqrt(), until * radiance / count);
        let by_noise = if noise <= wanted { 1.0 } else { (wanted / noise).powi(2).min(0.99) };
        by_paths.max(by_noise).min(1.0)
    }
}
