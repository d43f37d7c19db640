//! A scan with its map and light, as every method is fitted to it: the common part of `compare` and `trade`.

use std::path::{Path, PathBuf};

use super::clean::CleanFlags;
use super::effort::EffortFlags;
use super::light::LightFlags;
use super::map::MapFlags;
use super::nuisance::NuisanceFlags;
use super::scan::{ReadFlags, SetupFlags};
use crate::cli::error::{Failure, without_effect};
use crate::fit::FitOptions;
use crate::forward::Setup;
use crate::measurement::Measurement;
use crate::method::Kind;
use crate::provenance::InputFile;
use crate::reconstruct::{Light, Task};
use crate::surface::Prepared;

/// All flags of a sample.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct SampleFlags {
    #[command(flatten)]
    pub(in crate::cli) effort: EffortFlags,
    #[command(flatten)]
    nuisance: NuisanceFlags,
    #[command(flatten)]
    setup: SetupFlags,
    #[command(flatten)]
    light: LightFlags,
    #[command(flatten)]
    map_flags: MapFlags,
    #[command(flatten)]
    read: ReadFlags,
    #[command(flatten)]
    clean: CleanFlags,
}

/// A scan and its map, read.
pub(in crate::cli) struct Loaded {
    pub(in crate::cli) measurement: Measurement,
    pub(in crate::cli) input: InputFile,
    pub(in crate::cli) setup: Setup,
    pub(in crate::cli) map: Option<Prepared>,
    options: FitOptions,
    light: Light,
    max_misfit: f64,
    in_plate: bool,
}

impl SampleFlags {
    /// Refuses what has no effect on any of the methods, or without maps.
    pub(in crate::cli) fn check(
        &self,
        methods: &[String],
        has_maps: bool,
        walks: bool,
    ) -> Result<(), Failure> {
        self.effort.check()?;
        self.setup.check()?;
        let any = |is: fn(&Kind) -> bool| methods.iter().any(|m| Kind::named(m).is_ok_and(is));
        self.map_flags.need_map(has_maps)?;
        self.effort.need_rays(any(|kind| kind.traced) || (walks && any(Kind::has_bounces)))?;
        if has_maps && any(|kind| kind.needs_map) && !any(Kind::is_wave) {
            return self.light.need_no_speckle();
        }
        self.light.need_waves(has_maps && any(Kind::is_wave), "no method sends waves on a map")
    }

    /// Refuses to rank laws where something of the instrument is fitted.
    pub(in crate::cli) fn need_no_nuisance(&self) -> Result<(), Failure> {
        self.nuisance.need_none()
    }

    /// Refuses all of them where there is no scan.
    pub(in crate::cli) fn need_scan(&self) -> Result<(), Failure> {
        let why = "models know their own sample";
        let given: Vec<_> = self.setup.given().into_iter().chain(self.read.given()).collect();
        without_effect(&self.clean.given(), why)?;
        without_effect(&given, why)?;
        without_effect(&self.nuisance.given(), why)?;
        self.light.need_waves(false, why)?;
        self.map_flags.need_map(false)?;
        self.effort.need_rays(false)
    }

    /// Reads a scan and its map.
    pub(in crate::cli) fn load(
        &self,
        scan: &Path,
        map: Option<&PathBuf>,
    ) -> Result<Loaded, Failure> {
        let (measurement, input) = self.read.read(scan, &self.setup)?;
        let measurement = self.clean.apply(&measurement, scan, self.effort.objective())?;
        let (body, setup) = self.setup.resolve(&measurement, scan, false)?;
        let setup = self.nuisance.opening(setup)?;
        let map = map.map(|path| self.map_flags.load_for_light(path)).transpose()?;
        let light = self.light.light(Some(&measurement.meta))?;
        let options = self.nuisance.apply(&self.effort.options(body), &measurement, &setup)?;
        let max_misfit = self.effort.max_misfit;
        let in_plate = self.setup.in_plate();
        Ok(Loaded { measurement, input, setup, map, options, light, max_misfit, in_plate })
    }
}

impl Loaded {
    /// What a reconstruction needs.
    pub(in crate::cli) fn task(&self) -> Task<'_> {
        Task {
            measurement: &self.measurement,
            setup: self.setup,
            options: self.options,
            max_misfit: self.max_misfit,
            map: self.map.as_ref(),
            light: self.light.clone(),
            bounces: None,
            input: Some(&self.input),
            of: &[],
            in_plate: self.in_plate,
            diagnose: true,
        }
    }
}

/// The methods asked for, each once, or all.
pub(in crate::cli) fn methods(asked: &[String]) -> Result<Vec<String>, Failure> {
    let mut methods: Vec<String> = Vec::new();
    for name in asked.iter().map(|n| n.trim()) {
        Kind::named(name)?;
        if !methods.iter().any(|m| m == name) {
            methods.push(name.to_owned());
        }
    }
    if methods.is_empty() {
        methods = Kind::of_paper().into_iter().map(String::from).collect();
    }
    Ok(methods)
}

#[cfg(test)]
mod tests {
    use super::{Kind, methods};

    #[test]
    fn methods_are_taken_once_and_all_without_a_word() {
        assert_eq!(methods(&[]).unwrap(), Kind::of_paper());
        let asked = ["normals", "ggx", "normals"].map(String::from);
        assert_eq!(methods(&asked).unwrap(), ["normals", "ggx"]);
        assert!(methods(&["phong".into()]).is_err());
    }
}
