//! A lobe while it is made: its values in double precision at the nodes, and sums over its facets.

use std::f64::consts::PI;

use asperity_core::bsdf::Lobe;
use asperity_core::direction::Side;
use asperity_core::quantity::RelativeIor;
use asperity_core::table::{
    BsdfTableRef, GAIN_STEPS, LobeHeader, SideTable, Storage, incidence_cosine, slope,
};

use super::facet::{Beam, Turned};
use super::law::{GOLDEN, Law};

/// Azimuths of a sum over facets, from the mirror direction to the other.
const AROUND: u32 = 24;
/// Cosine that stands for grazing light, which itself scatters nothing.
const GRAZING: f64 = 2e-3;

/// A lobe and its values.
#[derive(Clone, Debug)]
pub(super) struct LobeGrid {
    pub(super) eta: f64,
    pub(super) side: Side,
    pub(super) lobe: Lobe,
    pub(super) header: LobeHeader,
    /// `v` at the nodes: radii, azimuths, incidences.
    pub(super) v: Vec<f64>,
    /// By what gains are changed for the sake of the flux.
    pub(super) trim: Vec<f64>,
}

/// Where node `k` of `count` lies on [0, 1].
pub(super) fn node(k: usize, count: u16) -> f64 {
    k as f64 / f64::from(count - 1)
}

impl LobeGrid {
    /// Without values yet.
    pub(super) fn new(eta: f64, (side, lobe): (Side, Lobe), header: LobeHeader) -> Self {
        let (v, trim) = (vec![0.0; header.shape.values()], vec![1.0; header.shape.gains()]);
        Self { eta, side, lobe, header, v, trim }
    }

    /// Cosine of incidence of a node.
    pub(super) fn cosine(&self, node_of: usize) -> f64 {
        self.cosine_at(node(node_of, self.header.shape.incidences))
    }

    fn cosine_at(&self, y: f64) -> f64 {
        incidence_cosine(y, f64::from(self.header.grazing)).max(GRAZING)
    }

    /// Cosines of incidence of the gains.
    pub(super) fn cosines(&self) -> Vec<f64> {
        let last = self.trim.len() - 1;
        (0..=last).map(|n| self.cosine_at(n as f64 / last as f64)).collect()
    }

    pub(super) fn beam(&self, cos: f64) -> Beam {
        Beam::new(self.eta, (self.side, self.lobe), self.header.form, cos)
    }

    /// Slope at a radius; the last node stands for what is half a cell before it.
    pub(super) fn slope(&self, r: f64) -> f64 {
        let most = 1.0 - 0.5 / f64::from(self.header.shape.radii - 1);
        slope(r.min(most), f64::from(self.header.scale))
    }

    /// Values of an incidence.
    pub(super) fn plane(&mut self, incidence: usize) -> &mut [f64] {
        let each = usize::from(self.header.shape.azimuths) * usize::from(self.header.shape.radii);
        &mut self.v[incidence * each..(incidence + 1) * each]
    }

    /// Stored numbers and the gains they are worth.
    pub(super) fn stored<S: Storage>(&self) -> (Vec<f32>, Vec<S>) {
        let full = f64::from(S::FULL);
        let mut values = Vec::with_capacity(self.v.len());
        for (plane, most) in self.planes().zip(self.largest()) {
            let unit = most / full;
            let code = |v: &f64| if unit > 0.0 { (v / unit) as f32 } else { 0.0 };
            values.extend(plane.iter().map(|v| S::nearest(code(v).min(S::FULL))));
        }
        (self.gains().iter().map(|gain| (gain / (full * full)) as f32).collect(), values)
    }

