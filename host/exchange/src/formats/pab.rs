//! Text of the pab-opto goniophotometer, which `pabopto2bsdf` of Radiance reads: one incidence a file.
//!
//! Layout and meaning: manual page and source of `pabopto2bsdf` (NREL/Radiance). Lines of the header begin with `#`; rows are `theta phi value` in
//! degrees about the sample, polar angles from the normal of the front, 0 to 180. `DSF` is the BSDF times the cosine of the outgoing
//! direction. The program reads a file up to the first line that is no row, so that files of several incidences, which are read here, are not written.

use std::f64::consts::PI;
use std::fmt::Write as _;

use super::flat::{Negatives, lobes, places};
use super::held;
use super::own;
use super::sampling::absolute;
use super::{Format, Source, Writer};
use crate::convention::{Global, Value, between};
use crate::error::{CannotHold, Fault};
use crate::frame::around;
use crate::sampled::{Band, SampledBsdf};
use crate::table::Reading;
use crate::text::{Lines, degrees, excerpt};

const NAME: &str = "pab-opto";

pub(super) const FORMAT: Format = Format {
    name: "pab",
    title: "pab-opto goniophotometer text",
    extensions: &["txt", "dat"],
    sniff: |source| {
        let is_format = |line: &str| line.starts_with("#format:") && line.contains("theta phi");
        source.start().lines().any(|line| is_format(line.trim()))
    },
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| Ok(absolute(true, law, subject, options)),
        encode,
        notes: &[
            "one incidence a file; pabopto2bsdf takes all files of a pair of sides at once",
            "pabopto2bsdf fits its own lobes to the readings: its flux is not that of the file",
        ],
    }),
};

/// What the header of an incidence says.
#[derive(Debug, Default)]
struct Header {
    theta: Option<f64>,
    phi: Option<f64>,
    value: Option<Value>,
    bands: Vec<Band>,
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let said = own::said(source.text.lines().filter(|line| line.starts_with('#')));
    let mut lines = Lines::new(NAME, &source.text);
    let (mut notes, mut readings) = (Vec::new(), Vec::new());
    let mut header = Header::default();
    let (mut negatives, mut in_rows) = (Negatives::default(), false);
    while let Some(line) = lines.next_filled() {
        if let Some(entry) = line.strip_prefix('#') {
            if std::mem::take(&mut in_rows) {
                // a further incidence keeps what its header does not say anew
                (header.theta, header.phi) = (None, None);
            }
            header.entry(&lines, entry, &mut notes)?;
            continue;
        }
        in_rows = true;
        let incidence = header.incidence(&lines)?;
        let Some(value) = header.value else {
            return Err(lines.fault("no '#format: theta phi' before the rows"));
        };
        let row = lines.numbers(line, "a number")?;
        let bands = header.bands.len().max(1);
        if row.len() != 2 + bands {
            let is = row.len();
            return Err(
                lines.fault(format!("a row of {is} numbers where {} are expected", 2 + bands))
            );
        }
        let to = global(&lines, row[0], row[1])?;
        let (side, theta_i) = incidence.side();
        let (leaving, theta_o) = to.side();
        for (k, v) in row[2..].iter().enumerate() {
            let known = said.wavelength_nm.map_or(Band::Unknown, Band::Wavelength);
            // at the horizon a cosine-weighted value says nothing
            let Some(f) = value.to_bsdf(negatives.clamp(*v), theta_o) else { continue };
            readings.push(Reading {
                side,
                lobe: between(side, leaving),
                band: header.bands.get(k).cloned().unwrap_or(known),
                incidence: [theta_i, incidence.phi],
                out: [theta_o, to.relative(incidence.phi)],
                f,
            });
        }
    }
    notes.extend(negatives.note());
    lobes(readings, &said, &notes, || lines.fault("no rows after the header"))
}

