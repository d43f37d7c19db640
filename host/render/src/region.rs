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
const LEAST_BATCHES: usize = 24;
/// Batches added at once.
const GROUP: usize = 8;
/// Paths of a batch.
const BATCH: u64 = 4096;

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
    loop {
        let dones: Vec<f64> = batches.iter().map(|b| done(b, until)).collect();
        let least = dones.iter().copied().fold(1.0, f64::min);
        if least >= 1.0 || tell(least).is_break() {
            break;
        }
        let wanting: Vec<usize> = (0..regions.len()).filter(|k| dones[*k] < 1.0).collect();
        let work: Vec<(usize, usize)> = wanting
            .iter()
            .flat_map(|&k| (batches[k].len()..batches[k].len() + GROUP).map(move |b| (k, b)))
            .collect();
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

/// How far a region is, 0 to 1.
fn done(batches: &[f64], until: Until) -> f64 {
    if batches.len() < LEAST_BATCHES {
        return 0.01 * batches.len() as f64 / LEAST_BATCHES as f64;
    }
    if batches.len() as u64 * BATCH >= until.most {
        return 1.0;
    }
    let Mean { mean, std_error } = mean(batches);
    if std_error <= until.relative * mean.abs() || (mean.abs() <= 0.0 && std_error <= 0.0) {
        return 1.0;
    }
    (until.relative * mean / std_error).powi(2).clamp(0.01, 0.99)
}
