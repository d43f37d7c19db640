//! Exports of the RT-300S goniophotometer: `.jdv`, `RayWiz` `.jdv`, text for `LightTools`, `.rtd` for Speos.
//!
//! Read off files of ua-loft/bsdf-tools. Lines may end with CR alone; a file holds a section for each incidence, and the whole set again
//! for each run. Polar angles are signed, the plane of incidence is at azimuth -90, and positive angles there are those of the
//! specular ray: the instrument calibrates at polar 30, azimuth -90, lighting 30. The files call their values raw data or an intensity and name
//! no unit: they are readings of unknown scale, `has_level` is false. Readings below zero, as after the subtraction of a blank, are kept as they are and
//! counted in the notes; a fit must leave them out.

use std::f64::consts::{FRAC_PI_2, PI};

use super::{Format, Source};
use crate::error::Fault;
use crate::frame::around;
use crate::sampled::{Band, Lobe, SampledBsdf, Side};
use crate::table::{Reading, collect};
use crate::text::{Lines, excerpt, fields};

const NAME: &str = "RT-300S";

pub(super) const FORMAT: Format = Format {
    name: "rt300s",
    title: "RT-300S export (jdv, RayWiz, LightTools, Speos rtd)",
    extensions: &["jdv", "rtd"],
    sniff: is_of_instrument,
    read: Some(read),
    write: None,
};

/// The exports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Jdv,
    RayWiz,
    LightTools,
    Rtd,
}

/// A section: one incidence.
#[derive(Debug)]
struct Section {
    incidence: f64,
    polar: Vec<f64>,
    azimuths: Vec<f64>,
    /// Azimuth after azimuth, each as long as there are polar angles.
    values: Vec<f64>,
    notes: Vec<String>,
}

/// Whether a text is one of the exports.
pub(super) fn is_of_instrument(source: &Source<'_>) -> bool {
    kind(source.start()).is_some()
}

fn kind(start: &str) -> Option<Kind> {
    let mut lines = start.split(['\r', '\n']).map(str::trim).filter(|line| !line.is_empty());
    let first = lines.next()?;
    let second = lines.next().unwrap_or("");
    if first.starts_with("DataType:") {
        let is_raywiz = first.to_ascii_lowercase().contains("raywiz");
        return Some(if is_raywiz { Kind::RayWiz } else { Kind::Jdv });
    }
    if first.starts_with("OPTIS - Anisotropic BSDF surface file v1") {
        return second.starts_with("SampleID").then_some(Kind::Rtd);
    }
    (first.starts_with("Name / Comment") && start.contains("Theta measure"))
        .then_some(Kind::LightTools)
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let mut lines = Lines::new(NAME, &source.text);
    let kind = kind(source.start()).ok_or_else(|| lines.fault("no export of the instrument"))?;
    let mut runs: Vec<Vec<Section>> = Vec::new();
    while lines.next_filled().is_some() {
        lines.back();
        let section = match kind {
            Kind::Jdv => jdv(&mut lines)?,
            Kind::RayWiz => raywiz(&mut lines)?,
            Kind::LightTools => lighttools(&mut lines)?,
            Kind::Rtd => rtd(&mut lines)?,
        };
        if !(-90.0..=90.0).contains(&section.incidence) {
            return Err(lines.fault(format!("an incidence beyond 90: {}", section.incidence)));
        }
        if section.polar.iter().any(|t| !(-90.0..=90.0).contains(t)) {
            return Err(lines.fault("a polar angle beyond 90"));
        }
        let same = |other: &Section| other.incidence.to_bits() == section.incidence.to_bits();
        match runs.last_mut().filter(|run| !run.iter().any(same)) {
            Some(run) => run.push(section),
            None => runs.push(vec![section]),
        }
    }
    Ok(runs.into_iter().flat_map(lobes).collect())
}

/// The lobes of a run of incidences.
fn lobes(run: Vec<Section>) -> Vec<SampledBsdf> {
    let mut notes: Vec<String> = Vec::new();
    let mut readings = Vec::new();
    for section in run {
        for note in section.notes {
            if !notes.contains(&note) {
                notes.push(note);
            }
        }
        let mut values = section.values.into_iter();
        for azimuth in &section.azimuths {
            for polar in &section.polar {
                let Some(f) = values.next() else { break };
                let turn = if *polar < 0.0 { PI } else { 0.0 };
                let phi = around(azimuth.to_radians() + FRAC_PI_2 + turn);
                readings.push(Reading {
                    side: Side::Air,
                    lobe: Lobe::Reflection,
                    band: Band::Unknown,
                    incidence: [section.incidence.abs().to_radians(), 0.0],
                    out: [polar.abs().to_radians(), phi],
                    f,
                });
            }
        }
    }
    let (all, below) = (readings.len(), readings.iter().filter(|r| r.f < 0.0).count());
    notes.push("the export names no unit: the scale is unknown".into());
    if below > 0 {
        notes.push(format!(
            "{below} of {all} readings are below zero, as after the subtraction of a blank: kept as readings, no BSDF is below zero"
        ));
    }
    let mut lobes = collect(readings, false);
    for lobe in &mut lobes {
        lobe.notes.clone_from(&notes);
        lobe.has_level = false;
    }
    lobes
}

