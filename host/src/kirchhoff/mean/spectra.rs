//! The mean density `D(|q|, q_z)` of the diffuse light of a map whose directions are all alike.
//!
//! A map is one sample of a surface, and its far field is speckle. What a larger piece of the same surface scatters is
//! the mean over rings of constant `|q_xy|`, of which there are 2 pi |q| / step orders. It depends on the
//! wavelength, the incidence and the vertical scale of the heights by `q_xy` and `q_z` alone, so one table serves
//! them all: a transform for each of a few `q_z`, 0.15 apart in logarithm, and cubic
//! interpolation of ln D between them. What is left of the speckle is known from the spread on each ring.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use asperity_fourier::{Coefficients, Fourier};
use rayon::prelude::*;
use rustfft::num_complex::Complex;

use super::coherent::Coherent;
use super::density::{Density, STEP};
use super::rings::{Node, Rings};
use crate::kirchhoff::field::phase;
use crate::surface::{Edges, HeightMap, Incomplete};

/// A map ready to be averaged at any `q_z`; what was computed is kept.
pub struct MeanSpectra {
    fourier: Fourier<f32>,
    nx: usize,
    heights_um: Vec<f64>,
    /// Hann's window along x and y; empty for a periodic map.
    windows: [Vec<f32>; 2],
    rings: Rings,
    radii: Arc<Vec<f64>>,
    coherent: Coherent,
    nodes: Mutex<BTreeMap<i32, Arc<Node>>>,
}

impl std::fmt::Debug for MeanSpectra {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MeanSpectra")
            .field("rings", &self.rings.radii.len())
            .finish_non_exhaustive()
    }
}

impl MeanSpectra {
    /// For a complete map. A map that is not periodic is weighted by Hann's window.
    ///
    /// # Errors
    /// [`Incomplete`] if points are missing.
    pub fn new(map: &HeightMap, edges: Edges) -> Result<Self, Incomplete> {
        let heights = map.need_complete()?;
        let (nx, ny) = (map.nx(), map.ny());
        let middle = heights.iter().sum::<f64>() / heights.len() as f64;
        let hann = |n: usize| -> Vec<f32> {
            if edges == Edges::Periodic {
                return Vec::new();
            }
            let at = |k: usize| (std::f64::consts::PI * (k as f64 + 0.5) / n as f64).sin().powi(2);
            (0..n).map(|k| at(k) as f32).collect()
        };
        let step = [(nx, map.dx_um()), (ny, map.dy_um())]
            .map(|(n, pitch)| std::f64::consts::TAU / (n as f64 * pitch));
        let rings = Rings::new((nx, ny), step, edges == Edges::Periodic);
        let windows = [hann(nx), hann(ny)];
        let weight = |k: usize| {
            let of = |n: usize, at: usize| windows[n].get(at).map_or(1.0, |w| f64::from(*w));
            of(0, k % nx) * of(1, k / nx)
        };
        let coherent = Coherent::new(heights, weight);
        Ok(Self {
            fourier: Fourier::new((nx, ny), Edges::Periodic),
            nx,
            heights_um: heights.iter().map(|h| h - middle).collect(),
            windows,
            radii: Arc::new(rings.radii.clone()),
            rings,
            coherent,
            nodes: Mutex::new(BTreeMap::new()),
        })
    }

    /// `|mean field|^2` at a `q_z`, under the window if there is one.
    pub(super) fn coherent(&self, q_z: f64) -> f64 {
        self.coherent.intensity(q_z)
    }

    /// The density for `q_z` from `low` to `high`, 1/um; below `low` it falls with the square of `q_z`.
    pub(super) fn density(&self, low: f64, high: f64) -> Density {
        let number = |q_z: f64| q_z.max(1e-12).ln() / STEP;
        let first = number(low).floor() as i32 - 1;
        let last = number(high.max(low)).ceil() as i32 + 1;
        let mut kept = self.nodes.lock().unwrap_or_else(PoisonError::into_inner);
        let missing: Vec<i32> = (first..=last).filter(|k| !kept.contains_key(k)).collect();
        if !missing.is_empty() {
            let mut room = self.fourier.room();
            for k in missing {
                let node = self.node((f64::from(k) * STEP).exp(), &mut room);
                kept.insert(k, Arc::new(node));
            }
        }
        let nodes = (first..=last).filter_map(|k| kept.get(&k).cloned()).collect();
        Density::new(first, nodes, Arc::clone(&self.radii), (self.rings.base, self.rings.ends))
    }

    fn node(&self, q_z: f64, room: &mut Coefficients<f32>) -> Node {
        let nx = self.nx;
        let turns = q_z / std::f64::consts::TAU;
        let ones = vec![1.0; nx];
        let rows: Vec<Complex<f64>> = self
            .heights_um
            .par_chunks(nx)
            .map_init(
                || vec![Complex::default(); nx],
                |line, heights| {
                    phase(heights, &ones, turns, line);
                    line.iter().map(|u| Complex::new(f64::from(u.re), f64::from(u.im))).sum()
                },
            )
            .collect();
        // the mean over all points is the best estimate of the coherent field
        let mean = rows.iter().sum::<Complex<f64>>() / self.heights_um.len() as f64;
        let coherent = Complex::new(mean.re as f32, mean.im as f32);
        self.fourier.transform(
            |j, line| {
                phase(&self.heights_um[j * nx..(j + 1) * nx], &ones, turns, line);
                for u in line.iter_mut() {
                    *u -= coherent;
                }
                if let Some(&across) = self.windows[1].get(j) {
                    for (u, w) in line.iter_mut().zip(&self.windows[0]) {
                        *u *= w * across;
                    }
                }
            },
            room,
        );
        self.rings.averaged(room, (1.0 - self.coherent(q_z)).max(0.0))
    }
}
