//! Plain CSV: `theta_i,phi_i,theta_o,phi_o,f`, degrees about the sample, BSDF in 1/sr.
//!
//! Angles are those of `asperity eval`: polar angles from +z, the air, 0 to 180; azimuths about it from x to y; `theta_i`, `phi_i` point to the
//! source, so that the specular ray has `phi_o = phi_i + 180`. A column `wavelength_nm` may follow. Lines that begin with `#` are comments.

use std::fmt::Write as _;

use super::own;
use super::{Format, Source, Writer};
use crate::convention::{Global, between};
use crate::error::{CannotHold, Fault};
use crate::interpolation::Interpolation;
use crate::law::{Coordinates, Layout};
use crate::plan::plan;
use crate::sampled::{Band, SampledBsdf, Symmetry};
use crate::table::{Reading, collect};
use crate::text::{Lines, degrees, excerpt};

const NAME: &str = "CSV of angles";

pub(super) const FORMAT: Format = Format {
    name: "csv",
    title: "CSV with the columns theta_i,phi_i,theta_o,phi_o,f",
    extensions: &["csv"],
    sniff: |source| head(&source.text).is_some(),
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| Ok(plan(law, subject, LAYOUT, options)),
        encode,
        notes: &[],
    }),
};

const LAYOUT: Layout = Layout {
    coordinates: Coordinates::Absolute,
    own_grids: true,
    interpolation: Interpolation::Linear,
};

const COLUMNS: [&str; 6] = ["theta_i", "phi_i", "theta_o", "phi_o", "f", "wavelength_nm"];

/// Where each of [`COLUMNS`] stands in the line of names; `None` if that is none.
fn head(text: &str) -> Option<[Option<usize>; 6]> {
    let line = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'))?;
    let names: Vec<_> = line.split(',').map(str::trim).collect();
    let places = COLUMNS.map(|name| names.iter().position(|n| *n == name));
    places[..5].iter().all(Option::is_some).then_some(places)
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let said = own::said(source.text.lines().take_while(|line| line.starts_with('#')));
    let mut lines = Lines::new(NAME, &source.text);
    let Some(places) = head(&source.text) else {
        return Err(lines.fault("no line of names"));
    };
    let (mut readings, mut notes, mut seen) = (Vec::new(), Vec::new(), false);
    while let Some(line) = lines.next_filled() {
        if let Some(note) = line.strip_prefix('#') {
            if !own::is_own(note) {
                notes.push(note.trim().to_owned());
            }
            continue;
        }
        if !std::mem::replace(&mut seen, true) {
            continue; // the names
        }
        let fields: Vec<_> = line.split(',').collect();
        let number = |k: usize| -> Result<f64, Fault> {
            let field = places[k].and_then(|at| fields.get(at));
            let field = field.ok_or_else(|| lines.fault(format!("no {}", COLUMNS[k])))?;
            lines.number_of(field, COLUMNS[k])
        };
        let (theta_i, theta_o, f) = (number(0)?, number(2)?, number(4)?);
        for (theta, name) in [(theta_i, COLUMNS[0]), (theta_o, COLUMNS[2])] {
            if !(0.0..=180.0).contains(&theta) {
                return Err(lines.fault(format!("{name} is outside 0 to 180: {theta}")));
            }
        }
        if f < 0.0 {
            return Err(lines.fault(format!("a negative BSDF: '{}'", excerpt(line))));
        }
        let from = Global { theta: theta_i.to_radians(), phi: number(1)?.to_radians() };
        let to = Global { theta: theta_o.to_radians(), phi: number(3)?.to_radians() };
        let (side, theta) = from.side();
        let (leaving, theta_o) = to.side();
        let band = match places[5] {
            Some(_) => Band::Wavelength(number(5)?),
            None => said.wavelength_nm.map_or(Band::Unknown, Band::Wavelength),
        };
        let phi = crate::frame::around(from.phi);
        let incidence = [theta, phi];
        let out = [theta_o, to.relative(phi)];
        readings.push(Reading { side, lobe: between(side, leaving), band, incidence, out, f });
    }
    let isotropic = said.symmetry == Some(Symmetry::Isotropic);
    let mut all = collect(readings, isotropic);
    if all.is_empty() {
        return Err(lines.fault("no readings after the line of names"));
    }
    for lobe in &mut all {
        lobe.index = said.index;
        lobe.notes.clone_from(&notes);
    }
    Ok(all)
}

#[allow(clippy::unnecessary_wraps, reason = "the signature of every format")]
fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let mut out = String::new();
    for line in lobes.first().map(own::lines).unwrap_or_default() {
        let _ = writeln!(out, "# {line}");
    }
    out.push_str("theta_i,phi_i,theta_o,phi_o,f,wavelength_nm\n");
    let has_wavelengths =
        lobes.iter().flat_map(|l| &l.bands).all(|b| matches!(b, Band::Wavelength(_)));
    if !has_wavelengths {
        out = out.replace(",f,wavelength_nm\n", ",f\n");
    }
    for lobe in lobes {
        for (k, incidence) in lobe.incidences.iter().enumerate() {
            let from = Global::of_incidence(lobe.side, [incidence.theta, incidence.phi]);
            let directions = incidence.nodes.directions();
            for (b, band) in lobe.bands.iter().enumerate() {
                for (at, f) in directions.iter().zip(lobe.band(k, b)) {
                    let to = Global::of_outgoing(lobe.side, lobe.lobe, incidence.phi, *at);
                    let angles = [from.theta, from.phi, to.theta, to.phi].map(degrees);
                    let _ = write!(out, "{},{f:.9e}", angles.join(","));
                    if let (Band::Wavelength(nm), true) = (band, has_wavelengths) {
                        let _ = write!(out, ",{nm}");
                    }
                    out.push('\n');
                }
            }
        }
    }
    Ok(out.into_bytes())
}
