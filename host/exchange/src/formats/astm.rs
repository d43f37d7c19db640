//! Tables of ASTM E1392 and E2387 (`.astm`).
//!
//! Layout: the reader of libbsdf (`KimuraRyo`). Lines `KEY value`; `NUM_POINTS n`; `VARS theta_i,phi_i,theta_s,phi_s,` and names of the values; then
//! rows with commas. Angles are radians; `theta_s` is measured from the normal of the side the light leaves to, and one above pi/2 is
//! transmission. Azimuths are about the sample: the specular ray is pi from the source. Names of values may be wavelengths, `550nm`.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;

use super::flat::{Negatives, lobes, places};
use super::held;
use super::own;
use super::sampling::absolute;
use super::{Format, Source, Writer};
use crate::error::{CannotHold, Fault};
use crate::frame::around;
use crate::sampled::{Band, Lobe, SampledBsdf, Side};
use crate::table::Reading;
use crate::text::{Lines, excerpt};

const NAME: &str = "ASTM E2387";

pub(super) const FORMAT: Format = Format {
    name: "astm",
    title: "ASTM E1392/E2387 table",
    extensions: &["astm"],
    sniff: |source| {
        let is_vars = |line: &str| line.starts_with("VARS") && line.contains("theta");
        source.start().lines().any(|line| is_vars(line.trim()))
    },
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| Ok(absolute(false, law, subject, options)),
        encode,
        // readers make a table of all angles that occur: the same ones for all incidences leave no gaps in it
        notes: &["readers that take no hint from the file must be told that it is of transmission"],
    }),
};

/// What stands in a column.
#[derive(Clone, Debug, PartialEq)]
enum Column {
    ThetaI,
    PhiI,
    ThetaS,
    PhiS,
    Value(Band),
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let said = own::said(source.text.lines().take_while(|line| !line.starts_with("VARS")));
    let mut lines = Lines::new(NAME, &source.text);
    let (mut notes, mut announced) = (Vec::new(), None);
    let columns = loop {
        let line = lines.expect("VARS")?;
        let (key, value) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match key {
            "VARS" => break columns(&lines, value, said.wavelength_nm)?,
            "NUM_POINTS" => {
                let n = value.trim().parse::<usize>();
                let bad =
                    |_| lines.fault(format!("NUM_POINTS is not a count: '{}'", excerpt(value)));
                announced = Some(n.map_err(bad)?);
            }
            _ if own::is_own(line) => {}
            _ => notes.push(line.trim_start_matches("COMMENT").trim().to_owned()),
        }
    };
    let side = said.side.unwrap_or(Side::Air);
    let (mut readings, mut rows) = (Vec::new(), 0);
    let mut negatives = Negatives::default();
    while let Some(line) = lines.next_filled() {
        rows += 1;
        let row = lines.numbers(line, "a number")?;
        if row.len() != columns.len() {
            let (is, ought) = (row.len(), columns.len());
            return Err(lines.fault(format!("a row of {is} numbers where VARS has {ought}")));
        }
        let of = |column: &Column| columns.iter().position(|c| c == column).map_or(0.0, |k| row[k]);
        let incidence = [of(&Column::ThetaI), around(of(&Column::PhiI))];
        let (theta_s, phi_s) = (of(&Column::ThetaS), of(&Column::PhiS));
        if !(0.0..=FRAC_PI_2 + 1e-6).contains(&incidence[0]) {
            return Err(lines.fault(format!("theta_i is outside 0 to pi/2: {}", incidence[0])));
        }
        // a negative angle lies on the other side of the normal
        let turned = if theta_s < 0.0 { PI } else { 0.0 };
        let theta = theta_s.abs();
        if theta > PI + 1e-6 {
            return Err(
                lines.fault(format!("theta_s is outside -pi to pi: {theta_s}; angles are radians"))
            );
        }
        let (theta, through) =
            if theta > FRAC_PI_2 + 1e-6 { (PI - theta, true) } else { (theta, false) };
        let lobe = if through { Lobe::Transmission } else { said.lobe.unwrap_or(Lobe::Reflection) };
        let out = [theta.max(0.0), around(phi_s + turned - incidence[1] - PI)];
        for (column, v) in columns.iter().zip(&row) {
            let Column::Value(band) = column else { continue };
            let f = negatives.clamp(*v);
            readings.push(Reading { side, lobe, band: band.clone(), incidence, out, f });
        }
    }
    if announced.is_some_and(|n| n != rows) {
        let n = announced.unwrap_or(0);
        return Err(lines.fault(format!("{rows} rows where NUM_POINTS is {n}")));
    }
    notes.extend(negatives.note());
    lobes(readings, &said, &notes, || lines.fault("no rows after VARS"))
}

