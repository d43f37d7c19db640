//! BRDF look-up table of ASAM `OpenMATERIAL` 3D (`.xompt`, JSON).
//!
//! Layout: the JSON schema of version 1.0.0. Rows of wavelength (m), polar angle of the incidence, polar angle and azimuth of the exit (radians, the azimuth
//! from that of the incidence), BRDF (1/sr), sorted by columns. The incidence points to its source, as is usual for a BRDF, so that the
//! specular ray has the azimuth pi; the one example is the same on both sides. Reflection only.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fmt::Write as _;

use serde::Deserialize;
use serde_json::{Value as Json, json};

use super::flat::{HORIZON, lobes, places};
use super::own;
use super::sampling::absolute;
use super::{Format, Source, Writer};
use crate::error::{CannotHold, Fault};
use crate::frame::around;
use crate::sampled::{Band, Lobe, SampledBsdf, Side, Symmetry};
use crate::table::Reading;

const NAME: &str = "OpenMATERIAL 3D";

pub(super) const FORMAT: Format = Format {
    name: "openmaterial",
    title: "OpenMATERIAL 3D BRDF table",
    extensions: &["xompt"],
    sniff: |source| {
        let text = source.text.trim_start();
        text.starts_with('{') && text.contains("\"lookupTable\"") && text.contains("\"brdf\"")
    },
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| match subject.lobe {
            Lobe::Reflection => Ok(absolute(true, law, subject, options)),
            Lobe::Transmission => Err(transmission()),
        },
        encode,
        notes: &["azimuth pi is the side of the specular ray", "fill in license and copyrights"],
    }),
};

fn transmission() -> CannotHold {
    let remedy = "choose --lobe reflection, or another format".into();
    CannotHold { format: NAME, what: "transmission".into(), remedy }
}

#[derive(Deserialize)]
struct File {
    #[serde(default)]
    metadata: Json,
    brdf: Table,
}

#[derive(Deserialize)]
struct Table {
    #[serde(rename = "lookupTable")]
    rows: Vec<[Option<f64>; 5]>,
}

