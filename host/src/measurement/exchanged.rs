//! Files of other programs ([`asperity_exchange`]) as scans: the readings in the plane of incidence.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use asperity_core::gonio::Geometry;
use asperity_exchange::{Band, Incidence, Lobe, SampledBsdf, Side};

use super::csv;
use super::error::{ScanError, ScanFault};
use super::{Measurement, Metadata, Quantity, Reading};

/// Directions nearer to the plane of incidence than this lie in it, radians.
const IN_PLANE: f64 = 1e-6;

/// Reads the content of a scan file, or of a file of scatter of any format of [`asperity_exchange::FORMATS`], whichever it is;
/// `name` is the path that errors show.
///
/// # Errors
/// [`ScanError`] with the place and the remedy.
pub fn parse(bytes: &[u8], name: impl AsRef<Path>) -> Result<Measurement, ScanError> {
    let name = name.as_ref();
    let file = name.file_name().unwrap_or_default().to_string_lossy();
    if asperity_exchange::formats::detect_bytes(&file, bytes).is_none() {
        return csv::parse(bytes, name);
    }
    let of_file = |fault| ScanError::new(name, fault);
    let (format, mut lobes) = asperity_exchange::read_bytes(&file, bytes)
        .map_err(|fault| of_file(ScanFault::Exchanged(Box::new(fault))))?;
    let refuse = |what: String| of_file(ScanFault::NoScan { format: format.title, what });
    let names = |l: &SampledBsdf| format!("{} from {}", l.lobe.name(), l.side.name());
    let lobe = match (lobes.pop(), lobes.len()) {
        (Some(one), 0) => one,
        (one, _) => {
            let all: Vec<_> = lobes.iter().chain(&one).map(names).collect();
            return Err(refuse(format!(
                "it holds {}; take one with `asperity convert --side --lobe`",
                all.join(", ")
            )));
        }
    };
    in_plane(&lobe).map_err(|e| match e {
        NotInPlane::What(what) => refuse(what),
        NotInPlane::Reading(e) => ScanError::of_reading(name, e, |_| 1),
    })
}

/// Why a lobe is no scan.
enum NotInPlane {
    What(String),
    Reading(super::InvalidReading),
}

/// The readings of a lobe in the plane of incidence.
fn in_plane(lobe: &SampledBsdf) -> Result<Measurement, NotInPlane> {
    let what = |text: &str| Err(NotInPlane::What(text.into()));
    if lobe.side == Side::Dielectric {
        return what(
            "it is light from inside the material, which no plate shows; a fit needs light from the air",
        );
    }
    if !lobe.has_level {
        return what("it gives the shape of the lobe and no level; give readings with a level");
    }
    if lobe.bands.len() > 1 {
        return what("it holds several wavelengths; convert it to csv and keep the rows of one");
    }
    if lobe.incidences.iter().any(|i| (i.phi - lobe.incidences[0].phi).abs() > IN_PLANE) {
        return what(
            "it holds several rotations of the sample; convert it to csv and keep the rows of one",
        );
    }
    let readings: Vec<_> = (0..lobe.incidences.len()).flat_map(|k| of_incidence(lobe, k)).collect();
    if readings.is_empty() {
        return what("no direction of it lies in the plane of incidence");
    }
    let meta = Metadata {
        geometry: Some(match lobe.lobe {
            Lobe::Reflection => Geometry::Reflection,
            Lobe::Transmission => Geometry::Transmission,
        }),
        ior: lobe.index,
        wavelength_nm: match lobe.bands.first() {
            Some(Band::Wavelength(nm)) => Some(*nm),
            _ => None,
        },
        quantity: Some(Quantity::Bsdf),
        ..Metadata::default()
    };
    Measurement::new(meta, readings).map_err(NotInPlane::Reading)
}

/// The readings of one incidence, those at equal angles as their mean.
fn of_incidence(lobe: &SampledBsdf, k: usize) -> Vec<Reading> {
    let incidence: &Incidence = &lobe.incidences[k];
    let degrees = |radians: f64| (radians.to_degrees() * 1e9).round() / 1e9;
    let mut means: BTreeMap<i64, (f64, f64, f64)> = BTreeMap::new();
    for ([theta, phi], value) in incidence.nodes.directions().into_iter().zip(lobe.band(k, 0)) {
        let sign = if phi < IN_PLANE || 2.0 * PI - phi < IN_PLANE {
            1.0
        } else if (phi - PI).abs() < IN_PLANE {
            -1.0
        } else if theta < IN_PLANE {
            0.0
        } else {
            continue;
        };
        if theta > PI / 2.0 - 1e-9 {
            continue; // the horizon says nothing
        }
        let theta_deg = degrees(sign * theta);
        let sums = means.entry((theta_deg * 1e7).round() as i64).or_insert((theta_deg, 0.0, 0.0));
        sums.1 += value;
        sums.2 += 1.0;
    }
    let sigma_deg = degrees(incidence.theta);
    let of =
        |(theta_deg, sum, n): (f64, f64, f64)| Reading { sigma_deg, theta_deg, value: sum / n };
    means.into_values().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "# asperity: ior = 1.49\ntheta_i,phi_i,theta_o,phi_o,f\n\
        30,0,10,180,2\n30,0,30,180,5\n30,0,20,0,1\n30,0,20,90,0.5\n0,0,0,0,3\n0,0,0,45,5\n";

    #[test]
    fn readings_in_the_plane_become_a_scan() {
        let scan = parse(FILE.as_bytes(), "file.csv").unwrap();
        let found: Vec<_> =
            scan.readings().iter().map(|r| (r.sigma_deg, r.theta_deg, r.value)).collect();
        assert_eq!(
            found,
            [(0.0, 0.0, 4.0), (30.0, -20.0, 1.0), (30.0, 10.0, 2.0), (30.0, 30.0, 5.0)]
        );
        assert_eq!(scan.meta.geometry, Some(Geometry::Reflection));
        assert_eq!((scan.meta.ior, scan.quantity()), (Some(1.49), Quantity::Bsdf));
    }

    #[test]
    fn light_from_inside_is_no_scan() {
        let inside = FILE.replace("\n30,0,", "\n150,0,").replace("\n0,0,", "\n180,0,");
        let error = parse(inside.as_bytes(), "file.csv").unwrap_err().to_string();
        assert!(error.contains("inside") && error.contains("from the air"), "{error}");
    }
}
