//! The virtual goniophotometer: a scan of a boundary.

mod rays;
mod refused;

use asperity_core::bsdf::Lobe;
use asperity_core::gonio::{AngleGrid, Geometry, gp200};
use asperity_core::plate::{Outcome, RoughSide};
use asperity_core::quantity::RelativeIor;

use crate::boundary::Boundary;
use crate::forward::{Angles, Effort, Incidence, Rays, Readings, Sample, Setup, simulate, wave};
use crate::measurement::meta::HeaderFault;
use crate::measurement::{AngleRange, Measurement, Metadata, Quantity, Reading};
use crate::shard::Shard;
use crate::surface::{Edges, Form};
use crate::watch::Watch;

use super::situation::{check_aperture, check_plate};
use super::subject::Subject;
use super::{header, needed};

pub use rays::RayNoise;
use rays::{MOST_RAYS, TRACED_RAYS};
pub use refused::NoScan;

/// What the instrument is to measure; the default is the GP-200's usual scan of transmitted light.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanRequest {
    /// Angles of incidence, 0 to below 90 degrees.
    pub sigma_deg: Vec<f64>,
    /// Rotations of the sample about its normal, 0 to below 360 degrees; a map is scanned as it lies.
    pub rotation_deg: Vec<f64>,
    /// Angles of observation.
    pub theta: AngleRange,
    /// Step of the angle of observation, degrees.
    pub step_deg: f64,
    /// Full angle of the detector's cone, degrees.
    pub aperture_deg: f64,
    /// Side of the detector; `None`: transmission, of an opaque body reflection.
    pub geometry: Option<Geometry>,
    /// Which way the rough face of a plate looks.
    pub rough_side: RoughSide,
    /// What the readings are.
    pub quantity: Quantity,
    /// Monte Carlo with so many rays per incidence; `None`: by quadrature, of a traced boundary 1.5e7 rays.
    pub rays: Option<u64>,
    /// Traces until the noise is at most so many percent of the largest reading, [`rays`](Self::rays) at most.
    pub until_percent: Option<f64>,
    /// Seed of the rays.
    pub seed: u64,
    /// The part of the incidences that is measured; all without it.
    pub shard: Option<Shard>,
}

impl Default for ScanRequest {
    fn default() -> Self {
        Self {
            sigma_deg: gp200::SIGMAS_DEG.to_vec(),
            rotation_deg: vec![0.0],
            theta: AngleRange::ALL,
            step_deg: gp200::STEP_DEG,
            aperture_deg: gp200::APERTURE_DEG,
            geometry: None,
            rough_side: RoughSide::Source,
            quantity: Quantity::Flux,
            rays: None,
            until_percent: None,
            seed: 1,
            shard: None,
        }
    }
}

/// A finished virtual scan.
#[derive(Clone, Debug)]
pub struct VirtualScan {
    /// Its readings and what is known of them.
    pub measurement: Measurement,
    /// Angle of incidence and reflected, transmitted and lost flux; Monte Carlo only.
    pub outcomes: Vec<(f64, Outcome<f64>)>,
    /// Flux left out of the internal passes; quadrature only.
    pub neglected: Option<f64>,
    /// Noise of the rays, incidence by incidence; Monte Carlo only.
    pub noise: Vec<RayNoise>,
    /// Whether it was stopped: the incidences that were finished are there.
    pub interrupted: bool,
}

impl ScanRequest {
    /// Measures a subject; the header says what it is.
    ///
    /// `watch` is told rays or transforms; a scan by rays that is stopped keeps the incidences that it finished.
    ///
    /// # Errors
    /// [`NoScan`].
    pub fn run(&self, subject: &Subject, watch: Watch<'_>) -> Result<VirtualScan, NoScan> {
        let checked = self.check(&subject.boundary)?;
        self.carry_out(&subject.boundary, &checked, of_subject(subject)?, watch)
    }

    /// Measures a boundary; `meta` is completed with what the instrument is.
    ///
    /// # Errors
    /// [`NoScan`].
    pub fn of_boundary(
        &self,
        boundary: &Boundary,
        meta: Metadata,
        watch: Watch<'_>,
    ) -> Result<VirtualScan, NoScan> {
        self.carry_out(boundary, &self.check(boundary)?, meta, watch)
    }

    /// Refuses what cannot be measured, before any work: the front end may open its output in between.
    ///
    /// # Errors
    /// [`NoScan`].
    pub fn check(&self, boundary: &Boundary) -> Result<Checked, NoScan> {
        let setup = self.setup(boundary)?;
        let lobes = needed::of_scan(&setup, self.rays.is_some());
        needed::need(boundary, lobes, "this scan")?;
        let grid = self.grid()?;
        let sigma = &self.sigma_deg;
        if let Some(bad) = sigma.iter().find(|s| !(0.0..90.0).contains(*s)) {
            return Err(NoScan::Incidence(*bad));
        }
        let is_repeated = |k: &usize| sigma[..*k].iter().any(|s| s.total_cmp(&sigma[*k]).is_eq());
        if let Some(k) = (1..sigma.len()).find(is_repeated) {
            return Err(NoScan::IncidenceTwice(sigma[k]));
        }
        self.check_rotations(boundary)?;
        if self.shard.is_some() && matches!(boundary, Boundary::Wave(_)) {
            return Err(NoScan::WavesAreWhole);
        }
        let usual = if self.until_percent.is_some() { MOST_RAYS } else { TRACED_RAYS };
        let count = self.rays.or(boundary.is_traced().then_some(usual));
        Ok(Checked { setup, grid, rays: count.map(|count| Rays { count, seed: self.seed }) })
    }

