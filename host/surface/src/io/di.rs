//! Nanoscope atomic force microscopes of Digital Instruments, Veeco and Bruker, version 4.3 on.
//!
//! A text header `\*File list`, or `\*EC File list`, of sections `\*Name` with `\key: value` lines; each `image list`
//! section is a channel of signed integers, line by line, the bottom line first. Its scale,
//! `\@2:Z scale: V [Sens. S] (a V/LSB) b V`, says that the full range of the integer is `b`, to be
//! multiplied by `\@Sens. S: V c nm/V`. The maps are the channels that give lengths so.

use super::bytes::{Cursor, pitch, points};
use super::channels::chosen;
use super::text::windows_1252;
use super::{MapFault, OpenOptions, RawMap};

const FORMAT: &str = "Nanoscope";
/// How files begin; the second is of a microscope in an electrochemical cell.
const STARTS: [&str; 2] = [r"\*File list", r"\*EC File list"];
const END: &str = r"\*File list end";
/// Headers are tens of kilobytes.
const LONGEST_HEADER: usize = 1 << 20;
/// Files have some ten sections; every image is sought in all of them.
const MOST_SECTIONS: usize = 256;
/// From this version on a point takes 4 bytes, whatever `Bytes/pixel` says.
const WIDE_SINCE: u32 = 0x0920_0000;

/// Whether the bytes begin like a Nanoscope file.
pub(super) fn detect(bytes: &[u8]) -> bool {
    let begins =
        |s: &str| bytes.get(..s.len()).is_some_and(|b| b.eq_ignore_ascii_case(s.as_bytes()));
    STARTS.into_iter().any(begins)
}

/// Reads the height channel of a Nanoscope file.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    if !detect(bytes) {
        return Err(damaged(format!("the first bytes are not {}", STARTS[0])));
    }
    let header = windows_1252(bytes.get(..bytes.len().min(LONGEST_HEADER)).unwrap_or_default());
    let sections = sections(&header)?;
    let channels = sections.iter().filter(|s| s.name.ends_with("image list"));
    let mut maps = Vec::new();
    for channel in channels.clone() {
        match full_range_um(channel, &sections) {
            Ok(Some(full_range_um)) => maps.push((channel, full_range_um)),
            // what is wrong with another channel does not matter once there are heights
            Err(fault) if maps.is_empty() => return Err(fault),
            Ok(None) | Err(_) => {}
        }
    }
    let names: Vec<String> = maps.iter().map(|(channel, _)| channel.title()).collect();
    let asked = if maps.is_empty() { 0 } else { chosen(FORMAT, &names, options)? };
    if let Some((channel, full_range_um)) = maps.get(asked) {
        let channels = if names.len() > 1 { names } else { Vec::new() };
        return Ok(RawMap { channels, ..map(bytes, channel, *full_range_um, &sections)? });
    }
    if channels.count() == 0 {
        return Err(damaged("the header lists no image".to_owned()));
    }
    Err(MapFault::Unsupported {
        format: FORMAT,
        what: "a file without a channel of heights in a unit of length".to_owned(),
        remedy: "export the height channel from the instrument's software",
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

struct Section<'a> {
    name: String,
    fields: Vec<(&'a str, &'a str)>,
}

impl<'a> Section<'a> {
    fn find(&self, wanted: &str) -> Option<&'a str> {
        let same = |(key, _): &&(&str, &str)| key.eq_ignore_ascii_case(wanted);
        self.fields.iter().find(same).map(|(_, value)| *value)
    }

    /// The name of the image, the last words of `@2:Image Data: S [Height] "Height Sensor"`.
    fn title(&self) -> String {
        let data = self.fields.iter().find(|(key, _)| key.ends_with(":Image Data"));
        let name = data.and_then(|(_, value)| value.split('"').nth(1));
        let direction = self.find("Line Direction").unwrap_or_default();
        format!("{} {direction}", name.unwrap_or_default()).trim().to_owned()
    }

    fn number<T: std::str::FromStr>(&self, key: &str) -> Result<T, MapFault> {
        let value = self.find(key).ok_or_else(|| damaged(format!("the line {key} is missing")))?;
        value.parse().map_err(|_| damaged(format!("the line {key} holds {value:?}")))
    }
}

