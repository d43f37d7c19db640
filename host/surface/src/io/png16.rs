//! Heights as grey of 16 bits in a PNG.
//!
//! The height of one count comes from a linear `pCAL` chunk with a unit of length, else from the user; without
//! either there are no heights. An `sCAL` chunk in metres gives the pixel size;
//! `pHYs` is the resolution of a print and says nothing.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder};

use super::bytes::{most_inflated, pitch, points};
use super::text::decode;
use super::unit::{LengthUnit, length_um};
use super::{MapFault, OpenOptions, RawMap, Source, Sources};

const FORMAT: &str = "PNG";
const MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Whether the file begins as the format asks.
pub(super) fn detect(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads the map.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let broken = |e: png::DecodingError| damaged(e.to_string());
    let mut decoder = Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let info = decoder.read_header_info().map_err(broken)?;
    let (nx, ny) = (info.width, info.height);
    let n = points(FORMAT, nx.into(), ny.into())?;
    if (info.color_type, info.bit_depth) != (ColorType::Grayscale, BitDepth::Sixteen) {
        return Err(MapFault::Unsupported {
            format: FORMAT,
            what: format!("{:?} of {} bits", info.color_type, info.bit_depth as u8),
            remedy: "export 16-bit grey; fewer bits round the heights to steps",
        });
    }
    let most = most_inflated(bytes);
    if n as u64 * 2 > most {
        return Err(MapFault::Inflates { format: FORMAT, what: "the image".into(), most });
    }
    let ([z_um, offset_um], z) = scale(bytes, options)?;
    if !(z_um.is_finite() && z_um != 0.0 && offset_um.is_finite()) {
        return Err(damaged("the height of a count is not a number above zero".into()));
    }
    let mut reader = decoder.read_info().map_err(broken)?;
    let mut counts = vec![0; n * 2];
    if reader.output_buffer_size() != Some(counts.len()) {
        return Err(damaged("the pixels have another size than its header says".into()));
    }
    reader.next_frame(&mut counts).map_err(broken)?;
    let [dx_um, dy_um] = scal(bytes)?.map_or([None; 2], |pitch| pitch.map(Some));
    let counts = counts.as_chunks::<2>().0.iter().map(|b| f64::from(u16::from_be_bytes(*b)));
    let heights_um = counts.map(|count| count * z_um + offset_um).collect();
    Ok(RawMap {
        dx_um,
        dy_um,
        sources: Sources { z, ..Sources::default() },
        ..RawMap::new(FORMAT, (nx as usize, ny as usize), heights_um)
    })
}

