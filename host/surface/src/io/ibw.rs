//! Igor binary waves of version 5, `.ibw`, as Asylum Research's microscopes write them: layers over x and y.
//!
//! A header of 64 bytes says the sizes of the parts: the wave with its own header of 320 bytes, a formula, a note, units,
//! labels. Numbers are of the machine that wrote them; x runs fastest, the bottom row comes first, layer after layer.
//! Layout: `WaveMetrics`, Igor Technical Note 003 (`IgorBin.h`), as igor2 and Gwyddion `igorfile.c` have it. With a note of
//! Asylum Research the unit of a layer follows from its name, since the header has one for all (`SurfaceTopography`
//! `IBW.py`). A wave need not say units; the user must then.

use super::bytes::{Cursor, bottom_up, pitch, points};
use super::channels::chosen;
use super::options::Stated;
use super::text::field_text;
use super::unit::LengthUnit;
use super::{MapFault, OpenOptions, RawMap, Sources};
use crate::message::excerpt;

const FORMAT: &str = "Igor ibw";
const HEADER: usize = 64;
const WAVE_HEADER: usize = 320;
/// Bytes of a label.
const LABEL: usize = 32;
/// Layers of a wave at most.
const MOST_LAYERS: u32 = 4096;

/// Whether the first number is the version, and the shorts of both headers add up to nothing.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let Some(headers) = bytes.get(..HEADER + WAVE_HEADER) else { return false };
    let little = match headers {
        [5, 0, ..] => true,
        [0, 5, ..] => false,
        _ => return false,
    };
    let short = if little { u16::from_le_bytes } else { u16::from_be_bytes };
    headers.as_chunks().0.iter().fold(0_u16, |sum, pair| sum.wrapping_add(short(*pair))) == 0
}

