//! Mean radiances of rectangles of the image, to a wanted error.

use std::ops::ControlFlow;

use rayon::prelude::*;

use crate::numbers::{EvenPoints, mix, stream};
use crate::path::Tracer;

/// A rectangle of the image, in pixels: from the first corner up to the second.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Its name.
    pub name: String,
    /// Upper left corner.
    pub from: [f64; 2],
    /// Lower right corner.
    pub to: [f64; 2],
}

/// A mean with its error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mean {
    /// The mean radiance.
    pub mean: f64,
    /// Its standard error.
    pub std_error: f64,
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Until {
    /// Standard error over the mean.
    pub relative: f64,
    /// Paths of a region at most.
    pub most: u64,
    /// Seed.
    pub seed: u64,
}

/// Batches from which the error is found at least.
const LEAST_BATCHES: usize = 32;
/// Batches added at once.
const GROUP: usize = 8;
/// Paths of a batch.
const BATCH: u64 = 4096;
/// How much more than needed by the error so far is made before it is looked at again. Bright paths are rare: whoever looks after
/// each batch stops where few of them have come, and is too dark.
const SPARE: f64 = 1.25;

/// The mean of each region until all are as exact as wanted. Batches of evenly spread points, each shifted by chance, give
/// the mean, and their scatter its error. `tell` hears the share that is done and says whether to go on; stopped, the
/// means so far are given.
///
/// The same bits with any number of threads.
pub fn region_means(
    tracer: &Tracer<'_>,
    regions: &[Region],
    until: Until,
    tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Vec<Mean> {
    let shares: Vec<f64> = tracer.scene().bands().iter().map(|band| band.share).collect();
    let mut batches: Vec<Vec<f64>> = vec![Vec::new(); regions.len()];
    let mut wanted = vec![LEAST_BATCHES; regions.len()];
    loop {
        for (wanted, batches) in wanted.iter_mut().zip(&batches) {
            if batches.len() >= *wanted {
                *wanted = needed(batches, until);
            }
        }
        let (have, want) =
            (batches.iter().map(Vec::len).sum::<usize>(), wanted.iter().sum::<usize>());
        if have >= want || tell(have as f64 / want as f64).is_break() {
            break;
        }
        let missing = |k: usize| batches[k].len()..wanted[k].min(batches[k].len() + GROUP);
        let work: Vec<(usize, usize)> =
            (0..regions.len()).flat_map(|k| missing(k).map(move |b| (k, b))).collect();
        let one = |&(region, number): &(usize, usize)| {
            batch(tracer, &regions[region], (region, number), (until.seed, &shares))
        };
        let found: Vec<f64> = work.par_iter().map(one).collect();
        for ((region, _), mean) in work.into_iter().zip(found) {
            batches[region].push(mean);
        }
    }
    batches.iter().map(|b| mean(b)).collect()
}

/// The mean of a batch of paths.
fn batch(
    tracer: &Tracer<'_>,
    region: &Region,
    (place, number): (usize, usize),
    (seed, shares): (u64, &[f64]),
) -> f64 {
    let key = mix(mix(mix(0x4e61, seed), place as u64), number as u64);
    let points = EvenPoints::new(key);
    let camera = tracer.scene().camera;
    let mut sum = 0.0;
    for k in 0..BATCH {
        let u = points.at(k);
        let at = [0, 1].map(|a| region.from[a] + u[a] * (region.to[a] - region.from[a]));
        let mut numbers = stream(mix(key, k));
        let band = k as usize % shares.len().max(1);
        let weight = shares.get(band).map_or(1.0, |share| share * shares.len() as f64);
        sum += weight * tracer.follow(camera.ray(at), band, &mut numbers).radiance;
    }
    sum / BATCH as f64
}

fn mean(batches: &[f64]) -> Mean {
    let n = batches.len() as f64;
    if batches.len() < 2 {
        return Mean { mean: batches.first().copied().unwrap_or(f64::NAN), std_error: f64::NAN };
    }
    let mean = batches.iter().sum::<f64>() / n;
    let squares: f64 = batches.iter().map(|b| (b - mean) * (b - mean)).sum();
    Mean { mean, std_error: (squares / (n * (n - 1.0))).sqrt() }
}

/// Batches that a region needs by the error it has: as many as it has if that is small enough.
fn needed(batches: &[f64], until: Until) -> usize {
    let Mean { mean, std_error } = mean(batches);
    let ratio = std_error / (until.relative * mean.abs());
    // black regions are done
    if ratio <= 1.0 || ratio.is_nan() {
        return batches.len();
    }
    let most = (until.most / BATCH) as usize;
    let more = (SPARE * ratio * ratio * batches.len() as f64).ceil() as usize;
    more.max(batches.len() + GROUP).min(most.max(batches.len()))
}
