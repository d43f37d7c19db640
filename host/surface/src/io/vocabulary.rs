//! The words of text files for units and pixels, English first.

/// The meaning of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Name {
    X,
    Y,
    Lateral,
    Z,
    /// All lengths.
    All,
    Pixel,
    PixelX,
    PixelY,
}

impl Name {
    pub(super) fn is_pixel(self) -> bool {
        matches!(self, Self::Pixel | Self::PixelX | Self::PixelY)
    }
}

/// Words that link names and their unit.
pub(super) const LINKS: [&str; 8] =
    ["in", "are", "is", "as", "given", "measured", "expressed", "stored"];
/// Words of the size of a pixel.
pub(super) const SIZES: [&str; 7] =
    ["size", "sizes", "spacing", "distance", "width", "pitch", "groesse"];
/// Names that are such a size by themselves.
pub(super) const SIZED: [&str; 14] = [
    "pixelsize",
    "pixelsizes",
    "pixelspacing",
    "pixelwidth",
    "pitch",
    "spacing",
    "dx",
    "dy",
    "stepsize",
    "pixelpitch",
    "xstep",
    "ystep",
    "xspacing",
    "yspacing",
];
/// Words that change nothing.
pub(super) const FILL: [&str; 30] = [
    "of",
    "the",
    "and",
    "axis",
    "axes",
    "coordinate",
    "coordinates",
    "position",
    "positions",
    "achse",
    "achsen",
    "koordinate",
    "koordinaten",
    "spalte",
    "spalten",
    "und",
    "sind",
    "werte",
    "column",
    "columns",
    "map",
    "surface",
    "sample",
    "these",
    "here",
    "for",
    "this",
    "file",
    "to",
    "both",
];
/// Words of a number about the map, such as its largest height.
pub(super) const ONE_NUMBER: [&str; 30] = [
    "max",
    "maximum",
    "min",
    "minimum",
    "mean",
    "average",
    "rms",
    "range",
    "std",
    "sigma",
    "peak",
    "valley",
    "full",
    "total",
    "ra",
    "rq",
    "rz",
    "sa",
    "sq",
    "sz",
    "offset",
    "reference",
    "resolution",
    "noise",
    "error",
    "accuracy",
    "working",
    "focal",
    "cutoff",
    "filter",
];
/// Units that are no length.
pub(super) const OTHER_UNITS: [&str; 12] =
    ["v", "mv", "uv", "na", "pa", "nn", "rad", "mrad", "deg", "degree", "degrees", "hz"];
/// Words of a pixel behind a quantity.
pub(super) const PER_PIXEL: [&str; 8] =
    ["pixel", "px", "pix", "pixels", "point", "pt", "sample", "step"];

/// The meaning of a word in lower case.
pub(super) fn name(text: &str) -> Option<Name> {
    Some(match text {
        "x" | "xaxis" | "xpos" | "xposition" | "xcoordinate" | "xcoord" | "xunit" | "xunits" => {
            Name::X
        }
        "y" | "yaxis" | "ypos" | "yposition" | "ycoordinate" | "ycoord" | "yunit" | "yunits" => {
            Name::Y
        }
        "xy" | "lateral" | "laterally" | "horizontal" | "xyunit" | "xyunits" | "lateralunit"
        | "lateralunits" => Name::Lateral,
        "z" | "zaxis" | "zpos" | "zposition" | "zcoordinate" | "zcoord" | "zunit" | "zunits"
        | "height" | "heights" | "heightunit" | "heightunits" | "value" | "values"
        | "valueunit" | "valueunits" | "depth" | "depths" | "elevation" | "elevations"
        | "topography" | "data" | "dataunit" | "zvalue" | "zvalues" | "vertical" | "h\u{f6}he"
        | "h\u{f6}hen" | "hoehe" | "hoehen" => Name::Z,
        "unit" | "units" | "xyz" | "length" | "lengths" | "dimension" | "dimensions"
        | "numbers" | "all" | "everything" | "einheit" | "einheiten" | "l\u{e4}ngen"
        | "laengen" | "alle" | "angaben" => Name::All,
        "pixel" | "px" | "pixelsize" | "pixelsizes" | "pixelspacing" | "pixelwidth"
        | "pixelpitch" | "pitch" | "spacing" | "stepsize" | "step" | "increment" | "sampling" => {
            Name::Pixel
        }
        "dx" | "xstep" | "xspacing" => Name::PixelX,
        "dy" | "ystep" | "yspacing" | "pixelheight" => Name::PixelY,
        _ => return None,
    })
}
