//! Files of profilometers, one reader per format, told apart by content and never by name.

mod error;
mod unit;
mod words;
mod options;
mod channels;
mod vocabulary;
mod said;
mod sentence;
mod bytes;
mod text;
mod zipped;
mod al3d;
mod di;
mod opd;
mod opdx;
mod metropro;
mod nms;
mod tmd;
mod nid;
mod frt;
mod ibw;
mod ole;
mod mnt;
mod plu;
mod plux;
mod vk;
mod gsf;
mod sdf;
mod x3p;
mod sur;
mod gwy;
mod gwyddion_text;
mod profile;
mod xyz;
mod matrix;
mod zygo_text;
mod keyence_csv;
mod npy;
mod png16;
mod tiff_float;
mod packed;
mod known;
mod open;
mod write;
#[cfg(test)]
mod tests_instruments;
#[cfg(test)]
mod tests_gwy;
#[cfg(test)]
mod tests_b;
#[cfg(test)]
mod tests_more;
#[cfg(test)]
mod samples;
#[cfg(test)]
mod tests_mutation;

pub(crate) use channels::listed;
pub use error::{MapError, MapFault};
pub use open::{FORMATS, Format, open, parse};
pub use options::{OpenOptions, Source, Sources};
pub use unit::{LengthUnit, NoLengthUnit};
pub use write::{gsf_bytes, sdf_text};

use crate::heightmap::HeightMap;

/// The content of a file without any assumption: what it lacks is `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct RawMap {
    /// Name of the format, for messages.
    pub format: &'static str,
    /// Columns, along x.
    pub nx: usize,
    /// Rows, along y.
    pub ny: usize,
    /// Distance of columns, um.
    pub dx_um: Option<f64>,
    /// Distance of rows, um.
    pub dy_um: Option<f64>,
    /// Heights in um, row by row, x fastest; NaN where the file marks a missing point.
    pub heights_um: Vec<f64>,
    /// The instrument, as the file names it.
    pub instrument: Option<String>,
    /// The sources of the units.
    pub sources: Sources,
    /// A note for the user, such as an ignored checksum.
    pub note: Option<String>,
    /// Names of all maps in the file, if its format can hold several; this one is that of the options, or the first.
    pub channels: Vec<String>,
}

impl RawMap {
    /// A map whose units the file says, without a pixel size.
    fn new(format: &'static str, (nx, ny): (usize, usize), heights_um: Vec<f64>) -> Self {
        Self {
            format,
            nx,
            ny,
            dx_um: None,
            dy_um: None,
            heights_um,
            instrument: None,
            sources: Sources::default(),
            note: None,
            channels: Vec::new(),
        }
    }

    /// The map, with a pixel size from elsewhere where the file has none.
    ///
    /// # Errors
    /// [`MapFault::NoPixelSize`] if neither says, or what [`HeightMap::new`] refuses.
    pub fn into_map(self, pixel_um: Option<f64>) -> Result<HeightMap, MapFault> {
        let dx = self.dx_um.or(pixel_um).ok_or(MapFault::NoPixelSize)?;
        let dy = self.dy_um.or(self.dx_um).or(pixel_um).ok_or(MapFault::NoPixelSize)?;
        Ok(HeightMap::new((self.nx, self.ny), (dx, dy), self.heights_um)?)
    }
}
