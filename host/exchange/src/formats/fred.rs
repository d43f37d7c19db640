//! Tabulated BSDF of FRED: `type bsdf_data`.
//!
//! Layout and meaning: FRED 24.90 help, "Tabulated BSDF"; files of ua-loft/bsdf-tools. A row of two numbers is a direction of the specular (or
//! direct) ray, the rows of three that follow are scatter directions and values. In the plane of incidence azimuths are 0 and polar angles
//! signed. Files of measurements also begin with lines of `!!` and have no header; degrees and 1/sr are meant. The file has no place for
//! comments, wavelength, side or lobe. The model is isotropic, so azimuths count from the plane of incidence in either sense. FRED interpolates
//! the logarithm: taken here as linear in both angles between the nodes.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;

use super::held;
use super::{Format, Source, Writer};
use crate::error::{CannotHold, Fault};
use crate::frame::{Frame, around, specular};
use crate::interpolation::Interpolation;
use crate::law::{Coordinates, Law, Layout, Options, Subject};
use crate::plan::plan;
use crate::sampled::{Band, Lobe, Nodes, SampledBsdf, Side, Symmetry};
use crate::table::{Reading, collect};
use crate::text::{Lines, degrees, excerpt};

const NAME: &str = "FRED";

pub(super) const FORMAT: Format = Format {
    name: "fred",
    title: "FRED tabulated BSDF",
    extensions: &["txt"],
    sniff: |source| {
        let mut lines = source.start().split(['\r', '\n']).map(str::trim).filter(|l| !l.is_empty());
        lines.next().is_some_and(|line| is_type(line) || line.starts_with("!!"))
    },
    read: Some(read),
    write: Some(Writer {
        sample,
        encode,
        notes: &[
            "FRED leaves ApplyTrans false by default: set it, and unset ApplyRefl, for a BTDF",
            "the file says neither side, lobe, index nor wavelength; theta_spec of a BTDF is the angle of the direct transmitted ray",
            "values below 1e-9 of the peak of their incidence are written as that, for FRED takes logarithms; polar angles end at 89.9",
        ],
    }),
};

const LAYOUT: Layout = Layout {
    coordinates: Coordinates::Absolute,
    own_grids: true,
    interpolation: Interpolation::Logarithmic,
};

/// Smallest value, of the peak of its incidence.
const FLOOR: f64 = 1e-9;

/// Largest polar angle, degrees: the edges at 90 are to be left out.
const EDGE: f64 = 89.9;

/// How numbers of a file are to be taken.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Meaning {
    /// Direction cosines along and across the plane of azimuth 0, rather than degrees.
    cosines: bool,
    /// Decimal logarithms.
    logarithms: bool,
    scale: f64,
}

fn is_type(line: &str) -> bool {
    let mut words = line.split_whitespace();
    words.next().is_some_and(|w| w.eq_ignore_ascii_case("type"))
        && words.next().is_some_and(|w| w.eq_ignore_ascii_case("bsdf_data"))
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let mut lines = Lines::new(NAME, &source.text);
    let mut notes = Vec::new();
    let mut meaning = Meaning { cosines: false, logarithms: false, scale: 1.0 };
    let name = source.name.to_ascii_lowercase();
    let lobe = if name.contains("btdf") { Lobe::Transmission } else { Lobe::Reflection };
    let mut readings = Vec::new();
    let mut ray: Option<[f64; 2]> = None;
    while let Some(line) = lines.next_filled() {
        if let Some(note) = line.strip_prefix("!!") {
            notes.push(note.split_whitespace().collect::<Vec<_>>().join(" "));
            continue;
        }
        if is_type(line) {
            meaning = format_line(&mut lines, &mut notes)?;
            continue;
        }
        match lines.numbers(line, "a number")?[..] {
            [a, b] => ray = Some(meaning.direction(&lines, a, b)?),
            [a, b, value] => {
                let ray = ray.ok_or_else(|| {
                    lines.fault("a value before the row of two numbers with its specular direction")
                })?;
                let [theta, phi] = meaning.direction(&lines, a, b)?;
                readings.push(Reading {
                    side: Side::Air,
                    lobe,
                    band: Band::Unknown,
                    // the x axis of the sample is that from which azimuths of rays count, reversed
                    incidence: ray,
                    out: [theta, around(phi - ray[1])],
                    f: meaning.bsdf(&lines, value)?,
                });
            }
            _ => {
                let line = excerpt(line);
                return Err(lines.fault(format!("neither two numbers nor three: '{line}'")));
            }
        }
    }
    if readings.is_empty() {
        return Err(lines.fault("no values"));
    }
    let zeros = readings.iter().filter(|r| r.f == 0.0).count();
    if zeros > 0 {
        notes.push(format!("{zeros} values are 0, of which FRED can take no logarithm"));
    }
    if !name.contains("btdf") && !name.contains("brdf") {
        notes.push("the file does not say whether it is of reflection or transmission: taken as reflection, unless its name has btdf in it".into());
    }
    straighten(&mut readings);
    let is_half = readings.iter().all(|r| r.out[1] <= PI + 1e-9);
    let mut lobes = collect(readings, is_half);
    for lobe in &mut lobes {
        lobe.interpolation = Interpolation::Logarithmic;
        lobe.notes.clone_from(&notes);
    }
    Ok(lobes)
}

