//! The stack of transforms over `q_z` that all orders of all beams share.

use asperity_fourier::{Coefficients, Ends, Fourier};
use rustfft::num_complex::Complex;

use super::kernel::{Kernel, WIDTH};
use super::patch::{Rim, RimPlane};
use super::screen::phase;
use crate::surface::{Edges, HeightMap, Incomplete};
use crate::watch::Watch;

/// The surroundings of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tiling {
    /// The map again.
    Periodic,
    /// Its mirror images.
    Mirrored,
    /// Nothing: only the map is lit, as a patch; its orders half as far apart as those of a period, and its coherent
    /// light as wide as diffraction at the patch makes it.
    Patch,
}

impl From<Edges> for Tiling {
    fn from(edges: Edges) -> Self {
        match edges {
            Edges::Periodic => Self::Periodic,
            Edges::Mirrored => Self::Mirrored,
        }
    }
}

/// A map ready to be transformed at any `q_z`.
pub(super) struct Stack {
    fourier: Fourier<f32>,
    pub(super) ends: Ends,
    pub(super) size: [usize; 2],
    pub(super) step: [f64; 2],
    /// From `|A|^2` of the whole field to that of the lit part, by order.
    pub(super) unit: f64,
    heights_um: Vec<f64>,
    weights: Vec<f32>,
    pub(super) kernel: Kernel,
    /// Of a patch.
    pub(super) rim: Option<Rim>,
}

/// One transform of a stack.
pub(super) struct Plane<'a> {
    pub(super) coefficients: &'a Coefficients<f32>,
    /// Of a patch.
    pub(super) rim: Option<RimPlane<'a>>,
    pub(super) q_z: f64,
}

impl Stack {
    pub(super) fn new(map: &HeightMap, tiling: Tiling) -> Result<Self, Incomplete> {
        let heights = map.need_complete()?;
        let range = heights
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(*h), b.max(*h)));
        let (middle, reach) = (0.5 * (range.0 + range.1), 0.5 * (range.1 - range.0));
        let mut heights_um: Vec<f64> = heights.iter().map(|h| h - middle).collect();
        let kernel = Kernel::new(reach);
        let mut weights = kernel.weights(&heights_um, reach);
        let (mut nx, mut ny) = (map.nx(), map.ny());
        let periods = if tiling == Tiling::Periodic { 1.0 } else { 2.0 };
        let step = [(nx, map.dx_um()), (ny, map.dy_um())]
            .map(|(n, pitch)| std::f64::consts::TAU / (periods * n as f64 * pitch));
        let (mut ends, mut unit, mut rim) = (Ends::Periodic, 1.0, None);
        match tiling {
            Tiling::Periodic => {}
            Tiling::Mirrored => ends = Ends::Mirrored,
            Tiling::Patch => {
                let pitch = [map.dx_um(), map.dy_um()];
                rim = Some(Rim::new(&heights_um, &weights, nx, pitch));
                (heights_um, weights) = (doubled(&heights_um, nx), doubled(&weights, nx));
                (nx, ny) = (2 * nx, 2 * ny);
                // a quarter of the area is lit: A is a quarter, and an order stands for a quarter of a cell
                unit = 4.0;
            }
        }
        let fourier = Fourier::new((nx, ny), ends);
        Ok(Self { fourier, ends, size: [nx, ny], step, unit, heights_um, weights, kernel, rim })
    }

    /// Lowest and highest order of a direction that the pitch can show.
    pub(super) fn numbers(&self, axis: usize) -> (isize, isize) {
        let n = self.size[axis] as isize;
        match self.ends {
            Ends::Periodic => (-(n / 2), (n - 1) / 2),
            Ends::Mirrored => (1 - n, n - 1),
        }
    }

    /// The planes that ranges of `q_z` in 1/um need, as multiples of the kernel's distance.
    pub(super) fn planes(&self, ranges: impl Iterator<Item = (f64, f64)>) -> std::ops::Range<i64> {
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = ranges.fold(none, |(a, b), (l, h)| (a.min(l), b.max(h)));
        let (low, high) = (low / self.kernel.distance, high / self.kernel.distance);
        let half = 0.5 * WIDTH as f64;
        if low > high { 0..0 } else { (low - half).ceil() as i64..(high + half).floor() as i64 + 1 }
    }

    /// Transforms planes one after the other and gives each to `take`; false if stopped.
    pub(super) fn each(
        &self,
        planes: std::ops::Range<i64>,
        watch: Watch<'_>,
        mut take: impl FnMut(&Plane<'_>),
    ) -> bool {
        let mut room = self.fourier.room();
        let nx = self.size[0];
        for number in planes {
            if watch.is_stopped() {
                return false;
            }
            let q_z = number as f64 * self.kernel.distance;
            let turns = q_z / std::f64::consts::TAU;
            let row = |j: usize, out: &mut [Complex<f32>]| {
                let at = j * nx..(j + 1) * nx;
                phase(&self.heights_um[at.clone()], &self.weights[at], turns, out);
            };
            self.fourier.transform(row, &mut room);
            let rim = self.rim.as_ref().map(|rim| rim.plane(turns));
            take(&Plane { coefficients: &room, rim, q_z });
        }
        true
    }
}

/// A grid in the first quarter of one of twice its sides, nothing around it.
fn doubled<T: Copy + Default>(grid: &[T], nx: usize) -> Vec<T> {
    let mut wide = vec![T::default(); 4 * grid.len()];
    for (to, from) in wide.chunks_exact_mut(2 * nx).zip(grid.chunks_exact(nx)) {
        to[..nx].copy_from_slice(from);
    }
    wide
}