impl Header {
    fn entry(
        &mut self,
        lines: &Lines<'_>,
        entry: &str,
        notes: &mut Vec<String>,
    ) -> Result<(), Fault> {
        let (key, value) = entry.split_once(char::is_whitespace).unwrap_or((entry, ""));
        let number = |what: &str| lines.number_of(value, what);
        match key {
            "intheta" => self.theta = Some(number(key)?),
            "inphi" => self.phi = Some(number(key)?),
            "incident_angle" => {
                let both = lines.numbers(value, key)?;
                let [theta, phi] = both.as_slice() else {
                    return Err(lines.fault("incident_angle is not a polar angle and an azimuth"));
                };
                (self.theta, self.phi) = (Some(*theta), Some(*phi));
            }
            "format:" => {
                let kind = value.split_whitespace().nth(2).unwrap_or("").to_ascii_uppercase();
                self.value = match kind.as_str() {
                    "DSF" => Some(Value::CosineWeighted),
                    "BSDF" | "BRDF" | "BTDF" => Some(Value::Bsdf),
                    _ => {
                        let value = excerpt(value);
                        return Err(lines.fault(format!(
                            "the format is not 'theta phi' with DSF or BSDF: '{value}'"
                        )));
                    }
                };
            }
            "colorimetry:" => {
                let names: &[&str] = match value.trim().to_ascii_uppercase().as_str() {
                    "CIE-XYZ" => &["X", "Y", "Z"],
                    "CIE-Y" => &["Y"],
                    other => {
                        return Err(
                            lines.fault(format!("unknown colorimetry '{}'", excerpt(other)))
                        );
                    }
                };
                self.bands = names.iter().map(|name| Band::Named((*name).into())).collect();
            }
            _ if own::is_own(entry) => {}
            _ => {
                let note = entry.trim().to_owned();
                if note.chars().any(char::is_alphanumeric) && !notes.contains(&note) {
                    notes.push(note);
                }
            }
        }
        Ok(())
    }

    fn incidence(&self, lines: &Lines<'_>) -> Result<Global, Fault> {
        let (Some(theta), Some(phi)) = (self.theta, self.phi) else {
            return Err(lines.fault("no '#intheta' and '#inphi' before the rows"));
        };
        global(lines, theta, phi)
    }
}

