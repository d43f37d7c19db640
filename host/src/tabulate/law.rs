//! Values of a law that can be evaluated: at every node, exactly.

use asperity_core::bsdf::Bsdf;
use rayon::prelude::*;

use super::facet::{Beam, tail};
use super::grid::{LobeGrid, node};

/// Steps of the bisection for the last facet before the horizon.
const STEPS: u32 = 24;

impl LobeGrid {
    /// Takes the values of a law.
    pub(super) fn fill<B: Bsdf<f64> + Sync>(&mut self, law: &B) {
        let shape = self.header.shape;
        let radii = usize::from(shape.radii);
        let planes: Vec<Vec<f64>> = (0..usize::from(shape.incidences))
            .into_par_iter()
            .map(|j| {
                let beam = self.beam(self.cosine(j));
                let row = |k: usize| self.row(law, &beam, 2.0 * node(k, shape.azimuths) - 1.0);
                let mut rows: Vec<Option<Vec<f64>>> =
                    (0..usize::from(shape.azimuths)).map(row).collect();
                // an azimuth whose facets all face away goes on as its neighbour on the mirror's side
                for k in (0..rows.len()).rev() {
                    if rows[k].is_none() {
                        rows[k] = rows.get(k + 1).cloned().flatten();
                    }
                }
                rows.into_iter().flat_map(|row| row.unwrap_or_else(|| vec![0.0; radii])).collect()
            })
            .collect();
        for (j, plane) in planes.into_iter().enumerate() {
            self.plane(j).copy_from_slice(&plane);
        }
    }

    /// `v` over the radii at one azimuth; beyond the last facet that sends light into the lobe it goes on as there.
    fn row<B: Bsdf<f64>>(&self, law: &B, beam: &Beam, p: f64) -> Option<Vec<f64>> {
        let count = self.header.shape.radii;
        let mut row = Vec::with_capacity(usize::from(count));
        let mut last: Option<(f64, f64)> = None;
        let mut beyond: Option<f64> = None;
        for k in 0..usize::from(count) {
            let r = node(k, count);
            if let (Some(v), None) = (self.value(law, beam, r, p), beyond) {
                last = Some((r, v));
                row.push(v);
            } else if let Some(v) = beyond {
                row.push(v);
            } else {
                let (from, v) = last?;
                let (mut low, mut high, mut edge) = (from, r, v);
                for _ in 0..STEPS {
                    let middle = 0.5 * (low + high);
                    match self.value(law, beam, middle, p) {
                        Some(v) => (low, edge) = (middle, v),
                        None => high = middle,
                    }
                }
                let _ = low;
                beyond = Some(edge);
                row.push(edge);
            }
        }
        Some(row)
    }

    fn value<B: Bsdf<f64>>(&self, law: &B, beam: &Beam, r: f64, p: f64) -> Option<f64> {
        let s = self.slope(r);
        let turned = beam.turn(s, p)?;
        let q = law.ars(beam.wi, turned.wo) / beam.per(&turned, self.header.form);
        let v = (q / tail(self.header.fall, s, f64::from(self.header.scale))).sqrt();
        (v.is_finite() && turned.wo.z().abs() > 1e-9).then_some(v)
    }
}
