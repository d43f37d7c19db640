//! The lists before the values, and the blocks of values.

use std::fmt::Write as _;

use super::tokens::Tokens;
use crate::error::Fault;
use crate::formats::lattice::Lattice;
use crate::sampled::{Lobe, SampledBsdf};
use crate::text::{degrees, excerpt};

/// What is equal about the plane of incidence or the ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Symmetric {
    /// Nothing.
    #[default]
    No,
    /// Left and right of the plane of incidence: azimuths from 0 to 180.
    Plane,
    /// All azimuths about the ray.
    Axis,
}

/// Channels of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    Grey,
    Rgb,
    Spectral(usize),
}

/// All before the values; angles in radians.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) symmetric: Symmetric,
    pub(super) content: Content,
    pub(super) is_intensity: bool,
    pub(super) is_relative: bool,
    pub(super) psi: Vec<f64>,
    pub(super) sigma: Vec<f64>,
    /// Polar angles of the direct rays.
    pub(super) rays: Option<Vec<f64>>,
    pub(super) phi: Vec<f64>,
    pub(super) theta: Vec<f64>,
}

/// A block of values.
#[derive(Debug)]
pub(super) struct Channel {
    pub(super) wavelength_nm: Option<f64>,
    /// One per incidence.
    pub(super) kbdf: Option<Vec<f64>>,
    pub(super) values: Vec<f64>,
}

impl Header {
    /// Whether it is of the coherent part, which has no directions.
    pub(super) fn is_coherent(&self) -> bool {
        self.theta.is_empty()
    }

    /// Directions of an incidence.
    pub(super) fn directions(&self) -> usize {
        if self.is_coherent() { 1 } else { self.theta.len() * self.phi.len() }
    }
}

const CHANNELS: [&str; 7] = ["bw", "wl", "red", "gre", "green", "blu", "blue"];

/// Reads up to the first block of values.
pub(super) fn read(tokens: &mut Tokens<'_>) -> Result<Header, Fault> {
    let mut symmetric = None;
    let (mut content, mut is_intensity, mut is_relative) = (None, false, false);
    let (mut psi, mut sigma, mut rays) = (Vec::new(), Vec::new(), None);
    let (mut phi, mut theta) = (Vec::new(), Vec::new());
    loop {
        let is_data = |word: &str| CHANNELS.iter().any(|c| word.eq_ignore_ascii_case(c));
        if tokens.peek().is_some_and(is_data) {
            break;
        }
        match tokens.word("a block of values")?.as_str() {
            "source" => drop(tokens.word("the kind of source")?),
            "typesym" => symmetric = Some(symmetry(tokens)?),
            "typecolormodel" => content = Some(colours(tokens)?),
            "typedata" => (is_intensity, is_relative) = data_type(tokens)?,
            "psi" => psi = list(tokens, "psi", 360.0)?,
            "sigma" => sigma = list(tokens, "sigma", 90.0)?,
            "sigmat" => rays = Some(direct(tokens, sigma.len())?),
            "phi" => phi = list(tokens, "phi", 360.0)?,
            "theta" => theta = list(tokens, "theta", 180.0)?,
            other => return Err(tokens.fault(format!("unknown keyword '{}'", excerpt(other)))),
        }
    }
    let content = content.ok_or_else(|| tokens.fault("no TypeColorModel before the values"))?;
    if sigma.is_empty() {
        return Err(tokens.fault("no sigma before the values"));
    }
    if phi.is_empty() != theta.is_empty() {
        let missing = if phi.is_empty() { "phi" } else { "theta" };
        return Err(tokens.fault(format!("no {missing} before the values")));
    }
    if psi.is_empty() {
        psi.push(0.0);
    }
    let symmetric = match symmetric {
        Some(Symmetric::Axis) if phi.len() > 1 => {
            return Err(tokens.fault("AxiSymmetrical with more than one phi"));
        }
        Some(Symmetric::Plane) if phi.last().is_some_and(|a| *a > std::f64::consts::PI + 1e-6) => {
            return Err(tokens.fault("PlaneSymmetrical with phi beyond 180"));
        }
        other => other.unwrap_or_default(),
    };
    Ok(Header { symmetric, content, is_intensity, is_relative, psi, sigma, rays, phi, theta })
}

fn symmetry(tokens: &mut Tokens<'_>) -> Result<Symmetric, Fault> {
    match tokens.word("the kind of symmetry")?.as_str() {
        "axisymmetrical" => Ok(Symmetric::Axis),
        "planesymmetrical" => Ok(Symmetric::Plane),
        "asymmetrical" => {
            if tokens.peek().is_some_and(|word| word.eq_ignore_ascii_case("4d")) {
                tokens.next();
            }
            Ok(Symmetric::No)
        }
        "dirsymmetrical" => Err(Fault::Unsupported {
            format: tokens.format,
            what: "TypeSym DirSymmetrical".into(),
            remedy: "export the file as ASymmetrical",
        }),
        other => Err(tokens.fault(format!("unknown TypeSym '{}'", excerpt(other)))),
    }
}

fn colours(tokens: &mut Tokens<'_>) -> Result<Content, Fault> {
    match tokens.word("the colour model")?.as_str() {
        "bw" => Ok(Content::Grey),
        "rgb" => Ok(Content::Rgb),
        "spectral" => Ok(Content::Spectral(tokens.count("wavelengths")?)),
        other => Err(tokens.fault(format!("unknown TypeColorModel '{}'", excerpt(other)))),
    }
}

