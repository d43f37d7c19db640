//! Measured BSDFs of Ansys Speos: `.anisotropicbsdf` and the spectral `.brdf`, both as text of version 8.
//!
//! Layout and meaning: Ansys Speos help, "Structure of Anisotropic BSDF Files", "Structure of BRDF files" and "Anisotropic BSDF Surface Overview";
//! files and converter of ansys/optical-automation. Angles are absolute, the specular direction lies at azimuth 0, reflection has polar
//! angles 0 to 90 and transmission 90 to 180. Tables are shapes alone: the percentages of the spectrum say what flux they have.
//! Assumed: values between the nodes are linear in both angles. The binary mode is not documented and not read.

mod block;
mod anisotropic;
mod spectral;
mod write;

use super::{Format, Source, Writer};
use crate::error::Fault;
use crate::interpolation::Interpolation;
use crate::law::{Coordinates, Layout};
use crate::plan::plan;
use crate::sampled::SampledBsdf;
use crate::text::Lines;

const NAME: &str = "Speos";

pub(super) const FORMAT: Format = Format {
    name: "speos",
    title: "Ansys Speos anisotropic or spectral BSDF (text)",
    extensions: &["anisotropicbsdf", "brdf"],
    sniff: |source| kind(source.start()).is_some() && !super::rt300s::is_of_instrument(source),
    read: Some(read),
    write: Some(Writer {
        sample: |law, subject, options| Ok(plan(law, subject, LAYOUT, options)),
        encode: write::encode,
        notes: &[
            "Speos takes the level from the percentages of the spectrum; they hold at the incidence that the file names with them",
            "the wavelength is written as a comment: the spectrum is flat about it",
        ],
    }),
};

/// The grid of the format.
const LAYOUT: Layout = Layout {
    coordinates: Coordinates::Absolute,
    own_grids: true,
    interpolation: Interpolation::Linear,
};

/// The kinds of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Anisotropic,
    Spectral,
}

/// What the first line says it is.
fn kind(start: &str) -> Option<Kind> {
    let first = start.split(['\r', '\n']).next()?.to_ascii_lowercase();
    let rest = first.trim().strip_prefix("optis - ")?.to_owned();
    if rest.starts_with("anisotropic bsdf surface file") {
        Some(Kind::Anisotropic)
    } else if rest.starts_with("brdf surface file") {
        Some(Kind::Spectral)
    } else {
        None
    }
}

fn read(source: &Source<'_>) -> Result<Vec<SampledBsdf>, Fault> {
    let mut lines = Lines::new(NAME, &source.text);
    match kind(source.start()) {
        Some(Kind::Anisotropic) => {
            let head = Head::read(&mut lines)?;
            anisotropic::read(&mut lines, &head)
        }
        Some(Kind::Spectral) => {
            let head = Head::read(&mut lines)?;
            spectral::read(&mut lines, &head)
        }
        None => Err(lines.fault("the first line is not that of a measured BSDF of Speos")),
    }
}

/// The rows that both kinds begin with.
#[derive(Debug)]
struct Head {
    /// Comment and description, line by line.
    notes: Vec<String>,
}

impl Head {
    /// Title, mode, comment, length of the description, description.
    fn read(lines: &mut Lines<'_>) -> Result<Self, Fault> {
        let remedy = "open it in the BSDF viewer of Speos and save it as text of version 8";
        let title = lines.expect("the title")?;
        let version = title.rsplit(['v', 'V']).next().unwrap_or("").trim();
        if version.parse::<f64>().is_ok_and(|v| !(8.0..9.0).contains(&v)) {
            let what = format!("version {version}");
            return Err(Fault::Unsupported { format: NAME, what, remedy });
        }
        match lines.expect("the mode, 0 for text")? {
            "0" => {}
            "1" => {
                let what = "the binary mode".into();
                return Err(Fault::Unsupported { format: NAME, what, remedy });
            }
            other => {
                let other = crate::text::excerpt(other);
                return Err(lines.fault(format!("the mode is not 0 (text) or 1: '{other}'")));
            }
        }
        let comment = lines.next_raw().unwrap_or("").trim();
        let field = lines.expect("the length of the description")?;
        let length: usize = field
            .parse()
            .map_err(|_| lines.fault("the length of the description is not a count"))?;
        let mut notes = Vec::new();
        if !comment.is_empty() && comment != "Comment" {
            notes.push(comment.to_owned());
        }
        let mut seen = 0;
        loop {
            let line = lines.next_raw().ok_or_else(|| lines.fault("the description is missing"))?;
            let is_end = seen + line.chars().count() >= length;
            if length == 0 && !line.trim().is_empty() {
                lines.back();
                break;
            }
            seen += line.chars().count() + 1;
            let all = line.split(write::BETWEEN).map(str::trim);
            notes.extend(all.filter(|part| !part.is_empty()).map(str::to_owned));
            if is_end {
                break;
            }
        }
        Ok(Self { notes })
    }

    /// What the project says of itself.
    fn said(&self) -> super::own::Said {
        super::own::said(self.notes.iter().map(String::as_str))
    }

    /// The rest.
    fn others(&self) -> Vec<String> {
        let of_others = |note: &&String| {
            !super::own::is_own(note)
                && *note != "Measurement description"
                && note.chars().any(char::is_alphanumeric)
        };
        self.notes.iter().filter(of_others).cloned().collect()
    }
}

/// Two flags, reflection and transmission.
fn flags(lines: &mut Lines<'_>) -> Result<[bool; 2], Fault> {
    let line = lines.expect("the flags of reflection and transmission")?;
    match crate::text::fields(line).collect::<Vec<_>>()[..] {
        ["1", "0"] => Ok([true, false]),
        ["0", "1"] => Ok([false, true]),
        ["1", "1"] => Ok([true, true]),
        _ => Err(lines.fault("expected two flags, reflection and transmission, one of them 1")),
    }
}

/// Whether values are proportional to the BSDF (1) or to the intensity (0).
fn values_are_bsdf(lines: &mut Lines<'_>) -> Result<bool, Fault> {
    match lines.expect("the type of the values")? {
        "1" => Ok(true),
        "0" => Ok(false),
        _ => Err(lines.fault("the type of the values is not 1 (BSDF) or 0 (intensity)")),
    }
}
