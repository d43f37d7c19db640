//! Heights as floats of 32 or 64 bits in a TIFF, `GeoTIFF` among them.
//!
//! `ModelPixelScale` (33550) gives the pixel size; such a file is in metres, the heights too, unless
//! its keys name another unit, which is refused. Without it the heights are in um unless the user says another unit, and there is no
//! pixel size: the resolution in a plain TIFF is that of a print. Points equal to `GDAL_NODATA`
//! (42113) and numbers that are not finite are missing. Only the first image is read.

use std::cmp::Ordering;
use std::io::Cursor;

use tiff::ColorType;
use tiff::TiffError;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::bytes::{most_inflated, pitch, points};
use super::options::Scale;
use super::{LengthUnit, MapFault, OpenOptions, RawMap, Source, Sources};
use crate::message::excerpt;

const FORMAT: &str = "TIFF";

const PIXEL_SCALE: Tag = Tag::Unknown(33550);
const GEO_KEYS: Tag = Tag::Unknown(34735);
const NODATA: Tag = Tag::Unknown(42113);

/// Whether the file begins as the format asks.
pub(super) fn detect(bytes: &[u8]) -> bool {
    [b"II\x2a\0", b"MM\0\x2a", b"II\x2b\0", b"MM\0\x2b"].iter().any(|m| bytes.starts_with(*m))
}

/// Reads the first image.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(broken)?;
    let (nx, ny) = decoder.dimensions().map_err(broken)?;
    let n = points(FORMAT, nx.into(), ny.into())?;
    let depth = match decoder.colortype().map_err(broken)? {
        ColorType::Gray(depth @ (32 | 64)) if is_float(&mut decoder)? => depth,
        other => return Err(unsupported(format!("{other:?} that is not one float a pixel"))),
    };
    let size = n * usize::from(depth / 8);
    let plain =
        decoder.find_tag_unsigned::<u16>(Tag::Compression).map_err(broken)?.unwrap_or(1) == 1;
    let most = most_inflated(bytes);
    if plain && size > bytes.len() {
        return Err(damaged(format!("{nx} x {ny} points cannot be in so few bytes")));
    }
    if size as u64 > most {
        return Err(MapFault::Inflates { format: FORMAT, what: "the image".into(), most });
    }
    let scale = Scaling::of(&mut decoder, options)?;
    let nodata = nodata(&mut decoder)?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = size;
    limits.intermediate_buffer_size = size.max(1 << 16);
    let mut decoder = decoder.with_limits(limits);
    let height =
        |v: f64, lost: bool| if lost || !v.is_finite() { f64::NAN } else { v * scale.z.um };
    let heights_um: Vec<f64> = match decoder.read_image().map_err(broken)? {
        DecodingResult::F32(values) => {
            let lost = nodata.map(|v| v as f32);
            values
                .iter()
                .map(|v| height((*v).into(), lost.is_some_and(|l| is_same(*v, l))))
                .collect()
        }
        DecodingResult::F64(values) => {
            values.iter().map(|v| height(*v, nodata.is_some_and(|l| is_same(*v, l)))).collect()
        }
        _ => return Err(unsupported("a pixel that is not one float".into())),
    };
    if heights_um.len() != n {
        return Err(damaged(format!("{} pixels instead of {nx} x {ny}", heights_um.len())));
    }
    Ok(RawMap {
        dx_um: scale.pixel_um.map(|[dx, _]| dx),
        dy_um: scale.pixel_um.map(|[_, dy]| dy),
        sources: Sources { z: scale.z.source, ..Sources::default() },
        ..RawMap::new(FORMAT, (nx as usize, ny as usize), heights_um)
    })
}

type File<'a> = Decoder<Cursor<&'a [u8]>>;

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

fn unsupported(what: String) -> MapFault {
    MapFault::Unsupported {
        format: FORMAT,
        what,
        remedy: "export one channel of 32-bit floats in metres",
    }
}

fn broken(error: TiffError) -> MapFault {
    match error {
        TiffError::UnsupportedError(what) => unsupported(what.to_string()),
        other => damaged(other.to_string()),
    }
}

