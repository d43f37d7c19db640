//! Surface scattering distribution data, SSDD 0.3 (`.ssdd`).
//!
//! Layout and meaning: "Surface scattering distribution data (SSDD) file format", version 0.3 of 2026-05-01 (libbsdf, `KimuraRyo`). A file has up to
//! four blocks: BRDF, BTDF, specular reflectance and transmittance. Angles are degrees, values BSDF in 1/sr, the polar angle of the
//! incidence the fastest index. Azimuths of the spherical coordinates count from the source, so that the specular ray is at 180. Those about the ray
//! count from the direction towards the normal; `PARAM4_LIST` is the polar angle of the ray less that of the incidence.
//!
//! The coherent part is a lobe of incidences without nodes, whose stated flux it is.

mod block;
mod lobe;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;

use self::block::Kind;
use super::held;
use super::lattice::Lattice;
use super::own;
use super::sampling::about_ray;
use super::{Format, Source, Writer};
use crate::error::{CannotHold, Fault};
use crate::sampled::{Band, Lobe, SampledBsdf};
use crate::text::degrees;

const NAME: &str = "SSDD";

pub(super) const FORMAT: Format = Format {
    name: "ssdd",
    title: "SSDD (surface scattering distribution data)",
    extensions: &["ssdd"],
    sniff: |source| {
        let mut lines =
            source.start().lines().filter(|l| !l.trim().is_empty() && !l.starts_with('#'));
        let is_version = lines.next().is_some_and(|l| l.starts_with("VERSION"));
        is_version && lines.any(|l| l.starts_with("DATA_TYPE"))
    },
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| about_ray(NAME, law, subject, options),
        encode,
        notes: &[],
    }),
};

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let blocks = block::read(NAME, source.bytes)?;
    blocks.iter().map(|block| lobe::of(NAME, block)).collect()
}

fn encode(lobes: &[SampledBsdf]) -> Result<Vec<u8>, CannotHold> {
    let refuse = |what: &str, remedy: &str| CannotHold::new(NAME, what, remedy);
    held::one_side(NAME, lobes)?;
    let mut out = String::from("VERSION 0.3\n");
    let _ = writeln!(out, "SOFTWARE asperity-{}", env!("CARGO_PKG_VERSION"));
    let mut seen = Vec::new();
    for lobe in lobes {
        let is_coherent = lobe.incidences.iter().all(|i| i.nodes.is_empty());
        let kind = match (lobe.lobe, is_coherent) {
            (Lobe::Reflection, false) => Kind::Brdf,
            (Lobe::Transmission, false) => Kind::Btdf,
            (Lobe::Reflection, true) => Kind::SpecularReflectance,
            (Lobe::Transmission, true) => Kind::SpecularTransmittance,
        };
        if seen.contains(&kind) {
            return Err(refuse("two lobes of a kind", "write a file for each"));
        }
        seen.push(kind);
        let colours = Colours::of(lobe).ok_or_else(|| {
            refuse("bands that are neither wavelengths nor three colours", "choose one")
        })?;
        out.push('\n');
        for line in own::lines(lobe) {
            let _ = writeln!(out, "# {line}");
        }
        let _ = writeln!(out, "DATA_TYPE {}\n{}", kind.word(), colours.lines());
        if is_coherent { coherent(&mut out, lobe)? } else { scatter(&mut out, lobe)? }
    }
    Ok(out.into_bytes())
}

/// How bands are said.
enum Colours {
    Monochrome,
    Three(&'static str),
    Spectrum(Vec<f64>),
}

impl Colours {
    fn of(lobe: &SampledBsdf) -> Option<Self> {
        let nm = |band: &Band| if let Band::Wavelength(nm) = band { Some(*nm) } else { None };
        if let Some(list) = lobe.bands.iter().map(nm).collect::<Option<Vec<f64>>>() {
            return list.windows(2).all(|w| w[0] < w[1]).then_some(Self::Spectrum(list));
        }
        match lobe.bands.as_slice() {
            [_] => Some(Self::Monochrome),
            [Band::Named(first), _, _] if first == "X" => Some(Self::Three("xyz")),
            [_, _, _] => Some(Self::Three("rgb")),
            _ => None,
        }
    }

    fn lines(&self) -> String {
        match self {
            Self::Monochrome => "COLOR_MODEL monochrome".into(),
            Self::Three(name) => format!("COLOR_MODEL {name}"),
            Self::Spectrum(list) => {
                let list: Vec<_> = list.iter().map(f64::to_string).collect();
                format!("COLOR_MODEL spectrum\nWAVELENGTH_LIST {}", list.join(" "))
            }
        }
    }
}

fn list(out: &mut String, name: &str, angles: impl IntoIterator<Item = f64>) {
    let list: Vec<_> = angles.into_iter().map(degrees).collect();
    let _ = writeln!(out, "{name} {}", list.join(" "));
}

fn scatter(out: &mut String, lobe: &SampledBsdf) -> Result<(), CannotHold> {
    let lattice = Lattice::of(NAME, lobe)?;
    out.push_str("PARAM_TYPE specular_coordinate_system\n");
    if lattice.grid.mirrored {
        out.push_str("REDUCTION_TYPE bilateral_symmetry\n");
    }
    list(out, "PARAM0_LIST", lattice.thetas.iter().copied());
    if lattice.phis.len() > 1 {
        list(out, "PARAM1_LIST", lattice.phis.iter().copied());
    }
    list(out, "PARAM2_LIST", lattice.grid.radii.iter().copied());
    list(out, "PARAM3_LIST", lattice.azimuths());
    if lobe.lobe == Lobe::Transmission {
        list(out, "PARAM4_LIST", lattice.rays.iter().zip(&lattice.thetas).map(|(r, t)| r - t));
    }
    out.push_str("SOURCE_TYPE generated\nDATA ascii\n");
    let (nt, np) = (lattice.thetas.len(), lattice.phis.len());
    // all rows, by incidence and band, so that the incidence may run fastest
    let rows: Vec<Vec<Vec<&[f64]>>> = (0..nt * np)
        .map(|k| {
            let incidence = lattice.incidence(k / nt, k % nt);
            (0..lobe.bands.len()).map(|band| lattice.rows(lobe, incidence, band)).collect()
        })
        .collect();
    for azimuth in 0..lattice.azimuths().len() {
        for radius in 0..lattice.grid.radii.len() {
            for bands in &rows {
                let colour: Vec<_> =
                    bands.iter().map(|rows| format!("{:.7e}", rows[azimuth][radius])).collect();
                let _ = writeln!(out, "{}", colour.join(" "));
            }
        }
    }
    Ok(())
}

fn coherent(out: &mut String, lobe: &SampledBsdf) -> Result<(), CannotHold> {
    let rotates = lobe.incidences.windows(2).any(|w| w[0].phi.to_bits() != w[1].phi.to_bits());
    let is_stated = lobe.incidences.iter().all(|i| i.stated.len() == lobe.bands.len());
    if rotates || !is_stated {
        let what = "a coherent part that depends on the azimuth, or is not stated".into();
        return Err(CannotHold {
            format: NAME,
            what,
            remedy: "give one of a single azimuth".into(),
        });
    }
    list(out, "PARAM0_LIST", lobe.incidences.iter().map(|i| i.theta));
    out.push_str("DATA ascii\n");
    for incidence in &lobe.incidences {
        let colour: Vec<_> = incidence.stated.iter().map(|v| format!("{v:.7e}")).collect();
        let _ = writeln!(out, "{}", colour.join(" "));
    }
    Ok(())
}