/// A direction of angles in degrees; a negative polar angle lies on the other side of the normal.
fn global(lines: &Lines<'_>, theta: f64, phi: f64) -> Result<Global, Fault> {
    if !(-180.0..=180.0).contains(&theta) || phi.abs() > 720.0 {
        return Err(lines.fault(format!("no direction in degrees: {theta} {phi}")));
    }
    let turned = if theta < 0.0 { PI } else { 0.0 };
    Ok(Global { theta: theta.abs().to_radians(), phi: around(phi.to_radians() + turned) })
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = |what: String, remedy: &str| CannotHold::new(NAME, what, remedy);
    let lobe = held::one_lobe(NAME, lobes)?;
    let [incidence] = lobe.incidences.as_slice() else {
        let n = lobe.incidences.len();
        return Err(refuse(format!("{n} incidences"), "write a file for each with --incidence"));
    };
    let is_xyz = matches!(lobe.bands.as_slice(), [Band::Named(x), _, _] if x == "X");
    if lobe.bands.len() != 1 && !is_xyz {
        let n = lobe.bands.len();
        return Err(refuse(format!("{n} bands that are not X, Y and Z"), "choose one"));
    }
    let mut out = String::new();
    let sample = lobe.notes.iter().find_map(|note| note.strip_prefix("Sample:"));
    let sample = sample.unwrap_or("asperity").trim().replace('"', "'");
    let _ = writeln!(out, "#sample_name \"{sample}\"");
    for line in own::lines(lobe) {
        let _ = writeln!(out, "# {line}");
    }
    let from = Global::of_incidence(lobe.side, [incidence.theta, incidence.phi]);
    let (theta, phi) = (degrees(from.theta), degrees(from.phi));
    let _ = writeln!(out, "#intheta {theta}\n#inphi {phi}\n#upphi 90");
    match lobe.bands.first() {
        Some(_) if is_xyz => out.push_str("#colorimetry: CIE-XYZ\n"),
        Some(Band::Named(name)) if name == "Y" => out.push_str("#colorimetry: CIE-Y\n"),
        _ => {}
    }
    out.push_str("#format: theta phi BSDF\n");
    for place in places(incidence) {
        let to = Global::of_outgoing(lobe.side, lobe.lobe, incidence.phi, place.out);
        let _ = write!(out, "{} {}", degrees(to.theta), degrees(to.phi));
        for band in 0..lobe.bands.len() {
            let f = lobe.band(0, band).get(place.node).copied().unwrap_or(0.0);
            let _ = write!(out, " {f:.7e}");
        }
        out.push('\n');
    }
    Ok(out.into_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::read_bytes;
    use crate::sampled::{Lobe, Side};

    const MANUAL: &str = "#incident_angle 82.5 180\n#format: theta phi DSF\n84.968 125.790 0.009744\n84.889 125.610 0.007737\n84.805 125.427 0.008569\n";

    fn read(text: &str) -> Result<Vec<SampledBsdf>, Fault> {
        let (format, lobes) = read_bytes("f01.txt", text.as_bytes())?;
        assert_eq!(format.name, "pab");
        Ok(lobes)
    }

    #[test]
    fn the_example_of_the_manual_is_a_cosine_weighted_reflection() {
        let lobe = &read(MANUAL).unwrap()[0];
        assert_eq!((lobe.side, lobe.lobe), (Side::Air, Lobe::Reflection));
        let incidence = &lobe.incidences[0];
        assert!((incidence.theta.to_degrees() - 82.5).abs() < 1e-12);
        // the specular ray of a source at 180 is at 0
        assert!((incidence.nodes.directions()[0][1].to_degrees() - 125.79).abs() < 1e-9);
        assert!((incidence.values[0] - 0.009_744 / 84.968_f64.to_radians().cos()).abs() < 1e-12);
    }

    #[test]
    fn sides_incidences_and_colours() {
        let text = "#sample_name \"film\"\n#colorimetry: CIE-XYZ\n#intheta 150\n#inphi 0\n#format: theta phi BTDF\n30 180 1 2 3\n10 180 4 5 -6\n#intheta 120\n#inphi 0\n60 180 7 8 9\n";
        let lobes = read(text).unwrap();
        let lobe = &lobes[0];
        assert_eq!((lobe.side, lobe.lobe, lobes.len()), (Side::Dielectric, Lobe::Transmission, 1));
        assert_eq!(lobe.bands.len(), 3);
        // ascending polar angles: from inside they are 30 and 60
        assert!((lobe.incidences[0].theta.to_degrees() - 30.0).abs() < 1e-9);
        assert_eq!(lobe.band(0, 2), [3.0, 0.0]);
        assert_eq!(lobe.band(1, 1), [8.0]);
        assert!(lobe.notes.iter().any(|note| note.starts_with("1 negative")));
    }

    #[test]
    fn several_incidences_are_not_written() {
        let lobes = read(&MANUAL.repeat(2).replacen("82.5", "80", 1)).unwrap();
        let text = encode(&lobes).unwrap_err().to_string();
        assert!(text.contains("2 incidences") && text.contains("--incidence"), "{text}");
    }

    #[test]
    fn damaged_files_are_named_by_line_and_remedy() {
        for (damage, line, what) in [
            (MANUAL.replace("82.5 180", "82.5"), 1, "incident_angle"),
            (MANUAL.replace("82.5", "eighty"), 1, "not a number"),
            (MANUAL.replace("DSF", "ABC"), 2, "DSF or BSDF"),
            (MANUAL.replace("#incident_angle 82.5 180\n", ""), 2, "intheta"),
            (MANUAL.replace("84.889 ", "284.889 "), 4, "no direction"),
            (MANUAL.replace(" 0.007737", ""), 4, "a row of 2"),
            (MANUAL.replace("0.007737", "inf"), 4, "not a number"),
            (MANUAL.replace("#format", "#colorimetry: RGB\n#format"), 2, "colorimetry"),
            (MANUAL.lines().take(2).collect::<Vec<_>>().join("\n"), 2, "no rows"),
        ] {
            let e = read(&damage).unwrap_err();
            let text = e.to_string();
            assert!(text.contains(what) && text.contains("export"), "{what}: {text}");
            let Fault::Line { line: at, .. } = e else { panic!("{text}") };
            assert_eq!(at, line, "{text}");
        }
    }
}
