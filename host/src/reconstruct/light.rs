//! The light of methods that send waves, as far as it is known, and the ways they may treat the speckle of a map.

use crate::kirchhoff::{Shadowing, Speckle, WaveBoundary, WaveOptions, Wavelengths};
use crate::method::{Kind, Waves, in_words};
use crate::surface::{Edges, HeightMap};

/// Points of a map that waves are sent on at most: 8192 x 8192, some 3 GB.
const MOST_POINTS: usize = 1 << 26;

/// The light as far as it is known.
#[derive(Clone, Debug, Default)]
pub struct Light {
    /// The wavelengths and their weights.
    pub wavelengths: Option<Wavelengths>,
    /// What becomes of the speckle; `None`: all ways that the map allows are tried.
    pub speckle: Option<Speckle>,
    /// Smith's shadowing; `None`: where the surface is steep and rough.
    pub shadowing: Option<Shadowing>,
}

/// Why no waves can be sent on a map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unlit {
    /// The wavelength is not known.
    #[error("waves have a length")]
    NoWavelength,
    /// A map that would take too much memory.
    #[error("{nx} x {ny} points are too many for waves (at most {MOST_POINTS})")]
    TooLarge {
        /// Points along x.
        nx: usize,
        /// Points along y.
        ny: usize,
    },
    /// A method that averages, for a surface that has a direction, or with its speckle kept.
    #[error(
        "method {} averages the speckle over azimuths: the surface must have no direction, and speckle `{}` is not for it",
        in_words(&Kind::names(|kind| kind.waves == Waves::AveragedSpeckle)),
        .0.name()
    )]
    OnlyAverages(Speckle),
    /// A surface with a direction, whose speckle was to be averaged.
    #[error("the surface has a direction: its speckle cannot be averaged over azimuths")]
    HasDirection,
}

impl Light {
    /// Light of given wavelengths.
    pub fn of(wavelengths: Wavelengths) -> Self {
        Self { wavelengths: Some(wavelengths), ..Self::default() }
    }

    /// Whether anything is said.
    pub fn is_known(&self) -> bool {
        self.wavelengths.is_some() || self.speckle.is_some() || self.shadowing.is_some()
    }

    /// The options of waves with one way to treat the speckle.
    fn options(&self, speckle: Speckle) -> Result<WaveOptions, Unlit> {
        Ok(WaveOptions {
            wavelengths: self.wavelengths.clone().ok_or(Unlit::NoWavelength)?,
            speckle,
            shadowing: self.shadowing.unwrap_or(Shadowing::Auto),
        })
    }

    /// The ways of a method to treat the speckle of a map: the one that is asked for, else all that it allows.
    ///
    /// # Errors
    /// [`Unlit`].
    pub fn variants(
        &self,
        waves: Waves,
        map: Option<(&HeightMap, Edges)>,
    ) -> Result<Vec<WaveOptions>, Unlit> {
        if let Some((map, _)) = map.filter(|(map, _)| map.nx() * map.ny() > MOST_POINTS) {
            return Err(Unlit::TooLarge { nx: map.nx(), ny: map.ny() });
        }
        let may_average = map.is_none_or(|(map, edges)| WaveBoundary::may_average(map, edges));
        let is_mirrored = map.is_some_and(|m| m.1 == Edges::Mirrored);
        if waves == Waves::AveragedSpeckle {
            let other = self.speckle.filter(|s| *s != Speckle::Averaged);
            if other.is_some() || !may_average {
                return Err(Unlit::OnlyAverages(other.unwrap_or(Speckle::Kept)));
            }
            return Ok(vec![self.options(Speckle::Averaged)?]);
        }
        let speckles: &[Speckle] = match &self.speckle {
            Some(Speckle::Averaged) if !may_average => return Err(Unlit::HasDirection),
            Some(asked) => std::slice::from_ref(asked),
            None => match (may_average, is_mirrored) {
                (true, false) => &[Speckle::Averaged, Speckle::Kept],
                (false, false) => &[Speckle::Kept],
                (true, true) => &[Speckle::Averaged, Speckle::Kept, Speckle::Patch],
                (false, true) => &[Speckle::Kept, Speckle::Patch],
            },
        };
        speckles.iter().map(|speckle| self.options(*speckle)).collect()
    }

    /// The one way to treat the speckle of a map: the one that is asked for, else the first of `usual` that it allows.
    ///
    /// # Errors
    /// [`Unlit`].
    pub fn variant(
        &self,
        waves: Waves,
        map: (&HeightMap, Edges),
        usual: &[Speckle],
    ) -> Result<WaveOptions, Unlit> {
        let mut variants = self.variants(waves, Some(map))?;
        let found = usual.iter().find_map(|s| variants.iter().position(|v| v.speckle == *s));
        // there is always one
        Ok(variants.swap_remove(found.unwrap_or(0)))
    }
}