/// Heights of a count and of the count zero in um, and who says so.
fn scale(bytes: &[u8], options: &OpenOptions) -> Result<([f64; 2], Source), MapFault> {
    if chunk(bytes, *b"sCAL").is_some() {
        options.lateral(FORMAT, Some(LengthUnit::Metre))?;
    } else {
        options.no_lateral_numbers(FORMAT)?;
    }
    let given = options.z_um.or(options.z_unit.map(LengthUnit::um));
    // the user's word goes before a chunk that is not understood, not before one that is
    let stated = match (pcal(bytes), given) {
        (Err(_), Some(_)) => None,
        (found, _) => found?,
    };
    match (stated, given) {
        (Some(scale), None) => Ok((scale, Source::File)),
        (Some(scale), Some(um)) if (scale[0] - um).abs() <= 1e-6 * um.abs() => {
            Ok((scale, Source::File))
        }
        (Some([um, _]), Some(given)) => Err(MapFault::Contradicts {
            format: FORMAT,
            says: format!("the file says that a count is {um} um;"),
            flag: format!("a height of {given} um"),
        }),
        (None, Some(um)) => Ok(([um, 0.0], Source::User)),
        (None, None) => Err(MapFault::Unsupported {
            format: FORMAT,
            what: "a file without the height of a count (pCAL)".into(),
            remedy: "give it by --z-um, or export heights as x3p, SDF, float TIFF or text",
        }),
    }
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

/// The content of a chunk in front of the pixels.
fn chunk(bytes: &[u8], name: [u8; 4]) -> Option<&[u8]> {
    let mut rest = bytes.get(MAGIC.len()..)?;
    loop {
        let (length, tail) = rest.split_first_chunk::<4>()?;
        let (kind, tail) = tail.split_first_chunk::<4>()?;
        let length = u32::from_be_bytes(*length) as usize;
        if *kind == name {
            return tail.get(..length);
        }
        if kind == b"IDAT" {
            return None;
        }
        rest = tail.get(length.checked_add(4)?..)?;
    }
}

/// The height of a count and of the count zero in um, from a `pCAL` chunk.
fn pcal(bytes: &[u8]) -> Result<Option<[f64; 2]>, MapFault> {
    let Some(content) = chunk(bytes, *b"pCAL") else { return Ok(None) };
    let parse = || {
        let start = content.iter().position(|b| *b == 0)? + 1;
        let (x0, rest) = content.get(start..)?.split_first_chunk::<4>()?;
        let (x1, rest) = rest.split_first_chunk::<4>()?;
        let (&[kind, _], rest) = rest.split_first_chunk::<2>()?;
        let [x0, x1] = [x0, x1].map(|x| f64::from(i32::from_be_bytes(*x)));
        let mut words = rest.split(|b| *b == 0).map(decode);
        let unit = length_um(&words.next()?);
        let mut number = || words.next()?.parse::<f64>().ok();
        let (p0, p1) = (number()?, number()?);
        let um = unit.filter(|_| kind == 0)?;
        // the sample is x0 + count (x1 - x0) / 65535, the height p0 + p1 sample / (x1 - x0)
        Some([p1 / 65535.0 * um, (p0 + p1 * x0 / (x1 - x0)) * um])
    };
    parse().map(Some).ok_or_else(|| MapFault::Unsupported {
        format: FORMAT,
        what: "a pCAL chunk that is not a line in a unit of length".into(),
        remedy: "export heights as x3p, SDF, float TIFF or text",
    })
}

/// The pixel sizes in um from an `sCAL` chunk in metres.
fn scal(bytes: &[u8]) -> Result<Option<[f64; 2]>, MapFault> {
    let Some([1, text @ ..]) = chunk(bytes, *b"sCAL") else { return Ok(None) };
    let mut sizes = text.split(|b| *b == 0).map(|word| decode(word).trim().parse::<f64>().ok());
    let mut side = || pitch(FORMAT, "sCAL", sizes.next().flatten().unwrap_or(0.0) * 1e6);
    Ok(Some([side()?, side()?]))
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::OpenOptions;
    use super::detect;
    use png::{BitDepth, ColorType};

    fn read(bytes: &[u8], z_um: Option<f64>) -> Result<super::RawMap, super::MapFault> {
        super::read(bytes, &OpenOptions { z_um, ..OpenOptions::default() })
    }

    fn image(
        nx: u32,
        color: ColorType,
        depth: BitDepth,
        chunks: &[(&[u8; 4], &[u8])],
        data: &[u8],
    ) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, nx, 2);
        encoder.set_color(color);
        encoder.set_depth(depth);
        let mut writer = encoder.write_header().unwrap();
        for (name, content) in chunks {
            writer.write_chunk(png::chunk::ChunkType(**name), content).unwrap();
        }
        writer.write_image_data(data).unwrap();
        writer.finish().unwrap();
        file
    }

    pub(in crate::io) fn sample(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
        let data: Vec<u8> =
            [0_u16, 1, 2, 3, 0x1234, 65535].iter().flat_map(|v| v.to_be_bytes()).collect();
        image(3, ColorType::Grayscale, BitDepth::Sixteen, chunks, &data)
    }

    pub(in crate::io) const PCAL: &[u8] = b"z\0\0\0\0\0\0\0\xff\xff\0\x02um\x001.0\x006.5535e1";
    pub(in crate::io) const SCAL: &[u8] = b"\x012e-6\x001e-6";

    #[test]
    fn counts_become_heights_by_a_scale() {
        let map = read(&sample(&[]), Some(0.5)).unwrap();
        assert_eq!((map.nx, map.ny, map.dx_um), (3, 2, None));
        assert_eq!(map.heights_um, [0.0, 0.5, 1.0, 1.5, 2330.0, 32767.5]);
        let file = sample(&[(b"pCAL", PCAL), (b"sCAL", SCAL)]);
        assert!(detect(&file));
        let map = read(&file, None).unwrap();
        assert!(
            (map.heights_um[5] - 66.535).abs() < 1e-9 && (map.heights_um[0] - 1.0).abs() < 1e-12
        );
        assert!(
            (map.dx_um.unwrap() - 2.0).abs() < 1e-12 && (map.dy_um.unwrap() - 1.0).abs() < 1e-12
        );
        let fault = read(&file, Some(1.0)).unwrap_err().to_string();
        assert!(fault.contains("contradicts"), "{fault}");
        assert!(read(&file, Some(1e-3)).is_ok());
    }

    #[test]
    fn malformed_images_are_refused() {
        let good = sample(&[]);
        let mut huge = good.clone();
        huge[16..24].copy_from_slice(&[0, 0, 64, 0, 0, 0, 64, 0]);
        let crc = |file: &mut Vec<u8>| {
            let mut sum = flate2::Crc::new();
            sum.update(&file[12..29]);
            let sum = sum.sum().to_be_bytes();
            file[29..33].copy_from_slice(&sum);
        };
        crc(&mut huge);
        let mut larger = huge.clone();
        larger[16..20].copy_from_slice(&[127; 4]);
        crc(&mut larger);
        let mut broken = good.clone();
        let at = broken.len() - 30;
        broken[at] ^= 255;
        let eight = image(3, ColorType::Grayscale, BitDepth::Eight, &[], &[0; 6]);
        let colour = image(1, ColorType::Rgb, BitDepth::Sixteen, &[], &[0; 12]);
        let pcal = |content: &[u8]| sample(&[(b"pCAL", content)]);
        for (file, z, word) in [
            (good.clone(), None, "without the height of a count"),
            (good.clone(), Some(f64::NAN), "not a number"),
            (good.clone(), Some(0.0), "not a number"),
            (good[..good.len() / 2].to_vec(), Some(1.0), ""),
            (good[..20].to_vec(), Some(1.0), ""),
            (broken, Some(1.0), ""),
            (huge, Some(1.0), "the image inflates"),
            (larger, Some(1.0), "crop the map"),
            (eight, Some(1.0), "of 8 bits"),
            (colour, Some(1.0), "Rgb"),
            (pcal(b"z"), None, "pCAL"),
            (pcal(b"z\0\0\0\0\0\0\0\xff\xff\0\x02V\x001\x002"), None, "pCAL"),
            (pcal(b"z\0\0\0\0\0\0\0\xff\xff\x01\x02um\x001\x002"), None, "pCAL"),
            (pcal(b"z\0\0\0\0\0\0\0\xff\xff\0\x02um\x001\x00two"), None, "pCAL"),
            (pcal(b"z\0\0\0\0\0\0\0\0\0\0\x02um\x001\x002"), None, "not a number"),
            (sample(&[(b"sCAL", b"\x01-1\x001")]), Some(1.0), "sCAL"),
        ] {
            let fault = read(&file, z).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
    }
}