    fn planes(&self) -> std::slice::Chunks<'_, f64> {
        let shape = self.header.shape;
        self.v.chunks(usize::from(shape.azimuths) * usize::from(shape.radii))
    }

    fn largest(&self) -> impl Iterator<Item = f64> {
        self.planes().map(|plane| plane.iter().copied().fold(0.0, f64::max))
    }

    /// The gains, one per step of incidence, if the largest value of each incidence is stored as 1.
    pub(super) fn gains(&self) -> Vec<f64> {
        let units: Vec<f64> = self.largest().map(|most| most * most).collect();
        // a dark incidence goes on as the nearest that is lit: it has no say in what is between
        let lit: Vec<usize> = (0..units.len()).filter(|j| units[*j] > 0.0).collect();
        let unit = |j: usize| lit.iter().min_by_key(|k| k.abs_diff(j)).map_or(0.0, |k| units[*k]);
        let steps = usize::from(GAIN_STEPS);
        let gain = |(n, trim): (usize, &f64)| {
            let (low, share) = (n / steps, (n % steps) as f64 / steps as f64);
            let high = (low + 1).min(units.len() - 1);
            (unit(low) * (1.0 - share) + unit(high) * share) * trim
        };
        self.trim.iter().enumerate().map(gain).collect()
    }

    /// Runs an expression with the lobe alone as a table, stored as it would be.
    pub(super) fn with_table<S: Storage, R>(
        &self,
        run: impl FnOnce(&BsdfTableRef<'_, S>) -> R,
    ) -> Option<R> {
        let (gains, values) = self.stored::<S>();
        let mut header = self.header;
        header.shape.intervals = 1;
        let quantiles: Vec<u16> = (0..header.shape.incidences).flat_map(|_| [0, 65535]).collect();
        let leans = vec![0; header.shape.leans()];
        let lobe = header.over(&gains, &values, &quantiles, &leans);
        let mut lit = SideTable::DARK.with_fluxes(0.0, &[[32767, 32767, 0, 0]; 2]);
        match self.lobe {
            Lobe::Reflection => lit.reflection = Some(lobe),
            Lobe::Transmission => lit.transmission = Some(lobe),
        }
        let sides = match self.side {
            Side::Air => [lit, SideTable::DARK],
            Side::Dielectric => [SideTable::DARK, lit],
        };
        let eta = RelativeIor::new(self.eta as f32).ok()?;
        BsdfTableRef::new(eta, header.scale, sides[0], sides[1]).ok().map(|table| run(&table))
    }

    /// Flux of the lobe of a law, at a cosine of incidence.
    pub(super) fn flux_of(&self, law: &dyn Law, cos: f64) -> f64 {
        let beam = self.beam(cos);
        let mut sum = 0.0;
        self.over_facets(&beam, |spot| {
            sum += law.ars(beam.wi, spot.turned.wo) / spot.turned.jacobian * spot.weight;
        });
        sum
    }

    /// Rings of a sum over facets, even in `r`.
    pub(super) fn rings(&self) -> u32 {
        let cells = u32::from(self.header.shape.radii - 1);
        cells * (192 / cells).max(2)
    }

    /// Visits facets that send a beam into the lobe, slopes ascending; weights are their solid angles.
    pub(super) fn over_facets(&self, beam: &Beam, mut visit: impl FnMut(&Spot)) {
        let s0 = f64::from(self.header.scale);
        let rings = self.rings();
        let step = PI / f64::from(AROUND);
        let around: [(f64, f64); AROUND as usize] =
            std::array::from_fn(|k| (step * k as f64).sin_cos());
        for ring in 0..rings {
            let r = (f64::from(ring) + 0.5) / f64::from(rings);
            let s = slope(r, s0);
            let cos = 1.0 / (1.0 + s * s).sqrt();
            // ds = s0 / (1 - r)^2 dr, both halves of the circle
            let ds = s0 / ((1.0 - r) * (1.0 - r)) / f64::from(rings);
            let weight = s * ds * cos * cos * cos * 2.0 * step;
            // azimuths of their own on each ring: a horizon that crosses the rings is met evenly
            let (sin_offset, cos_offset) = (step * (f64::from(ring) * GOLDEN).fract()).sin_cos();
            for (sin, cos) in around {
                let p = cos * cos_offset - sin * sin_offset;
                if let Some(turned) = beam.turn(s, p) {
                    visit(&Spot { r, s, p, weight, turned });
                }
            }
        }
    }
}

/// A facet of a sum.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub(super) r: f64,
    pub(super) s: f64,
    pub(super) p: f64,
    /// Solid angle it stands for.
    pub(super) weight: f64,
    pub(super) turned: Turned,
}