/// Reads a layer of a wave.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let wave = Wave::read(bytes)?;
    let number = chosen(FORMAT, &wave.names, options)?;
    let stated = Stated { x: wave.units[0], y: wave.units[1], z: wave.height_unit(number)? };
    let [dx, dy] = wave.steps;
    let pitch_x = pitch(FORMAT, "the step along x", dx)?;
    let scales = options.points(FORMAT, stated, pitch_x)?;
    let (nx, ny) = (wave.nx as usize, wave.ny as usize);
    let size = wave.kind.size();
    let length = nx * ny * size;
    let numbers = Cursor::at(FORMAT, wave.data, number * length)?.bytes(length)?;
    let height = |value: f64| if value.is_finite() { value * scales.z.um } else { f64::NAN };
    let mut heights_um: Vec<f64> =
        numbers.chunks_exact(size).map(|b| height(wave.kind.value(b, wave.little))).collect();
    bottom_up(&mut heights_um, nx);
    let dy_um =
        if ny > 1 { Some(pitch(FORMAT, "the step along y", dy * scales.y.um)?) } else { None };
    Ok(RawMap {
        dx_um: Some(pitch(FORMAT, "the step along x", dx * scales.x.um)?),
        dy_um,
        instrument: wave.instrument(),
        sources: Sources { xy: scales.x.source, z: scales.z.source },
        channels: if wave.names.len() > 1 { wave.names } else { Vec::new() },
        ..RawMap::new(FORMAT, (nx, ny), heights_um)
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

fn unsupported(what: String) -> MapFault {
    MapFault::Unsupported { format: FORMAT, what, remedy: "export the height layer as .gwy or SDF" }
}

/// How a number is stored.
#[derive(Clone, Copy)]
struct Kind {
    bits: u8,
    float: bool,
    signed: bool,
}

impl Kind {
    fn of(code: u16) -> Result<Self, MapFault> {
        let signed = code & 0x40 == 0;
        match code & !0x40 {
            2 => Ok(Self { bits: 32, float: true, signed }),
            4 => Ok(Self { bits: 64, float: true, signed }),
            8 => Ok(Self { bits: 8, float: false, signed }),
            0x10 => Ok(Self { bits: 16, float: false, signed }),
            0x20 => Ok(Self { bits: 32, float: false, signed }),
            _ => Err(unsupported(format!("a wave of the type {code:#x}, complex or text,"))),
        }
    }

    fn size(self) -> usize {
        usize::from(self.bits / 8)
    }

    fn value(self, bytes: &[u8], little: bool) -> f64 {
        let add = |value: u64, byte: &u8| value << 8 | u64::from(*byte);
        let word = if little { bytes.iter().rev().fold(0, add) } else { bytes.iter().fold(0, add) };
        match (self.float, self.bits, self.signed) {
            (true, 32, _) => f32::from_bits(word as u32).into(),
            (true, ..) => f64::from_bits(word),
            (false, 8, true) => f64::from(word as i8),
            (false, 16, true) => f64::from(word as i16),
            (false, 32, true) => f64::from(word as i32),
            _ => word as f64,
        }
    }
}

/// The parts of a wave.
struct Wave<'a> {
    little: bool,
    kind: Kind,
    nx: u32,
    ny: u32,
    /// Distances of points, in the file's units.
    steps: [f64; 2],
    /// Units of x and y.
    units: [Option<LengthUnit>; 2],
    /// Unit of the values, as the header has it for all layers.
    value_unit: String,
    /// Names of the layers.
    names: Vec<String>,
    /// Whether the names are labels of the file.
    labelled: bool,
    note: String,
    data: &'a [u8],
}

impl<'a> Wave<'a> {
    fn read(bytes: &'a [u8]) -> Result<Self, MapFault> {
        let little = match bytes {
            [5, 0, ..] => true,
            [0, 5, ..] => false,
            [2, 0, ..] | [0, 2, ..] => return Err(unsupported("version 2".into())),
            _ => return Err(damaged("its first number is not the version 5".into())),
        };
        let mut header = Numbers { cursor: Cursor::new(FORMAT, bytes), little };
        header.cursor.skip(4)?; // version, checksum
        let mut size = || header.size();
        let (wave, formula, note, unit) = (size()?, size()?, size()?, size()?);
        let dim_units = [size()?, size()?, size()?, size()?];
        let labels = [size()?, size()?, size()?, size()?];
        let mut parts = Cursor::at(FORMAT, bytes, HEADER)?;
        let wave = parts.bytes(wave)?;
        parts.skip(formula)?;
        let note = field_text(parts.bytes(note)?);
        let extended = field_text(parts.bytes(unit)?);
        let mut wave_header = Numbers { cursor: Cursor::at(FORMAT, wave, 16)?, little };
        let kind = Kind::of(wave_header.short()?)?;
        wave_header.cursor.skip(68 - 18)?;
        let mut count = || wave_header.size();
        let (nx, ny, layers, blocks) = (count()?, count()?, count()?, count()?);
        if blocks > 1 {
            return Err(unsupported("a wave of four dimensions".into()));
        }
        let steps = [wave_header.double()?, wave_header.double()?];
        wave_header.cursor.skip(148 - 100)?;
        let mut short_unit = || wave_header.cursor.bytes(4).map(field_text);
        let value_unit = Some(short_unit()?).filter(|_| extended.is_empty()).unwrap_or(extended);
        let short_units = [short_unit()?, short_unit()?];
        let mut units = [None; 2];
        for (k, size) in dim_units.into_iter().enumerate() {
            let extended = field_text(parts.bytes(size)?);
            if let (Some(unit), Some(short)) = (units.get_mut(k), short_units.get(k)) {
                *unit = length(if extended.is_empty() { short } else { &extended }, "x and y")?;
            }
        }
        let mut names = Vec::new();
        for (k, size) in labels.into_iter().enumerate() {
            let text = parts.bytes(size)?;
            if k == 2 {
                // the first is the name of the dimension
                names = text.chunks(LABEL).skip(1).map(field_text).collect();
            }
        }
        let number = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let (nx, ny, layers) = (number(nx), number(ny).max(1), number(layers).max(1));
        points(FORMAT, nx.into(), ny.into())?;
        if layers > MOST_LAYERS {
            return Err(damaged(format!("it has {layers} layers")));
        }
        let labelled = !names.is_empty();
        names.resize(layers as usize, String::new());
        let data = wave.get(WAVE_HEADER..).unwrap_or_default();
        Ok(Self { little, kind, nx, ny, steps, units, value_unit, names, labelled, note, data })
    }

    /// The unit of a layer: of its name where the microscope wrote a note, else that of the header.
    fn height_unit(&self, number: usize) -> Result<Option<LengthUnit>, MapFault> {
        let name = self.names.get(number).map_or("", String::as_str);
        if self.note.is_empty() || !self.labelled {
            return length(&self.value_unit, "the values");
        }
        let base = name.split("Mod").next().unwrap_or_default();
        let base = base.strip_suffix("Retrace").or(base.strip_suffix("Trace")).unwrap_or(base);
        if let Some(unit) = self.note_value(&format!("{base}Unit")) {
            return length(unit, "the values");
        }
        let base = base.strip_prefix("DAC").or(base.strip_prefix("Nap")).unwrap_or(base);
        let heights = ["Height", "ZSensor", "Deflection", "Amplitude"];
        if heights.iter().any(|start| base.starts_with(start)) {
            return Ok(Some(LengthUnit::Metre));
        }
        Err(unsupported(format!("layer {number}, `{}`, as heights", excerpt(name))))
    }

    fn note_value(&self, key: &str) -> Option<&str> {
        let mut pairs = self.note.split(['\r', '\n']).filter_map(|line| line.split_once(':'));
        pairs.find(|(k, _)| k.trim() == key).map(|(_, value)| value.trim())
    }

    fn instrument(&self) -> Option<String> {
        self.note_value("MicroscopeModel").filter(|m| !m.is_empty()).map(excerpt)
    }
}

/// A unit of length; `None` where the file says none.
fn length(text: &str, of: &str) -> Result<Option<LengthUnit>, MapFault> {
    if text.is_empty() {
        return Ok(None);
    }
    match LengthUnit::parse(text) {
        Some(unit) => Ok(Some(unit)),
        None => Err(unsupported(format!("the unit `{}` of {of}", excerpt(text)))),
    }
}

/// Reads numbers in the order of bytes of the machine that wrote them.
struct Numbers<'a> {
    cursor: Cursor<'a>,
    little: bool,
}

