//! A file as a law: what its own program finds between its nodes.

use crate::frame::direction;
use crate::law::{Law, Subject};
use crate::nearest::Nearest;
use crate::sampled::{Nodes, SampledBsdf};

/// A lobe of a file, at the incidences of the file.
#[derive(Debug)]
pub struct FileLaw<'a> {
    lobe: &'a SampledBsdf,
    /// Of the incidences whose nodes form no grid.
    nearest: Vec<Option<Nearest>>,
}

impl<'a> FileLaw<'a> {
    /// The law of a lobe.
    pub fn new(lobe: &'a SampledBsdf) -> Self {
        let index = |nodes: &Nodes| match nodes {
            Nodes::Grid(_) => None,
            nodes => Some(Nearest::new(nodes.directions().into_iter())),
        };
        Self { lobe, nearest: lobe.incidences.iter().map(|i| index(&i.nodes)).collect() }
    }

    /// What it is the law of.
    pub fn subject(&self) -> Subject {
        let lobe = self.lobe;
        Subject {
            side: lobe.side,
            lobe: lobe.lobe,
            index: lobe.index,
            symmetry: lobe.symmetry,
            band: lobe.bands.first().cloned().unwrap_or(crate::sampled::Band::Unknown),
            notes: lobe.notes.clone(),
            coherent: 0.0,
            closed: None,
        }
    }
}

impl Law for FileLaw<'_> {
    /// Incidences are those of the file; others have no value.
    fn value(&self, [theta, phi]: [f64; 2], out: [f64; 2]) -> f64 {
        let all = self.lobe.incidences.iter();
        let found = all
            .zip(&self.nearest)
            .enumerate()
            .find(|(_, (i, _))| (i.theta - theta).abs() < 1e-9 && (i.phi - phi).abs() < 1e-9);
        match found {
            None => 0.0,
            Some((_, (incidence, None))) => incidence.value(0, out, self.lobe.interpolation),
            Some((k, (_, Some(nearest)))) => {
                let node = nearest.find(direction(out));
                node.and_then(|n| self.lobe.band(k, 0).get(n)).copied().unwrap_or(0.0)
            }
        }
    }
}