/// The second line of a header.
fn format_line(lines: &mut Lines<'_>, notes: &mut Vec<String>) -> Result<Meaning, Fault> {
    let line = lines.expect("the line that begins with format")?;
    let mut words = line.split_whitespace();
    if !words.next().is_some_and(|w| w.eq_ignore_ascii_case("format")) {
        return Err(lines.fault(format!("expected a line of format, found '{}'", excerpt(line))));
    }
    let (mut cosines, mut logarithms, mut scale) = (None, None, 1.0);
    for word in words {
        match word.to_ascii_lowercase().split_once('=') {
            Some(("angles", "deg")) => cosines = Some(false),
            Some(("angles", "sin")) => cosines = Some(true),
            Some(("bsdf", "value")) => logarithms = Some(false),
            Some(("bsdf", "log")) => logarithms = Some(true),
            Some(("scale", value)) => scale = lines.number_of(value, "scale")?,
            Some(("exclude" | "num", _)) => notes.push(format!("for FRED: {word}")),
            _ => return Err(lines.fault(format!("unknown word of format: '{}'", excerpt(word)))),
        }
    }
    let (Some(cosines), Some(logarithms)) = (cosines, logarithms) else {
        return Err(lines.fault("format does not say angles=deg or sin and bsdf=value or log"));
    };
    if scale <= 0.0 {
        return Err(lines.fault(format!("a scale that is not above 0: {scale}")));
    }
    Ok(Meaning { cosines, logarithms, scale })
}

impl Meaning {
    /// Polar angle, 0 to pi/2, and azimuth.
    fn direction(self, lines: &Lines<'_>, a: f64, b: f64) -> Result<[f64; 2], Fault> {
        if self.cosines {
            let sin = a.hypot(b);
            if sin > 1.0 + 1e-6 {
                return Err(lines.fault(format!("direction cosines beyond 1: {a}, {b}")));
            }
            let phi = if sin == 0.0 { 0.0 } else { around(a.atan2(b)) };
            return Ok([sin.min(1.0).asin(), phi]);
        }
        if !(-90.0..=90.0).contains(&a) || !(-360.0..=360.0).contains(&b) {
            return Err(lines.fault(format!("angles out of range, in degrees: {a}, {b}")));
        }
        let turn = if a < 0.0 { PI } else { 0.0 };
        Ok([a.abs().to_radians(), around(b.to_radians() + turn)])
    }

    fn bsdf(self, lines: &Lines<'_>, value: f64) -> Result<f64, Fault> {
        let f = self.scale * if self.logarithms { 10.0_f64.powf(value) } else { value };
        if f < 0.0 || !f.is_finite() {
            return Err(lines.fault(format!("a BSDF that is negative or none: {value}")));
        }
        Ok(f)
    }
}

/// At normal incidence the azimuth of the specular ray means nothing: that of the other incidences is taken if they have only one.
fn straighten(readings: &mut [Reading]) {
    let mut others = readings.iter().filter(|r| r.incidence[0] > 0.0).map(|r| r.incidence[1]);
    let Some(phi) = others.next() else { return };
    if others.any(|other| other.to_bits() != phi.to_bits()) {
        return;
    }
    for reading in readings.iter_mut().filter(|r| r.incidence[0] == 0.0) {
        reading.out[1] = around(reading.out[1] + reading.incidence[1] - phi);
        reading.incidence[1] = phi;
    }
}

/// A law that never falls to zero.
struct Floored<'a> {
    law: &'a dyn Law,
    /// Incidence and smallest value.
    least: Vec<([f64; 2], f64)>,
}

