//! Nanosurf `.nid` and `.ezd`: sections of `key=value` lines in text, `#!`, then the channels one after the other.
//!
//! `[DataSet]` lists groups and channels; the section of a channel says its points, its integers and the ranges of its
//! axes. Numbers of a channel go over `Dim2Range` from `Dim2Min` on; the lowest line comes first. Maps are the channels
//! whose values and places are lengths, in the order of the file. Layout after Gwyddion `ezdfile.c` and `SurfaceTopography`
//! `EZD.py`, which say the same.

use std::collections::HashMap;

use super::bytes::{Cursor, bottom_up, pitch, points};
use super::channels::chosen;
use super::text::windows_1252;
use super::unit::LengthUnit;
use super::{MapFault, OpenOptions, RawMap};
use crate::message::excerpt;

const FORMAT: &str = "Nanosurf nid";
const START: &[u8] = b"[DataSet]";
/// What ends the text, at the start of a line.
const DATA: &[u8] = b"\n#!";
/// Texts are tens of kilobytes.
const LONGEST_TEXT: usize = 4 << 20;
/// Files have some sixteen channels.
const MOST_CHANNELS: u32 = 256;

/// Whether the bytes begin like a nid file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(START)
}

/// Reads a channel of heights.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let start = bytes.get(..bytes.len().min(LONGEST_TEXT)).unwrap_or_default();
    let end = start.windows(DATA.len()).position(|w| w == DATA);
    let end = end.ok_or_else(|| damaged("its text has no end, #!".into()))?;
    let text = windows_1252(start.get(..end).unwrap_or_default());
    let sections = sections(&text);
    let all = channels(&sections)?;
    let maps: Vec<&Channel> = all.iter().filter(|c| c.is_map()).collect();
    let names: Vec<String> = maps.iter().map(|c| c.name.clone()).collect();
    if names.is_empty() {
        return Err(unsupported("a file without a channel of heights".into()));
    }
    let number = chosen(FORMAT, &names, options)?;
    let Some(channel) = maps.get(number) else { return Err(damaged("it has no channel".into())) };
    let data = bytes.get(end + DATA.len()..).unwrap_or_default();
    let mut map = channel.map(data)?;
    let head = sections.iter().find_map(|s| s.find("Head type")).filter(|head| !head.is_empty());
    map.instrument = Some(head.map_or("Nanosurf".into(), |h| format!("Nanosurf {}", excerpt(h))));
    map.channels = names;
    Ok(map)
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

fn unsupported(what: String) -> MapFault {
    MapFault::Unsupported { format: FORMAT, what, remedy: "save a height channel as .gwy or SDF" }
}

struct Section<'a> {
    name: &'a str,
    lines: HashMap<&'a str, &'a str>,
}

impl<'a> Section<'a> {
    fn find(&self, key: &str) -> Option<&'a str> {
        self.lines.get(key).map(|value| value.trim())
    }

    fn need(&self, key: &str) -> Result<&'a str, MapFault> {
        let missing = || damaged(format!("[{}] has no {key}", excerpt(self.name)));
        self.find(key).ok_or_else(missing)
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<T, MapFault> {
        let value = self.need(key)?;
        value.parse().map_err(|_| damaged(format!("{key} is `{}`", excerpt(value))))
    }
}

fn sections(text: &str) -> Vec<Section<'_>> {
    let mut sections: Vec<Section> = Vec::new();
    for line in text.lines().map(str::trim) {
        if let Some(name) = line.strip_prefix('[').and_then(|l| l.strip_suffix(']')) {
            sections.push(Section { name, lines: HashMap::new() });
        } else if let (Some((key, value)), Some(section)) =
            (line.split_once('='), sections.last_mut())
        {
            section.lines.entry(key.trim()).or_insert(value);
        }
    }
    sections
}

/// A channel of the file, whatever its values are.
struct Channel {
    name: String,
    /// Where it begins behind the text.
    offset: usize,
    nx: u64,
    ny: u64,
    bits: u32,
    signed: bool,
    big_endian: bool,
    /// Range over x and y, um; `None` if they are no lengths.
    size_um: Option<[f64; 2]>,
    /// Least height and range of heights, um.
    range_um: Option<[f64; 2]>,
}