/// The columns of `VARS`: by name, or the first four in their order.
fn columns(lines: &Lines<'_>, names: &str, said_nm: Option<f64>) -> Result<Vec<Column>, Fault> {
    let names: Vec<_> = names.split(',').map(str::trim).collect();
    let angle = |name: &str| match name.to_ascii_lowercase().as_str() {
        "theta_i" => Some(Column::ThetaI),
        "phi_i" => Some(Column::PhiI),
        "theta_s" | "theta_r" | "theta_o" => Some(Column::ThetaS),
        "phi_s" | "phi_r" | "phi_o" => Some(Column::PhiS),
        _ => None,
    };
    let mut columns: Vec<Column> =
        names.iter().map(|name| angle(name).unwrap_or_else(|| Column::Value(band(name)))).collect();
    for needed in [Column::ThetaI, Column::ThetaS, Column::PhiS] {
        if columns.iter().filter(|c| **c == needed).count() != 1 {
            return Err(lines.fault(format!(
                "VARS must have {needed:?} once: '{}'",
                excerpt(&names.join(","))
            )));
        }
    }
    let values = columns.iter().filter(|c| matches!(c, Column::Value(_))).count();
    if values == 0 {
        return Err(lines.fault("VARS has no name of a value after the angles"));
    }
    if let (1, Some(nm)) = (values, said_nm) {
        columns
            .iter_mut()
            .filter(|c| matches!(c, Column::Value(_)))
            .for_each(|c| *c = Column::Value(Band::Wavelength(nm)));
    }
    Ok(columns)
}

/// The band of a name.
fn band(name: &str) -> Band {
    let nm = name.strip_suffix("nm").and_then(|n| n.trim().parse::<f64>().ok());
    match nm.filter(|nm| nm.is_finite() && *nm > 0.0) {
        Some(nm) => Band::Wavelength(nm),
        None if name.is_empty() || name.eq_ignore_ascii_case("BSDF") => Band::Unknown,
        None => Band::Named(name.into()),
    }
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let lobe = held::one_lobe(NAME, lobes)?;
    let mut out = String::new();
    for line in own::lines(lobe) {
        let _ = writeln!(out, "COMMENT {line}");
    }
    let all: Vec<_> = lobe.incidences.iter().map(places).collect();
    let name = |band: &Band| match band {
        Band::Wavelength(nm) => format!("{nm}nm"),
        Band::Named(name) => name.replace(',', " "),
        Band::Unknown => "BSDF".into(),
    };
    let names: Vec<_> = lobe.bands.iter().map(name).collect();
    let _ = writeln!(out, "NUM_POINTS {}", all.iter().map(Vec::len).sum::<usize>());
    let _ = writeln!(out, "VARS theta_i,phi_i,theta_s,phi_s,{}", names.join(","));
    for (k, (incidence, places)) in lobe.incidences.iter().zip(&all).enumerate() {
        for place in places {
            let phi_s = around(incidence.phi + PI + place.out[1]);
            let angles = [incidence.theta, incidence.phi, place.out[0], phi_s];
            let angles: Vec<_> = angles.iter().map(|a| radians(*a)).collect();
            let _ = write!(out, "{}", angles.join(","));
            for band in 0..lobe.bands.len() {
                let f = lobe.band(k, band).get(place.node).copied().unwrap_or(0.0);
                let _ = write!(out, ",{f:.7e}");
            }
            out.push('\n');
        }
    }
    Ok(out.into_bytes())
}