    fn check_rotations(&self, boundary: &Boundary) -> Result<(), NoScan> {
        let all = &self.rotation_deg;
        if let Some(bad) = all.iter().find(|r| !(0.0..360.0).contains(*r)) {
            return Err(NoScan::Rotation(*bad));
        }
        let is_repeated = |k: usize| all[..k].iter().any(|r| r.total_cmp(&all[k]).is_eq());
        if all.is_empty() || (1..all.len()).any(is_repeated) {
            return Err(NoScan::Rotations);
        }
        let is_map = boundary.is_traced() || matches!(boundary, Boundary::Wave(_));
        if is_map && all.iter().any(|r| *r > 0.0) {
            return Err(NoScan::MapIsNotTurned);
        }
        Ok(())
    }

    /// Incidences and rotations in the order of the readings, those of its part.
    fn beams(&self) -> Vec<(f64, f64)> {
        let of = |&sigma| self.rotation_deg.iter().map(move |&rotation| (sigma, rotation));
        let all = self.sigma_deg.iter().flat_map(of).enumerate();
        let held = all.filter(|(k, _)| self.shard.is_none_or(|shard| shard.holds(*k)));
        held.map(|(_, beam)| beam).collect()
    }

    /// Incidences and rotations of all parts.
    pub fn incidences(&self) -> usize {
        self.sigma_deg.len() * self.rotation_deg.len()
    }

    /// Those of its part.
    pub fn held(&self) -> usize {
        self.beams().len()
    }

    /// Whether its part holds no incidence.
    pub fn is_empty(&self) -> bool {
        self.held() == 0
    }

    fn setup(&self, boundary: &Boundary) -> Result<Setup, NoScan> {
        let (sample, usual) = match boundary.eta() {
            Some(eta) => {
                let eta = RelativeIor::new(eta).map_err(|e| NoScan::Index(e.to_string()))?;
                if !boundary.is_sheet() {
                    check_plate(eta)?;
                }
                (Sample::Plate { eta, rough_side: self.rough_side }, Geometry::Transmission)
            }
            None => (Sample::Opaque, Geometry::Reflection),
        };
        let usual = match boundary {
            law if law.lobe() == Some(Lobe::Reflection) => Geometry::Reflection,
            _ => usual,
        };
        let geometry = self.geometry.unwrap_or(usual);
        if sample == Sample::Opaque && geometry == Geometry::Transmission {
            return Err(NoScan::OpaqueTransmits);
        }
        let (aperture_deg, quantity) = (self.aperture_deg, self.quantity);
        check_aperture(aperture_deg, quantity)?;
        if (self.rays.is_some() || boundary.is_traced()) && aperture_deg <= 0.0 {
            return Err(NoScan::RaysNeedAperture);
        }
        if matches!(boundary, Boundary::Wave(_)) && self.rays.is_some() {
            return Err(NoScan::WavesAreNotTraced);
        }
        let is_coherent = match boundary {
            Boundary::Wave(_) => true,
            Boundary::Table(table) => table.is_coherent(),
            // values of a BSDF leave it out, as instruments that give them do
            law => law.keeps_direction() && quantity == Quantity::Flux,
        };
        if is_coherent && aperture_deg <= 0.0 {
            return Err(NoScan::CoherentNeedsAperture);
        }
        Ok(Setup { sample, geometry, aperture_deg, slit_height_deg: None, quantity })
    }

    fn grid(&self) -> Result<AngleGrid<f64>, NoScan> {
        let (from_deg, to_deg) = (self.theta.min_deg().max(-90.0), self.theta.max_deg().min(90.0));
        if from_deg > to_deg {
            return Err(NoScan::Outside(self.theta));
        }
        let step_deg = self.step_deg;
        let count = ((to_deg - from_deg) / step_deg + 1e-6).floor();
        if !(step_deg > 0.0 && step_deg.is_finite() && (0.0..=1e6).contains(&count)) {
            return Err(NoScan::Step { step_deg, from_deg, to_deg });
        }
        Ok(AngleGrid { start_deg: from_deg, step_deg, count: count as usize + 1 })
    }

