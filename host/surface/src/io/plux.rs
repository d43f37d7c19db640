//! Sensofar `.plux`: a zip archive with `index.xml` and layers of floats in um, row by row.
//!
//! `GENERAL` holds `IMAGE_SIZE_X`, `IMAGE_SIZE_Y` in points and `FOV_X`, `FOV_Y`, the pixel in um; `LAYER_0`, `LAYER_1` and so
//! on name the file of a layer in `FILENAME_Z`. NaN is a missing point. Layout after `SurfaceTopography` `PLUX.py` and Gwyddion
//! `sensofarx.c`. Not tested with a file of an instrument: none is public.

use super::bytes::{pitch, points};
use super::channels::chosen;
use super::text::decode;
use super::zipped::{self, Archive};
use super::{MapFault, OpenOptions, RawMap};
use crate::message::excerpt;

const FORMAT: &str = "Sensofar plux";
const INDEX: &str = "index.xml";
/// Indices are some kilobytes.
const LONGEST_INDEX: usize = 1 << 20;
/// Layers at most.
const MOST_LAYERS: usize = 256;

/// Whether the bytes are a zip archive with an index of images.
pub(super) fn detect(bytes: &[u8]) -> bool {
    zipped::detect(bytes)
        && Archive::open(FORMAT, bytes).is_ok_and(|mut archive| {
            let index = archive.find(INDEX).map(|number| archive.read(number));
            // a damaged index is that of a damaged file
            index.is_some_and(|index| {
                index.is_ok_and(|i| i.windows(12).any(|w| w == b"IMAGE_SIZE_X"))
            })
        })
}

/// Reads a layer.
pub(super) fn read(bytes: &[u8], options: &OpenOptions) -> Result<RawMap, MapFault> {
    let mut archive = Archive::open(FORMAT, bytes)?;
    let Some(number) = archive.find(INDEX) else {
        return Err(damaged("it has no index.xml".into()));
    };
    let index = archive.read(number)?;
    if index.len() > LONGEST_INDEX {
        return Err(damaged(format!("its index has {} bytes", index.len())));
    }
    let index = decode(&index);
    let general = Element(&index).inside("GENERAL")?;
    let (nx, ny): (u64, u64) = (general.number("IMAGE_SIZE_X")?, general.number("IMAGE_SIZE_Y")?);
    let count = points(FORMAT, nx, ny)?;
    let dx_um = pitch(FORMAT, "FOV_X", general.number("FOV_X")?)?;
    let dy_um = pitch(FORMAT, "FOV_Y", general.number("FOV_Y")?)?;
    let layers: Vec<Element> = (0..MOST_LAYERS)
        .map_while(|k| Element(&index).inside(&format!("LAYER_{k}")).ok())
        .collect();
    if layers.is_empty() {
        return Err(damaged("its index has no layer".into()));
    }
    let names: Vec<String> = (0..layers.len()).map(|k| format!("layer {k}")).collect();
    let number = chosen(FORMAT, &names, options)?;
    let Some(layer) = layers.get(number) else { return Err(damaged("it has no layer".into())) };
    let name = layer.inside("FILENAME_Z")?.0.trim();
    let Some(file) = archive.find(name) else {
        return Err(damaged(format!("the archive has no `{}`", excerpt(name))));
    };
    let content = archive.read(file)?;
    if content.len() != 4 * count {
        let what = format!(
            "`{}` has {} bytes, not those of {nx} x {ny} floats",
            excerpt(name),
            content.len()
        );
        return Err(damaged(what));
    }
    let height = |b: &[u8; 4]| match f64::from(f32::from_le_bytes(*b)) {
        um if um.is_finite() => um,
        _ => f64::NAN,
    };
    let heights_um = content.as_chunks().0.iter().map(height).collect();
    Ok(RawMap {
        dx_um: Some(dx_um),
        dy_um: Some(dy_um),
        instrument: Some("Sensofar".into()),
        channels: if names.len() > 1 { names } else { Vec::new() },
        ..RawMap::new(FORMAT, (nx as usize, ny as usize), heights_um)
    })
}

fn damaged(what: String) -> MapFault {
    MapFault::Damaged { format: FORMAT, what }
}

