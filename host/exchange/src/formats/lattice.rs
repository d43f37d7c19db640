//! A lobe as the product of four lists: azimuths and polar angles of the incidence, azimuths and radii about the ray.

use crate::error::CannotHold;
use crate::frame::Frame;
use crate::sampled::{Grid, Incidence, Nodes, SampledBsdf};

/// Such a lobe.
#[derive(Debug)]
pub(super) struct Lattice<'a> {
    /// Polar angles of the incidences.
    pub(super) thetas: Vec<f64>,
    /// Azimuths of the incidences.
    pub(super) phis: Vec<f64>,
    /// Polar angle of the specular or direct ray of each of `thetas`.
    pub(super) rays: Vec<f64>,
    /// The grid of the first incidence; the others differ in the ray alone.
    pub(super) grid: &'a Grid,
    /// Whether the first azimuth must be written again a turn later, for readers that do not go round.
    pub(super) is_open: bool,
    /// Whether a mirrored grid is written whole, for formats that have no word for it.
    pub(super) unfolds: bool,
    /// Places in the lobe, the polar angle fastest.
    order: Vec<usize>,
}

/// Angles nearer than this are the same.
const SAME: f64 = 2e-9;

impl<'a> Lattice<'a> {
    pub(super) fn of(format: &'static str, lobe: &'a SampledBsdf) -> Result<Self, CannotHold> {
        let refuse = |what: &str, remedy: &str| CannotHold {
            format,
            what: what.into(),
            remedy: remedy.into(),
        };
        let mut grids = Vec::new();
        for incidence in &lobe.incidences {
            match &incidence.nodes {
                Nodes::Grid(grid) => match grid.frame {
                    Frame::Specular { theta } => grids.push((grid, theta)),
                    Frame::Absolute | Frame::Cosines { .. } => {
                        return Err(refuse("a grid of other angles", "sample it anew"));
                    }
                },
                _ => return Err(refuse("single directions", "sample it anew, or write csv")),
            }
        }
        let Some(&(grid, _)) = grids.first() else {
            return Err(refuse("a lobe without incidences", "give some with --incidence"));
        };
        let same = |a: &[f64], b: &[f64]| {
            a.len() == b.len() && a.iter().zip(b).all(|(x, y)| (x - y).abs() < SAME)
        };
        if !grids.iter().all(|(g, _)| {
            same(&g.radii, &grid.radii)
                && same(&g.azimuths, &grid.azimuths)
                && g.mirrored == grid.mirrored
        }) {
            return Err(refuse("incidences with different grids", "sample it anew"));
        }
        let thetas = different(lobe.incidences.iter().map(|i| i.theta));
        let phis = different(lobe.incidences.iter().map(|i| i.phi));
        let find = |theta: f64, phi: f64| {
            let is = |i: &Incidence| (i.theta - theta).abs() < SAME && (i.phi - phi).abs() < SAME;
            lobe.incidences.iter().position(is)
        };
        let order: Option<Vec<usize>> =
            phis.iter().flat_map(|p| thetas.iter().map(|t| find(*t, *p))).collect();
        let Some(order) = order.filter(|o| o.len() == lobe.incidences.len()) else {
            return Err(refuse(
                "rotations with different incidences",
                "give the same ones for each",
            ));
        };
        let rays = order.iter().take(thetas.len()).map(|k| grids[*k].1).collect();
        let turn = std::f64::consts::TAU;
        let ends = grid.azimuths.first().zip(grid.azimuths.last());
        let is_open = !grid.mirrored && ends.is_some_and(|(a, b)| b - a < turn - SAME);
        Ok(Self { thetas, phis, rays, grid, is_open, unfolds: false, order })
    }

    /// The azimuths about the ray: with the first one again if the circle is open, with the other half if it unfolds.
    pub(super) fn azimuths(&self) -> Vec<f64> {
        let mut azimuths = self.grid.azimuths.clone();
        if self.unfolds {
            azimuths.extend(self.other_half().map(|a| std::f64::consts::TAU - a));
        }
        if let (true, Some(first)) = (self.is_open, azimuths.first().copied()) {
            azimuths.push(first + std::f64::consts::TAU);
        }
        azimuths
    }

    /// Azimuths below pi of a mirrored grid, descending.
    fn other_half(&self) -> impl Iterator<Item = f64> {
        let below = |a: &f64| *a < std::f64::consts::PI - SAME;
        self.grid.azimuths.iter().rev().copied().filter(below)
    }

    /// Place in the lobe of an azimuth and a polar angle of the incidence.
    pub(super) fn incidence(&self, phi: usize, theta: usize) -> usize {
        self.order.get(phi * self.thetas.len() + theta).copied().unwrap_or(0)
    }

    /// Rows of values of a band of an incidence, one an azimuth of [`Self::azimuths`].
    pub(super) fn rows<'b>(
        &self,
        lobe: &'b SampledBsdf,
        incidence: usize,
        band: usize,
    ) -> Vec<&'b [f64]> {
        let mut rows: Vec<&[f64]> =
            lobe.band(incidence, band).chunks(self.grid.radii.len().max(1)).collect();
        if self.unfolds {
            let half = rows.clone();
            let skipped = half.len() - self.other_half().count();
            rows.extend(half.into_iter().rev().skip(skipped));
        }
        if let (true, Some(first)) = (self.is_open, rows.first().copied()) {
            rows.push(first);
        }
        rows
    }
}

/// The different numbers of a list, ascending.
fn different(all: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut list: Vec<f64> = all.collect();
    list.sort_by(f64::total_cmp);
    list.dedup_by(|a, b| (*a - *b).abs() < SAME);
    list
}
