//! What the verbs that write files of other programs share: their flags, and the report of what was written.

use std::path::Path;

use asperity_exchange::compare::{Row, compare};
use asperity_exchange::compare_patches::compare_patches;
use asperity_exchange::formats::Writer;
use asperity_exchange::law::{Law, Options, Subject};
use asperity_exchange::{FORMATS, Format, Lobe, SampledBsdf, Side, read_bytes};
use clap::ValueEnum;
use serde::Serialize;

use super::error::Failure;
use super::flags::scan::number;
use super::{print, say};
use crate::output::AtomicFile;

/// Sides of a boundary, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum SideFlag {
    /// Light from the air
    Air,
    /// Light from inside the material
    Dielectric,
}

/// Lobes, as a flag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum LobeFlag {
    /// Light that comes back
    Reflection,
    /// Light that goes through
    Transmission,
}

impl From<SideFlag> for Side {
    fn from(flag: SideFlag) -> Self {
        match flag {
            SideFlag::Air => Self::Air,
            SideFlag::Dielectric => Self::Dielectric,
        }
    }
}

impl From<LobeFlag> for Lobe {
    fn from(flag: LobeFlag) -> Self {
        match flag {
            LobeFlag::Reflection => Self::Reflection,
            LobeFlag::Transmission => Self::Transmission,
        }
    }
}

/// How finely a file is sampled.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct GridFlags {
    /// Angles of incidence in degrees, in the medium the light comes from [default: 0 to 85 in steps of 5]
    #[arg(long, value_name = "DEG,...", value_delimiter = ',', value_parser = number)]
    incidence: Vec<f64>,
    /// Azimuths of the incidence in degrees, for a surface with a direction [default: 0]
    #[arg(long, value_name = "DEG,...", value_delimiter = ',', allow_hyphen_values = true, value_parser = number)]
    azimuth: Vec<f64>,
    /// Largest error between angles, percent of the peak of each incidence
    #[arg(long, value_name = "PERCENT", default_value_t = 0.5, value_parser = number)]
    tolerance: f64,
    /// Write it though the format is too coarse for the lobe, or what comes out is further off than asked
    #[arg(long)]
    accept: bool,
}

/// Largest relative error of the flux of a file.
const FLUX: f64 = 0.001;

impl GridFlags {
    /// The settings of a grid.
    pub(super) fn options(&self) -> Result<Options, Failure> {
        let usual = Options::default();
        if !(self.tolerance > 0.0 && self.tolerance <= 50.0) {
            let t = self.tolerance;
            return Err(Failure::bad(format!(
                "--tolerance {t} is not usable; give percent from above 0 to 50"
            )));
        }
        let mut incidences = Vec::new();
        let azimuths: &[f64] = if self.azimuth.is_empty() { &[0.0] } else { &self.azimuth };
        for azimuth in azimuths {
            let thetas: Vec<f64> = if self.incidence.is_empty() {
                usual.incidences.iter().map(|at| at[0].to_degrees()).collect()
            } else {
                self.incidence.clone()
            };
            for theta in thetas {
                if !(0.0..90.0).contains(&theta) {
                    return Err(Failure::bad(format!(
                        "--incidence {theta} is not usable; give 0 to below 90 degrees"
                    )));
                }
                let phi = azimuth.rem_euclid(360.0);
                incidences.push([theta, phi].map(f64::to_radians));
            }
        }
        incidences.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0])));
        incidences.dedup();
        let accept = self.accept;
        Ok(Options {
            incidences,
            tolerance: self.tolerance / 100.0,
            flux_tolerance: FLUX,
            accept,
            ..usual
        })
    }
}

/// The format of a name, with what writes it.
pub(super) fn writer(name: &str) -> Result<(&'static Format, Writer), Failure> {
    let written: Vec<_> = FORMATS.iter().filter(|f| f.write.is_some()).map(|f| f.name).collect();
    let format = Format::of_name(name);
    match format.and_then(|f| f.write.map(|w| (f, w))) {
        Some(found) => Ok(found),
        None if format.is_some() => Err(Failure::bad(format!(
            "--format {name} is read, not written; give one of {}",
            written.join(", ")
        ))),
        None => Err(Failure::bad(format!(
            "--format {name} is not known; give one of {}",
            written.join(", ")
        ))),
    }
}

/// A file to write: the format, the law behind it, and where it goes.
pub(super) struct Writing<'a> {
    pub(super) format: &'static Format,
    pub(super) writer: Writer,
    pub(super) law: &'a dyn Law,
    pub(super) subject: &'a Subject,
    pub(super) options: &'a Options,
    pub(super) path: &'a Path,
    pub(super) json: bool,
}

/// What is printed of a file.
#[derive(Serialize)]
struct Answer<'a> {
    asperity: u32,
    format: &'a str,
    side: &'a str,
    lobe: &'a str,
    bytes: usize,
    /// Incidence by incidence; empty for a format that is only written.
    incidences: &'a [Row],
    notes: &'a [String],
}

