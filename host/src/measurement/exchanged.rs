//! Files of other programs ([`asperity_exchange`]) as scans: all readings of one lobe and one band.

use std::path::Path;

use asperity_core::gonio::Geometry;
use asperity_exchange::{Band, Incidence, Lobe, SampledBsdf, Side};

use super::csv;
use super::error::{ScanError, ScanFault};
use super::layout::Layout;
use super::{Measurement, Metadata, Quantity, Reading, Stated};

/// The format whose files do not say whether light is reflected or transmitted: what the user says counts.
const STATES_NO_LOBE: &str = "fred";

/// Which part of a file is meant, where it holds several.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Reflection or transmission.
    pub geometry: Option<Geometry>,
    /// A wavelength in nm, or the name of a band such as `Visible`.
    pub band: Option<String>,
    /// What the numbers are, whatever the file says.
    pub quantity: Option<Stated>,
}

/// Reads the content of a scan file, or of a file of scatter of any format of [`asperity_exchange::FORMATS`], whichever it is;
/// `name` is the path that errors show.
///
/// # Errors
/// [`ScanError`] with the place and the remedy.
pub fn parse(bytes: &[u8], name: impl AsRef<Path>, part: &Part) -> Result<Measurement, ScanError> {
    parse_noting(bytes, name, part).map(|(scan, _)| scan)
}

/// The same with how a scan file is written.
///
/// # Errors
/// [`ScanError`] with the place and the remedy.
pub fn parse_noting(
    bytes: &[u8],
    name: impl AsRef<Path>,
    part: &Part,
) -> Result<(Measurement, Layout), ScanError> {
    let name = name.as_ref();
    let of_file = |fault| ScanError::new(name, fault);
    let file = name.file_name().unwrap_or_default().to_string_lossy();
    if asperity_exchange::formats::detect_bytes(&file, bytes).is_none() {
        let band = part.band.as_ref().map(|text| text.trim().parse::<f64>().map_err(|_| text));
        let nm = band.transpose();
        let nm = nm.map_err(|text| of_file(ScanFault::NoBand { asked: text.clone() }))?;
        return csv::parse_stated(bytes, name, nm, part.quantity);
    }
    let (format, mut lobes) = asperity_exchange::read_bytes(&file, bytes)
        .map_err(|fault| of_file(ScanFault::Exchanged(Box::new(fault))))?;
    if let (Some(said), true, [lobe]) =
        (part.geometry, format.name == STATES_NO_LOBE, lobes.as_mut_slice())
    {
        lobe.lobe = match said {
            Geometry::Reflection => Lobe::Reflection,
            Geometry::Transmission => Lobe::Transmission,
        };
    }
    let refuse = |what: String| of_file(ScanFault::NoScan { format: format.title, what });
    let lobe = the_lobe(lobes, part).map_err(refuse)?;
    let band = the_band(&lobe, part).map_err(refuse)?;
    let readings: Vec<_> = lobe
        .incidences
        .iter()
        .enumerate()
        .flat_map(|(k, incidence)| of_incidence(incidence, lobe.band(k, band)))
        .collect();
    if readings.is_empty() {
        return Err(refuse("it holds no direction above the surface".into()));
    }
    let mut meta = Metadata {
        geometry: Some(geometry(&lobe)),
        ior: lobe.index,
        wavelength_nm: match lobe.bands.get(band) {
            Some(Band::Wavelength(nm)) => Some(*nm),
            _ => None,
        },
        quantity: Some(Quantity::Bsdf),
        ..Metadata::default()
    };
    if let Some(stated) = part.quantity {
        meta.state(stated);
    }
    let scan = Measurement::new(meta, readings).map_err(|e| ScanError::of_reading(name, e, |_| 1));
    Ok((scan?, Layout::default()))
}

fn geometry(lobe: &SampledBsdf) -> Geometry {
    match lobe.lobe {
        Lobe::Reflection => Geometry::Reflection,
        Lobe::Transmission => Geometry::Transmission,
    }
}

