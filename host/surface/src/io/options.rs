//! Information that a file may lack and the user can give, above all units. They are never guessed.

use super::unit::LengthUnit;
use super::{MapFault, RawMap};

/// Information from the user about a file. Limits are not options: 2^28 points, files of 4 GiB, and for compressed
/// content 64 MiB and 256 times the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpenOptions {
    /// Pixel size in um, for files that give none.
    pub pixel_um: Option<f64>,
    /// Unit of the lateral numbers of a file that does not say it.
    pub xy_unit: Option<LengthUnit>,
    /// Unit of the heights of a file that does not say it.
    pub z_unit: Option<LengthUnit>,
    /// Height of a step of one in um, for files of counts or of numbers without a unit.
    pub z_um: Option<f64>,
    /// Whether an x3p file whose `main.xml` is not that of its checksum is read all the same.
    pub ignore_checksum: bool,
    /// Number from 0 of the map in a file of several; by default the first.
    pub channel: Option<usize>,
}

/// The source of the units of the lateral numbers or of the heights of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Source {
    /// The file, or the standard of its format.
    #[default]
    File,
    /// The user.
    User,
    /// This program's documentation, for arrays: um.
    Documentation,
}

/// The sources of the units of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sources {
    /// Of the pixel size, if there is one.
    pub xy: Source,
    /// Of the heights.
    pub z: Source,
}

/// The units that a file gives; `None` where it gives none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stated {
    pub(super) x: Option<LengthUnit>,
    pub(super) y: Option<LengthUnit>,
    pub(super) z: Option<LengthUnit>,
}

/// Micrometres per unit, and their source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    pub(super) um: f64,
    pub(super) source: Source,
}

/// The scales of a list of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scales {
    pub(super) x: Scale,
    pub(super) y: Scale,
    pub(super) z: Scale,
}

impl OpenOptions {
    /// The scale of heights: of the file if it says one, else of the user.
    ///
    /// `pixel_is_missing` only serves the message.
    pub(super) fn heights(
        &self,
        format: &'static str,
        stated: Option<LengthUnit>,
        pixel_is_missing: bool,
    ) -> Result<Scale, MapFault> {
        let unknown = MapFault::NoUnits { format, xy: false, z: true, pixel: pixel_is_missing };
        self.vertical(format, stated)?.ok_or(unknown)
    }

    /// The scale of heights that are in um by this program's documentation, unless the user says otherwise.
    pub(super) fn heights_or_um(&self, format: &'static str) -> Result<Scale, MapFault> {
        let um = Scale { um: 1.0, source: Source::Documentation };
        Ok(self.vertical(format, None)?.unwrap_or(um))
    }

    fn vertical(
        &self,
        format: &'static str,
        stated: Option<LengthUnit>,
    ) -> Result<Option<Scale>, MapFault> {
        if let (Some(unit), Some(um)) = (self.z_unit, self.z_um)
            && !is_same(unit.um(), um)
        {
            let says = format!("--z-unit {unit}, where");
            return Err(MapFault::Contradicts { format, says, flag: format!("--z-um {um}") });
        }
        let given = self.z_um.or(self.z_unit.map(LengthUnit::um));
        let Some(unit) = stated else {
            return Ok(given.map(|um| Scale { um, source: Source::User }));
        };
        if given.is_some_and(|um| !is_same(unit.um(), um)) {
            let says = format!("the file says that heights are in {unit};");
            return Err(MapFault::Contradicts { format, says, flag: self.z_flag() });
        }
        Ok(Some(Scale { um: unit.um(), source: Source::File }))
    }

    /// The scale of lateral numbers; `None` if neither the file nor the user says.
    pub(super) fn lateral(
        &self,
        format: &'static str,
        stated: Option<LengthUnit>,
    ) -> Result<Option<Scale>, MapFault> {
        match (stated, self.xy_unit) {
            (Some(stated), Some(given)) if !is_same(stated.um(), given.um()) => {
                let says = format!("the file says that x and y are in {stated};");
                Err(MapFault::Contradicts { format, says, flag: format!("--xy-unit {given}") })
            }
            (Some(unit), _) => Ok(Some(Scale { um: unit.um(), source: Source::File })),
            (None, Some(unit)) => Ok(Some(Scale { um: unit.um(), source: Source::User })),
            (None, None) => Ok(None),
        }
    }

    /// The scales of points whose columns are `pitch_x` apart in the file's own numbers.
    ///
    /// A pixel size from the user says the lateral unit as well.
    pub(super) fn points(
        &self,
        format: &'static str,
        stated: Stated,
        pitch_x: f64,
    ) -> Result<Scales, MapFault> {
        let pixel = self.pixel_um.map(|um| Scale { um: um / pitch_x, source: Source::User });
        let x = self.lateral(format, stated.x)?.or(pixel);
        let y = self.lateral(format, stated.y)?.or(pixel);
        match (x, y, self.vertical(format, stated.z)?) {
            (Some(x), Some(y), Some(z)) => Ok(Scales { x, y, z }),
            (x, y, z) => {
                let xy = x.is_none() || y.is_none();
                Err(MapFault::NoUnits { format, xy, z: z.is_none(), pixel: false })
            }
        }
    }

    /// A map whose format has units of its own: flags must not say anything else.
    ///
    /// `unit` is that of the format, if it is the same for all files.
    pub(super) fn agree(&self, map: RawMap, unit: Option<LengthUnit>) -> Result<RawMap, MapFault> {
        let differs = |um: f64| unit.is_none_or(|own| !is_same(own.um(), um));
        let z = self.z_um.or(self.z_unit.map(LengthUnit::um));
        let (xy, z) = (self.xy_unit.is_some_and(|u| differs(u.um())), z.is_some_and(differs));
        if !(xy || z) {
            return Ok(map);
        }
        let of = unit.map(|u| format!(", {u}")).unwrap_or_default();
        let flag = if z { self.z_flag() } else { self.xy_flag() };
        let says = format!("the file has its own units{of};");
        Err(MapFault::Contradicts { format: map.format, says, flag })
    }

    /// Refuses a lateral unit where the file has no lateral numbers.
    pub(super) fn no_lateral_numbers(&self, format: &'static str) -> Result<(), MapFault> {
        if self.xy_unit.is_none() {
            return Ok(());
        }
        Err(MapFault::Unsupported {
            format,
            what: format!("{} of a file without a pixel size", self.xy_flag()),
            remedy: "give --pixel-um instead",
        })
    }

    fn z_flag(&self) -> String {
        match (self.z_um, self.z_unit) {
            (Some(um), _) => format!("--z-um {um}"),
            (None, Some(unit)) => format!("--z-unit {unit}"),
            (None, None) => String::new(),
        }
    }

    fn xy_flag(&self) -> String {
        self.xy_unit.map(|unit| format!("--xy-unit {unit}")).unwrap_or_default()
    }
}

/// Whether two scales are the same but for rounding.
fn is_same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs()
}
