//! A file as a law: what its own program finds between its nodes.

use std::f64::consts::FRAC_PI_2;

use crate::frame::{Frame, direction};
use crate::law::{Law, Subject};
use crate::nearest::Nearest;
use crate::sampled::{Incidence, Nodes, SampledBsdf, Symmetry};

/// Angles nearer than this are the same.
const SAME: f64 = 1e-9;

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
    /// The incidences to sample it at, polar angle and azimuth: those of the file; of an isotropic lobe one of each polar angle.
    pub fn incidences(&self) -> Vec<[f64; 2]> {
        let mut all: Vec<[f64; 2]> =
            self.lobe.incidences.iter().map(|i| [i.theta, i.phi]).collect();
        if self.is_turnable() {
            let first = all.first().map_or(0.0, |at| at[1]);
            all.sort_by(|a, b| a[0].total_cmp(&b[0]));
            all.dedup_by(|a, b| (a[0] - b[0]).abs() < SAME);
            for at in &mut all {
                at[1] = first;
            }
        }
        all
    }

    /// Whether an azimuth of the source is as good as another.
    fn is_turnable(&self) -> bool {
        self.lobe.symmetry != Symmetry::None
    }

    /// The number of an incidence of the file.
    fn find(&self, [theta, phi]: [f64; 2]) -> Option<usize> {
        let near = |i: &Incidence| {
            (i.theta - theta).abs() < SAME && (self.is_turnable() || (i.phi - phi).abs() < SAME)
        };
        self.lobe.incidences.iter().position(near)
    }
}

impl FileLaw<'_> {
    /// The value of an incidence of the file.
    fn own(&self, k: usize, out: [f64; 2]) -> f64 {
        match &self.nearest[k] {
            None => self.lobe.incidences[k].value(0, out, self.lobe.interpolation),
            Some(nearest) => {
                let node = nearest.find(direction(out));
                node.and_then(|n| self.lobe.band(k, 0).get(n)).copied().unwrap_or(0.0)
            }
        }
    }

    /// The value at an incidence that the file does not have: that of the nearest patch or azimuth; else between those of the two nearest polar
    /// angles, each at the same place about its own ray.
    fn between(&self, [theta, phi]: [f64; 2], out: [f64; 2]) -> f64 {
        let all = &self.lobe.incidences;
        let distance = |i: &Incidence| {
            let phi = if self.is_turnable() { i.phi } else { phi };
            1.0 - direction([i.theta, i.phi]).dot(direction([theta, phi]))
        };
        let order = |a: &usize, b: &usize| distance(&all[*a]).total_cmp(&distance(&all[*b]));
        let Some(near) = (0..all.len()).min_by(order) else { return 0.0 };
        if self.has_grain() {
            return self.own(near, out);
        }
        // of the azimuth of the nearest, the polar angles to both sides
        let same = |k: &usize| (all[*k].phi - all[near].phi).abs() < SAME;
        let below = (0..all.len()).filter(same).filter(|k| all[*k].theta <= theta);
        let below = below.max_by(|a, b| all[*a].theta.total_cmp(&all[*b].theta));
        let above = (0..all.len()).filter(same).filter(|k| all[*k].theta > theta);
        let above = above.min_by(|a, b| all[*a].theta.total_cmp(&all[*b].theta));
        let (Some(a), Some(b)) = (below.or(above), above.or(below)) else { return 0.0 };
        let shifted = |k: usize| {
            let rays = [theta, all[k].theta].map(|theta| self.lobe.specular(theta));
            let [Some(here), Some(there)] = rays else { return self.own(k, out) };
            let place = Frame::Specular { theta: here }.coordinates(out);
            let [theta, phi] = Frame::Specular { theta: there }.absolute(place);
            self.own(k, [theta.min(FRAC_PI_2 - 1e-6), phi])
        };
        let gap = all[b].theta - all[a].theta;
        let share = if gap > 0.0 { (theta - all[a].theta) / gap } else { 0.0 };
        shifted(a) * (1.0 - share) + shifted(b) * share
    }
}

impl Law for FileLaw<'_> {
    /// At incidences of the file the file's own values; at others those between them.
    fn value(&self, incidence: [f64; 2], out: [f64; 2]) -> f64 {
        match self.find(incidence) {
            Some(k) => self.own(k, out),
            None => self.between(incidence, out),
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
    fn a_table_has_values_between_its_incidences() {
        let lobe = coarse();
        let law = FileLaw::new(&lobe);
        let ray = |theta: f64| law.value([theta, 0.0], [theta, 0.0]);
        let (a, b) = (10.0_f64.to_radians(), 50.0_f64.to_radians());
        assert!((ray(a) - 0.3).abs() < 1e-12 && (ray(b) - 0.5).abs() < 1e-12);
        assert!((ray(f64::midpoint(a, b)) - 0.4).abs() < 1e-12);
        assert!((ray(1.2) - 0.5).abs() < 1e-12 && (ray(0.0) - 0.3).abs() < 1e-12);
        // an isotropic table knows every azimuth
        assert!((law.value([a, 2.0], [a, 0.0]) - 0.3).abs() < 1e-12);
    }

    #[test]
    fn a_table_becomes_cells_and_patches_with_its_flux() {
        let lobe = coarse();
        let law = FileLaw::new(&lobe);
        for name in ["tensortree3", "klems"] {
            let options =
                Options { incidences: law.incidences(), accept: true, ..Options::default() };
            let write = Format::of_name(name).unwrap().write.unwrap();
            let made = (write.sample)(&law, &law.subject(), &options).unwrap();
            let near = |theta: f64| {
                let distance = |k: &usize| (made.incidences[*k].theta - theta).abs();
                let all = 0..made.incidences.len();
                all.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
            };
            for (k, at) in law.incidences().iter().enumerate() {
                let (is, ought) = (made.flux(near(at[0]), 0), lobe.flux(k, 0));
                // the nearest patch is some degrees away
                assert!((is / ought - 1.0).abs() < 0.08, "{name} {at:?}: {is} {ought}");
            }
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