impl Numbers<'_> {
    fn short(&mut self) -> Result<u16, MapFault> {
        if self.little { self.cursor.u16() } else { self.cursor.be_u16() }
    }

    /// A count, which cannot be negative.
    fn size(&mut self) -> Result<usize, MapFault> {
        let value = if self.little { self.cursor.i32()? } else { self.cursor.be_i32()? };
        usize::try_from(value).map_err(|_| damaged(format!("it says a size of {value}")))
    }

    fn double(&mut self) -> Result<f64, MapFault> {
        let kind = Kind { bits: 64, float: true, signed: true };
        Ok(kind.value(self.cursor.bytes(8)?, self.little))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::detect;
    use crate::io::{MapFault, OpenOptions, RawMap};

    fn read(bytes: &[u8], channel: Option<usize>) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions { channel, ..OpenOptions::default() })
    }

    /// What a file is made of.
    pub(in crate::io) struct Parts {
        pub(in crate::io) little: bool,
        pub(in crate::io) units: [&'static str; 2],
        pub(in crate::io) kind: u16,
        pub(in crate::io) shape: [u32; 4],
        pub(in crate::io) labels: &'static str,
        pub(in crate::io) note: &'static str,
    }

    impl Parts {
        pub(in crate::io) fn new() -> Self {
            let shape = [2, 2, 2, 0];
            Self { little: true, units: ["nm", "um"], kind: 2, shape, labels: "", note: "" }
        }

        /// Layers that count on, points 0.5 and 0.25 units apart.
        pub(in crate::io) fn file(&self) -> Vec<u8> {
            let order = |mut b: Vec<u8>| {
                if !self.little {
                    b.reverse();
                }
                b
            };
            let long = |n: u32| order(n.to_le_bytes().to_vec());
            let text = |s: &str, size: usize| {
                let mut bytes = s.as_bytes().to_vec();
                bytes.resize(size, 0);
                bytes
            };
            let labels: Vec<u8> = self.labels.split('|').flat_map(|l| text(l, 32)).collect();
            let labels = if self.labels.is_empty() { Vec::new() } else { labels };
            let count: u32 = self.shape.iter().map(|n| (*n).clamp(1, 9)).product();
            let data: Vec<u8> = (0..count)
                .flat_map(|k| match self.kind & !0x40 {
                    2 => order((k as f32).to_le_bytes().to_vec()),
                    4 => order(f64::from(k).to_le_bytes().to_vec()),
                    8 => vec![k as u8],
                    0x10 => order((k as u16).to_le_bytes().to_vec()),
                    _ => long(k),
                })
                .collect();
            let mut file = order(vec![5, 0]);
            file.extend([0, 0]);
            file.extend(long(320 + data.len() as u32));
            file.extend(long(0));
            file.extend(long(self.note.len() as u32));
            file.extend([0; 5 * 4 + 2 * 4]);
            file.extend(long(labels.len() as u32));
            file.resize(64 + 16, 0);
            file.extend(order(self.kind.to_le_bytes().to_vec()));
            file.resize(64 + 68, 0);
            file.extend(self.shape.iter().flat_map(|n| long(*n)));
            for step in [0.5_f64, 0.25, 1.0, 1.0] {
                file.extend(order(step.to_le_bytes().to_vec()));
            }
            file.resize(64 + 148, 0);
            let [z, xy] = self.units;
            for unit in [z, xy, xy] {
                file.extend(text(unit, 4));
            }
            file.resize(64 + 320, 0);
            let short = if self.little { u16::from_le_bytes } else { u16::from_be_bytes };
            let pairs = file.as_chunks::<2>().0.iter();
            let sum = pairs.fold(0_u16, |sum, pair| sum.wrapping_sub(short(*pair)));
            let sum = order(sum.to_le_bytes().to_vec());
            file[2..4].copy_from_slice(&sum);
            [file, data, self.note.as_bytes().to_vec(), labels].concat()
        }
    }

    #[test]
    fn layers_are_read_whatever_machine_wrote_them() {
        for (little, kind) in
            [(true, 2), (false, 2), (true, 4), (false, 4), (true, 8), (true, 0x50), (false, 0x60)]
        {
            let file = Parts { little, kind, labels: "dim|Height|Other", ..Parts::new() }.file();
            assert!(detect(&file));
            let map = read(&file, None).unwrap();
            assert_eq!((map.nx, map.ny, map.dx_um, map.dy_um), (2, 2, Some(0.5), Some(0.25)));
            assert_eq!(map.channels, ["Height", "Other"]);
            assert_eq!(map.heights_um, [2e-3, 3e-3, 0.0, 1e-3]);
            assert_eq!(read(&file, Some(1)).unwrap().heights_um, [6e-3, 7e-3, 4e-3, 5e-3]);
        }
    }

    #[test]
    fn units_are_asked_for_and_never_guessed() {
        let file = Parts { units: ["", ""], ..Parts::new() }.file();
        let fault = read(&file, None).unwrap_err().to_string();
        assert!(fault.contains("--xy-unit and --z-unit"), "{fault}");
        let unit = |name: &str| name.parse().ok();
        let options =
            OpenOptions { xy_unit: unit("mm"), z_unit: unit("nm"), ..OpenOptions::default() };
        let map = super::read(&file, &options).unwrap();
        assert_eq!((map.dx_um, map.heights_um[1]), (Some(500.0), 3e-3));
        let wrong = Parts { units: ["V", "um"], ..Parts::new() }.file();
        assert!(read(&wrong, None).unwrap_err().to_string().contains("unit `V`"));
    }

    #[test]
    fn a_note_makes_the_unit_follow_from_the_name() {
        let labels = "d|HeightTrace|PhaseRetrace";
        let note = "MicroscopeModel: Cypher\rA: 1";
        let parts = Parts { units: ["m", "um"], labels, note, ..Parts::new() };
        let map = read(&parts.file(), None).unwrap();
        assert_eq!((map.heights_um[3], map.instrument.as_deref()), (1e6, Some("Cypher")));
        let fault = read(&parts.file(), Some(1)).unwrap_err().to_string();
        assert!(fault.contains("`PhaseRetrace`, as heights"), "{fault}");
        let said = Parts { note: "HeightUnit: nm", ..parts };
        assert_eq!(read(&said.file(), None).unwrap().heights_um[3..], [1e-3]);
    }

    #[test]
    fn malformed_files_are_refused() {
        let parts = || Parts { labels: "d|a|b", note: "A: 1", ..Parts::new() };
        let good = Parts { note: "", ..parts() }.file();
        for end in [0, 1, 40, 64, 200, 384, good.len() - 1] {
            assert!(read(&good[..end], None).is_err(), "{end}");
        }
        for shape in
            [[0, 2, 2, 0], [2, 2, 2, 2], [70000, 70000, 1, 0], [9000, 9000, 1, 0], [2, 2, 9999, 0]]
        {
            assert!(read(&Parts { shape, note: "", ..parts() }.file(), None).is_err(), "{shape:?}");
        }
        for kind in [0, 1, 3, 0x200] {
            assert!(read(&Parts { kind, ..parts() }.file(), None).is_err(), "{kind}");
        }
        let with = |at: usize, bytes: &[u8]| {
            let mut file = good.clone();
            file[at..at + bytes.len()].copy_from_slice(bytes);
            read(&file, None).is_err()
        };
        assert!(
            with(0, &[2]) && with(0, &[7]) && with(4, &[255; 4]) && with(12, &[255, 255, 255, 127])
        );
        assert!(with(148, &(-1_f64).to_le_bytes()) && with(156, &f64::NAN.to_le_bytes()));
        assert!(with(44, &[0, 0, 0, 127]) && with(4, &[100, 0]));
    }
}
