//! What is known of a scene before anything is decided: its paths, and what every law would make of them.

use std::sync::Arc;

use asperity_core::bsdf::LobeSet;
use asperity_core::quantity::RelativeIor;

use super::detect::{Detector, Parts};
use super::estimate::{Estimate, estimate};
use super::gates::{SmoothRough, Waves};
use super::law::SceneLaw;
use super::paths::Setting;
use super::rough::{Rough, single};
use super::scene::{Figures, Scene, Statistics, Surface};
use super::spectrum;
use crate::boundary::Boundary;
use crate::method::Bounces;

/// Width of slopes that is planned for where nothing is known.
const NOMINAL_ALPHA: f64 = 0.2;
/// Relative change of the width whose effect is computed.
pub(super) const STEP: f64 = 0.02;
/// Shifts of the lattice of paths for what is small beside their noise.
const SHIFTS: u64 = 4;
/// Paths of each shift for the wavelengths.
const BAND_PATHS: u64 = 1 << 16;
/// Wavelengths that stand for the whole band.
pub(super) const BAND: usize = 5;

/// How a law is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reduced {
    /// One bounce, double precision.
    One,
    /// All bounces, single precision.
    AllSingle,
    /// One bounce, single precision.
    OneSingle,
    /// A larger width.
    Wider,
}

/// A scene with its paths.
pub(super) struct Study {
    pub(super) law: SceneLaw,
    /// Whether the surface is not known, and the law only a typical one.
    pub(super) is_nominal: bool,
    pub(super) setting: Setting,
    pub(super) eta: RelativeIor<f64>,
    /// The law with everything on, at the middle of the band.
    pub(super) full: Arc<Boundary>,
    /// The law of one bounce; the full one where there is no choice.
    pub(super) one: Arc<Boundary>,
    pub(super) estimate: Estimate,
    reduced: Vec<Reduced>,
    pub(super) paths: (u64, u64),
}

impl Study {
    /// Follows the paths of a scene.
    ///
    /// # Errors
    /// A law that cannot be had, or a scene without light; the text says what to change.
    pub(super) fn of(scene: &Scene, paths: (u64, u64)) -> Result<Self, String> {
        let known = SceneLaw::of(&scene.surface)?;
        let is_nominal = known.is_none();
        let law = match known {
            Some(law) => law,
            None => nominal()?,
        };
        let nm = spectrum::nodes(&scene.source, 1)[0].0;
        let index = spectrum::index(&scene.body, nm);
        let eta = RelativeIor::new(index).map_err(|e| format!("ior {index} is {e}"))?;
        let setting = setting(scene, eta);
        let full = Arc::new(law.at(index, Bounces::All)?);
        let one =
            if law.has_bounces() { Arc::new(law.at(index, Bounces::One)?) } else { full.clone() };
        let wider = law.wider(1.0 + STEP).and_then(|law| law.at(index, Bounces::All).ok());
        let singles = [single(&full), single(&one)];
        let [all_single, one_single] = &singles;
        let mut reduced: Vec<(Reduced, &dyn Rough)> = Vec::new();
        if law.has_bounces() {
            reduced.push((Reduced::One, &*one));
        }
        if let Some(law) = all_single {
            reduced.push((Reduced::AllSingle, &**law));
        }
        if let Some(law) = one_single {
            reduced.push((Reduced::OneSingle, &**law));
        }
        if let Some(law) = &wider {
            reduced.push((Reduced::Wider, law));
        }
        let laws: Vec<&dyn Rough> = reduced.iter().map(|(_, law)| *law).collect();
        let estimate = estimate(&setting, &*full, &laws, paths);
        let reduced = reduced.iter().map(|(kind, _)| *kind).collect();
        let value = setting.detector.value(&estimate.full);
        if !(value.is_finite() && value > 0.0) {
            return Err(
                "no light of the source reaches what is wanted; check faces, angles and cones"
                    .into(),
            );
        }
        Ok(Self { law, is_nominal, setting, eta, full, one, estimate, reduced, paths })
    }

    pub(super) fn detector(&self) -> &Detector {
        &self.setting.detector
    }

    /// The quantity with everything on.
    pub(super) fn value(&self) -> f64 {
        self.detector().value(&self.estimate.full)
    }

    /// The error of a reduced law of which some lobes are kept, and its standard error, as fractions; `None` of a law that there is not.
    pub(super) fn error(&self, law: Option<Reduced>, kept: LobeSet) -> Option<(f64, f64)> {
        let index = match law {
            None => None,
            Some(kind) => Some(self.reduced.iter().position(|k| *k == kind)?),
        };
        let spread = index.map_or(0.0, |k| self.estimate.spread(k) / self.estimate.full[0]);
        Some((self.off(&self.estimate.sums(index, kept)), spread))
    }