/// A piece of XML without attributes.
#[derive(Clone, Copy)]
struct Element<'a>(&'a str);

impl Element<'_> {
    /// The content of the first element of a name.
    fn inside(self, name: &str) -> Result<Self, MapFault> {
        let missing = || damaged(format!("its index has no {name}"));
        let (_, rest) = self.0.split_once(&format!("<{name}>")).ok_or_else(missing)?;
        let (content, _) = rest.split_once(&format!("</{name}>")).ok_or_else(missing)?;
        Ok(Self(content))
    }

    fn number<T: std::str::FromStr>(self, name: &str) -> Result<T, MapFault> {
        let text = self.inside(name)?.0.trim();
        text.parse().map_err(|_| damaged(format!("{name} is `{}`", excerpt(text))))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::zipped::tests::zip;
    use super::detect;
    use crate::io::{MapFault, OpenOptions, RawMap};

    fn read(bytes: &[u8], channel: Option<usize>) -> Result<RawMap, MapFault> {
        super::read(bytes, &OpenOptions { channel, ..OpenOptions::default() })
    }

    /// Two layers of 3 x 2 points, 0.5 and 0.25 um apart.
    pub(in crate::io) fn sample(change: impl Fn(String) -> String) -> Vec<u8> {
        let index = "<?xml version=\"1.0\"?><xml><GENERAL><DATE>x</DATE><IMAGE_SIZE_X>3</IMAGE_SIZE_X>\
                     <IMAGE_SIZE_Y>2</IMAGE_SIZE_Y><FOV_X>0.5</FOV_X><FOV_Y>0.25</FOV_Y></GENERAL>\
                     <LAYER_0><FILENAME_Z>LAYER_0.raw</FILENAME_Z></LAYER_0>\
                     <LAYER_1><FILENAME_Z>LAYER_1.raw</FILENAME_Z></LAYER_1></xml>";
        let index = change(index.to_owned());
        let layer = |z: f32| [z, 2.0, -3.0, f32::NAN, 5.0, 0.0].map(f32::to_le_bytes).concat();
        let (first, second) = (layer(1.0), layer(7.0));
        let files: [(&str, &[u8]); 4] = [
            ("./recipe.txt", b"<xml/>"),
            ("index.xml", index.as_bytes()),
            ("LAYER_0.raw", &first),
            ("LAYER_1.raw", &second),
        ];
        zip(&files, true)
    }

    #[test]
    fn layers_are_micrometres() {
        let file = sample(|i| i);
        let map = read(&file, None).unwrap();
        assert!(detect(&file) && !detect(&zip(&[("index.xml", b"<html>")], false)));
        assert_eq!((map.nx, map.ny, map.dx_um, map.dy_um), (3, 2, Some(0.5), Some(0.25)));
        assert_eq!(map.heights_um[..3], [1.0, 2.0, -3.0]);
        assert!(map.heights_um[3].is_nan() && map.heights_um[4..] == [5.0, 0.0]);
        assert_eq!(read(&file, Some(1)).unwrap().heights_um[..1], [7.0]);
        assert!(read(&file, Some(2)).is_err());
    }

    #[test]
    fn malformed_files_are_refused() {
        let good = sample(|i| i);
        for end in [0, 30, 200, good.len() - 1] {
            assert!(read(&good[..end], None).is_err(), "{end}");
        }
        for (old, new) in [
            ("IMAGE_SIZE_X>3<", "IMAGE_SIZE_X>0<"),
            ("IMAGE_SIZE_X>3<", "IMAGE_SIZE_X>4<"),
            ("IMAGE_SIZE_X>3<", "IMAGE_SIZE_X>-3<"),
            ("IMAGE_SIZE_X>3<", "IMAGE_SIZE_X>99999999<"),
            ("<IMAGE_SIZE_Y>2</IMAGE_SIZE_Y>", ""),
            ("<FOV_X>0.5", "<FOV_X>0"),
            ("<FOV_Y>0.25", "<FOV_Y>nan"),
            ("GENERAL", "SPECIAL"),
            ("LAYER_0>", "LAYER_9>"),
            ("LAYER_0.raw", "LAYER_7.raw"),
        ] {
            assert!(read(&sample(|i| i.replace(old, new)), None).is_err(), "{old} {new}");
        }
    }
}