fn damaged(what: impl Into<String>) -> Fault {
    Fault::Damaged { format: NAME, what: what.into() }
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let file: File = serde_json::from_str(&source.text).map_err(|e| {
        let message = e.to_string();
        let what = message.split(" at line ").next().unwrap_or("").chars().take(120).collect();
        Fault::Line { format: NAME, line: e.line().max(1), what }
    })?;
    let text = |key: &str| file.metadata.get(key).and_then(Json::as_str).unwrap_or("");
    let said = own::said(text("description").lines());
    let mut notes: Vec<String> = text("description")
        .lines()
        .filter(|line| !own::is_own(line) && !line.trim().is_empty())
        .map(str::to_owned)
        .collect();
    for (title, key) in [("Sample", "name"), ("Sources", "sources"), ("License", "license")] {
        let note = format!("{title}: {}", text(key));
        if !text(key).is_empty() && text(key) != "NA" && !notes.contains(&note) {
            notes.push(note);
        }
    }
    let side = said.side.unwrap_or(Side::Air);
    let (mut readings, mut empty) = (Vec::new(), 0);
    for (k, row) in file.brdf.rows.iter().enumerate() {
        let [Some(metres), Some(theta_i), Some(theta_o), Some(phi_o), Some(f)] = *row else {
            empty += 1;
            continue;
        };
        let bad = |what: String| damaged(format!("row {} of lookupTable: {what}", k + 1));
        if !(1e-9..=17.16e-3).contains(&metres) {
            return Err(bad(format!("a wavelength outside 1e-9 to 0.01716 m: {metres}")));
        }
        for (theta, name) in [(theta_i, "incident"), (theta_o, "exit")] {
            if !(0.0..=FRAC_PI_2 + 1e-6).contains(&theta) {
                return Err(bad(format!("the {name} angle is outside 0 to pi/2 rad: {theta}")));
            }
        }
        if !(-TAU - 1e-5..=TAU + 1e-5).contains(&phi_o) {
            return Err(bad(format!("the azimuth is outside 0 to 2 pi rad: {phi_o}")));
        }
        if f < 0.0 {
            return Err(bad(format!("a negative BRDF: {f}")));
        }
        // nanometres without digits that only the power of ten made
        let band = Band::Wavelength((metres * 1e15).round() / 1e6);
        let out = [theta_o.min(FRAC_PI_2), around(phi_o - PI)];
        let incidence = [theta_i.min(FRAC_PI_2), 0.0];
        readings.push(Reading { side, lobe: Lobe::Reflection, band, incidence, out, f });
    }
    if empty > 0 {
        notes.push(format!("{empty} rows with null were left out"));
    }
    lobes(readings, &said, &notes, || damaged("no rows in lookupTable"))
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = |what: &str, remedy: &str| CannotHold::new(NAME, what, remedy);
    let [lobe] = lobes else {
        return Err(refuse("more than one lobe", "write the reflection alone"));
    };
    if lobe.lobe == Lobe::Transmission {
        return Err(transmission());
    }
    if lobe.symmetry == Symmetry::None {
        return Err(refuse("a surface that must not be turned", "give one incident azimuth"));
    }
    let metres = |band: &Band| match band {
        Band::Wavelength(nm) => Some(nm * 1e-9),
        _ => None,
    };
    let wavelengths: Option<Vec<f64>> = lobe.bands.iter().map(metres).collect();
    let wavelengths = wavelengths
        .ok_or_else(|| refuse("values without a wavelength", "give one with --wavelength-nm"))?;
    let mut rows: Vec<([f64; 4], f64)> = Vec::new();
    for (k, incidence) in lobe.incidences.iter().enumerate() {
        let places = places(incidence);
        for (b, metres) in wavelengths.iter().enumerate() {
            let values = lobe.band(k, b);
            rows.extend(places.iter().map(|place| {
                let [theta_o, phi] = place.out;
                let phi_o = (around(phi + PI)).min(TAU - 1e-6);
                let f = values.get(place.node).copied().unwrap_or(0.0);
                ([*metres, incidence.theta.min(HORIZON), theta_o, phi_o], f)
            }));
        }
    }
    rows.sort_by(|a, b| {
        let pairs = a.0.iter().zip(&b.0);
        pairs.map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut table = String::new();
    for (k, ([metres, theta_i, theta_o, phi_o], f)) in rows.iter().enumerate() {
        let [theta_i, theta_o, phi_o] = [*theta_i, *theta_o, *phi_o].map(radians);
        let comma = if k > 0 { ",\n" } else { "" };
        let _ = write!(table, "{comma}[{metres:e},{theta_i},{theta_o},{phi_o},{f:.7e}]");
    }
    let list: Vec<_> = wavelengths.iter().map(|m| format!("{m:e}")).collect();
    let list = list.join(",");
    let head = metadata(lobe, table.as_bytes());
    let text = format!(
        "{{\"metadata\":{head},\n\"brdf\":{{\"wavelengths\":[{list}],\n\"lookupTable\":[\n{table}\n]}}}}\n"
    );
    Ok(text.into_bytes())
}

/// An angle with no digits that only rounding made.
fn radians(angle: f64) -> f64 {
    (angle * 1e13).round() / 1e13
}

fn metadata(lobe: &SampledBsdf, table: &[u8]) -> Json {
    let description = own::lines(lobe).join("\n");
    let sample = lobe.notes.iter().find_map(|note| note.strip_prefix("Sample:"));
    json!({
        "name": sample.unwrap_or("NA").trim(),
        "description": description,
        "uuid": uuid(&[description.as_bytes(), table]),
        "materialVersion": "1.0.0",
        "openMaterial3dVersion": "1.0.0",
        "copyrights": ["NA"],
        "license": "NA",
        "authors": ["NA"],
        "sources": "simulation"
    })
}

/// An identifier of a content, of version 8 of RFC 9562: two hashes of Fowler, Noll and Vo.
fn uuid(parts: &[&[u8]]) -> String {
    let hash = |start: u64| {
        let bytes = parts.iter().flat_map(|part| part.iter());
        bytes.fold(start, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x0100_0000_01b3))
    };
    let (high, low) = (hash(0xcbf2_9ce4_8422_2325), hash(0x6c62_272e_07bb_0142));
    let high = high & !0xf000 | 0x8000;
    let low = low & !(0b11 << 62) | 0b10 << 62;
    format!(
        "{:08x}-{:04x}-{:04x}-{:04x}-{:012x}",
        high >> 32,
        high >> 16 & 0xffff,
        high & 0xffff,
        low >> 48,
        low & 0xffff_ffff_ffff
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::read_bytes;

    fn read_text(text: &str) -> Result<Vec<SampledBsdf>, Fault> {
        let (format, lobes) = read_bytes("a.xompt", text.as_bytes())?;
        assert_eq!(format.name, "openmaterial");
        Ok(lobes)
    }

    #[test]
    fn the_example_is_a_level_for_each_incidence() {
        let path = "formats/openmaterial/example_material_lidar_brdf.xompt";
        let Some(path) = asperity_needs::data(path) else { return };
        let (format, lobes) = crate::read(&path).unwrap();
        assert_eq!(format.name, "openmaterial");
        let [lobe] = lobes.as_slice() else { panic!("{}", lobes.len()) };
        assert_eq!(lobe.bands, [Band::Wavelength(905.0)]);
        // 905 rows of five incidences, a level each: found with json and collections.Counter of Python
        let levels = [
            (1.500_983, 1.325_5e-3),
            (1.518_436, 9.944_78e-4),
            (1.535_89, 6.631_54e-4),
            (1.553_343, 3.316_27e-4),
            ("1.570796".parse().unwrap(), 3.316_44e-5),
        ];
        assert_eq!(lobe.incidences.len(), levels.len());
        for ((k, incidence), (theta, level)) in lobe.incidences.iter().enumerate().zip(levels) {
            assert_eq!(
                (incidence.theta.to_bits(), incidence.nodes.len()),
                (f64::to_bits(theta), 181)
            );
            assert!(incidence.values.iter().all(|f| f.to_bits() == f64::to_bits(level)));
            assert!((lobe.flux(k, 0) / (PI * level) - 1.0).abs() < 1e-9);
        }
        assert!(lobe.notes.iter().any(|note| note == "Sample: asphalt_brdf_for_lidar"));
    }

    const SMALL: &str = "{\"metadata\": {\"name\": \"x\"},\n\"brdf\": {\"wavelengths\": [5.5e-7],\n\"lookupTable\": [\n[5.5e-7, 0.5, 0.2, 0, 0.1],\n[5.5e-7, 0.5, 0.2, 3.141592653589793, 0.3],\n[null, 0.5, 0.3, 0, 0.1]\n]}}";

    #[test]
    fn azimuths_count_from_the_source() {
        let lobe = &read_text(SMALL).unwrap()[0];
        let incidence = &lobe.incidences[0];
        assert!((incidence.value(0, [0.2, 0.0], lobe.interpolation) - 0.3).abs() < 1e-15);
        assert!((incidence.value(0, [0.2, PI], lobe.interpolation) - 0.1).abs() < 1e-15);
        assert!(lobe.notes.iter().any(|note| note.starts_with("1 rows with null")));
        let again = read_bytes("b", &encode(std::slice::from_ref(lobe)).unwrap()).unwrap().1;
        assert_eq!(again[0].incidences[0].nodes.len(), 2);
        assert_eq!(again[0].bands, [Band::Wavelength(550.0)]);
    }

    #[test]
    fn transmission_and_unknown_wavelengths_are_refused() {
        let lobe = read_text(SMALL).unwrap().remove(0);
        let through = SampledBsdf { lobe: Lobe::Transmission, ..lobe.clone() };
        let unknown = SampledBsdf { bands: vec![Band::Unknown], ..lobe };
        for (lobe, what) in [(through, "transmission"), (unknown, "--wavelength-nm")] {
            let text = encode(&[lobe]).unwrap_err().to_string();
            assert!(text.contains(what), "{text}");
        }
    }

    #[test]
    fn damaged_files_are_named_with_a_remedy() {
        for (damage, what) in [
            (SMALL.replace("]}}", "]}"), "line 7"),
            (SMALL.replace("0.2, 0, 0.1", "0.2, 0"), "line 4"),
            (SMALL.replace("0.2, 0, 0.1", "0.2, \"0\", 0.1"), "line 4"),
            (
                SMALL.replace("[5.5e-7, 0.5, 0.2, 0,", "[550, 0.5, 0.2, 0,"),
                "row 1 of lookupTable: a wavelength",
            ),
            (SMALL.replace("0.5, 0.2", "30, 0.2"), "row 1 of lookupTable: the incident angle"),
            (SMALL.replace("0.2, 3.14", "20, 3.14"), "row 2 of lookupTable: the exit angle"),
            (SMALL.replace("3.14", "180.14"), "row 2 of lookupTable: the azimuth"),
            (SMALL.replace("0.3]", "-0.3]"), "row 2 of lookupTable: a negative"),
            (SMALL.replace("0.5,", "null,"), "no rows"),
        ] {
            let text = read_text(&damage).unwrap_err().to_string();
            assert!(text.contains(what) && text.contains("export"), "{what}: {text}");
        }
    }
}
