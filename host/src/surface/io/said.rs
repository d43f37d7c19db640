//! What the words of a text file say of its units and its pixel size.
//!
//! Comments, lines of names and lines of words are read alike. A unit belongs to what is named in front of it:
//! ```text
//! # x [um] y [um] z [nm]            X_um;Y_um;Height_nm             x, y in mm, z in um
//! # Lateral units: m                # Heights in nm                 # Units: um
//! # pixel size: 0.5 um              # dx [um] = 0.5, dy [um] = 0.25 # 0.5 um/pixel
//! ```
//! A unit between brackets belongs to the one name before it, any other to all that are listed. A unit behind a
//! number is that of a quantity, and counts for a pixel size alone: `wavelength 550 nm` says nothing of the map. What
//! is not understood is not said.

use super::MapFault;
use super::options::Stated;
use super::unit::LengthUnit;
use super::words::{Token, tokens};

/// What was found so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Said {
    x: Place,
    y: Place,
    z: Place,
    all: Place,
    pitch: [Option<Pitch>; 2],
    /// Whether two pixel sizes were said.
    two_sizes: bool,
}

/// The unit of something.
#[derive(Clone, Debug, Default)]
struct Place {
    unit: Option<LengthUnit>,
    /// Why it cannot be used: two units, or none of length.
    wrong: Option<String>,
}

impl Place {
    fn or<'a>(&'a self, other: &'a Self) -> &'a Self {
        if self.unit.is_some() || self.wrong.is_some() { self } else { other }
    }

    fn get(&self) -> Option<LengthUnit> {
        self.unit.filter(|_| self.wrong.is_none())
    }
}

/// A distance of points, with its unit if that stands beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pitch {
    pub(super) value: f64,
    pub(super) unit: Option<LengthUnit>,
}

/// What a word names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Name {
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
    fn is_pixel(self) -> bool {
        matches!(self, Self::Pixel | Self::PixelX | Self::PixelY)
    }
}

impl Said {
    /// Takes a line in, and says whether anything was understood.
    pub(super) fn take(&mut self, line: &str) -> bool {
        let tokens = tokens(line);
        if let Some(units) = only_units(&tokens) {
            match *units.as_slice() {
                [unit] => self.set(Name::All, unit),
                [x, y, z] => {
                    for (name, unit) in [(Name::X, x), (Name::Y, y), (Name::Z, z)] {
                        self.set(name, unit);
                    }
                }
                _ => return false,
            }
            return true;
        }
        Line::new(self).read(&tokens)
    }

    /// The units; none where the file speaks against itself.
    pub(super) fn units(&self) -> Stated {
        let [x, y, z] = self.places();
        Stated { x: x.get(), y: y.get(), z: z.get() }
    }

    fn places(&self) -> [&Place; 3] {
        let (x, y) = (self.x.or(&self.y), self.y.or(&self.x));
        [x.or(&self.all), y.or(&self.all), self.z.or(&self.all)]
    }

    /// The distances of columns and rows.
    pub(super) fn pitch(&self) -> [Option<Pitch>; 2] {
        let [x, y] = self.pitch;
        if self.two_sizes { [None; 2] } else { [x, y.or(x)] }
    }

    /// A fault with what the file says instead of the units that are missing.
    pub(super) fn explain(&self, fault: MapFault) -> MapFault {
        let MapFault::NoUnits { format, .. } = fault else { return fault };
        match self.places().iter().find_map(|place| place.wrong.clone()) {
            Some(what) => MapFault::Unsupported {
                format,
                what,
                remedy: "export heights over lengths, or give the units by --xy-unit and --z-unit",
            },
            None => fault,
        }
    }

    fn set(&mut self, name: Name, unit: LengthUnit) {
        for place in self.of(name) {
            match place.unit {
                Some(before) if before != unit => {
                    place.wrong = Some(format!("a unit that is once {before} and once {unit}"));
                }
                _ => place.unit = Some(unit),
            }
        }
    }