/// The lobe that is meant, or why there is none.
fn the_lobe(mut lobes: Vec<SampledBsdf>, part: &Part) -> Result<SampledBsdf, String> {
    let names = |lobes: &[SampledBsdf]| {
        let name = |l: &SampledBsdf| format!("{} from {}", l.lobe.name(), l.side.name());
        lobes.iter().map(name).collect::<Vec<_>>().join(", ")
    };
    let held = names(&lobes);
    lobes.retain(|lobe| lobe.side == Side::Air);
    if lobes.is_empty() {
        return Err(format!(
            "it holds {held}: light from inside the material, which no plate shows; a fit needs light from the air"
        ));
    }
    if let Some(asked) = part.geometry {
        lobes.retain(|lobe| geometry(lobe) == asked);
    }
    let lobe = match (lobes.pop(), lobes.len()) {
        (Some(one), 0) => one,
        (None, _) => return Err(format!("it holds {held}: correct --geometry")),
        _ => return Err(format!("it holds {held}; choose one with --geometry")),
    };
    if !lobe.has_level {
        return Err(
            "it gives the shape of the lobe and no level; give readings with a level".into()
        );
    }
    Ok(lobe)
}

/// The number of the band that is meant, or why there is none.
fn the_band(lobe: &SampledBsdf, part: &Part) -> Result<usize, String> {
    let name = |band: &Band| match band {
        Band::Wavelength(nm) => format!("{nm} nm"),
        Band::Named(name) => name.clone(),
        Band::Unknown => "a band without a name".into(),
    };
    let held = || lobe.bands.iter().map(name).collect::<Vec<_>>().join(", ");
    let Some(asked) = &part.band else {
        return match lobe.bands.len() {
            1 => Ok(0),
            _ => Err(format!("it holds {}; choose one with --band", held())),
        };
    };
    let is_asked = |band: &Band| match (band, asked.trim().parse::<f64>()) {
        (Band::Wavelength(nm), Ok(asked)) => (nm - asked).abs() <= csv::SAME_NM,
        (Band::Named(name), _) => name.eq_ignore_ascii_case(asked.trim()),
        _ => false,
    };
    let found = lobe.bands.iter().position(is_asked);
    found.ok_or_else(|| format!("no band is `{asked}`; it holds {}: correct --band", held()))
}

/// The readings of one incidence, those in equal directions as their mean.
fn of_incidence(incidence: &Incidence, values: &[f64]) -> Vec<Reading> {
    // what is left of a decimal angle after the way through radians
    let degrees = |radians: f64| (radians.to_degrees() * 1e7).round() / 1e7;
    let (sigma_deg, rotation) = (degrees(incidence.theta), degrees(incidence.phi));
    let rotation_deg = rotation.rem_euclid(360.0);
    let directions = incidence.nodes.directions().into_iter().zip(values);
    // the horizon says nothing
    let above = directions.filter(|([theta, _], _)| degrees(*theta) < 90.0);
    let reading = |(direction, value): ([f64; 2], &f64)| Reading {
        rotation_deg,
        ..Reading::at(sigma_deg, direction.map(degrees), *value)
    };
    let mut readings: Vec<Reading> = above.map(reading).collect();
    readings.sort_by(Reading::compare_place);
    let equal = |a: &Reading, b: &Reading| a.compare_place(b).is_eq();
    let mean = |same: &[Reading]| {
        let sum: f64 = same.iter().map(|r| r.value).sum();
        Reading { value: sum / same.len() as f64, ..same[0] }
    };
    readings.chunk_by(equal).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "# asperity: ior = 1.49\ntheta_i,phi_i,theta_o,phi_o,f\n\
        30,0,10,180,2\n30,0,30,180,5\n30,0,20,0,1\n30,0,20,90,0.5\n0,0,0,0,3\n0,0,0,45,5\n";

    #[test]
    fn readings_of_all_directions_become_a_scan() {
        let scan = parse(FILE.as_bytes(), "file.csv", &Part::default()).unwrap();
        let at = |sigma, polar, value| Reading::at(sigma, polar, value);
        // azimuths of the file count from the source, and the pole is read twice
        let expected = [
            at(0.0, [0.0, 0.0], 4.0),
            at(30.0, [20.0, 180.0], 1.0),
            at(30.0, [10.0, 0.0], 2.0),
            at(30.0, [30.0, 0.0], 5.0),
            at(30.0, [20.0, 270.0], 0.5),
        ];
        assert_eq!(scan.readings(), expected);
        assert_eq!(scan.by_plane().count(), 3);
        assert_eq!(scan.meta.geometry, Some(Geometry::Reflection));
        assert_eq!((scan.meta.ior, scan.quantity()), (Some(1.49), Quantity::Bsdf));
    }

    #[test]
    fn light_from_inside_is_no_scan() {
        let inside = FILE.replace("\n30,0,", "\n150,0,").replace("\n0,0,", "\n180,0,");
        let error = parse(inside.as_bytes(), "file.csv", &Part::default()).unwrap_err().to_string();
        assert!(error.contains("inside") && error.contains("from the air"), "{error}");
    }
}