/// The sections of the header, up to its end mark.
fn sections(header: &str) -> Result<Vec<Section<'_>>, MapFault> {
    let mut sections: Vec<Section> = Vec::new();
    for line in header.lines() {
        if line.trim_end().eq_ignore_ascii_case(END) {
            return Ok(sections);
        }
        if sections.len() > MOST_SECTIONS {
            return Err(damaged(format!("the header has more than {MOST_SECTIONS} sections")));
        }
        if let Some(name) = line.strip_prefix(r"\*") {
            sections.push(Section { name: name.trim().to_ascii_lowercase(), fields: Vec::new() });
        } else if let (Some(line), Some(section)) = (line.strip_prefix('\\'), sections.last_mut()) {
            let (key, value) = line.split_once(": ").unwrap_or((line, ""));
            section.fields.push((key.trim_end_matches(':'), value.trim()));
        }
    }
    Err(damaged(format!("the header has no end, {END}")))
}

/// What the full range of a channel's integers is in um; `None` if it is not a length.
fn full_range_um(channel: &Section, all: &[Section]) -> Result<Option<f64>, MapFault> {
    // the channel's number stands before the name: `@2:Z scale`
    let is_scale = |key: &str| {
        let key = key.trim_start_matches('@').trim_start_matches(|c: char| c.is_ascii_digit());
        key.trim_start_matches(':').eq_ignore_ascii_case("Z scale")
    };
    let Some((_, scale)) = channel.fields.iter().find(|(key, _)| is_scale(key)) else {
        return Ok(None);
    };
    let sensitivity = scale.split_once('[').and_then(|(_, t)| t.split_once(']')).map(|(s, _)| s);
    let (range, unit) = number_and_unit(scale)
        .ok_or_else(|| damaged(format!("the line Z scale holds {scale:?}")))?;
    let Some((range_unit, range_base)) = si(unit) else { return Ok(None) };
    let um = match sensitivity {
        None if range_base == "m" => range * range_unit * 1e6,
        None => return Ok(None),
        Some(name) => {
            let key = format!("@{name}");
            let Some(value) = all.iter().find_map(|s| s.find(&key)) else {
                return Ok(None);
            };
            let (factor, unit) = number_and_unit(value)
                .ok_or_else(|| damaged(format!("the line {key} holds {value:?}")))?;
            let Some((length, per)) = unit.split_once('/') else { return Ok(None) };
            match (si(length), si(per)) {
                (Some((length, "m")), Some((per, base))) if base == range_base => {
                    range * range_unit * factor * length / per * 1e6
                }
                _ => return Ok(None),
            }
        }
    };
    if um.is_finite() && um.abs() > 0.0 {
        return Ok(Some(um));
    }
    Err(damaged(format!("the scale of the heights is {um} um")))
}

/// The number and the unit at the end of a value like `V [...] (...) 24.5 V`.
fn number_and_unit(value: &str) -> Option<(f64, &str)> {
    let end = value.rsplit([')', ']']).next()?.trim().trim_start_matches("V ").trim();
    let (number, unit) = end.split_once(' ')?;
    Some((number.parse().ok()?, unit.trim()))
}

/// A unit of length or tension in m or V, and which it is.
fn si(unit: &str) -> Option<(f64, &'static str)> {
    if matches!(unit, "Å" | "A") {
        return Some((1e-10, "m"));
    }
    let (prefix, base) = match unit.strip_suffix('m') {
        Some(prefix) => (prefix, "m"),
        None => (unit.strip_suffix('V')?, "V"),
    };
    let factor = match prefix {
        "" => 1.0,
        "k" => 1e3,
        "m" => 1e-3,
        "u" | "~" | "µ" | "μ" => 1e-6,
        "n" => 1e-9,
        "p" => 1e-12,
        _ => return None,
    };
    Some((factor, base))
}

