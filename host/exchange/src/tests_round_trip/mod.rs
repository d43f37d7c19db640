//! Every format that is written and read: values at the nodes, flux, peak against the law.

#![allow(clippy::print_stdout, reason = "shown with --nocapture")]

mod patches;
mod peers;
mod trees;

use asperity_core::bsdf::{Bsdf, Ggx};
use asperity_core::direction::Direction;
use asperity_core::quantity::{Alpha, RelativeIor};

use crate::compare::{Row, compare};
use crate::convention::Global;
use crate::formats::{Format, read_bytes};
use crate::law::{Closed, Law, Options, Subject};
use crate::sampled::{Band, Lobe, Side, Symmetry};

struct Facets {
    ggx: Ggx<f64>,
    side: Side,
    lobe: Lobe,
}

impl Law for Facets {
    fn value(&self, incidence: [f64; 2], out: [f64; 2]) -> f64 {
        let of = |g: Global| {
            let (sin, cos) = g.theta.sin_cos();
            Direction::new(sin * g.phi.cos(), sin * g.phi.sin(), cos).unwrap()
        };
        let wi = of(Global::of_incidence(self.side, incidence));
        let wo = of(Global::of_outgoing(self.side, self.lobe, incidence[1], out));
        self.ggx.eval(wi, wo)
    }
}

fn lobes(alpha: f64) -> Vec<(Facets, Subject)> {
    let mut all = Vec::new();
    for side in [Side::Air, Side::Dielectric] {
        for lobe in [Lobe::Reflection, Lobe::Transmission] {
            let ggx = Ggx::new(Alpha::new(alpha).unwrap(), RelativeIor::new(1.49).unwrap());
            let subject = Subject {
                side,
                lobe,
                index: Some(1.49),
                symmetry: Symmetry::Isotropic,
                band: Band::Wavelength(550.0),
                notes: vec!["Sample: GGX".into()],
                coherent: 0.0,
                closed: Some(Closed::Ggx { alpha }),
            };
            all.push((Facets { ggx, side, lobe }, subject));
        }
    }
    all
}

fn rows(format: &Format, law: &Facets, subject: &Subject, options: &Options) -> Option<Vec<Row>> {
    let write = format.write?;
    format.read?;
    let sampled = match (write.sample)(law, subject, options) {
        Ok(sampled) => sampled,
        Err(e) => {
            println!("{}: {e}", format.name);
            return None;
        }
    };
    let bytes = (write.encode)(std::slice::from_ref(&sampled)).unwrap();
    let (found, read) =
        read_bytes("file", &bytes).unwrap_or_else(|e| panic!("{}: {e}", format.name));
    assert_eq!(found.name, format.name);
    let one = read.iter().find(|r| r.side == subject.side && r.lobe == subject.lobe);
    let one = one.unwrap_or_else(|| panic!("{}: no such lobe", format.name));
    assert_eq!(one.index, subject.index, "{}", format.name);
    Some(compare(one, &sampled, law))
}

/// Facets without masking, whose BSDF has no bound at grazing.
struct Unmasked;

impl Law for Unmasked {
    fn value(&self, incidence: [f64; 2], out: [f64; 2]) -> f64 {
        let cosine = out[0].cos().max(1e-9);
        let along = out[0].sin() * out[1].cos() - incidence[0].sin();
        let across = out[0].sin() * out[1].sin();
        (-(along * along + across * across) / 0.05).exp() / cosine
    }
}

#[test]
fn a_law_without_bound_at_grazing_keeps_its_flux() {
    let (_, subject) = lobes(0.2).remove(0);
    let incidences = [0.0_f64, 30.0, 60.0, 80.0].map(|d| [d.to_radians(), 0.0]).to_vec();
    let options = Options { incidences, ..Options::default() };
    for name in ["zemax", "csv"] {
        let write = Format::of_name(name).unwrap().write.unwrap();
        let made = (write.sample)(&Unmasked, &subject, &options).unwrap();
        for row in compare(&made, &made, &Unmasked) {
            println!("{name} {row:?} {}", row.flux_percent());
            assert!(row.flux_percent().abs() < 0.1, "{name}: {row:?} {}", row.flux_percent());
            assert!(row.peak_percent().abs() < 0.5, "{name}: {row:?} {}", row.peak_percent());
        }
    }
}

/// Errors allowed, percent: of values at nodes, of the flux, of the peak.
struct Allowed {
    node: f64,
    flux: f64,
    peak: f64,
    /// Whether widths and sides that take long to sample are left to long runs.
    is_slow: bool,
}

impl Default for Allowed {
    fn default() -> Self {
        Self { node: 1e-3, flux: 0.1, peak: 0.5, is_slow: false }
    }
}

