//! Writing: one grid for all incidences.

use std::f64::consts::PI;
use std::fmt::Write as _;

use super::{NAME, SOURCE, TRISTIMULUS};
use crate::error::CannotHold;
use crate::formats::own;
use crate::frame::Frame;
use crate::sampled::{Band, Grid, Lobe, Nodes, SampledBsdf, Side};
use crate::text::degrees;

pub(super) fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = |what: &str, remedy: &str| CannotHold::new(NAME, what, remedy);
    let first = lobes.first().ok_or_else(|| refuse("no lobe", "give one"))?;
    let all = lobes.iter().flat_map(|lobe| &lobe.incidences);
    let grids: Option<Vec<&Grid>> = all
        .map(|i| match &i.nodes {
            Nodes::Grid(grid) if grid.frame == Frame::Absolute => Some(grid),
            _ => None,
        })
        .collect();
    let grids = grids.ok_or_else(|| {
        refuse("directions that are no grid of absolute angles", "sample it anew")
    })?;
    let grid = *grids.first().ok_or_else(|| refuse("a lobe without incidences", "give some"))?;
    if grids.iter().any(|g| *g != grid) {
        return Err(refuse("incidences with different grids", "sample it anew"));
    }
    let bands = first.bands.len();
    if lobes.iter().any(|lobe| lobe.bands != first.bands || ![1, 3].contains(&bands)) {
        return Err(refuse("wavelengths other than one, or X, Y and Z", "write a file for each"));
    }
    let turns = lobes.iter().any(|lobe| {
        lobe.incidences.iter().any(|i| i.phi.to_bits() != lobe.incidences[0].phi.to_bits())
    });
    if turns {
        return Err(refuse(
            "rotations of the sample, whose azimuths would differ",
            "use speos or zemax",
        ));
    }
    let mut out = String::new();
    for line in own::lines(first) {
        let _ = writeln!(out, "# {line}");
    }
    let symmetry = if grid.mirrored { "PlaneSymmetrical" } else { "Asymmetric" };
    let content = if bands == 3 { "XYZ" } else { "Monochrome" };
    let _ = write!(out, "Symmetry {symmetry}\nSpectralContent {content}\n");
    // relative 0 is opposite to the source; of a mirrored grid the half beyond it ascends from the source
    let azimuth = |a: &f64| if grid.mirrored { SOURCE + PI - a } else { SOURCE + PI + a };
    let mut azimuths: Vec<(f64, usize)> =
        grid.azimuths.iter().enumerate().map(|(j, a)| (azimuth(a), j)).collect();
    for (a, _) in &mut azimuths {
        if *a >= 2.0 * PI {
            *a -= 2.0 * PI;
        }
    }
    azimuths.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (name, angles) in [
        ("ScatterAzimuth", azimuths.iter().map(|a| a.0).collect::<Vec<_>>()),
        ("ScatterRadial", grid.radii.clone()),
    ] {
        let list: Vec<_> = angles.iter().map(|a| degrees(*a)).collect();
        let _ = writeln!(out, "{name} {}\n{}", angles.len(), list.join(" "));
    }
    out.push_str("DataBegin\n");
    for lobe in lobes {
        for (k, incidence) in lobe.incidences.iter().enumerate() {
            for (band, tristimulus) in TRISTIMULUS.iter().enumerate().take(bands) {
                block(&mut out, lobe, k, band);
                if bands == 3 {
                    let _ = writeln!(out, "TristimulusValue {tristimulus}");
                }
                let _ = writeln!(out, "TIS {:.9}", lobe.flux(k, band));
                let values = &lobe.band(k, band);
                let n = incidence.nodes.len() / azimuths.len().max(1);
                for (_, j) in &azimuths {
                    let row = values.get(j * n..(j + 1) * n).unwrap_or(&[]);
                    let row: Vec<_> = row.iter().map(|v| format!("{v:.7e}")).collect();
                    let _ = writeln!(out, "{}", row.join(" "));
                }
            }
        }
    }
    out.push_str("DataEnd\n");
    Ok(out.into_bytes())
}

/// The lines before the values.
fn block(out: &mut String, lobe: &SampledBsdf, k: usize, band: usize) {
    let theta = lobe.incidences[k].theta;
    let (aoi, side) = match lobe.side {
        Side::Air => (theta, "Front"),
        Side::Dielectric => (PI - theta, "Back"),
    };
    let kind = if lobe.lobe == Lobe::Reflection { "BRDF" } else { "BTDF" };
    let _ = write!(out, "AOI {}\nPOI {}\nSide {side}\n", degrees(aoi), degrees(SOURCE));
    if let Some(Band::Wavelength(nm)) = lobe.bands.get(band) {
        let _ = writeln!(out, "Wavelength {nm}");
    }
    let _ = writeln!(out, "ScatterType {kind}");
}