fn data_type(tokens: &mut Tokens<'_>) -> Result<(bool, bool), Fault> {
    let is_intensity = match tokens.word("the quantity of the values")?.as_str() {
        "luminance" => false,
        "intensity" => true,
        other => return Err(tokens.fault(format!("unknown TypeData '{}'", excerpt(other)))),
    };
    match tokens.word("Absolute or Relative")?.as_str() {
        "absolute" => Ok((is_intensity, false)),
        "relative" => Ok((is_intensity, true)),
        other => {
            Err(tokens.fault(format!("TypeData is not Absolute or Relative: '{}'", excerpt(other))))
        }
    }
}

/// A counted list of ascending angles.
fn list(tokens: &mut Tokens<'_>, what: &str, most: f64) -> Result<Vec<f64>, Fault> {
    let n = tokens.count(what)?;
    let angles = tokens.exactly(n, what, f64::NEG_INFINITY)?;
    if let Some([a, b]) = angles.array_windows().find(|[a, b]| b <= a) {
        return Err(tokens.fault(format!("{what} do not ascend: {b} after {a}")));
    }
    if let Some(a) = angles.iter().find(|a| !(0.0..=most).contains(*a)) {
        return Err(tokens.fault(format!("{what} is outside 0 to {most}: {a}")));
    }
    Ok(angles.into_iter().map(f64::to_radians).collect())
}

/// `sigmat`: as many as `sigma`, without a count; a writer that puts one is understood.
fn direct(tokens: &mut Tokens<'_>, n: usize) -> Result<Vec<f64>, Fault> {
    let mut angles = tokens.numbers();
    let counted = angles.first().is_some_and(|first| first.to_bits() == (n as f64).to_bits());
    if counted && angles.len() == n + 1 {
        angles.remove(0);
    }
    if angles.len() != n {
        let is = angles.len();
        return Err(tokens.fault(format!("{is} angles of sigmat where sigma has {n}")));
    }
    if let Some(a) = angles.iter().find(|a| !(0.0..=90.0).contains(*a)) {
        return Err(tokens.fault(format!("sigmat is outside 0 to 90: {a}")));
    }
    Ok(angles.into_iter().map(f64::to_radians).collect())
}

/// The next block of values; `None` at the end.
pub(super) fn channel(tokens: &mut Tokens<'_>, header: &Header) -> Result<Option<Channel>, Fault> {
    let Some(title) = tokens.next() else { return Ok(None) };
    let title = title.to_ascii_lowercase();
    if !CHANNELS.contains(&title.as_str()) {
        return Err(
            tokens.fault(format!("expected a block of values, found '{}'", excerpt(&title)))
        );
    }
    let is_nm = title == "wl";
    if is_nm != matches!(header.content, Content::Spectral(_)) {
        return Err(
            tokens.fault(format!("a block '{title}' that TypeColorModel does not announce"))
        );
    }
    let wavelength_nm = if is_nm { Some(tokens.number("a wavelength")?) } else { None };
    if wavelength_nm.is_some_and(|nm| nm <= 0.0) {
        return Err(tokens.fault("a wavelength that is not positive"));
    }
    let incidences = header.psi.len() * header.sigma.len();
    let mut kbdf = None;
    let mut word = tokens.word("kbdf or def")?;
    if word == "kbdf" {
        kbdf = Some(tokens.exactly(incidences, "kbdf", 0.0)?);
        word = tokens.word("def")?;
    }
    if word != "def" {
        return Err(tokens.fault(format!("expected def, found '{}'", excerpt(&word))));
    }
    let n = incidences.checked_mul(header.directions());
    let n = n.ok_or_else(|| tokens.fault("lists whose product is too large"))?;
    let values = tokens.exactly(n, "values", 0.0)?;
    match tokens.peek() {
        Some(word) if word.eq_ignore_ascii_case("enddef") => drop(tokens.next()),
        Some(word) if word.parse::<f64>().is_ok() => {
            return Err(tokens.fault("more values than the lists announce"));
        }
        _ => {}
    }
    Ok(Some(Channel { wavelength_nm, kbdf, values }))
}

/// Writes all before the values.
pub(super) fn write(out: &mut String, lobe: &SampledBsdf, lattice: &Lattice<'_>, all_nm: bool) {
    let rotates = lattice.phis.len() > 1;
    let symmetric = match (rotates, lattice.grid.mirrored) {
        (false, true) => "PlaneSymmetrical",
        (false, false) => "ASymmetrical",
        (true, _) => "ASymmetrical 4D",
    };
    let content = match lobe.bands.len() {
        1 => "BW".into(),
        n if all_nm => format!("spectral {n}"),
        _ => "RGB".to_owned(),
    };
    let _ = write!(
        out,
        "Source Measured\nTypeSym {symmetric}\nTypeColorModel {content}\nTypeData Luminance Absolute\n"
    );
    if rotates {
        write_list(out, "psi", true, &lattice.phis);
    }
    write_list(out, "sigma", true, &lattice.thetas);
    if lobe.lobe == Lobe::Transmission {
        write_list(out, "sigmat", false, &lattice.rays);
    }
    write_list(out, "phi", true, &lattice.azimuths());
    write_list(out, "theta", true, &lattice.grid.radii);
}

/// A list with its name and its count.
fn write_list(out: &mut String, name: &str, count: bool, angles: &[f64]) {
    let list: Vec<_> = angles.iter().map(|a| degrees(*a)).collect();
    let count = if count { format!(" {}", angles.len()) } else { String::new() };
    let _ = writeln!(out, "{name}{count}\n {}", list.join(" "));
}