/// All channels in the order of the file.
fn channels(sections: &[Section]) -> Result<Vec<Channel>, MapFault> {
    let Some(set) = sections.first() else { return Err(damaged("it has no section".into())) };
    let (mut channels, mut offset) = (Vec::new(), 0_usize);
    let groups: u32 = set.number("GroupCount")?;
    for group in 0..groups.min(MOST_CHANNELS) {
        let count: u32 = set.number(&format!("Gr{group}-Count"))?;
        for channel in 0..count.min(MOST_CHANNELS) {
            let Some(name) = set.find(&format!("Gr{group}-Ch{channel}")) else { continue };
            let Some(section) = sections.iter().find(|s| s.name == name) else { continue };
            if channels.len() >= MOST_CHANNELS as usize {
                return Err(damaged(format!("it has more than {MOST_CHANNELS} channels")));
            }
            let channel = Channel::new(section, offset)?;
            offset = offset.saturating_add(channel.length()?);
            channels.push(channel);
        }
    }
    Ok(channels)
}

impl Channel {
    fn new(section: &Section, offset: usize) -> Result<Self, MapFault> {
        if section.need("SaveMode")? != "Binary" {
            return Err(unsupported("a channel in text".into()));
        }
        let bits = section.number("SaveBits")?;
        if ![8, 16, 32].contains(&bits) {
            return Err(unsupported(format!("a channel of {bits} bits")));
        }
        let unit = |axis| section.find(&format!("Dim{axis}Unit")).and_then(LengthUnit::parse);
        let range = |axis: u8, unit: LengthUnit| -> Result<f64, MapFault> {
            Ok(section.number::<f64>(&format!("Dim{axis}Range"))? * unit.um())
        };
        let size_um = match (unit(0), unit(1)) {
            (Some(x), Some(y)) => Some([range(0, x)?, range(1, y)?]),
            _ => None,
        };
        let range_um = match unit(2) {
            Some(z) => Some([section.number::<f64>("Dim2Min")? * z.um(), range(2, z)?]),
            None => None,
        };
        let name = match (section.find("Frame"), section.find("Dim2Name")) {
            (Some(frame), Some(name)) => format!("{frame} ({name})"),
            (frame, name) => frame.or(name).unwrap_or_default().to_owned(),
        };
        Ok(Self {
            name,
            offset,
            nx: section.number("Points")?,
            ny: section.number("Lines")?,
            bits,
            signed: section.need("SaveSign")? == "Signed",
            big_endian: section.need("SaveOrder")? != "Intel",
            size_um,
            range_um,
        })
    }

    fn is_map(&self) -> bool {
        self.size_um.is_some() && self.range_um.is_some()
    }

    /// Bytes of its points.
    fn length(&self) -> Result<usize, MapFault> {
        Ok(points(FORMAT, self.nx, self.ny)? * (self.bits / 8) as usize)
    }

    /// The map of it in the bytes behind the text.
    fn map(&self, data: &[u8]) -> Result<RawMap, MapFault> {
        let (Some(size_um), Some([least_um, range_um])) = (self.size_um, self.range_um) else {
            return Err(unsupported("a channel that is no heights".into()));
        };
        if !(least_um.is_finite() && range_um.is_finite()) {
            return Err(damaged(format!("its heights go over {range_um} um from {least_um} um")));
        }
        let bytes = Cursor::at(FORMAT, data, self.offset)?.bytes(self.length()?)?;
        let full = 2_f64.powi(self.bits as i32);
        let shift = if self.signed { full / 2.0 } else { 0.0 };
        let height = |value: f64| least_um + (value + shift) * (range_um / full);
        let width = (self.bits / 8) as usize;
        let mut heights_um: Vec<f64> =
            bytes.chunks_exact(width).map(|b| height(self.value(b))).collect();
        let (nx, ny) = (self.nx as usize, self.ny as usize);
        bottom_up(&mut heights_um, nx);
        let [dx, dy] = [size_um[0] / self.nx as f64, size_um[1] / self.ny as f64];
        Ok(RawMap {
            dx_um: Some(pitch(FORMAT, "Dim0Range", dx)?),
            dy_um: Some(pitch(FORMAT, "Dim1Range", dy)?),
            ..RawMap::new(FORMAT, (nx, ny), heights_um)
        })
    }

    /// The integer in some bytes.
    fn value(&self, bytes: &[u8]) -> f64 {
        let add = |value: u32, byte: &u8| value << 8 | u32::from(*byte);
        let value = if self.big_endian {
            bytes.iter().fold(0, add)
        } else {
            bytes.iter().rev().fold(0, add)
        };
        match (self.signed, self.bits) {
            (false, _) => f64::from(value),
            (true, 8) => f64::from(value as i8),
            (true, 16) => f64::from(value as i16),
            (true, _) => f64::from(value as i32),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::detect;
    use crate::io::{MapFault, OpenOptions, RawMap};

    fn read(bytes: &[u8], channel: Option<usize>) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions { channel, ..OpenOptions::default() })
    }