fn map(
    bytes: &[u8],
    channel: &Section,
    full_range_um: f64,
    all: &[Section],
) -> Result<RawMap, MapFault> {
    let (nx, ny) = (channel.number("Samps/line")?, channel.number("Number of lines")?);
    let count = points(FORMAT, nx, ny)?;
    let (nx, ny) = (nx as usize, ny as usize);
    let version = all.iter().find_map(|s| s.find("Version")).unwrap_or_default();
    let version = u32::from_str_radix(version.trim_start_matches("0x"), 16).unwrap_or(0);
    let length: usize = channel.number("Data length")?;
    let size = match channel.number("Bytes/pixel")? {
        2 | 4 if version >= WIDE_SINCE && length / 4 >= count => 4,
        size @ (2 | 4) => size,
        size => {
            return Err(MapFault::Unsupported {
                format: FORMAT,
                what: format!("a height of {size} bytes"),
                remedy: "export the height channel as text",
            });
        }
    };
    let mut cursor = Cursor::new(FORMAT, bytes);
    cursor.skip(channel.number("Data offset")?)?;
    let mut cursor = Cursor::new(FORMAT, cursor.bytes(count * size)?);
    let unit_um = full_range_um / if size == 2 { 65536.0 } else { 65536.0 * 65536.0 };
    let mut heights_um = vec![f64::NAN; count];
    for line in heights_um.chunks_exact_mut(nx).rev() {
        for height in line {
            let value = if size == 2 { f64::from(cursor.i16()?) } else { f64::from(cursor.i32()?) };
            *height = value * unit_um;
        }
    }
    let (dx_um, dy_um) = pixel_um(channel, nx, ny)?;
    let equipment = |key| all.iter().find_map(|s| s.find(key)).filter(|name| !name.is_empty());
    let equipment = equipment("Microscope").or_else(|| equipment("Description"));
    let instrument = equipment.map(str::to_owned);
    Ok(RawMap { dx_um, dy_um, instrument, ..RawMap::new(FORMAT, (nx, ny), heights_um) })
}

/// The pixel sizes from `Scan Size: 10 10 ~m`, or `10000 nm` for the width alone.
fn pixel_um(
    channel: &Section,
    nx: usize,
    ny: usize,
) -> Result<(Option<f64>, Option<f64>), MapFault> {
    let Some(size) = channel.find("Scan Size") else { return Ok((None, None)) };
    let bad = || damaged(format!("the line Scan Size holds {size:?}"));
    let words: Vec<&str> = size.split_whitespace().collect();
    let (numbers, unit) = match words.as_slice() {
        [numbers @ .., unit] if (1..=2).contains(&numbers.len()) => (numbers, unit),
        _ => return Err(bad()),
    };
    let Some((metres, "m")) = si(unit) else { return Err(bad()) };
    let pixel = |k: usize, n: usize| match numbers.get(k) {
        Some(number) => {
            let size: f64 = number.parse().map_err(|_| bad())?;
            pitch(FORMAT, "Scan Size", size * metres * 1e6 / n as f64).map(Some)
        }
        None => Ok(None),
    };
    Ok((pixel(0, nx)?, pixel(1, ny)?))
}

#[cfg(test)]
pub(super) mod tests {
    use super::{detect, si};
    use crate::io::{MapFault, OpenOptions, RawMap};

