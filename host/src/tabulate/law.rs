//! Values of a law that can be evaluated: at every node, exactly.

use asperity_core::bsdf::{Bsdf, Lobe, Scattered};
use asperity_core::direction::Direction;
use rayon::prelude::*;

use super::facet::{Beam, tail};
use super::grid::{LobeGrid, node};

/// Steps of the bisection for the last facet before the horizon.
const STEPS: u32 = 24;

/// The law that fills a table: a [`Bsdf`] behind one pointer, so that this code is compiled once.
pub(super) trait Law: Sync {
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64;
    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>>;
    fn slope(&self) -> f64;
}

impl<B: Bsdf<f64> + Sync> Law for B {
    fn ars(&self, wi: Direction<f64>, wo: Direction<f64>) -> f64 {
        Bsdf::ars(self, wi, wo)
    }
    fn sample_lobe(&self, wi: Direction<f64>, lobe: Lobe, u: [f64; 2]) -> Option<Scattered<f64>> {
        Bsdf::sample_lobe(self, wi, lobe, u)
    }
    fn slope(&self) -> f64 {
        Bsdf::slope(self)
    }
}

impl LobeGrid {
    /// Takes the values of a law.
    pub(super) fn fill(&mut self, law: &dyn Law) {
        let shape = self.header.shape;
        let planes: Vec<Option<Vec<f64>>> = (0..usize::from(shape.incidences))
            .into_par_iter()
            .map(|j| {
                let beam = self.beam(self.cosine(j));
                let row = |k: usize| self.row(law, &beam, 2.0 * node(k, shape.azimuths) - 1.0);
                let mut rows: Vec<Option<Vec<f64>>> =
                    (0..usize::from(shape.azimuths)).map(row).collect();
                // an azimuth whose facets send nothing goes on as its neighbour on the mirror's side, or, as beyond the critical
                // angle, where only facets that lean the other way send any, as that on the other side
                for k in (0..rows.len()).rev() {
                    if rows[k].is_none() {
                        rows[k] = rows.get(k + 1).cloned().flatten();
                    }
                }
                for k in 1..rows.len() {
                    if rows[k].is_none() {
                        rows[k] = rows.get(k - 1).cloned().flatten();
                    }
                }
                let rows: Option<Vec<Vec<f64>>> = rows.into_iter().collect();
                rows.map(|rows| rows.concat())
            })
            .collect();
        // an incidence that no facet sends light from has no say in what is between it and the next: it goes on as that
        let lit: Vec<usize> = (0..planes.len()).filter(|j| planes[*j].is_some()).collect();
        for j in 0..planes.len() {
            let near = lit.iter().min_by_key(|k| k.abs_diff(j));
            if let Some(plane) = near.and_then(|k| planes[*k].as_ref()) {
                self.plane(j).copy_from_slice(plane);
            }
        }
    }

    /// `v` over the radii at one azimuth. Facets that send light into the lobe lie between two slopes (those beyond send it into
    /// the surface, those before may reflect it totally); outside it goes on as at these edges.
    fn row(&self, law: &dyn Law, beam: &Beam, p: f64) -> Option<Vec<f64>> {
        let count = self.header.shape.radii;
        let at = |k: usize| node(k, count);
        let mut row: Vec<Option<f64>> =
            (0..usize::from(count)).map(|k| self.value(law, beam, at(k), p)).collect();
        let first = row.iter().position(Option::is_some)?;
        let last = row.iter().rposition(Option::is_some)?;
        if first > 0 {
            let edge = self.edge(law, beam, p, [at(first), at(first - 1)]);
            row[..first].fill(edge);
        }
        if last + 1 < row.len() {
            let edge = self.edge(law, beam, p, [at(last), at(last + 1)]);
            row[last + 1..].fill(edge);
        }
        let mut before = 0.0;
        let keep = |v: Option<f64>| {
            before = v.unwrap_or(before);
            before
        };
        Some(row.into_iter().map(keep).collect())
    }

    /// The value at the last facet between one that sends light into the lobe and one that does not.
    fn edge(&self, law: &dyn Law, beam: &Beam, p: f64, ends: [f64; 2]) -> Option<f64> {
        let [mut inside, mut outside] = ends;
        let mut edge = self.value(law, beam, inside, p);
        for _ in 0..STEPS {
            let middle = 0.5 * (inside + outside);
            match self.value(law, beam, middle, p) {
                Some(v) => (inside, edge) = (middle, Some(v)),
                None => outside = middle,
            }
        }
        edge
    }

    fn value(&self, law: &dyn Law, beam: &Beam, r: f64, p: f64) -> Option<f64> {
        let s = self.slope(r);
        let turned = beam.turn(s, p)?;
        let q = law.ars(beam.wi, turned.wo) / beam.per(&turned, f64::from(self.header.masking));
        let v = (q / tail(self.header.fall, s, f64::from(self.header.scale))).sqrt();
        (v.is_finite() && turned.wo.z().abs() > 1e-9).then_some(v)
    }
}
