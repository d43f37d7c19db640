//! Verdicts about fits: broken and unphysical input is never accepted without its cause, and sound input is never accused.

use asperity::fit::FitOptions;
use asperity::forward::Sample;
use asperity::measurement::{Measurement, Metadata, Quantity, Reading};
use asperity::method::{Body, GgxMethod, Method};
use asperity::model::Grade;
use asperity::reconstruct::{Entry, Situation, Task, usually_asked};
use asperity::watch::Watch;
use asperity_core::gonio::{AngleGrid, Geometry};
use asperity_core::plate::RoughSide;
use asperity_tests::extensive;
use rayon::prelude::*;

use crate::common::{GAUSS, Virtual};

/// Uniform numbers, the same on every machine.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn within(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.uniform()
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    fn choose(&mut self, count: usize) -> usize {
        (self.uniform() * count as f64) as usize
    }
}

/// A sample in an instrument, with what is known of it.
#[derive(Clone)]
struct Case {
    method: &'static str,
    scan: Measurement,
    situation: Situation,
    options: FitOptions,
}

const TILTS: [f64; 3] = [0.0, 20.0, 45.0];
const GRID: AngleGrid<f64> = AngleGrid { start_deg: -80.0, step_deg: 1.0, count: 161 };

/// A sound scan: GGX or Normals in a plate or GGX on a metal, with noise of 0.1 to 0.5 % of the largest reading.
fn sound(random: &mut Random) -> Case {
    let ior = random.within(1.4, 1.7);
    let alpha = random.within(0.12, 0.45);
    let kind = random.choose(4);
    let of_plate = |method: &dyn Method, values: &[f64], geometry| {
        Virtual::plate(method, values, ior, RoughSide::Source, geometry)
    };
    let body = Body::Dielectric { ior };
    let (virtual_sample, method) = match kind {
        0 => (of_plate(&GgxMethod::new(body), &[alpha], Geometry::Transmission), "ggx"),
        1 => (of_plate(&GgxMethod::new(body), &[alpha], Geometry::Reflection), "ggx"),
        2 => {
            let values = [random.within(8.0, 20.0), random.within(1.5, 3.0)];
            (of_plate(&GAUSS, &values, Geometry::Transmission), "normals")
        }
        _ => (Virtual::opaque(alpha, random.within(0.2, 0.9), random.within(0.001, 0.05)), "ggx"),
    };
    let noise = random.within(1e-3, 5e-3);
    let sample = virtual_sample.with_aperture(random.within(0.5, 2.0));
    scan_of(&sample, method, noise, random)
}

fn scan_of(sample: &Virtual, method: &'static str, noise: f64, random: &mut Random) -> Case {
    let exact = sample.exact_scan(&TILTS, &GRID);
    let largest = exact.largest_reading();
    let noisy = |r: &Reading| {
        // shot noise, and a little of the electronics
        let shot = noise * (r.value * largest).sqrt();
        let value = r.value + shot * random.normal() + 0.05 * noise * largest * random.normal();
        Reading { value, ..*r }
    };
    let readings = exact.readings().iter().map(noisy).collect();
    let body = match sample.setup.sample {
        Sample::Plate { eta, .. } => Body::Dielectric { ior: eta.get() },
        Sample::Opaque => Body::Opaque,
    };
    let scan = Measurement::new(Metadata::default(), readings).unwrap();
    let situation = Situation { body, setup: sample.setup };
    Case { method, scan, situation, options: FitOptions::new(body) }
}

impl Case {
    fn fit(&self) -> Entry {
        let mut task = Task::new(&self.scan, self.situation);
        task.options = self.options;
        let profile = (self.method == "normals").then_some("gauss");
        let trials = task.trials(self.method, profile, &usually_asked).unwrap();
        task.fit(&trials, Watch::nobody()).unwrap().entry
    }

    fn what(&self) -> String {
        let setup = &self.situation.setup;
        format!("{:?} in {:?}, {} deg", self.situation.body, setup.geometry, setup.aperture_deg)
    }

    fn is_opaque(&self) -> bool {
        self.situation.body == Body::Opaque
    }

    fn changed(mut self, change: impl Fn(&Reading) -> Option<Reading>) -> Self {
        let readings = self.scan.readings().iter().filter_map(change).collect();
        self.scan = Measurement::new(self.scan.meta.clone(), readings).unwrap();
        self
    }

    fn times(self, factor: f64) -> Self {
        self.changed(|r| Some(Reading { value: r.value * factor, ..*r }))
    }

    fn largest_at(&self, tilt: f64) -> f64 {
        let here = self.scan.readings().iter().filter(|r| (r.sigma_deg - tilt).abs() < 1e-9);
        here.map(|r| r.value).fold(0.0, f64::max)
    }
}

