//! The XML of WINDOW and Radiance around the numbers of Klems matrices and tensor trees.
//!
//! Layout: LBNL schema `BSDF-v1.7.7.xsd`; meaning of the directions: Radiance, `doc/notes/BSDFdirections.txt`, `bsdf_m.c`, `bsdf_t.c`.
//!
//! # Sides
//! WINDOW's Front is the exterior, which is Radiance's back. Here the air is Radiance's front, the side of the surface normal, +z:
//! `Reflection Back` is reflection of light from the air, `Transmission Back` light from the air into the
//! dielectric, `Transmission Front` light from the dielectric into the air, `Reflection Front` reflection inside. Axes x and y are the same on both
//! sides. An incident patch names the direction the light goes to: the source is on the other side in x and y.
//!
//! Values are BSDF, 1/sr, without cosine, whatever `ScatteringDataType` says (reflection blocks are typed BTDF too). Index, wavelength and
//! symmetry have no place in the format: files of this project have them in comments.

use std::fmt::Write as _;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::own;
use crate::error::Fault;
use crate::sampled::{Band, Lobe, SampledBsdf, Side};
use crate::text::excerpt;

pub(super) const NAME: &str = "WINDOW XML";

/// Rings of patches that a basis may have at most.
const MOST_RINGS: usize = 200;
/// Nesting of elements.
const DEEPEST: usize = 64;

/// How the numbers of a block are arranged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Structure {
    /// A line for each outgoing patch, incident patches along it.
    Columns,
    /// A line for each incident patch.
    Rows,
    /// A tensor tree of so many coordinates.
    Tree(usize),
}

/// A ring of patches of equal width in azimuth, the first one about azimuth 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ring {
    /// Polar angles of its edges, radians.
    pub(super) edges: [f64; 2],
    /// Number of patches.
    pub(super) count: usize,
}

/// A basis that a file defines.
#[derive(Clone, Debug, Default)]
pub(super) struct Basis {
    pub(super) name: String,
    pub(super) rings: Vec<Ring>,
}

/// The numbers of a direction.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) side: Side,
    pub(super) lobe: Lobe,
    pub(super) band: Band,
    /// Basis of incident and outgoing patches; that of trees in both.
    pub(super) bases: [String; 2],
    /// The numbers.
    pub(super) data: String,
    /// Line where they begin.
    pub(super) line: usize,
}

/// What a file holds.
#[derive(Clone, Debug)]
pub(super) struct Document {
    pub(super) structure: Structure,
    pub(super) bases: Vec<Basis>,
    pub(super) blocks: Vec<Block>,
    pub(super) notes: Vec<String>,
    pub(super) said: own::Said,
}

impl Document {
    /// The light of a block: a file of this project says its wavelength in a comment.
    pub(super) fn band(&self, block: &Block) -> Band {
        match (&block.band, self.said.wavelength_nm) {
            (Band::Named(name), Some(nm)) if name.eq_ignore_ascii_case("visible") => {
                Band::Wavelength(nm)
            }
            (band, _) => band.clone(),
        }
    }
}

/// A fault of a line.
pub(super) fn fault(line: usize, what: impl Into<String>) -> Fault {
    Fault::Line { format: NAME, line, what: what.into() }
}

/// The text of the first element of a name; for detection.
pub(super) fn peek<'a>(text: &'a str, element: &str) -> Option<&'a str> {
    if !text.contains("WindowElement") {
        return None;
    }
    let mut rest = text;
    loop {
        rest = rest.get(rest.find(element)? + element.len()..)?;
        if let Some(content) = rest.strip_prefix('>') {
            return content.split('<').next().map(str::trim);
        }
    }
}

/// Whether a text is of the format at all.
pub(super) fn is_window(text: &str) -> bool {
    text.contains("WindowElement")
}

/// Parses a file.
pub(super) fn parse(text: &str) -> Result<Document, Fault> {
    let mut reader = Reader::from_str(text);
    reader.config_mut().allow_dangling_amp = true;
    let mut parser = Parser { text, ..Parser::default() };
    loop {
        let at = reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|e| {
            let place = (reader.error_position() as usize).min(text.len());
            fault(line_of(text, place), e.to_string())
        })?;
        match event {
            Event::Start(tag) => {
                let end = reader.buffer_position() as usize;
                parser.start(&tag, end)?;
            }
            Event::Empty(tag) => {
                parser.start(&tag, at)?;
                parser.end(at)?;
            }
            Event::End(_) => parser.end(at)?,
            Event::Text(t) => parser.value.push_str(&t),
            Event::CData(t) => parser.value.push_str(&t),
            Event::GeneralRef(name) => {
                let known = match name.as_ref() {
                    "amp" => '&',
                    "lt" => '<',
                    "gt" => '>',
                    "quot" => '"',
                    "apos" => '\'',
                    _ => name.resolve_char_ref().ok().flatten().unwrap_or('?'),
                };
                parser.value.push(known);
            }
            Event::Comment(comment) => parser.comment(&comment),
            Event::Eof => break,
            Event::Decl(_) | Event::PI(_) | Event::DocType(_) => {}
        }
    }
    if !parser.path.is_empty() {
        let open = parser.path.join("/");
        return Err(fault(line_of(text, text.len()), format!("the file ends within {open}")));
    }
    parser.document()
}