    fn of(&mut self, name: Name) -> Vec<&mut Place> {
        match name {
            Name::X => vec![&mut self.x],
            Name::Y => vec![&mut self.y],
            Name::Lateral => vec![&mut self.x, &mut self.y],
            Name::Z => vec![&mut self.z],
            Name::All => vec![&mut self.all],
            Name::Pixel | Name::PixelX | Name::PixelY => Vec::new(),
        }
    }

    fn set_pitch(&mut self, axis: usize, value: f64, unit: Option<LengthUnit>) {
        let Some(place) = self.pitch.get_mut(axis) else { return };
        let new = Pitch { value, unit };
        self.two_sizes |= place.is_some_and(|before| before != new);
        *place = Some(new);
    }
}

/// The units of a line of nothing else.
fn only_units(tokens: &[Token]) -> Option<Vec<LengthUnit>> {
    let tokens = tokens.iter().filter(|t| **t != Token::Comma);
    let units: Option<Vec<_>> =
        tokens.map(|t| if let Token::Unit { unit, .. } = t { Some(*unit) } else { None }).collect();
    units.filter(|units| !units.is_empty())
}

/// A line on its way.
#[expect(clippy::struct_excessive_bools, reason = "each says what stood before in the line")]
struct Line<'a> {
    said: &'a mut Said,
    /// What was named since the last unit.
    names: Vec<Name>,
    /// Whether a word or sign says that a unit comes for all of them.
    linked: bool,
    /// Whether the next name is that of one number, such as the largest height.
    veto: bool,
    /// Numbers since the last name or unit.
    numbers: Vec<f64>,
    /// Whether it was of pixels before.
    about_pixels: bool,
    /// Whether a number is a distance of points even without a unit.
    sized: bool,
    /// Whether a second distance may follow.
    second: bool,
    understood: bool,
}

impl<'a> Line<'a> {
    fn new(said: &'a mut Said) -> Self {
        Self {
            said,
            names: Vec::new(),
            linked: false,
            veto: false,
            numbers: Vec::new(),
            about_pixels: false,
            sized: false,
            second: false,
            understood: false,
        }
    }

    fn read(mut self, tokens: &[Token]) -> bool {
        let mut rest = tokens;
        while let Some((token, behind)) = rest.split_first() {
            rest = behind;
            match token {
                Token::Number(value) => self.numbers.push(*value),
                Token::Assign => self.linked = true,
                Token::Comma => {}
                Token::Word { text, bracketed } => self.word(text, *bracketed),
                Token::Unit { unit, bracketed } => {
                    let more = run(rest);
                    if self.numbers.is_empty() && !more.is_empty() {
                        rest = rest
                            .iter()
                            .position(not_listed)
                            .and_then(|k| rest.get(k..))
                            .unwrap_or_default();
                        self.list(&[&[*unit], more.as_slice()].concat());
                    } else if self.numbers.is_empty() {
                        let values = values_behind(rest);
                        self.unit(*unit, *bracketed, &values);
                    } else {
                        self.quantity(*unit, rest);
                    }
                }
            }
        }
        if self.sized && self.names.iter().any(|n| n.is_pixel()) {
            self.pitches(None);
        }
        self.understood
    }

    fn word(&mut self, text: &str, bracketed: bool) {
        self.second = false;
        if let Some(name) = name(text) {
            self.name(name, text);
        } else if LINKS.contains(&text) {
            self.linked = true;
        } else if SIZES.contains(&text) {
            self.sized = self.about_pixels;
            self.sharpen(text, "width", Name::PixelX);
        } else if ONE_NUMBER.contains(&text) {
            self.forget();
            self.veto = true;
        } else if !FILL.contains(&text) {
            let is_unit = (bracketed || self.linked) && OTHER_UNITS.contains(&text);
            if is_unit && self.numbers.is_empty() && !self.veto {
                for name in std::mem::take(&mut self.names) {
                    for place in self.said.of(name) {
                        place.wrong = Some(format!("the unit `{text}`"));
                        self.understood = true;
                    }
                }
            }
            self.forget();
        }
    }