/// The ways in which a scan may be broken, with words of which the causes must contain one.
fn broken(case: Case, kind: usize, random: &mut Random) -> Option<(Case, &'static [&'static str])> {
    let opaque = case.is_opaque();
    let largest = case.scan.largest_reading();
    Some(match kind {
        0 => (case.times(100.0), &["percent", "counts"]),
        1 => (case.times(1000.0), &["1000", "percent", "counts"]),
        2 => (case.times(1e6 / largest), &["counts"]),
        3 => (case.times(1.0 / largest), &["normalised"]),
        4 => {
            let peaks: Vec<f64> = TILTS.iter().map(|t| case.largest_at(*t)).collect();
            let own = |r: &Reading| {
                let k = TILTS.iter().position(|t| (t - r.sigma_deg).abs() < 1e-9)?;
                Some(Reading { value: r.value / peaks[k], ..*r })
            };
            (case.changed(own), &["normalised to their own peaks"])
        }
        5 => {
            let radians = |r: &Reading| {
                let [sigma_deg, theta_deg] = [r.sigma_deg, r.theta_deg].map(f64::to_radians);
                Some(Reading { sigma_deg, theta_deg, ..*r })
            };
            (case.changed(radians), &["radians"])
        }
        6 => {
            let mirrored = |r: &Reading| Some(Reading { theta_deg: -r.theta_deg, ..*r });
            (case.changed(mirrored), &["--theta-sign"])
        }
        7 => {
            // the side that is rough is told by the refraction of the other face alone
            let mut case = case;
            let Sample::Plate { rough_side, .. } = &mut case.situation.setup.sample else {
                return None;
            };
            *rough_side = RoughSide::Detector;
            (case, &["--rough-side", "--ior", "zero of", "gain", "aperture"])
        }
        8 => {
            let mut case = case;
            let Sample::Plate { .. } = case.situation.setup.sample else { return None };
            let geometry = &mut case.situation.setup.geometry;
            *geometry = match *geometry {
                Geometry::Reflection => Geometry::Transmission,
                Geometry::Transmission => Geometry::Reflection,
            };
            (case, &["--geometry"])
        }
        9 if !opaque => {
            let mut case = case;
            case.situation.setup.aperture_deg *= 1.4;
            (case, &["--aperture"])
        }
        10 => {
            let at = random.within(-6.0, 6.0);
            let blind = |r: &Reading| {
                let value =
                    if (r.theta_deg - r.sigma_deg - at).abs() < 3.5 { 0.0 } else { r.value };
                Some(Reading { value, ..*r })
            };
            (case.changed(blind), &["--drop zeros"])
        }
        11 => {
            let share = random.within(0.5, 0.8);
            let clip = |r: &Reading| Some(Reading { value: r.value.min(share * largest), ..*r });
            (case.changed(clip), &["saturated"])
        }
        12 => {
            let by = random.within(1.0, 3.0);
            let shift = |r: &Reading| Some(Reading { theta_deg: r.theta_deg + by, ..*r });
            (case.changed(shift), &["zero of theta", "zero of sigma"])
        }
        13 => {
            // reflectance factors in place of a BSDF, of a body bright enough that they are more light than there is
            let mut sample = Virtual::opaque(0.3, random.within(0.4, 0.9), 0.01);
            (sample.setup.quantity, sample.setup.aperture_deg) = (Quantity::Bsdf, 0.0);
            let case = scan_of(&sample, "ggx", 2e-3, random);
            (case.times(std::f64::consts::PI), &["divide by pi"])
        }
        14 => {
            let mut case = case;
            let Body::Dielectric { ior } = case.situation.body else { return None };
            let off = if random.uniform() < 0.5 { 0.15 } else { -0.15 };
            let body = Body::Dielectric { ior: ior + off };
            if let Sample::Plate { eta, .. } = &mut case.situation.setup.sample {
                *eta = body.eta().unwrap();
            }
            (case.situation.body, case.options.body) = (body, body);
            (case, &["--ior"])
        }
        _ => return None,
    })
}

#[test]
fn sound_scans_are_never_accused() {
    let count = if extensive() { 200 } else { 6 };
    let mut random = Random(11);
    let cases: Vec<Case> = (0..count).map(|_| sound(&mut random)).collect();
    cases.par_iter().enumerate().for_each(|(k, case)| {
        let entry = case.fit();
        let verdict = &entry.verdict;
        let what = format!("{k}, {} {}: {verdict:?}", case.what(), entry.label);
        assert!(verdict.grade == Grade::WithinNoise && verdict.causes.is_empty(), "{what}");
    });
}

#[test]
fn broken_scans_are_never_accepted_without_their_cause() {
    // every second way, unless there is time
    let (count, step) = if extensive() { (1000, 1) } else { (8, 2) };
    let mut random = Random(5);
    let mut cases = Vec::new();
    while cases.len() < count {
        cases.extend(broken(sound(&mut random), step * cases.len() % 15, &mut random));
    }
    let miss = |(k, (case, words)): (usize, &(Case, &[&str]))| {
        let verdict = case.fit().verdict;
        let causes = verdict.causes.join("; ");
        let is_named = words.iter().any(|word| causes.contains(word));
        let missed =
            (!is_named).then(|| format!("{}, {}: {words:?} {verdict:?}", k + 1, case.what()));
        // a thousand of them take half an hour
        println!("{} {}", k + 1, missed.as_deref().unwrap_or("named"));
        missed
    };
    let missed: Vec<String> = cases.par_iter().enumerate().filter_map(miss).collect();
    assert!(missed.is_empty(), "{} of {count}: {missed:#?}", missed.len());
}
