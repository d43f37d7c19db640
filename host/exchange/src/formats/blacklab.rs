//! Bidirectional reflectance factors of the Blacklab goniometer: pi times the BRDF, a column for each wavelength.
//!
//! Read off a file of ua-loft/bsdf-tools. `src_z` and `view_z` are polar angles, `src_a` and `view_a` azimuths of source and detector, degrees.
//! A set of angles may be read again: both readings are kept.

use super::{Format, Source};
use crate::convention::{Global, Value};
use crate::error::Fault;
use crate::sampled::{Band, Lobe, SampledBsdf, Side};
use crate::table::{Reading, collect};
use crate::text::Lines;

const NAME: &str = "Blacklab BRF";

pub(super) const FORMAT: Format = Format {
    name: "blacklab",
    title: "Blacklab reflectance factors (BRF)",
    extensions: &["txt"],
    sniff: |source| {
        let is_head = |line: &str| line.trim_start().starts_with("src_z");
        source.start().split(['\r', '\n']).any(is_head)
    },
    read: Some(read),
    write: None,
};

const COLUMNS: [&str; 4] = ["src_z", "src_a", "view_z", "view_a"];

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let mut lines = Lines::new(NAME, &source.text);
    let mut notes = Vec::new();
    let names = loop {
        let line = lines.expect("the line of names")?;
        if line.starts_with("src_z") {
            break line;
        }
        notes.push(line.to_owned());
    };
    let bands = bands(&lines, names)?;
    let mut readings = Vec::new();
    while let Some(line) = lines.next_filled() {
        let row = lines.numbers(line, "a value")?;
        if row.len() != bands.len() + 4 {
            let (is, ought) = (row.len(), bands.len() + 4);
            return Err(lines.fault(format!("{is} numbers where there are {ought} names")));
        }
        for (name, theta) in [(COLUMNS[0], row[0]), (COLUMNS[2], row[2])] {
            if !(0.0..=90.0).contains(&theta) {
                return Err(lines.fault(format!("{name} is outside 0 to 90: {theta}")));
            }
        }
        let [theta_i, phi_i, theta_o, phi_o] = [0, 1, 2, 3].map(|k| row[k].to_radians());
        let phi_i = crate::frame::around(phi_i);
        let to = Global { theta: theta_o, phi: phi_o };
        for (band, factor) in bands.iter().zip(&row[4..]) {
            let Some(f) = Value::Factor.to_bsdf(*factor, theta_o).filter(|f| *f >= 0.0) else {
                return Err(lines.fault(format!("a negative reflectance factor: {factor}")));
            };
            readings.push(Reading {
                side: Side::Air,
                lobe: Lobe::Reflection,
                band: band.clone(),
                incidence: [theta_i, phi_i],
                out: [theta_o, to.relative(phi_i)],
                f,
            });
        }
    }
    let mut all = collect(readings, false);
    if all.is_empty() {
        return Err(lines.fault("no readings after the line of names"));
    }
    for lobe in &mut all {
        lobe.notes.clone_from(&notes);
    }
    Ok(all)
}

/// The wavelengths in the names of the columns.
fn bands(lines: &Lines<'_>, names: &str) -> Result<Vec<Band>, Fault> {
    let mut names = names.split_whitespace();
    for column in COLUMNS {
        if names.next() != Some(column) {
            return Err(lines.fault(format!("no column {column} in its place")));
        }
    }
    let mut bands = Vec::new();
    for name in names {
        let nm = name.strip_suffix("nm").and_then(|n| n.parse::<f64>().ok());
        let nm = nm.filter(|nm| nm.is_finite() && *nm > 0.0);
        let nm = nm.ok_or_else(|| {
            lines.fault(format!("a column that is no wavelength in nm: '{name}'"))
        })?;
        bands.push(Band::Wavelength(nm));
    }
    if bands.is_empty() {
        return Err(lines.fault("no column of a wavelength"));
    }
    Ok(bands)
}