/// Lines `key: value`.
type Pairs<'a> = Vec<(String, &'a str)>;

/// Reads `key: value` lines up to one that `end` knows, which is the last one read.
fn header<'a>(
    lines: &mut Lines<'a>,
    end: fn(&str) -> bool,
    what: &str,
) -> Result<(Pairs<'a>, &'a str), Fault> {
    let mut all = Vec::new();
    loop {
        let line = lines.expect(what)?;
        if end(line) {
            return Ok((all, line));
        }
        let (key, value) = line.split_once(':').unwrap_or((line, ""));
        all.push((key.trim().to_owned(), value.trim()));
    }
}

/// Those that say something of sample and instrument.
fn notes(header: &[(String, &str)]) -> Vec<String> {
    let told = |(key, value): &&(String, &str)| {
        !value.is_empty()
            && !["Incidence", "Polar", "Azimuth"].contains(&key.as_str())
            && !key.starts_with("Theta measure")
            && !key.starts_with("Phi measure")
            && key != "SampleID"
    };
    header.iter().filter(told).map(|(key, value)| format!("{key}: {value}")).collect()
}

fn value<'a>(lines: &Lines<'_>, header: &[(String, &'a str)], key: &str) -> Result<&'a str, Fault> {
    let found = header.iter().find(|(name, _)| name == key).map(|(_, value)| *value);
    found.ok_or_else(|| lines.fault(format!("no line '{key}' before the values")))
}

/// A row that begins with its own angle.
fn row(lines: &mut Lines<'_>, n: usize) -> Result<(f64, Vec<f64>), Fault> {
    let line = lines.expect("a row of values")?;
    let mut row = lines.numbers(line, "a value")?;
    if row.len() != n + 1 {
        let is = row.len();
        return Err(lines
            .fault(format!("a row of {is} numbers where an angle and {n} values are expected")));
    }
    let angle = row.remove(0);
    Ok((angle, row))
}

/// Angles from the first to the last.
fn steps(lines: &Lines<'_>, [first, last, step]: [f64; 3]) -> Result<Vec<f64>, Fault> {
    let n = ((last - first) / step).round();
    if !(0.0..=100_000.0).contains(&n) || (first + n * step - last).abs() > 1e-6 * step.abs() {
        return Err(lines.fault(format!("no angles from {first} to {last} by {step}")));
    }
    Ok((0..=n as usize).map(|k| first + step * k as f64).collect())
}

fn jdv(lines: &mut Lines<'_>) -> Result<Section, Fault> {
    let (header, _) = header(lines, |line| line == "Raw data", "Raw data")?;
    let incidence = lines.number_of(value(lines, &header, "Incidence")?, "the incidence")?;
    let angles = |key: &str| -> Result<Vec<f64>, Fault> {
        let numbers = lines.numbers(value(lines, &header, key)?, "an angle")?;
        let [first, last, step] = numbers[..] else {
            return Err(lines.fault(format!("{key} is not first, last and step")));
        };
        steps(lines, [first, last, step])
    };
    let (polar, azimuths) = (angles("Polar")?, angles("Azimuth")?);
    let notes = notes(&header);
    let line = lines.expect("the polar angles")?;
    let listed = lines.numbers(line, "a polar angle")?;
    if listed.len() != polar.len() {
        let (is, ought) = (listed.len(), polar.len());
        return Err(lines.fault(format!("{is} polar angles where the line Polar says {ought}")));
    }
    let mut section = Section { incidence, polar: listed, azimuths: vec![], values: vec![], notes };
    for _ in azimuths {
        let (azimuth, values) = row(lines, section.polar.len())?;
        section.azimuths.push(azimuth);
        section.values.extend(values);
    }
    Ok(section)
}

fn raywiz(lines: &mut Lines<'_>) -> Result<Section, Fault> {
    let is_number = |line: &str| line.starts_with(|c: char| c.is_ascii_digit());
    let (header, counts) = header(lines, is_number, "three counts")?;
    let counts = lines.numbers(counts, "a count")?;
    let [incidences, azimuthal, polar] = counts[..] else {
        return Err(
            lines.fault("expected three counts: incidences, steps of azimuth and polar angle")
        );
    };
    let ends = lines.exactly(4, "first and last azimuth and polar angle")?;
    if (incidences - 1.0).abs() > 0.0
        || !(1.0..=1e5).contains(&azimuthal)
        || !(1.0..=1e5).contains(&polar)
    {
        return Err(lines.fault(format!(
            "counts that are none of one incidence: {incidences} {azimuthal} {polar}"
        )));
    }
    let azimuths = steps(lines, [ends[0], ends[1], (ends[1] - ends[0]) / azimuthal])?;
    let polar = steps(lines, [ends[2], ends[3], (ends[3] - ends[2]) / polar])?;
    let incidence = lines.exactly(1, "the incidence")?[0];
    let mut rows = Vec::new();
    for _ in &polar {
        rows.push(lines.exactly(azimuths.len(), "a row of values")?);
    }
    Ok(Section {
        incidence,
        values: across(&rows, azimuths.len()),
        polar,
        azimuths,
        notes: notes(&header),
    })
}

/// Values azimuth after azimuth, of rows polar angle after polar angle.
fn across(rows: &[Vec<f64>], azimuths: usize) -> Vec<f64> {
    let column = |j: usize| rows.iter().filter_map(move |row| row.get(j).copied());
    (0..azimuths).flat_map(column).collect()
}

fn lighttools(lines: &mut Lines<'_>) -> Result<Section, Fault> {
    let (header, line) =
        header(lines, |line| line.starts_with("Theta Lighting"), "Theta Lighting")?;
    let field = fields(line).nth(2).unwrap_or("");
    let incidence = lines.number_of(field, "Theta Lighting")?;
    let angles = |name: &str| -> Result<Vec<f64>, Fault> {
        let of = |end: &str| -> Result<f64, Fault> {
            let key = format!("{name} measure {end}");
            lines.number_of(value(lines, &header, &key)?, &key)
        };
        steps(lines, [of("beginning")?, of("end")?, of("step")?])
    };
    let (thetas, azimuths) = (angles("Theta")?, angles("Phi")?);
    let (mut polar, mut rows) = (Vec::new(), Vec::new());
    for _ in thetas {
        let (angle, values) = row(lines, azimuths.len())?;
        polar.push(angle);
        rows.push(values);
    }
    Ok(Section {
        incidence,
        values: across(&rows, azimuths.len()),
        polar,
        azimuths,
        notes: notes(&header),
    })
}

/// The incidence is in the name of the sample alone; the table of absolute angles that follows holds the same readings, partly averaged, and is passed over.
fn rtd(lines: &mut Lines<'_>) -> Result<Section, Fault> {
    let title = lines.expect("the title")?;
    if !title.starts_with("OPTIS - Anisotropic BSDF surface file v1") {
        return Err(lines.fault(format!("expected a title, found '{}'", excerpt(title))));
    }
    let sample = lines.expect("SampleID")?;
    let number = sample.rsplit(' ').next().and_then(|word| word.parse::<f64>().ok());
    let incidence = number.filter(|t| t.is_finite()).ok_or_else(|| {
        lines.fault(format!("no incidence at the end of the name: '{}'", excerpt(sample)))
    })?;
    while lines.expect("Reflection Spectrum")? != "Reflection Spectrum" {}
    let n = lines.expect("the number of wavelengths")?;
    for _ in 0..lines.count(n, "wavelengths")? {
        lines.exactly(2, "wavelength and percentage")?;
    }
    let line = lines.expect("the azimuths")?;
    let azimuths = lines.numbers(line, "an azimuth")?;
    let (mut polar, mut rows) = (Vec::new(), Vec::new());
    while let Some(line) = lines.next_raw().filter(|line| !line.trim().is_empty()) {
        lines.back();
        let _ = line;
        let (angle, values) = row(lines, azimuths.len())?;
        polar.push(angle);
        rows.push(values);
    }
    if rows.is_empty() {
        return Err(lines.fault("no rows of values"));
    }
    while let Some(line) = lines.next_filled() {
        if line.starts_with("OPTIS") {
            lines.back();
            break;
        }
    }
    let notes = vec!["incidences are those in the names of the samples".to_owned()];
    Ok(Section { incidence, values: across(&rows, azimuths.len()), polar, azimuths, notes })
}
