//! Units and pixel size from the words of a text file.
//!
//! Comments, lines of names and lines of words are read alike. A unit belongs to what is named in front of it:
//! ```text
//! # x [um] y [um] z [nm]            X_um;Y_um;Height_nm             x, y in mm, z in um
//! # Lateral units: m                # Heights in nm                 # Units: um
//! # pixel size: 0.5 um              # dx [um] = 0.5, dy [um] = 0.25 # 0.5 um/pixel
//! ```
//! A unit between brackets belongs to the one name before it, any other to all that are listed. A unit behind a
//! number is that of a quantity, and counts for a pixel size alone: `wavelength 550 nm` says nothing of the map.
//! Words that are not understood are ignored.

use super::MapFault;
use super::options::Stated;
use super::unit::LengthUnit;
use super::vocabulary::Name;

/// The findings so far.
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
pub(super) struct Place {
    pub(super) unit: Option<LengthUnit>,
    /// Why it cannot be used: two units, or none of length.
    pub(super) wrong: Option<String>,
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

impl Said {
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

    pub(super) fn set(&mut self, name: Name, unit: LengthUnit) {
        for place in self.of(name) {
            match place.unit {
                Some(before) if before != unit => {
                    place.wrong = Some(format!("a unit that is once {before} and once {unit}"));
                }
                _ => place.unit = Some(unit),
            }
        }
    }

    pub(super) fn of(&mut self, name: Name) -> Vec<&mut Place> {
        match name {
            Name::X => vec![&mut self.x],
            Name::Y => vec![&mut self.y],
            Name::Lateral => vec![&mut self.x, &mut self.y],
            Name::Z => vec![&mut self.z],
            Name::All => vec![&mut self.all],
            Name::Pixel | Name::PixelX | Name::PixelY => Vec::new(),
        }
    }

    pub(super) fn set_pitch(&mut self, axis: usize, value: f64, unit: Option<LengthUnit>) {
        let Some(place) = self.pitch.get_mut(axis) else { return };
        let new = Pitch { value, unit };
        self.two_sizes |= place.is_some_and(|before| before != new);
        *place = Some(new);
    }
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
            ("1: x [um] 2: y [um] 3: z [nm]", "um um nm"),
            ("Einheit: \u{b5}m", "um um um"),
            ("Einheiten: mm, mm, \u{b5}m", "mm mm um"),
            ("Einheit X: mm\nEinheit Z: \u{b5}m", "mm mm um"),
            ("X-Achse in mm; Y-Achse in mm; Z-Achse in \u{b5}m", "mm mm um"),
            ("x-Koordinate [mm];y-Koordinate [mm];H\u{f6}he [\u{b5}m]", "mm mm um"),
            ("alle Angaben in \u{b5}m", "um um um"),
            ("L\u{e4}ngen in mm", "mm mm mm"),
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
