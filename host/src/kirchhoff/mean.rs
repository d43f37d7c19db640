//! The mean density `D(|q|, q_z)` of the diffuse light of a map whose directions are all alike.
//!
//! A map is one sample of a surface, and its far field is speckle. What a larger piece of the same surface scatters is
//! the mean over rings of constant `|q_xy|`, of which there are 2 pi |q| / step orders. It depends on the
//! wavelength, the incidence and the vertical scale of the heights by `q_xy` and `q_z` alone, so one table serves
//! them all: a transform for each of a few `q_z`, a tenth apart in logarithm, and cubic
//! interpolation of ln D between them. What is left of the speckle is known from the spread on each ring.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;
use rustfft::num_complex::Complex;

use super::coherent::Coherent;
use super::fft::Fourier;
use super::screen::phase;
use crate::surface::{Edges, HeightMap, Incomplete};

/// Steps of ln `q_z`.
const STEP: f64 = 0.1;
/// Growth of the rings' width with their radius.
const GROWTH: f64 = 0.04;
/// What stands for no light: ln of a density.
const DARK: f64 = -230.0;

/// A map ready to be averaged at any `q_z`; what was computed is kept.
pub struct MeanSpectra {
    fourier: Fourier<f32>,
    nx: usize,
    heights_um: Vec<f64>,
    /// Hann's window along x and y; empty for a periodic map.
    windows: [Vec<f32>; 2],
    rings: Rings,
    pitches_um: [f64; 2],
    coherent: Coherent,
    nodes: Mutex<BTreeMap<i32, Arc<Node>>>,
}

impl std::fmt::Debug for MeanSpectra {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MeanSpectra").field("rings", &self.rings.radii.len()).finish_non_exhaustive()
    }
}

/// Which ring an order belongs to.
#[derive(Clone, Debug)]
struct Rings {
    /// Mean radius of each, 1/um; ascending.
    radii: Vec<f64>,
    /// Area of the orders in each, 1/um^2.
    areas: Vec<f64>,
    /// Radius of the smallest order, 1/um.
    base: f64,
}

/// The mean density at one `q_z`.
#[derive(Debug)]
pub(super) struct Node {
    /// ln D by ring, D in um^2.
    pub(super) ln_density: Vec<f64>,
    /// Relative standard error of D by ring: the speckle that is left.
    pub(super) speckle: Vec<f32>,
    /// `integral of D over q` up to each ring's outer edge.
    pub(super) cumulated: Vec<f64>,
}

/// Number of a ring: one order wide near the centre, then in proportion to the radius.
fn ring(orders: f64) -> usize {
    // integral of d r / (1 + g r)
    ((1.0 + GROWTH * orders).ln() / GROWTH).round() as usize
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
        Ok(Self {
            fourier: Fourier::new((nx, ny), Edges::Periodic),
            nx,
            heights_um: heights.iter().map(|h| h - middle).collect(),
            windows: [hann(nx), hann(ny)],
            rings: Rings::new((nx, ny), step),
            pitches_um: [map.dx_um(), map.dy_um()],
            coherent: Coherent::new(heights),
            nodes: Mutex::new(BTreeMap::new()),
        })
    }

    /// `|mean field|^2` at a `q_z`.
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
        let mut room = self.fourier.room();
        for k in missing {
            let node = self.node((f64::from(k) * STEP).exp(), &mut room);
            kept.insert(k, Arc::new(node));
        }
        let nodes = (first..=last).filter_map(|k| kept.get(&k).cloned()).collect();
        Density { first, nodes, radii: self.rings.radii.clone(), base: self.rings.base }
    }

    fn node(&self, q_z: f64, room: &mut super::fft::Coefficients<f32>) -> Node {
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
        self.rings.averaged(room, (1.0 - mean.norm_sqr()).max(0.0), self.windows[0].is_empty())
    }

    /// Pitch of the map, um.
    pub(super) fn pitches_um(&self) -> [f64; 2] {
        self.pitches_um
    }
}

impl Rings {
    fn new((nx, ny): (usize, usize), step: [f64; 2]) -> Self {
        let base = (step[0] * step[1]).sqrt();
        let mut this = Self { radii: Vec::new(), areas: Vec::new(), base };
        let mut count: Vec<u64> = Vec::new();
        each_order((nx, ny), step, |_, radius| {
            let at = ring(radius / base);
            if at >= count.len() {
                count.resize(at + 1, 0);
                this.radii.resize(at + 1, 0.0);
            }
            count[at] += 1;
            this.radii[at] += radius;
        });
        for (radius, n) in this.radii.iter_mut().zip(&count) {
            *radius /= (*n).max(1) as f64;
        }
        this.areas = count.iter().map(|n| *n as f64 * step[0] * step[1]).collect();
        // a ring that no order falls into takes its place between the others
        for k in 1..this.radii.len() {
            if count[k] == 0 {
                this.radii[k] = this.radii[k - 1] + base;
            }
        }
        this
    }

    /// Means over rings, scaled so that all of them hold `total`.
    fn averaged(
        &self,
        of: &super::fft::Coefficients<f32>,
        total: f64,
        periodic: bool,
    ) -> Node {
        let [nx, ny] = of.size();
        let step = self.base;
        let n = self.radii.len();
        // columns in fixed blocks, so that the sums do not depend on the threads
        let sums: Vec<Vec<[f64; 3]>> = (0..nx.div_ceil(64))
            .into_par_iter()
            .map(|block| {
                let mut sums = vec![[0.0; 3]; n];
                for x in block * 64..((block + 1) * 64).min(nx) {
                    let column = of.column(x as isize);
                    let qx = of.frequency(0, x);
                    for (y, a) in column.iter().enumerate() {
                        let radius = qx.hypot(of.frequency(1, y));
                        let _ = (radius, a, step, ny, periodic);
                        let at = 0;
                        let power = f64::from(a.norm_sqr());
                        sums[at][0] += 1.0;
                        sums[at][1] += power;
                        sums[at][2] += power * power;
                    }
                }
                sums
            })
            .collect();
        let _ = (sums, total);
        todo!()
    }
}

fn each_order((nx, ny): (usize, usize), step: [f64; 2], mut one: impl FnMut(usize, f64)) {
    let signed = |k: usize, n: usize| if 2 * k < n { k as f64 } else { k as f64 - n as f64 };
    for x in 0..nx {
        for y in 0..ny {
            let radius = (signed(x, nx) * step[0]).hypot(signed(y, ny) * step[1]);
            if x + y > 0 {
                one(x * ny + y, radius);
            }
        }
    }
}
