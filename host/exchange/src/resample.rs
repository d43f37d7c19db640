//! A file as a law: what its own program finds between its nodes.

use crate::frame::direction;
use crate::law::{Law, Subject};
use crate::nearest::Nearest;
use crate::sampled::{Incidence, Nodes, SampledBsdf};

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

impl FileLaw<'_> {
    /// The number of an incidence of the file.
    fn find(&self, [theta, phi]: [f64; 2]) -> Option<usize> {
        let near = |i: &Incidence| (i.theta - theta).abs() < 1e-9 && (i.phi - phi).abs() < 1e-9;
        self.lobe.incidences.iter().position(near)
    }
}

impl Law for FileLaw<'_> {
    /// Incidences are those of the file; others have no value.
    fn value(&self, incidence: [f64; 2], out: [f64; 2]) -> f64 {
        let Some(k) = self.find(incidence) else { return 0.0 };
        match &self.nearest[k] {
            None => self.lobe.incidences[k].value(0, out, self.lobe.interpolation),
            Some(nearest) => {
                let node = nearest.find(direction(out));
                node.and_then(|n| self.lobe.band(k, 0).get(n)).copied().unwrap_or(0.0)
            }
        }
    }

    fn flux(&self, incidence: [f64; 2]) -> Option<f64> {
        let k = self.find(incidence)?;
        self.has_grain().then(|| self.lobe.flux(k, 0))
    }

    /// Patches and single directions have one value each, and steps between them.
    fn has_grain(&self) -> bool {
        self.nearest.iter().any(Option::is_some)
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;
    use crate::compare::compare;
    use crate::formats::{Format, read_bytes};
    use crate::law::Options;

    /// A table of few angles, its last radius at 80 degrees.
    fn coarse() -> SampledBsdf {
        let mut text = String::from(
            "Source Measured\nSymmetry PlaneSymmetrical\nSpectralContent Monochrome\nScatterType BRDF\nSampleRotation 1\n0\n\
             AngleOfIncidence 2\n10 50\nScatterAzimuth 3\n0 90 180\nScatterRadial 5\n0 20 40 60 80\nMonochrome\nDataBegin\n",
        );
        for peak in [0.3, 0.5] {
            text += "TIS 0.2\n";
            for side in [1.0, 0.8, 0.9] {
                let row = [1.0, 0.6 * side, 0.3 * side, 0.2 * side, 0.1 * side];
                for v in row {
                    let _ = write!(text, "{}\t", v * peak);
                }
                text.push('\n');
            }
        }
        text += "DataEnd\n";
        read_bytes("a.bsdf", text.as_bytes()).unwrap().1.remove(0)
    }

    #[test]
    fn a_table_sampled_anew_keeps_its_flux() {
        let lobe = coarse();
        let law = FileLaw::new(&lobe);
        let incidences = lobe.incidences.iter().map(|i| [i.theta, i.phi]).collect();
        let options = Options { incidences, ..Options::default() };
        let write = Format::of_name("csv").unwrap().write.unwrap();
        let made = (write.sample)(&law, &law.subject(), &options).unwrap();
        let bytes = (write.encode)(std::slice::from_ref(&made)).unwrap();
        let file = read_bytes("a.csv", &bytes).unwrap().1.remove(0);
        for (k, row) in compare(&file, &made, &law).iter().enumerate() {
            assert!(row.flux_percent().abs() < 0.1, "{row:?} {}", row.flux_percent());
            let own = lobe.flux(k, 0);
            assert!((row.flux_file / own - 1.0).abs() < 2e-3, "{row:?} {own}");
        }
    }

    #[test]
    fn single_directions_sampled_anew_keep_their_flux() {
        let mut lobe = coarse();
        for incidence in &mut lobe.incidences {
            let directions = incidence.nodes.directions();
            let over = |at: &[f64; 2]| at[0] < 1.5;
            let pairs = directions.iter().zip(&incidence.values).filter(|(at, _)| over(at));
            let (points, values) = pairs.map(|(at, v)| (*at, *v)).unzip();
            (incidence.nodes, incidence.values) = (Nodes::Points(points), values);
        }
        let law = FileLaw::new(&lobe);
        let incidences = lobe.incidences.iter().map(|i| [i.theta, i.phi]).collect();
        let options = Options { incidences, ..Options::default() };
        let write = Format::of_name("csv").unwrap().write.unwrap();
        let made = (write.sample)(&law, &law.subject(), &options).unwrap();
        for k in 0..lobe.incidences.len() {
            let (is, ought) = (made.flux(k, 0), lobe.flux(k, 0));
            assert!((is / ought - 1.0).abs() < 1e-6, "{is} {ought}");
            assert!(made.incidences[k].nodes.len() < 20_000);
        }
    }
}