/// Writes and reads the lobes of GGX: of one width at two incidences, of three widths at three with `ASPERITY_EXTENSIVE=1`.
fn check(name: &str, allowed: &Allowed) {
    let format = Format::of_name(name).unwrap();
    let is_long = std::env::var_os("ASPERITY_EXTENSIVE").is_some();
    let mut compared = 0;
    let (alphas, degrees): (&[f64], &[f64]) =
        if is_long { (&[0.02, 0.2, 0.6], &[0.0, 30.0, 60.0]) } else { (&[0.2], &[0.0, 45.0]) };
    for &alpha in alphas {
        for (law, subject) in lobes(alpha) {
            if allowed.is_slow && subject.side == Side::Dielectric && !is_long {
                continue;
            }
            let options = Options {
                incidences: degrees.iter().map(|d| [d.to_radians(), 0.0]).collect(),
                ..Options::default()
            };
            let title = format!("{name} {alpha} {:?} {:?}", subject.side, subject.lobe);
            for row in rows(format, &law, &subject, &options).unwrap_or_default() {
                println!(
                    "{title}: {:.0} deg {} nodes, flux {:.5} {:.4} %, peak {:.4} {:.4} % node {:.2e} %",
                    row.incidence_deg,
                    row.nodes,
                    row.flux_law,
                    row.flux_percent(),
                    row.peak_law,
                    row.peak_percent(),
                    row.node_error_percent
                );
                if row.peak_law == 0.0 {
                    continue; // nothing is transmitted there
                }
                compared += 1;
                assert!(row.node_error_percent < allowed.node, "{title}: {row:?}");
                assert!(row.flux_percent().abs() < allowed.flux, "{title}: {row:?}");
                assert!(row.peak_percent().abs() < allowed.peak, "{title}: {row:?}");
                if let Some(stated) = row.flux_stated {
                    assert!((stated - row.flux_file).abs() < 1e-6, "{title}: {row:?}");
                }
            }
        }
    }
    assert!(compared > 3, "{name}: {compared} incidences");
}

#[test]
fn zemax() {
    check("zemax", &Allowed::default());
}

#[test]
fn csv() {
    check("csv", &Allowed::default());
}

#[test]
fn integra() {
    check("integra", &Allowed::default());
}

#[test]
fn ssdd() {
    check("ssdd", &Allowed::default());
}

/// The same with a file for each incidence; returns how many were compared.
fn check_each(name: &str) -> usize {
    let format = Format::of_name(name).unwrap();
    let allowed = Allowed { node: 1e-3, ..Allowed::default() };
    let mut compared = 0;
    for (law, subject) in lobes(0.2) {
        for degrees in [0.0_f64, 45.0] {
            let incidences = vec![[degrees.to_radians(), 0.0]];
            let options = Options { incidences, ..Options::default() };
            for row in rows(format, &law, &subject, &options).unwrap_or_default() {
                if row.peak_law == 0.0 {
                    continue; // nothing is transmitted there
                }
                compared += 1;
                assert!(row.node_error_percent < allowed.node, "{row:?}");
                assert!(row.flux_percent().abs() < allowed.flux, "{row:?}");
                assert!(row.peak_percent().abs() < allowed.peak, "{row:?}");
            }
        }
    }
    compared
}

#[test]
fn pab() {
    assert_eq!(check_each("pab"), 8);
}

#[test]
fn astm() {
    check("astm", &Allowed::default());
}

#[test]
fn bird() {
    check("bird", &Allowed::default());
}

#[test]
fn openmaterial() {
    // it holds reflection alone
    assert_eq!(check_each("openmaterial"), 4);
}

#[test]
fn npz() {
    check("npz", &Allowed::default());
}

#[test]
fn speos() {
    check("speos", &Allowed::default());
}

#[test]
fn lighttools() {
    check("lighttools", &Allowed::default());
}

#[test]
fn tracepro() {
    check("tracepro", &Allowed { is_slow: true, ..Allowed::default() });
}

/// The file of FRED says neither side nor lobe nor index, so the reader is told.
#[test]
fn fred() {
    let format = Format::of_name("fred").unwrap();
    let write = format.write.unwrap();
    for (law, subject) in lobes(0.2) {
        let incidences = [0.0_f64, 30.0, 60.0].map(|d| [d.to_radians(), 0.0]).to_vec();
        let options = Options { incidences, ..Options::default() };
        let sampled = (write.sample)(&law, &subject, &options).unwrap();
        let bytes = (write.encode)(std::slice::from_ref(&sampled)).unwrap();
        let (found, read) = read_bytes("file", &bytes).unwrap();
        assert_eq!(found.name, "fred");
        let mut read = read.into_iter().next().unwrap();
        (read.side, read.lobe, read.index) = (subject.side, subject.lobe, subject.index);
        assert_eq!(read.symmetry, Symmetry::Isotropic);
        assert_eq!(read.incidences.len(), sampled.incidences.len());
        for (incidence, ought) in read.incidences.iter_mut().zip(&sampled.incidences) {
            let ray = sampled.specular(ought.theta).unwrap();
            assert!((incidence.theta - ray).abs() < 1e-9);
            incidence.theta = ought.theta;
            assert!(incidence.values.iter().all(|v| *v > 0.0));
            let edge = incidence.nodes.directions().iter().map(|d| d[0]).fold(0.0, f64::max);
            assert!(edge < 89.95_f64.to_radians());
        }
        for row in compare(&read, &sampled, &law) {
            if row.peak_law == 0.0 {
                continue;
            }
            assert!(row.node_error_percent < 1e-4, "{row:?}");
            assert!(row.flux_percent().abs() < 0.1, "{row:?}");
            assert!(row.peak_percent().abs() < 0.5, "{row:?}");
        }
    }
}
