//! Faults of a height-map file.

use std::path::PathBuf;

use crate::heightmap::HeightMapError;
use crate::message::one_line;

/// A height-map file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct MapError {
    /// The file.
    pub path: PathBuf,
    /// The fault and the remedy.
    pub fault: MapFault,
}

/// The fault; the text ends with the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapFault {
    /// It cannot be opened.
    #[error("cannot be read ({0}); check the path and the permissions")]
    Io(#[from] std::io::Error),
    /// There is nothing in it.
    #[error("the file is empty; export the map again")]
    Empty,
    /// No reader knows it.
    #[error("no known height-map format; export it as one of {known}")]
    Unknown {
        /// Names of the formats.
        known: String,
    },
    /// Nothing that is packed in it is a map.
    #[error(
        "the {format} file holds no known height map{files}; give one of x3p, SDF, al3d, opd or another that \
             `asperity stats --help` lists"
    )]
    NoneInside {
        /// The container.
        format: &'static str,
        /// What is in it: nothing, or `, only ...`.
        files: String,
    },
    /// A file in an archive cannot be used.
    #[error("in `{name}`: {fault}")]
    Inside {
        /// The file.
        name: String,
        /// Its fault.
        fault: Box<MapFault>,
    },
    /// It breaks the rules of its format.
    #[error(
        "{format}: {}; the file is damaged or not of this format, export it again",
        one_line(what)
    )]
    Damaged {
        /// The format.
        format: &'static str,
        /// The fault and its place.
        what: String,
    },
    /// It uses a part of its format that is not supported.
    #[error("{format}: {} is not supported; {remedy}", one_line(what))]
    Unsupported {
        /// The format.
        format: &'static str,
        /// What.
        what: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// More points than allowed.
    #[error("{format}: {nx} x {ny} points are more than {} million; crop the map", MOST_POINTS / 1_000_000)]
    TooLarge {
        /// The format.
        format: &'static str,
        /// Columns.
        nx: u64,
        /// Rows.
        ny: u64,
    },
    /// Compressed content that would inflate too much.
    #[error(
        "{format}: {what} inflates to more than {most} bytes; if this is a map, save it unpacked"
    )]
    Inflates {
        /// The format.
        format: &'static str,
        /// The part of the file.
        what: String,
        /// Most bytes allowed for a file of this size.
        most: u64,
    },
    /// A checksum of what describes the map, not of its points, is not right.
    #[error(
        "{format}: {}; export the map again, or give --ignore-checksum if only the description was corrected",
        one_line(what)
    )]
    Checksum {
        /// The format.
        format: &'static str,
        /// Which and how.
        what: String,
    },
    /// Heights over one line only.
    #[error(
        "{format}: this is a profile, not a map: {}; give heights over x and y",
        one_line(what)
    )]
    Profile {
        /// The format.
        format: &'static str,
        /// The evidence.
        what: String,
    },
    /// The file has no map of the number asked for.
    #[error("{format}: --channel {asked} is not in the file, which has {there}; give one of them")]
    NoChannel {
        /// The format.
        format: &'static str,
        /// The number.
        asked: usize,
        /// The maps in the file.
        there: String,
    },
    /// The units of the numbers are unknown.
    #[error("{format}: the file does not say {}; {}", unsaid(*xy, *z, *pixel), unit_flags(format, *xy, *z, *pixel))]
    NoUnits {
        /// The format.
        format: &'static str,
        /// Whether that of x and y is missing.
        xy: bool,
        /// Whether that of heights is missing.
        z: bool,
        /// Whether the pixel size is missing too.
        pixel: bool,
    },
    /// A flag says another unit than the file.
    #[error("{format}: {says} {flag} contradicts it; leave the flag out")]
    Contradicts {
        /// The format.
        format: &'static str,
        /// The unit already given.
        says: String,
        /// The flag.
        flag: String,
    },
    /// The file gives no pixel size.
    #[error("the file gives no pixel size; give --pixel-um")]
    NoPixelSize,
    /// The numbers make no map.
    #[error("{0}; check the file")]
    Map(#[from] HeightMapError),
}

fn unsaid(xy: bool, z: bool, pixel: bool) -> &'static str {
    match (xy, z, pixel) {
        (true, true, _) => "the units of x and y and of its heights",
        (true, false, _) => "the unit of x and y",
        (false, _, true) => "the unit of its heights, nor its pixel size",
        (false, _, false) => "the unit of its heights",
    }
}

fn unit_flags(format: &str, xy: bool, z: bool, pixel: bool) -> &'static str {
    match (xy, z, pixel) {
        // nobody writes a line into a binary file
        (true, true, _) if !format.ends_with("text") => {
            "give --xy-unit and --z-unit, such as --xy-unit mm --z-unit um"
        }
        (true, true, _) => {
            "give --xy-unit and --z-unit, such as --xy-unit mm --z-unit um, or write a line \
             `# x [mm] y [mm] z [um]` into it"
        }
        (true, false, _) => "give --xy-unit, such as --xy-unit mm",
        (false, _, true) => {
            "give --z-unit, such as --z-unit um, or --z-um, the height of a step of one, and --pixel-um"
        }
        (false, _, false) => {
            "give --z-unit, such as --z-unit um, or --z-um, the height of a step of one"
        }
    }
}

/// Most points of a map that is read: 16384 x 16384.
pub(super) const MOST_POINTS: u64 = 1 << 28;