impl Law for Floored<'_> {
    fn value(&self, incidence: [f64; 2], out: [f64; 2]) -> f64 {
        let least =
            self.least.iter().find(|(at, _)| at.map(f64::to_bits) == incidence.map(f64::to_bits));
        let least = least.map_or(0.0, |l| l.1);
        self.law.value(incidence, out).max(least)
    }

    fn flux(&self, incidence: [f64; 2]) -> Option<f64> {
        self.law.flux(incidence)
    }
}

/// [`FLOOR`] of about the peak of an incidence: the largest value at the ray and on a coarse grid.
fn least(law: &dyn Law, incidence: [f64; 2], ray: Option<f64>) -> f64 {
    let at = |k: i32, l: i32| [f64::from(k) * FRAC_PI_2 / 45.0, f64::from(l) * PI / 12.0];
    let grid = (0..45).flat_map(|k| (0..24).map(move |l| at(k, l)));
    let all = grid.chain(ray.map(|theta| [theta, 0.0]));
    let peak = all.map(|out| law.value(incidence, out)).fold(0.0, f64::max);
    (FLOOR * peak).max(f64::MIN_POSITIVE)
}

fn sample(law: &dyn Law, subject: &Subject, options: &Options) -> Result<SampledBsdf, CannotHold> {
    let refuse = |what: &str, remedy: &str| CannotHold::new(NAME, what, remedy);
    if subject.symmetry != Symmetry::Isotropic {
        return Err(refuse(
            "a surface that is not isotropic",
            "use another format, such as zemax or speos",
        ));
    }
    let ratio = SampledBsdf {
        side: subject.side,
        lobe: subject.lobe,
        index: subject.index,
        symmetry: subject.symmetry,
        bands: vec![],
        interpolation: LAYOUT.interpolation,
        incidences: vec![],
        has_level: true,
        notes: vec![],
    }
    .ratio();
    let has_ray = |at: &&[f64; 2]| specular(at[0], ratio).is_some();
    let incidences: Vec<[f64; 2]> = options.incidences.iter().filter(has_ray).copied().collect();
    if incidences.is_empty() {
        return Err(refuse(
            "incidences beyond the critical angle, which have no direct ray",
            "give smaller ones with --incidence",
        ));
    }
    let of = |at: &[f64; 2]| (*at, least(law, *at, specular(at[0], ratio)));
    let floored = Floored { law, least: incidences.iter().map(of).collect() };
    let options = Options { incidences, ..options.clone() };
    let mut sampled = plan(&floored, subject, LAYOUT, &options);
    for incidence in &mut sampled.incidences {
        let Nodes::Grid(grid) = &mut incidence.nodes else { continue };
        let edge = EDGE.to_radians();
        let keep = grid.radii.iter().filter(|r| **r < edge - 1e-4).count();
        grid.radii.truncate(keep);
        grid.radii.push(edge);
        let at = [incidence.theta, incidence.phi];
        incidence.values = grid.directions().iter().map(|out| floored.value(at, *out)).collect();
    }
    Ok(sampled)
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = |what: &str, remedy: &str| CannotHold::new(NAME, what, remedy);
    let sampled = held::one_lobe(NAME, lobes)?;
    if sampled.symmetry != Symmetry::Isotropic {
        return Err(refuse("a surface that is not isotropic", "use another format"));
    }
    if sampled.bands.len() != 1 {
        return Err(refuse("more than one wavelength", "write a file for each"));
    }
    let is_other = |nodes: &Nodes| matches!(nodes, Nodes::Grid(g) if g.frame != Frame::Absolute);
    if sampled.incidences.iter().any(|i| is_other(&i.nodes)) {
        return Err(refuse("directions about the specular ray", "sample it anew"));
    }
    let mut order: Vec<usize> = (0..sampled.incidences.len()).collect();
    order.sort_by(|a, b| sampled.incidences[*a].theta.total_cmp(&sampled.incidences[*b].theta));
    let mut out = String::from("type bsdf_data\nformat angles=deg bsdf=value scale=1\n");
    for k in order {
        let incidence = &sampled.incidences[k];
        let ray = sampled.specular(incidence.theta).ok_or_else(|| {
            refuse("incidences beyond the critical angle", "leave them out with --incidence")
        })?;
        let _ = writeln!(out, "{}\t0", degrees(ray));
        let floor = FLOOR * sampled.peak(k, 0);
        for (at, value) in incidence.nodes.directions().iter().zip(sampled.band(k, 0)) {
            if at[0].to_degrees() > EDGE + 1e-9 {
                continue;
            }
            let value = value.max(floor).max(f64::MIN_POSITIVE);
            let _ = writeln!(out, "{}\t{}\t{value:.7e}", degrees(at[0]), degrees(at[1]));
        }
    }
    Ok(out.into_bytes())
}