/// An angle with no digits that only rounding made.
fn radians(angle: f64) -> String {
    format!("{}", (angle * 1e13).round() / 1e13)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::read_bytes;
    use crate::sampled::{Nodes, Symmetry};

    fn read(text: &str) -> Result<Vec<SampledBsdf>, Fault> {
        let (format, lobes) = read_bytes("a.astm", text.as_bytes())?;
        assert_eq!(format.name, "astm");
        Ok(lobes)
    }

    /// A scan in the plane of incidence: the source at pi, the specular ray at 0.
    fn plane() -> String {
        let mut text = String::from(
            "SAMPLE black paint\nNUM_POINTS 18\nVARS theta_i,phi_i,theta_s,phi_s,450nm,550nm\n",
        );
        for k in 0..9 {
            for phi in [0.0, PI] {
                let theta = 0.15 * f64::from(k) + 0.01;
                let _ = writeln!(text, "0.5,{PI:.12},{theta},{phi:.12},{},{}", 0.2, 0.4);
            }
        }
        text
    }

    #[test]
    fn a_scan_in_one_plane_is_not_zero_elsewhere() {
        let lobe = &read(&plane()).unwrap()[0];
        assert_eq!(lobe.bands, [450.0, 550.0].map(Band::Wavelength));
        assert!(matches!(lobe.incidences[0].nodes, Nodes::Points(_)));
        assert_eq!(lobe.notes, ["SAMPLE black paint"]);
        for (band, level) in [0.2, 0.4].into_iter().enumerate() {
            // a level all over the hemisphere scatters pi times as much
            assert!((lobe.flux(0, band) - PI * level).abs() < 1e-9);
            for phi in [0.3, 1.5, 4.0] {
                let f = lobe.incidences[0].value(band, [0.7, phi], lobe.interpolation);
                assert!((f - level).abs() < 1e-15);
            }
        }
        // 0 of the file is the specular side here
        assert!(lobe.incidences[0].nodes.directions()[0][1].abs() < 1e-9);
    }

    #[test]
    fn negatives_transmission_and_missing_azimuths() {
        let text = "VARS theta_i,theta_s,phi_s,BSDF\n0,0.2,0,-0.1\n0,3.0,0,0.5\n";
        let lobes = read(text).unwrap();
        assert_eq!(
            lobes.iter().map(|l| l.lobe).collect::<Vec<_>>(),
            [Lobe::Reflection, Lobe::Transmission]
        );
        assert_eq!(lobes[0].incidences[0].values, [0.0]);
        assert!((lobes[1].incidences[0].nodes.directions()[0][0] - (PI - 3.0)).abs() < 1e-15);
        assert!(lobes[0].notes[0].starts_with("1 negative"));
        assert_eq!(lobes[0].symmetry, Symmetry::Rotational);
    }

    #[test]
    fn damaged_files_are_named_by_line_and_remedy() {
        let good = plane();
        for (damage, line, what) in [
            (good.replace("NUM_POINTS 18", "NUM_POINTS many"), 2, "NUM_POINTS"),
            (good.replace("NUM_POINTS 18", "NUM_POINTS 19"), 22, "18 rows"),
            (good.replace("theta_s,", ""), 3, "ThetaS"),
            (good.replace(",450nm,550nm", ""), 3, "no name of a value"),
            (good.replace("0.5,", "0.5,1,"), 4, "a row of 7"),
            (good.replace("0.5,", "x,"), 4, "not a number"),
            (good.replace("0.5,", "30,"), 4, "theta_i is outside"),
            (good.replace(",0.01,", ",20,"), 4, "radians"),
            (
                good.lines().take(3).collect::<Vec<_>>().join("\n").replace("NUM_POINTS 18\n", ""),
                2,
                "no rows",
            ),
        ] {
            let e = read(&damage).unwrap_err();
            let text = e.to_string();
            assert!(text.contains(what) && text.contains("export"), "{what}: {text}");
            let Fault::Line { line: at, .. } = e else { panic!("{text}") };
            assert_eq!(at, line, "{text}");
        }
    }
}