    /// The error of sums.
    pub(super) fn off(&self, sums: &Parts) -> f64 {
        self.detector().error(&self.estimate.full, sums)
    }

    /// The error of any other law, found on the same paths, with its standard error.
    pub(super) fn error_of(&self, law: &dyn Rough, kept: LobeSet) -> (f64, f64) {
        let found = estimate(&self.setting, &*self.full, &[law], self.paths);
        (self.off(&found.sums(Some(0), kept)), found.spread(0) / self.estimate.full[0])
    }

    /// The relative change of the quantity for one of the width.
    pub(super) fn sensitivity(&self) -> Option<f64> {
        let (off, _) = self.error(Some(Reduced::Wider), LobeSet::ALL)?;
        Some(off / STEP)
    }

    /// The share of the quantity whose light met a lobe between two angles of incidence, degrees.
    pub(super) fn weight(&self, lobe: usize, [from, to]: [usize; 2]) -> f64 {
        self.estimate.weights[lobe][from / 5..to / 5].iter().sum()
    }

    /// The largest angle of incidence at which light meets the kept lobes, degrees: a thousandth of it may come from beyond.
    pub(super) fn most_incidence(&self, kept: LobeSet) -> f64 {
        let mut most = 0;
        for (k, (side, lobe)) in LobeSet::ORDER.into_iter().enumerate() {
            if !kept.contains(LobeSet::of(side, lobe)) {
                continue;
            }
            let mut left: f64 = self.estimate.weights[k].iter().sum::<f64>() * 1e-3;
            for (class, weight) in self.estimate.weights[k].iter().enumerate().rev() {
                left -= weight;
                if left < 0.0 {
                    most = most.max(class + 1);
                    break;
                }
            }
        }
        (5.0 * most as f64).min(85.0)
    }

    /// The waves of the scene, and by how much rays alone err, as a fraction; `None` where Rq is not known.
    pub(super) fn waves(&self, scene: &Scene) -> Option<(Waves, f64)> {
        let figures = self.law.figures?;
        let rq = figures.rq_um?;
        let nm = scene.source.wavelength_nm[1];
        let slope = figures.alpha / std::f64::consts::SQRT_2;
        let waves = Waves::of(&self.estimate, (rq, figures.correlation_um, slope), (nm, self.eta));
        let smooth = Setting { by_rays: true, ..self.setting.clone() };
        let found =
            estimate(&smooth, &SmoothRough(smooth.smooth), &[], (self.paths.0 / 4, self.paths.1));
        let value = self.detector().value(&found.full);
        let change = if value.is_finite() { value / self.value() - 1.0 } else { -1.0 };
        let error = waves.coherent * change;
        Some((waves, error))
    }

    /// What a rule of so many wavelengths errs against the whole band, a fraction with its standard error, on the same paths.
    ///
    /// # Errors
    /// A law that there is not at an index.
    pub(super) fn band(&self, scene: &Scene, count: usize) -> Result<(f64, f64), String> {
        let mut off = Vec::new();
        for shift in 0..SHIFTS {
            let seed = self.paths.1.wrapping_mul(SHIFTS).wrapping_add(shift);
            let paths = (BAND_PATHS, seed);
            off.push(self.mean(scene, count, paths)? / self.mean(scene, BAND, paths)? - 1.0);
        }
        let n = off.len() as f64;
        let mean = off.iter().sum::<f64>() / n;
        let square: f64 = off.iter().map(|x| (x - mean).powi(2)).sum();
        Ok((mean, (square / (n * (n - 1.0))).sqrt()))
    }

    /// The quantity over the band by a rule of so many wavelengths.
    fn mean(&self, scene: &Scene, count: usize, paths: (u64, u64)) -> Result<f64, String> {
        let at = |nm: f64| -> Result<f64, String> {
            let index = spectrum::index(&scene.body, nm);
            let eta = RelativeIor::new(index).map_err(|e| format!("ior {index} is {e}"))?;
            let setting = setting(scene, eta);
            let law = self.law.at(index, Bounces::All)?;
            Ok(setting.detector.value(&estimate(&setting, &law, &[], paths).full))
        };
        let mut mean = 0.0;
        for (nm, weight) in spectrum::nodes(&scene.source, count) {
            mean += weight * at(nm)?;
        }
        Ok(mean)
    }
}

/// A scene at an index.
pub(super) fn setting(scene: &Scene, eta: RelativeIor<f64>) -> Setting {
    let detector = Detector::of(&scene.wanted.quantity);
    Setting::new(scene.body, eta, scene.source.emission.clone(), detector)
}

/// A typical law.
fn nominal() -> Result<SceneLaw, String> {
    let statistics = Statistics::Gaussian;
    let figures = Figures { rq_um: None, correlation_um: None, alpha: NOMINAL_ALPHA, statistics };
    SceneLaw::of(&Surface::Figures(figures))?.ok_or_else(|| "there is no typical law".into())
}