/// Whether a value is the one of missing points, exactly.
fn is_same<T: PartialOrd + Copy>(value: T, nodata: T) -> bool {
    value.partial_cmp(&nodata) == Some(Ordering::Equal)
}

fn is_float(decoder: &mut File) -> Result<bool, MapFault> {
    let kinds = decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).map_err(broken)?;
    Ok(kinds.is_some_and(|kinds| kinds == [3]))
}

/// Micrometres of pixels and heights.
struct Scaling {
    pixel_um: Option<[f64; 2]>,
    z: Scale,
}

impl Scaling {
    fn of(decoder: &mut File, options: &OpenOptions) -> Result<Self, MapFault> {
        let Some(scale) = decoder.find_tag(PIXEL_SCALE).map_err(broken)? else {
            options.no_lateral_numbers(FORMAT)?;
            return Ok(Self { pixel_um: None, z: options.heights_or_um(FORMAT)? });
        };
        let &[dx, dy, z] = scale.into_f64_vec().map_err(broken)?.as_slice() else {
            return Err(damaged("ModelPixelScale has not three numbers".into()));
        };
        let [dx_um, dy_um] = [dx, dy].map(|m| pitch(FORMAT, "ModelPixelScale", m * 1e6));
        if !z.is_finite() {
            return Err(damaged("ModelPixelScale has no scale of heights".into()));
        }
        let keys = decoder.find_tag_unsigned_vec::<u16>(GEO_KEYS).map_err(broken)?;
        for key in keys.unwrap_or_default().chunks_exact(4).skip(1) {
            match *key {
                // geographic coordinates, units of length other than the metre
                [1024, 0, _, 2] => return Err(unsupported("a pixel size in degrees".into())),
                [3076 | 4099, 0, _, unit] if unit != 9001 => {
                    return Err(unsupported(format!("the unit of length {unit}")));
                }
                _ => {}
            }
        }
        // a third scale of zero means none
        let z = if z.abs() > 0.0 { z } else { 1.0 };
        options.lateral(FORMAT, Some(LengthUnit::Metre))?;
        options.heights(FORMAT, Some(LengthUnit::Metre), false)?;
        let z = Scale { um: z * 1e6, source: Source::File };
        Ok(Self { pixel_um: Some([dx_um?, dy_um?]), z })
    }
}

/// The number that marks missing points.
fn nodata(decoder: &mut File) -> Result<Option<f64>, MapFault> {
    let Some(value) = decoder.find_tag(NODATA).map_err(broken)? else { return Ok(None) };
    let text = value.into_string().map_err(broken)?;
    let text = text.trim_matches(['\0', ' ']);
    text.parse().map(Some).map_err(|_| damaged(format!("GDAL_NODATA is `{}`", excerpt(text))))
}

#[cfg(test)]
pub(super) mod tests {
    use std::io::Cursor;

    use tiff::encoder::{Compression, DeflateLevel, TiffEncoder, TiffValue, colortype};
    use tiff::tags::Tag;

    use super::super::OpenOptions;
    use super::{GEO_KEYS, NODATA, PIXEL_SCALE, detect};

    fn read(bytes: &[u8]) -> Result<super::RawMap, super::MapFault> {
        super::read(bytes, &OpenOptions::default())
    }