/// Line of a byte, from 1.
fn line_of(text: &str, at: usize) -> usize {
    text.match_indices('\n').take_while(|(place, _)| *place < at).count() + 1
}

#[derive(Default)]
struct Parser<'a> {
    text: &'a str,
    path: Vec<String>,
    value: String,
    /// Byte where the text of the open element begins.
    begun: usize,
    structure: Option<Structure>,
    bases: Vec<Basis>,
    blocks: Vec<Block>,
    notes: Vec<String>,
    own: Vec<String>,
    unit: String,
    wavelength: (String, String),
    open: Open,
    ring: ([Option<f64>; 2], usize),
    layers: usize,
    passed: Vec<String>,
}

/// A block that is being read.
#[derive(Default)]
struct Open {
    direction: String,
    column: String,
    row: String,
    basis: String,
    kind: String,
    data: String,
    line: usize,
}

impl Parser<'_> {
    fn start(&mut self, tag: &BytesStart<'_>, end: usize) -> Result<(), Fault> {
        let name = tag.local_name().as_ref().to_owned();
        if self.path.len() >= DEEPEST {
            return Err(fault(line_of(self.text, end), "elements are nested too deep"));
        }
        let unit = tag.attributes().with_checks(false).flatten().find(|a| {
            let key: &str = a.key.as_ref();
            key.eq_ignore_ascii_case("unit")
        });
        self.unit = unit.map_or_else(String::new, |a| a.value.to_string());
        match name.as_str() {
            "AngleBasis" if self.path.last().is_some_and(|p| p == "DataDefinition") => {
                self.bases.push(Basis::default());
            }
            "AngleBasisBlock" => self.ring = ([None; 2], 0),
            "WavelengthData" => self.wavelength = (String::new(), String::new()),
            "WavelengthDataBlock" => self.open = Open::default(),
            "Layer" => self.layers += 1,
            _ => {}
        }
        self.path.push(name);
        self.value.clear();
        self.begun = end;
        Ok(())
    }

    fn end(&mut self, at: usize) -> Result<(), Fault> {
        let Some(name) = self.path.pop() else { return Ok(()) };
        let value = self.value.trim().to_owned();
        let line = || line_of(self.text, at);
        let parent = self.path.last().map_or("", String::as_str);
        let number = |what: &str| {
            value.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
                fault(line(), format!("{what} is not a number: '{}'", excerpt(&value)))
            })
        };
        match (parent, name.as_str()) {
            ("Material", "Name" | "Manufacturer") if !value.is_empty() => {
                self.notes.push(format!("{name}: {}", excerpt(&value)));
            }
            ("DataDefinition", "IncidentDataStructure") => {
                self.structure = Some(match value.to_ascii_lowercase().as_str() {
                    "columns" => Structure::Columns,
                    "rows" => Structure::Rows,
                    "tensortree3" => Structure::Tree(3),
                    "tensortree4" => Structure::Tree(4),
                    _ => {
                        let what = format!("IncidentDataStructure '{}'", excerpt(&value));
                        let remedy = "give Columns, Rows, TensorTree3 or TensorTree4";
                        return Err(Fault::Unsupported { format: NAME, what, remedy });
                    }
                });
            }
            ("AngleBasis", "AngleBasisName") => {
                if let Some(basis) = self.bases.last_mut() {
                    basis.name.clone_from(&value);
                }
            }
            ("ThetaBounds", "LowerTheta") => self.ring.0[0] = Some(number("LowerTheta")?),
            ("ThetaBounds", "UpperTheta") => self.ring.0[1] = Some(number("UpperTheta")?),
            ("AngleBasisBlock", "nPhis") => {
                let n = value.parse::<usize>().ok().filter(|n| (1..=1000).contains(n));
                let bad = || format!("nPhis is not one from 1 to 1000: '{}'", excerpt(&value));
                self.ring.1 = n.ok_or_else(|| fault(line(), bad()))?;
            }
            ("AngleBasis", "AngleBasisBlock") => {
                let ring = ring(self.ring).map_err(|what| fault(line(), what))?;
                let full = "a basis has too many rings";
                if let Some(basis) = self.bases.last_mut() {
                    if basis.rings.len() >= MOST_RINGS {
                        return Err(fault(line_of(self.text, at), full));
                    }
                    basis.rings.push(ring);
                }
            }
            ("WavelengthData", "Wavelength") => self.wavelength = (self.unit.clone(), value),
            (_, "WavelengthDataDirection") => self.open.direction = value,
            (_, "ColumnAngleBasis") => self.open.column = value,
            (_, "RowAngleBasis") => self.open.row = value,
            ("WavelengthDataBlock", "AngleBasis") => self.open.basis = value,
            (_, "ScatteringDataType") => self.open.kind = value,
            (_, "ScatteringData") => {
                self.open.data = std::mem::take(&mut self.value);
                self.open.line = line_of(self.text, self.begun);
            }
            (_, "WavelengthDataBlock") => self.block(at)?,
            _ => {}
        }
        self.value.clear();
        Ok(())
    }

    /// Takes the block that ends here, unless it holds no BSDF.
    fn block(&mut self, at: usize) -> Result<(), Fault> {
        let open = std::mem::take(&mut self.open);
        if self.layers > 1 {
            self.passed.push("further layers".into());
            return Ok(());
        }
        let direction = open.direction.split_whitespace().collect::<Vec<_>>().join(" ");
        let (side, lobe) = match direction.to_ascii_lowercase().as_str() {
            "transmission back" => (Side::Air, Lobe::Transmission),
            "reflection back" => (Side::Air, Lobe::Reflection),
            "transmission front" => (Side::Dielectric, Lobe::Transmission),
            "reflection front" => (Side::Dielectric, Lobe::Reflection),
            "absorbed front" | "absorbed back" => {
                self.passed.push(direction);
                return Ok(());
            }
            _ => {
                let what = format!("unknown WavelengthDataDirection '{}'", excerpt(&direction));
                return Err(fault(line_of(self.text, at), what));
            }
        };
        let kind = open.kind.to_ascii_uppercase();
        if kind.starts_with("FRACTIONAL") {
            self.passed.push(excerpt(&open.kind));
            return Ok(());
        }
        let band = band(&self.wavelength);
        if let Band::Named(name) = &band {
            let name = name.to_ascii_lowercase();
            if name == "cie-u" || name == "cie-v" {
                self.passed.push("chromaticity".into());
                return Ok(());
            }
        }
        if open.line == 0 {
            let what = format!("no ScatteringData of {direction}");
            return Err(fault(line_of(self.text, at), what));
        }
        let bases = if open.basis.is_empty() {
            [open.column, open.row]
        } else {
            [open.basis.clone(), open.basis]
        };
        let Open { data, line, .. } = open;
        self.blocks.push(Block { side, lobe, band, bases, data, line });
        Ok(())
    }

    fn comment(&mut self, comment: &str) {
        for line in comment.lines() {
            if own::is_own(line) {
                self.own.push(line.to_owned());
            } else if line.chars().any(char::is_alphanumeric) && self.notes.len() < 100 {
                self.notes.push(line.trim().to_owned());
            }
        }
    }

    fn document(mut self) -> Result<Document, Fault> {
        let last = line_of(self.text, self.text.len());
        let structure =
            self.structure.ok_or_else(|| fault(last, "the file has no IncidentDataStructure"))?;
        if self.blocks.is_empty() {
            return Err(fault(last, "the file has no block of a BSDF"));
        }
        self.passed.sort();
        self.passed.dedup();
        self.notes.extend(self.passed.iter().map(|what| format!("left out: {what}")));
        let said = own::said(self.own.iter().map(String::as_str));
        Ok(Document { structure, bases: self.bases, blocks: self.blocks, notes: self.notes, said })
    }
}