    /// A force, then two maps of 2 x 2 points, 1 um wide and 500 nm high: of 16 bits over 65.536 nm, of 8 over 256 um.
    pub(in crate::io) fn sample(change: impl Fn(String) -> String) -> Vec<u8> {
        let channel = |k: u8, unit: &str, bits: u8, sign: &str, order: &str| {
            format!(
                "[DataSet-0:{k}]\r\nPoints=2\r\nLines=2\r\nFrame=Forward\r\nDim0Unit=um\r\nDim0Range=1\r\n\
                 Dim1Unit=nm\r\nDim1Range=500\r\nDim2Name=Z{k}\r\nDim2Unit={unit}\r\nDim2Range={}\r\nDim2Min=-1\r\n\
                 SaveMode=Binary\r\nSaveBits={bits}\r\nSaveSign={sign}\r\nSaveOrder={order}\r\n",
                if bits == 8 { "256" } else { "65.536" }
            )
        };
        let text = format!(
            "[DataSet]\r\nVersion=2\r\nGroupCount=1\r\nGr0-Count=4\r\nGr0-Ch0=DataSet-0:0\r\n\
             Gr0-Ch1=DataSet-0:1\r\nGr0-Ch3=DataSet-0:3\r\n[DataSet-Info]\r\n-- Scan --=---\r\nHead type=Flex\r\n{}{}{}\r\n#!",
            channel(0, "N", 16, "Signed", "Intel"),
            channel(1, "nm", 16, "Signed", "Intel"),
            channel(3, "um", 8, "Unsigned", "Motorola")
        );
        let mut file: Vec<u8> = change(text).into_bytes();
        file.extend([0xff; 8]);
        file.extend([-32768_i16, -32767, 0, 32767].iter().flat_map(|z| z.to_le_bytes()));
        file.extend([0, 1, 2, 255]);
        file
    }

    #[test]
    fn the_maps_are_the_channels_of_lengths() {
        let file = sample(|t| t);
        let map = read(&file, None).unwrap();
        assert!(detect(&file) && (map.nx, map.ny) == (2, 2));
        assert_eq!((map.dx_um, map.dy_um), (Some(0.5), Some(0.25)));
        assert_eq!(map.channels, ["Forward (Z1)", "Forward (Z3)"]);
        assert_eq!(map.instrument.as_deref(), Some("Nanosurf Flex"));
        let close = |map: &RawMap, um: [f64; 4]| {
            map.heights_um.iter().zip(um).all(|(z, um)| (z - um).abs() < 1e-9)
        };
        // -1 nm and a picometre a step, the lower line first in the file
        assert!(close(&map, [31.768e-3, 64.535e-3, -1e-3, -0.999e-3]), "{:?}", map.heights_um);
        let second = read(&file, Some(1)).unwrap();
        assert!(close(&second, [1.0, 254.0, -1.0, 0.0]), "{:?}", second.heights_um);
        assert!(read(&file, Some(2)).unwrap_err().to_string().contains("1 `Forward (Z3)`"));
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = sample(|t| t);
        for end in [0, 9, 60, good.len() - 21, good.len() - 5] {
            assert!(read(&good[..end], Some(1)).is_err(), "{end}");
        }
        for (old, new) in [
            ("#!", "# "),
            ("GroupCount=1", "GroupCount=0"),
            ("GroupCount=1", "GroupCount=many"),
            ("Gr0-Count=4", "Gr0-Count=4294967296"),
            ("Gr0-Count=4\r\n", ""),
            ("Points=2", "Points=0"),
            ("Points=2", "Points=100000"),
            ("Points=2", "Points=18446744073709551615"),
            ("Points=2", "Points=-2"),
            ("Lines=2\r\n", ""),
            ("SaveBits=16", "SaveBits=24"),
            ("SaveMode=Binary", "SaveMode=ASCII"),
            ("Dim0Range=1", "Dim0Range=0"),
            ("Dim1Range=500", "Dim1Range=nan"),
            ("Dim2Range=65.536", "Dim2Range=inf"),
            ("Dim2Min=-1", "Dim2Min=x"),
            ("Dim2Unit=nm", "Dim2Unit=V"),
        ] {
            let change = |text: String| text.replace(old, new).replace("Dim2Unit=um", "Dim2Unit=V");
            assert!(read(&sample(change), None).is_err(), "{old} {new}");
        }
        let many = "Gr0-Ch0=DataSet-0:0\r\n".repeat(3);
        let group = |k| format!("Gr{k}-Count=1\r\nGr{k}-Ch0=DataSet-0:0\r\n");
        let groups: Vec<String> = (0..2000).map(group).collect();
        let groups = groups.concat();
        let change = |text: String| {
            text.replace("GroupCount=1", &format!("GroupCount=4294967295\r\n{groups}{many}"))
        };
        assert!(read(&sample(change), None).is_err());
    }
}