    fn name(&mut self, name: Name, text: &str) {
        // `z unit`: the word goes with the name before it
        if name == Name::All && !self.names.is_empty() {
            self.linked = true;
            return;
        }
        if self.sharpen(text, "height", Name::PixelY) {
            return;
        }
        self.numbers.clear();
        self.linked = false;
        if name.is_pixel() {
            self.about_pixels = true;
            self.sized |= SIZED.contains(&text);
        }
        self.names.push(name);
    }

    /// Makes of a pixel its width or height, and says whether it did.
    fn sharpen(&mut self, text: &str, wanted: &str, to: Name) -> bool {
        match self.names.last_mut() {
            Some(last) if *last == Name::Pixel && text == wanted => {
                *last = to;
                self.sized = true;
                true
            }
            _ => false,
        }
    }

    fn forget(&mut self) {
        self.names.clear();
        self.numbers.clear();
        self.linked = false;
        self.sized = false;
    }

    /// A unit without a number before it; `values` are the numbers behind it.
    fn unit(&mut self, unit: LengthUnit, bracketed: bool, values: &[f64]) {
        if self.names.iter().any(|n| n.is_pixel()) {
            // `pixel size [um]: 0.5`
            self.numbers = values.to_vec();
            self.pitches(Some(unit));
        } else if values.is_empty() && !self.veto {
            let all = self.linked && !bracketed;
            let from = if all { 0 } else { self.names.len().saturating_sub(1) };
            let names = self.names.split_off(from);
            self.set(&names, |_| unit);
        }
        self.veto = false;
        self.forget();
    }

    /// As many units as names, in their order.
    fn list(&mut self, units: &[LengthUnit]) {
        let mut names = std::mem::take(&mut self.names);
        names.retain(|n| *n != Name::All);
        if names.len() == units.len() && !self.veto {
            self.set(&names, |k| units.get(k).copied().unwrap_or(LengthUnit::Metre));
        }
        self.veto = false;
        self.forget();
    }

    /// Sets the units of names; `all` beside others means these others.
    fn set(&mut self, names: &[Name], unit: impl Fn(usize) -> LengthUnit) {
        let others = names.iter().any(|n| *n != Name::All);
        for (k, name) in names.iter().enumerate() {
            if *name != Name::All || !others {
                self.said.set(*name, unit(k));
                self.understood = true;
            }
        }
    }

    /// A unit behind numbers: counts for the distance of points only.
    fn quantity(&mut self, unit: LengthUnit, rest: &[Token]) {
        let named = self.names.iter().any(|n| n.is_pixel());
        let axis = !self.names.is_empty()
            && self.about_pixels
            && self.names.iter().all(|n| matches!(n, Name::X | Name::Y));
        let second = self.second && self.names.is_empty();
        let counts = (named || axis || second || is_per_pixel(rest)) && !self.veto;
        if counts {
            if second {
                self.names.push(Name::PixelY);
            }
            self.about_pixels = true;
            self.pitches(Some(unit));
        }
        self.veto = false;
        self.forget();
        self.second = counts && !second;
    }

    /// The numbers as distances of points.
    fn pitches(&mut self, unit: Option<LengthUnit>) {
        let has = |wanted: &[Name]| self.names.iter().any(|n| wanted.contains(n));
        if has(&[Name::Z]) {
            return;
        }
        let (x, y) = (has(&[Name::X, Name::PixelX]), has(&[Name::Y, Name::PixelY]));
        match *self.numbers.as_slice() {
            [value] => self.said.set_pitch(usize::from(y && !x), value, unit),
            [first, second] if x == y => {
                self.said.set_pitch(0, first, unit);
                self.said.set_pitch(1, second, unit);
            }
            _ => return,
        }
        self.understood = true;
    }
}