fn ring(([lower, upper], count): ([Option<f64>; 2], usize)) -> Result<Ring, String> {
    let (Some(lower), Some(upper)) = (lower, upper) else {
        return Err("a ring without LowerTheta and UpperTheta".into());
    };
    if !(0.0..90.0).contains(&lower) || upper <= lower || upper > 90.0 {
        return Err(format!("a ring from {lower} to {upper} degrees"));
    }
    if count == 0 {
        return Err("a ring without nPhis".into());
    }
    Ok(Ring { edges: [lower.to_radians(), upper.to_radians()], count })
}

fn band((unit, name): &(String, String)) -> Band {
    let unit = unit.to_ascii_lowercase();
    let scale = if unit.starts_with("nano") {
        1.0
    } else if unit.starts_with("micro") {
        1000.0
    } else {
        0.0
    };
    match name.parse::<f64>() {
        Ok(value) if scale > 0.0 && value.is_finite() && value > 0.0 => {
            Band::Wavelength(value * scale)
        }
        _ if name.is_empty() => Band::Unknown,
        _ => Band::Named(excerpt(name)),
    }
}

/// The words of a text that are not blank, comma or semicolon, with their lines; braces are words.
pub(super) fn words(data: &str, line: usize) -> impl Iterator<Item = (&str, usize)> {
    let mut line = line;
    let mut rest = data;
    std::iter::from_fn(move || {
        let is_gap = |c: char| c.is_whitespace() || c == ',' || c == ';';
        let start = rest.find(|c| !is_gap(c))?;
        line += rest.get(..start)?.matches('\n').count();
        rest = rest.get(start..)?;
        let is_brace = |c: char| c == '{' || c == '}';
        let end = if rest.starts_with(is_brace) {
            1
        } else {
            rest.find(|c| is_gap(c) || is_brace(c)).unwrap_or(rest.len())
        };
        let (word, after) = rest.split_at_checked(end)?;
        rest = after;
        Some((word, line))
    })
}

