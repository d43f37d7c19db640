//! A method by its name.

use asperity_core::ndf::law::Profile;

use super::{
    GgxMethod, HeightsMethod, MeasuredHybridMethod, MeasuredRayMethod, MeasuredWaveMethod, Method,
    NormalsMethod, Surface,
};
use crate::kirchhoff::WaveOptions;
use crate::measurement::excerpt;
use crate::surface::{Edges, HeightMap};

/// The names of the methods, for messages.
pub const METHODS: [&str; 6] =
    ["ggx", "normals", "heights", "measured-ray", "measured-wave", "measured-hybrid"];

/// The five methods of the paper: what `compare` tries unless told otherwise.
pub const PAPER: [&str; 5] = ["ggx", "normals", "heights", "measured-ray", "measured-wave"];

/// What it takes to make a method.
#[derive(Clone, Copy)]
pub struct Choice<'a> {
    /// Its name.
    pub name: &'a str,
    /// Shape of the law, for methods that have one; gauss if not said.
    pub law: Option<&'a str>,
    /// The body.
    pub surface: Surface,
    /// Which of the optional parameters are wanted.
    pub asked: &'a dyn Fn(&str) -> bool,
    /// The measured map and how it goes on, for methods that need one.
    pub map: Option<(&'a HeightMap, Edges)>,
    /// How waves are sent, for methods that do.
    pub wave: Option<&'a WaveOptions>,
    /// Seed of the heights, for methods that draw them.
    pub seed: u64,
}

impl std::fmt::Debug for Choice<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Choice").field("name", &self.name).finish_non_exhaustive()
    }
}

impl<'a> Choice<'a> {
    /// Whether a method of this name uses a height map.
    pub fn needs_map(name: &str) -> bool {
        matches!(name, "measured-ray" | "measured-wave" | "measured-hybrid")
    }

    /// Whether a method of this name sends waves, and needs their length.
    pub fn is_wave(name: &str) -> bool {
        matches!(name, "measured-wave" | "measured-hybrid")
    }

    /// Whether a method of this name knows speckle as an average only.
    pub fn is_averaged(name: &str) -> bool {
        name == "measured-hybrid"
    }

    /// Whether a method of this name has a law.
    pub fn has_law(name: &str) -> bool {
        matches!(name, "normals" | "heights")
    }

    /// A method for a body, nothing optional asked for.
    pub fn new(name: &'a str, surface: Surface) -> Self {
        Self { name, law: None, surface, asked: &|_| false, map: None, wave: None, seed: 1 }
    }

    fn need_map(&self) -> Result<(&'a HeightMap, Edges), String> {
        self.map.ok_or_else(|| format!("method {} needs a height map; give --map FILE", self.name))
    }

    fn need_wave(&self) -> Result<WaveOptions, String> {
        let missing = || format!("method {} needs --wavelength-nm; give it in nm", self.name);
        self.wave.cloned().ok_or_else(missing)
    }

    /// The method.
    ///
    /// # Errors
    /// With the names that exist, or what the method lacks.
    pub fn method(&self) -> Result<Box<dyn Method>, String> {
        let profile = match self.law {
            None | Some("gauss") => Profile::Gauss,
            Some("cauchy") => Profile::Cauchy,
            Some(other) => {
                return Err(format!("law `{}` is unknown; write gauss or cauchy", excerpt(other)));
            }
        };
        if self.surface == Surface::Opaque && self.name != "ggx" && METHODS.contains(&self.name) {
            return Err(format!(
                "method {} needs a dielectric with a refractive index; an opaque body can be \
                 described with ggx",
                self.name
            ));
        }
        match self.name {
            "ggx" => Ok(Box::new(GgxMethod::new(self.surface))),
            "normals" => Ok(Box::new(NormalsMethod { profile, centre: (self.asked)("theta0") })),
            "heights" => Ok(Box::new(HeightsMethod::new(profile, self.seed, self.asked))),
            "measured-ray" => {
                let (map, edges) = self.need_map()?;
                MeasuredRayMethod::new(map, edges, (self.asked)("cutoff_um"))
                    .map(|m| Box::new(m) as Box<dyn Method>)
                    .map_err(|e| e.to_string())
            }
            "measured-wave" => {
                let (map, edges) = self.need_map()?;
                MeasuredWaveMethod::new(map, edges, (self.asked)("cutoff_um"), self.need_wave()?)
                    .map(|m| Box::new(m) as Box<dyn Method>)
                    .map_err(|e| e.to_string())
            }
            "measured-hybrid" => {
                let (map, edges) = self.need_map()?;
                MeasuredHybridMethod::new(map, edges, (self.asked)("cutoff_um"), self.need_wave()?)
                    .map(|m| Box::new(m) as Box<dyn Method>)
                    .map_err(|e| e.to_string())
            }
            other => Err(format!(
                "method `{}` is unknown; the methods are {}",
                excerpt(other),
                METHODS.join(", ")
            )),
        }
    }
}