impl Writing<'_> {
    /// Writes the lobe, reads it back, and prints how far it is from the law.
    pub(super) fn run(&self, output: AtomicFile, made: &SampledBsdf) -> Result<(), Failure> {
        let bytes = (self.writer.encode)(std::slice::from_ref(made)).map_err(Failure::bad)?;
        let rows = self.read_back(&bytes, made)?;
        let notes = self.notes(made);
        let is_stdout = output.is_stdout();
        let length = bytes.len();
        let far = self.too_far(&rows);
        if let (Some(far), false) = (&far, self.options.accept) {
            return Err(Failure::No(format!(
                "{far}; nothing was written: give a smaller --tolerance, other --incidence, or --accept"
            )));
        }
        crate::output::finish_all(vec![(output, bytes)])?;
        let answer = Answer {
            asperity: 1,
            format: self.format.name,
            side: self.subject.side.name(),
            lobe: self.subject.lobe.name(),
            bytes: length,
            incidences: &rows,
            notes: &notes,
        };
        if is_stdout {
            for note in &notes {
                say::note(format_args!("note: {note}"));
            }
            return Ok(());
        }
        print(&if self.json {
            serde_json::to_string_pretty(&answer).map_err(Failure::bad)? + "\n"
        } else {
            human(&answer)
        })
    }

    fn read_back(&self, bytes: &[u8], made: &SampledBsdf) -> Result<Vec<Row>, Failure> {
        if self.format.read.is_none() {
            return Ok(Vec::new());
        }
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let (_, lobes) = read_bytes(&name, bytes).map_err(|e| {
            Failure::Trouble(format!("the file cannot be read back: {e}; nothing was written"))
        })?;
        let own = |l: &&SampledBsdf| l.side == self.subject.side && l.lobe == self.subject.lobe;
        let Some(lobe) = lobes.iter().find(own).or(lobes.first()) else { return Ok(Vec::new()) };
        let patches = compare_patches(lobe, self.law);
        Ok(patches.unwrap_or_else(|| compare(lobe, made, self.law)))
    }

    /// What the user of the file must know.
    fn notes(&self, made: &SampledBsdf) -> Vec<String> {
        let mut notes: Vec<String> = self.writer.notes.iter().map(|&n| n.to_owned()).collect();
        let left_out = self.options.incidences.len().saturating_sub(made.incidences.len());
        let is_gridded =
            made.incidences.iter().all(|i| self.options.incidences.contains(&[i.theta, i.phi]));
        if left_out > 0 && is_gridded {
            notes.push(format!(
                "{left_out} incidences beyond the critical angle have no direct ray, and no place in this format"
            ));
        }
        if self.subject.coherent > 0.0 {
            notes.push(format!(
                "coherent light, up to {:.4} of the flux, is not in the file: its program needs it as a specular part of the surface",
                self.subject.coherent
            ));
        }
        if self.subject.index.is_some() {
            notes.push("the index is constant: it does not change with the wavelength".into());
        }
        notes
    }

    /// The first incidence whose flux or peak is not right.
    fn too_far(&self, rows: &[Row]) -> Option<String> {
        let peak = 100.0 * self.options.tolerance;
        let flux = 100.0 * self.options.flux_tolerance;
        let is_patched = rows.iter().any(|row| row.node_error_percent.is_nan());
        rows.iter().filter(|row| row.flux_law > 1e-9).find_map(|row| {
            let (f, p) = (row.flux_percent(), row.peak_percent());
            let at = row.incidence_deg;
            if f.abs() > flux * 1.0001 {
                Some(format!("at {at} deg the flux of the file is {f:.2} % from that of the model"))
            } else if p.abs() > peak && !is_patched {
                Some(format!("at {at} deg the peak of the file is {p:.2} % from that of the model"))
            } else {
                None
            }
        })
    }
}

fn human(answer: &Answer<'_>) -> String {
    use std::fmt::Write as _;
    let mut text = format!(
        "{}: {} from {}, {} bytes\n",
        answer.format, answer.lobe, answer.side, answer.bytes
    );
    if !answer.incidences.is_empty() {
        text += "  incidence   directions   flux      error %    peak, 1/sr   error %    values, % of peak\n";
    }
    for row in answer.incidences {
        let _ = writeln!(
            text,
            "  {:6.2}      {:7}      {:.5}   {:+.4}    {:<10.5} {:+.4}     {:.1e}",
            row.incidence_deg,
            row.nodes,
            row.flux_law,
            row.flux_percent(),
            row.peak_law,
            row.peak_percent(),
            row.node_error_percent
        );
    }
    for note in answer.notes {
        let _ = writeln!(text, "note: {note}");
    }
    text
}