    fn carry_out(
        &self,
        boundary: &Boundary,
        Checked { setup, grid, rays }: &Checked,
        mut meta: Metadata,
        watch: Watch<'_>,
    ) -> Result<VirtualScan, NoScan> {
        let angles: Vec<f64> = (0..grid.count).map(|k| as_written(grid.degrees(k))).collect();
        let raw = match rays {
            None => self.summed(boundary, setup, &angles, watch)?,
            Some(rays) => self.traced_until(boundary, setup, &angles, *rays, watch),
        };
        if raw.values.is_empty() {
            return Err(NoScan::InterruptedEarly);
        }
        if let (Boundary::Wave(waves), Some(errors)) = (boundary, &raw.std_errors) {
            header::speckle(waves, errors, &raw.values, &mut meta)?;
        }
        if let Some(light) = boundary.wavelengths() {
            header::light(light, &mut meta)?;
        }
        self.say(boundary, setup, &raw, &mut meta);
        let beams = self.beams();
        let at = beams.iter().flat_map(|&(s, r)| angles.iter().map(move |&t| (s, r, t)));
        let reading = |((sigma_deg, rotation_deg, theta_deg), value)| Reading {
            rotation_deg,
            ..Reading::in_plane(sigma_deg, theta_deg, value)
        };
        let readings = at.zip(raw.values.iter().copied()).map(reading).collect();
        Ok(VirtualScan {
            measurement: Measurement::new(meta, readings)?,
            outcomes: raw.outcomes,
            neglected: raw.neglected,
            noise: raw.noise,
            interrupted: raw.interrupted,
        })
    }

    /// By quadrature, or from the orders of waves.
    fn summed(
        &self,
        boundary: &Boundary,
        setup: &Setup,
        angles: &[f64],
        watch: Watch<'_>,
    ) -> Result<Raw, NoScan> {
        let one = |(sigma_deg, rotation_deg)| Incidence {
            rotation_deg,
            ..Incidence::in_plane(sigma_deg, angles.to_vec())
        };
        let plan = Angles { incidences: self.beams().into_iter().map(one).collect() };
        let done = if let Boundary::Wave(waves) = boundary {
            wave(waves, setup, &plan, Effort::Full, watch)
        } else {
            let no_rays = Rays { count: 1, seed: 0 };
            simulate(boundary, setup, &plan, Effort::Full, no_rays, watch)
        };
        let Readings { values, std_errors, neglected, .. } = done.ok_or(NoScan::Interrupted)?;
        Ok(Raw { values, std_errors, neglected: Some(neglected.flux), ..Raw::default() })
    }

    /// Completes the header.
    fn say(&self, boundary: &Boundary, setup: &Setup, raw: &Raw, meta: &mut Metadata) {
        let how = match raw.rays {
            None if matches!(boundary, Boundary::Wave(_)) => "Kirchhoff".to_owned(),
            None => "quadrature".to_owned(),
            Some(traced) => format!("Monte Carlo, {traced} rays an incidence"),
        };
        meta.instrument = Some(format!("asperity scan, {how}"));
        meta.geometry = Some(setup.geometry);
        meta.aperture_deg = (setup.aperture_deg > 0.0).then_some(setup.aperture_deg);
        meta.calibration = Some("relative to the beam without sample".into());
        if let Sample::Plate { rough_side, .. } = setup.sample {
            meta.rough_side = Some(rough_side);
        }
        if setup.quantity == Quantity::Bsdf {
            meta.quantity = Some(Quantity::Bsdf);
        }
        if raw.rays.is_none() {
            return;
        }
        meta.seed = Some(self.seed);
        if let Some(noise) = RayNoise::percent(&raw.noise) {
            meta.noise_floor_percent = Some(noise);
        }
    }
}

/// An angle without what binary fractions leave of it: 40.1, not 40.099999999999994.
fn as_written(deg: f64) -> f64 {
    (deg * 1e9).round() / 1e9
}

/// A request that can be carried out.
#[derive(Clone, Copy, Debug)]
pub struct Checked {
    setup: Setup,
    grid: AngleGrid<f64>,
    rays: Option<Rays>,
}

/// Readings before they are a measurement: incidence by incidence, as far as they were finished.
#[derive(Default)]
struct Raw {
    values: Vec<f64>,
    std_errors: Option<Vec<f64>>,
    noise: Vec<RayNoise>,
    /// Rays per incidence.
    rays: Option<u64>,
    outcomes: Vec<(f64, Outcome<f64>)>,
    neglected: Option<f64>,
    interrupted: bool,
}

/// What the header says of a subject.
fn of_subject(subject: &Subject) -> Result<Metadata, HeaderFault> {
    let sample = Some(format!("virtual: {}", subject.path.display()));
    let mut meta = Metadata { sample, ior: subject.ior, ..Metadata::default() };
    if let Some(said) = &subject.table {
        meta.set("table", said)?;
    }
    if let Some(map) = &subject.preparation {
        let (edges, form) = (map.edges.map(Edges::name), map.form.map(Form::name));
        for (key, word) in [("edges", edges), ("form_removed", form)] {
            if let Some(word) = word {
                meta.set(key, word)?;
            }
        }
    }
    Ok(meta)
}