    fn read(bytes: &[u8]) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions::default())
    }

    pub(in crate::io) fn file(change: impl Fn(String) -> String, points: &[u8]) -> Vec<u8> {
        let channel = |title: &str, scale: &str| {
            format!(
                "\\*Ciao image list\n\\Data offset: 1500\n\\Data length: 24\n\\Bytes/pixel: 2\n\
                 \\Samps/line: 3\n\\Number of lines: 2\n\\Scan Size: 1.5 500e-3 ~m\n\
                 \\@2:Image Data: S [{title}] \"{title}\"\n\
                 \\@Z magnify: C [2:Z scale] 0.01\n\\@2:Z scale: {scale}\n"
            )
        };
        let header = format!(
            "\\*File list\n\\Version: 0x05120130\n\\*Equipment list\n\\Description: Icon\n\
             \\*Ciao scan list\n\\@Sens. Zsens: V 50 nm/V\n\\@Sens. Amp: V 2 nA/V\n{}{}{END}\n\x1a",
            channel("Amplitude", "V [Sens. Amp] (0.01 V/LSB) 3 V"),
            channel("Height", "V [Sens. Zsens] (0.3 mV/LSB) 6553.6 mV"),
            END = super::END
        );
        let mut bytes: Vec<u8> = change(header).chars().map(|c| c as u8).collect();
        bytes.resize(1500, 0);
        bytes.extend(points);
        bytes
    }

    pub(in crate::io) fn points() -> Vec<u8> {
        [1i16, 2, 3, -4, 5, 6].iter().flat_map(|z| z.to_le_bytes()).collect()
    }

    #[test]
    fn the_height_channel_is_found_and_scaled() {
        let bytes = file(|h| h, &points());
        let map = read(&bytes).unwrap();
        assert!(detect(&bytes) && (map.nx, map.ny) == (3, 2));
        assert!((map.dx_um.unwrap() - 0.5).abs() < 1e-12);
        assert!((map.dy_um.unwrap() - 0.25).abs() < 1e-12);
        assert_eq!(map.instrument.as_deref(), Some("Icon"));
        // 6.5536 V x 50 nm/V / 65536 = 5e-6 um a step; the bottom line is first in the file
        for (read, put) in map.heights_um.iter().zip([-4.0, 5.0, 6.0, 1.0, 2.0, 3.0]) {
            assert!((read - 5e-6 * put).abs() < 1e-15, "{read} {put}");
        }
    }

    #[test]
    fn of_several_heights_one_is_chosen() {
        let heights = |header: String| {
            header
                .replace("(0.01 V/LSB) 3 V", "(0.01 V/LSB) 3276.8 mV")
                .replace("2 nA/V", "25 nm/V")
        };
        let file = file(heights, &points());
        let of = |channel| {
            super::read(&file, &OpenOptions { channel, ..OpenOptions::default() })
                .map_err(|e| e.to_string())
        };
        let [first, second] = [of(None).unwrap(), of(Some(1)).unwrap()];
        assert_eq!(first.channels, ["Amplitude", "Height"]);
        // a quarter of the scale
        assert!((second.heights_um[1] / first.heights_um[1] - 4.0).abs() < 1e-9);
        assert!(of(Some(2)).unwrap_err().contains("1 `Height`"));
    }

    #[test]
    fn new_files_have_four_bytes_a_point_and_old_ones_one_size() {
        let wide: Vec<u8> = [1i32 << 16; 6].iter().flat_map(|z| z.to_le_bytes()).collect();
        let map = read(&file(|h| h.replace("0x0512", "0x0940"), &wide)).unwrap();
        assert!(map.heights_um.iter().all(|z| (z - 5e-6).abs() < 1e-15));
        let map = read(&file(|h| h.replace("1.5 500e-3 ~m", "1500 nm"), &points())).unwrap();
        assert!((map.dx_um.unwrap() - 0.5).abs() < 1e-12 && map.dy_um.is_none());
        assert_eq!(si("µm"), si("~m"));
        assert!(si("Arb").is_none() && si("").is_none());
    }

    #[test]
    fn malformed_files_are_refused() {
        let bytes = file(|h| h, &points());
        for end in [0, 5, 11, 100, 500, 1400, 1499, 1511] {
            assert!(read(&bytes[..end]).is_err(), "{end}");
        }
        // so many images, each sought in all sections, would take minutes
        let many = format!("\\*File list\n{}", "\\*Ciao image list\n".repeat(300));
        let fault = read(many.as_bytes()).unwrap_err();
        assert!(fault.to_string().contains("more than 256 sections"), "{fault}");
        for (old, new) in [
            ("\\*File list\n", "\\*Force file list\n"),
            (super::END, ""),
            ("image list", "picture list"),
            ("nm/V", "pA/V"),
            ("nm/V", "nm"),
            ("50 nm/V", "x nm/V"),
            ("6553.6 mV", "0 mV"),
            ("6553.6 mV", "nan mV"),
            ("6553.6 mV", "6553.6mV"),
            ("line: 3", "line: 0"),
            ("line: 3", "line: -3"),
            ("line: 3", "line: 16000000"),
            ("line: 3", "line: 18446744073709551615"),
            ("Samps/line: 3\n", ""),
            ("offset: 1500", "offset: 1504"),
            ("offset: 1500", "offset: 18446744073709551615"),
            ("pixel: 2", "pixel: 3"),
            ("1.5 500e-3 ~m", "0 0 ~m"),
            ("1.5 500e-3 ~m", "-1 1 ~m"),
            ("1.5 500e-3 ~m", "1.5 1.5 V"),
            ("1.5 500e-3 ~m", ""),
        ] {
            assert!(read(&file(|h| h.replace(old, new), &points())).is_err(), "{old} {new}");
        }
    }
}