/// A finite value of a block.
pub(super) fn value_of(word: &str, line: usize) -> Result<f64, Fault> {
    let value = word.parse::<f64>().ok().filter(|v| v.is_finite());
    value.ok_or_else(|| fault(line, format!("a value is not a number: '{}'", excerpt(word))))
}

/// Sets values that only noise made negative to 0, as Radiance does with every one; `None` if there are none.
pub(super) fn without_noise(values: &mut [f64], line: usize) -> Result<Option<String>, Fault> {
    let most = values.iter().copied().fold(0.0, f64::max);
    let mut count = 0;
    for v in values.iter_mut().filter(|v| **v < 0.0) {
        if *v < -1e-3 * most {
            return Err(fault(line, format!("a block with a negative BSDF: {v}")));
        }
        *v = 0.0;
        count += 1;
    }
    Ok((count > 0).then(|| format!("{count} small negative values are 0")))
}

/// The name of a block in a file.
fn direction(side: Side, lobe: Lobe) -> &'static str {
    match (side, lobe) {
        (Side::Air, Lobe::Reflection) => "Reflection Back",
        (Side::Air, Lobe::Transmission) => "Transmission Back",
        (Side::Dielectric, Lobe::Reflection) => "Reflection Front",
        (Side::Dielectric, Lobe::Transmission) => "Transmission Front",
    }
}

/// The file of some lobes: `definition` inside `DataDefinition`, `basis` of a block, and the numbers of each lobe.
pub(super) fn text(
    lobes: &[SampledBsdf],
    definition: &str,
    basis: &str,
    data: &[String],
) -> Vec<u8> {
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    for line in lobes.first().map(own::lines).unwrap_or_default() {
        // of several lobes each block says its own
        if lobes.len() > 1 && (line.contains(": side = ") || line.contains(": lobe = ")) {
            continue;
        }
        let _ = writeln!(out, "<!-- {} -->", line.replace("--", "- -"));
    }
    out.push_str(
        "<WindowElement xmlns=\"http://windows.lbl.gov\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
         xsi:schemaLocation=\"http://windows.lbl.gov/BSDF-v1.4.xsd\">\n\
         <WindowElementType>System</WindowElementType>\n<FileType>BSDF</FileType>\n<Optical>\n<Layer>\n\
         \t<Material>\n\t\t<Name>rough surface</Name>\n\t\t<Manufacturer>Asperity</Manufacturer>\n\
         \t\t<DeviceType>Other</DeviceType>\n\t</Material>\n\t<DataDefinition>\n",
    );
    out.push_str(definition);
    out.push_str("\t</DataDefinition>\n");
    for (lobe, data) in lobes.iter().zip(data) {
        let _ = write!(
            out,
            "\t<WavelengthData>\n\t\t<LayerNumber>System</LayerNumber>\n\
             \t\t<Wavelength unit=\"Integral\">Visible</Wavelength>\n\
             \t\t<SourceSpectrum>CIE Illuminant D65 1nm.ssp</SourceSpectrum>\n\
             \t\t<DetectorSpectrum>ASTM E308 1931 Y.dsp</DetectorSpectrum>\n\
             \t\t<WavelengthDataBlock>\n\t\t\t<WavelengthDataDirection>{}</WavelengthDataDirection>\n\
             {basis}\t\t\t<ScatteringDataType>BTDF</ScatteringDataType>\n\t\t\t<ScatteringData>\n{data}\
             \t\t\t</ScatteringData>\n\t\t</WavelengthDataBlock>\n\t</WavelengthData>\n",
            direction(lobe.side, lobe.lobe)
        );
    }
    out.push_str("</Layer>\n</Optical>\n</WindowElement>\n");
    out.into_bytes()
}