    type Tags<'a> = (Option<&'a [f64]>, Option<&'a [u16]>, Option<&'a str>);

    fn image<C: colortype::ColorType>(
        compression: Compression,
        tags: Tags,
        data: &[C::Inner],
    ) -> Vec<u8>
    where
        [C::Inner]: TiffValue,
    {
        let mut file = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut file).unwrap().with_compression(compression);
        let mut image = encoder.new_image::<C>(3, 2).unwrap();
        if let Some(scale) = tags.0 {
            image.encoder().write_tag(PIXEL_SCALE, scale).unwrap();
        }
        if let Some(keys) = tags.1 {
            image.encoder().write_tag(GEO_KEYS, keys).unwrap();
        }
        if let Some(text) = tags.2 {
            image.encoder().write_tag(NODATA, text).unwrap();
        }
        image.write_data(data).unwrap();
        file.into_inner()
    }

    const KEYS: &[u16] = &[1, 1, 0, 2, 1024, 0, 1, 1, 3076, 0, 1, 9001];

    pub(in crate::io) fn sample(compression: Compression) -> Vec<u8> {
        let tags: Tags = (Some(&[2e-6, 1e-6, 0.0]), Some(KEYS), Some("-9999"));
        image::<colortype::Gray32Float>(
            compression,
            tags,
            &[0.0, 1e-6, 2e-6, -9999.0, f32::NAN, 5e-6],
        )
    }

    #[test]
    fn floats_are_read_packed_or_not() {
        for compression in [
            Compression::Uncompressed,
            Compression::Lzw,
            Compression::Deflate(DeflateLevel::default()),
        ] {
            let file = sample(compression);
            assert!(detect(&file));
            let map = read(&file).unwrap();
            assert_eq!((map.nx, map.ny), (3, 2));
            assert!(
                (map.dx_um.unwrap() - 2.0).abs() < 1e-9 && (map.dy_um.unwrap() - 1.0).abs() < 1e-9
            );
            assert!((map.heights_um[5] - 5.0).abs() < 1e-6);
            assert!(map.heights_um[3].is_nan() && map.heights_um[4].is_nan());
        }
        let values = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let map =
            read(&image::<colortype::Gray64Float>(Compression::Lzw, (None, None, None), &values))
                .unwrap();
        assert_eq!((map.dx_um, map.heights_um), (None, values.to_vec()));
    }

    #[test]
    fn malformed_images_are_refused() {
        let float =
            |tags| image::<colortype::Gray32Float>(Compression::Uncompressed, tags, &[1.0; 6]);
        let good = sample(Compression::Uncompressed);
        // finds an entry of the directory and changes its value
        let with = |tag: Tag, value: u32| {
            let mut file = good.clone();
            let at = u32::from_le_bytes([file[4], file[5], file[6], file[7]]) as usize;
            let count = u16::from_le_bytes([file[at], file[at + 1]]) as usize;
            let entry = (0..count).map(|k| at + 2 + 12 * k);
            let entry =
                entry.into_iter().find(|e| file[*e..*e + 2] == tag.to_u16().to_le_bytes()).unwrap();
            file[entry + 8..entry + 12].copy_from_slice(&value.to_le_bytes());
            file
        };
        for (file, word) in [
            (good[..7].to_vec(), ""),
            (good[..good.len() - 3].to_vec(), ""),
            (good[..good.len() / 2].to_vec(), ""),
            (with(Tag::ImageWidth, 0), ""),
            (with(Tag::ImageWidth, 16384), "so few bytes"),
            (with(Tag::ImageWidth, u32::MAX), "crop the map"),
            (with(Tag::SampleFormat, 1), "not one float"),
            (with(Tag::Compression, 7), ""),
            (with(Tag::StripOffsets, u32::MAX), ""),
            (with(Tag::StripByteCounts, u32::MAX), ""),
            (float((Some(&[-1.0, 1.0, 0.0]), None, None)), "ModelPixelScale gives"),
            (float((Some(&[f64::NAN, 1.0, 0.0]), None, None)), "ModelPixelScale gives"),
            (float((Some(&[1.0, 1.0]), None, None)), "three numbers"),
            (float((Some(&[1.0, 1.0, 0.0]), Some(&[1, 1, 0, 1, 1024, 0, 1, 2]), None)), "degrees"),
            (float((Some(&[1.0, 1.0, 0.0]), Some(&[1, 1, 0, 1, 3076, 0, 1, 9002]), None)), "9002"),
            (float((None, None, Some("none"))), "GDAL_NODATA"),
            (
                image::<colortype::Gray16>(Compression::Uncompressed, (None, None, None), &[1; 6]),
                "Gray(16)",
            ),
            (
                image::<colortype::Gray32>(Compression::Uncompressed, (None, None, None), &[1; 6]),
                "Gray(32)",
            ),
            (
                image::<colortype::RGB32Float>(
                    Compression::Uncompressed,
                    (None, None, None),
                    &[1.0; 18],
                ),
                "RGB(32)",
            ),
        ] {
            let fault = read(&file).unwrap_err().to_string();
            assert!(fault.contains(word), "{word}: {fault}");
        }
    }
}