/// Whether what follows a quantity says that it is that of a pixel.
fn is_per_pixel(rest: &[Token]) -> bool {
    let word = |k: usize| match rest.get(k) {
        Some(Token::Word { text, .. }) => text.as_str(),
        _ => "",
    };
    PER_PIXEL.contains(&word(0)) || (word(0) == "per" && PER_PIXEL.contains(&word(1)))
}

/// Whether a token ends a list of units.
fn not_listed(token: &Token) -> bool {
    !matches!(token, Token::Unit { .. } | Token::Comma)
}

/// The units that follow at once, commas apart.
fn run(rest: &[Token]) -> Vec<LengthUnit> {
    let listed = rest.iter().take_while(|t| !not_listed(t));
    listed
        .filter_map(|t| if let Token::Unit { unit, .. } = t { Some(*unit) } else { None })
        .collect()
}

/// The numbers that follow at once, behind a sign or none, commas apart.
fn values_behind(rest: &[Token]) -> Vec<f64> {
    let rest = if let [Token::Assign, rest @ ..] = rest { rest } else { rest };
    if !matches!(rest.first(), Some(Token::Number(_))) {
        return Vec::new();
    }
    let listed = rest.iter().take_while(|t| matches!(t, Token::Number(_) | Token::Comma));
    listed.filter_map(|t| if let Token::Number(value) = t { Some(*value) } else { None }).collect()
}

/// Words that link names and their unit.
const LINKS: [&str; 10] =
    ["in", "are", "is", "as", "given", "measured", "expressed", "stored", "einheit", "einheiten"];
/// Words of the size of a pixel.
const SIZES: [&str; 7] = ["size", "sizes", "spacing", "distance", "width", "pitch", "groesse"];
/// Names that are such a size by themselves.
const SIZED: [&str; 14] = [
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
const FILL: [&str; 21] = [
    "of",
    "the",
    "and",
    "axis",
    "axes",
    "coordinate",
    "coordinates",
    "position",
    "positions",
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
const ONE_NUMBER: [&str; 30] = [
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
const OTHER_UNITS: [&str; 12] =
    ["v", "mv", "uv", "na", "pa", "nn", "rad", "mrad", "deg", "degree", "degrees", "hz"];
/// Words of a pixel behind a quantity.
const PER_PIXEL: [&str; 8] = ["pixel", "px", "pix", "pixels", "point", "pt", "sample", "step"];

fn name(text: &str) -> Option<Name> {
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
        | "numbers" | "all" | "everything" => Name::All,
        "pixel" | "px" | "pixelsize" | "pixelsizes" | "pixelspacing" | "pixelwidth"
        | "pixelpitch" | "pitch" | "spacing" | "stepsize" | "step" | "increment" | "sampling" => {
            Name::Pixel
        }
        "dx" | "xstep" | "xspacing" => Name::PixelX,
        "dy" | "ystep" | "yspacing" | "pixelheight" => Name::PixelY,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::Said;

    /// The units of x, y, z and the pitches, as a short text.
    fn said(text: &str) -> String {
        let mut said = Said::default();
        for line in text.lines() {
            said.take(line);
        }
        let units = said.units();
        let units = [units.x, units.y, units.z].map(|u| u.map_or("-", |u| u.name())).join(" ");
        let [dx, dy] = said.pitch().map(|p| match p {
            Some(p) => format!(" {}{}", p.value, p.unit.map_or("?", |u| u.name())),
            None => String::new(),
        });
        format!("{units}{dx}{dy}")
    }

    #[test]
    fn units_are_read_in_their_usual_spellings() {
        for (text, expected) in [
            ("x [um] y [um] z [um]", "um um um"),
            ("x(mm)\ty(mm)\tz(\u{3bc}m)", "mm mm um"),
            ("X_um;Y_um;Height_nm", "um um nm"),
            ("x/mm, y/mm, z/um", "mm mm um"),
            ("\"X {micron}\" \"Y {micron}\" \"Z {micron}\"", "um um um"),
            ("x um y um z nm", "um um nm"),
            ("x, um; y, um; z, nm", "um um nm"),
            ("X-axis [m]  Y-axis [m]  Z-axis [m]", "m m m"),
            ("x, y in mm, z in um", "mm mm um"),
            ("x, y [mm], z [um]", "mm mm um"),
            ("x y z in micrometres", "um um um"),
            ("Units: x, y mm; z um", "mm mm um"),
            ("x y z\num um nm", "um um nm"),
            ("units (x, y, z): um, um, nm", "um um nm"),
            ("Lateral units: mm\nx;y;z [um]", "mm mm um"),
            ("Lateral units: m\nValue units: nm", "m m nm"),
            ("XY unit = mm\nz-unit: \u{b5}m", "mm mm um"),
            ("all lengths in metres", "m m m"),
            ("Units: um", "um um um"),
            ("unit nm", "nm nm nm"),
            ("Heights in nm", "- - nm"),
            ("all heights are given in nm", "- - nm"),
            ("Height units: nm", "- - nm"),
            ("heights in nm, pixel 1.634 um", "- - nm 1.634um 1.634um"),
            ("Topography (\u{c5})", "- - angstrom"),
            ("height_um", "- - um"),
            ("z in inches", "- - inch"),
            ("x [in], y [in], z [uin]", "inch inch uin"),
        ] {
            assert_eq!(said(text), expected, "{text}");
        }
    }

    #[test]
    fn a_pixel_size_needs_its_unit_beside_it() {
        for (text, expected) in [
            ("Pixel size: 0.5 \u{b5}m", "- - - 0.5um 0.5um"),
            ("pixel size [nm]: 500", "- - - 500nm 500nm"),
            ("pixel_size_um = 0.5", "- - - 0.5um 0.5um"),
            ("pixel size = 0.5 x 0.25 um", "- - - 0.5um 0.25um"),
            ("Pixel size: 0.5 um x 0.25 um", "- - - 0.5um 0.25um"),
            ("pixel size x: 0.5 um, y: 0.25 um", "- - - 0.5um 0.25um"),
            ("pixel width 0.5 um\npixel height 0.25 um", "- - - 0.5um 0.25um"),
            ("dx = 0,5 um, dy = 0,25 um", "- - - 0.5um 0.25um"),
            ("dx=dy=0.5um", "- - - 0.5um 0.5um"),
            ("x step 0.5 um; y step 0.25 um", "- - - 0.5um 0.25um"),
            ("Scale: 0.5 um/px", "- - - 0.5um 0.5um"),
            ("0.5 um per pixel", "- - - 0.5um 0.5um"),
            ("pixel size 0.5", "- - - 0.5? 0.5?"),
            ("lateral unit: um\npixel size: 0.5", "um um - 0.5? 0.5?"),
            ("pixel size 0.5 um, wavelength 0.55 um", "- - - 0.5um 0.5um"),
        ] {
            assert_eq!(said(text), expected, "{text}");
        }
    }

    #[test]
    fn what_is_said_of_something_else_is_not_said_of_the_map() {
        for text in [
            "wavelength 550 nm",
            "wavelength (nm): 550",
            "Height: 100 um",
            "max height [um]: 3.2",
            "maximum height in nm",
            "Rq [nm] 34",
            "z range (nm) -3 3",
            "z step 0.1 um",
            "lateral resolution 0.4 um",
            "cutoff 0.8 mm",
            "512 x 512 pixels",
            "stored in a file",
            "heights",
            "z in volts",
            "it was a dark and stormy night",
            "height above the stage of the microscope in mm",
            "2 px/um",
        ] {
            assert_eq!(said(text), "- - -", "{text}");
        }
        // what speaks against itself is asked for
        assert_eq!(said("heights in nm\nz unit: um"), "- - -");
        assert_eq!(said("Units: um\nValue units: V"), "um um -");
        assert_eq!(said("pixel size 0.5 um\npixel size 0.6 um"), "- - -");
    }
}
