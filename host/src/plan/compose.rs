//! From a scene to its plan.
//!
//! The search goes in this order, each step with the choices before it made: the law and its paths; whether waves are needed
//! (`gates`); the lobes; the wavelengths; the way to evaluate, with bounces, precision, table or grid (`decide`); the measuring
//! schedule (`measuring`). Each takes the least that keeps the sum of the errors within [`USED`] of the bound.

use asperity_core::bsdf::LobeSet;

use super::cost::{Costs, Way};
use super::decide::{Blocked, Chosen, Search, USED};
use super::everything::everything;
use super::gates::{Failing, Waves};
use super::measuring;
use super::quoted::{of_lobe, rigorous_error, solve};
use super::record::{CostRecord, FORMAT, Plan, Predicted, Reason, SceneRecord, words};
use super::refusal::{Impossible, NoPlan};
use super::rough::lobe_words;
use super::scene::{Quantity, Scene, Surface};
use super::spectrum;
use super::study::{BAND, Reduced, STEP, Study};
use crate::method::Bounces;
use crate::reconstruct::CutErrors;

/// Paths of a plan.
pub const PATHS: u64 = 8192;
/// Share of the bound that lobes left out may use.
const LOBES: f64 = 0.2;
/// Share of the bound that wavelengths left out may use.
const WAVELENGTHS: f64 = 0.2;
/// Share of the bound below which the waves of light are left out.
const RAYS: f64 = 0.5;
/// What is said of Kirchhoff's approximation where it passes its rule, % of the peak.
const KIRCHHOFF_PERCENT: f64 = 1.0;

/// Plans a scene: the same plan for the same scene, costs and seed.
///
/// # Errors
/// [`NoPlan`].
pub fn plan(scene: &Scene, costs: &Costs, seed: u64) -> Result<Plan, NoPlan> {
    // a cone takes little of the light, and narrow lobes send it little more
    let paths = match scene.wanted.quantity {
        Quantity::Cone(_) | Quantity::Image { .. } => 4 * PATHS,
        Quantity::Flux { .. } | Quantity::Haze => PATHS,
    };
    let study = Study::of(scene, (paths, seed)).map_err(NoPlan::Bad)?;
    let mut draft = Composer {
        scene,
        costs,
        study: &study,
        choices: Vec::new(),
        left: Vec::new(),
        warnings: Vec::new(),
        seed,
        solved: solve(&study, scene)?,
    };
    draft.say_surface();
    draft.waves()?;
    let lobes = draft.lobes();
    let (count, band) = draft.wavelengths().map_err(NoPlan::Bad)?;
    let search = Search { scene, study: &study, costs, lobes, band };
    match search.run() {
        Ok(chosen) => Ok(draft.finish(&chosen, (count, band))),
        Err(blocked) => {
            let Blocked { nearest, obstacles } = *blocked;
            let nearest = nearest.map(|mut chosen| {
                // it is not near enough
                chosen.why = chosen.why.split("; the ").next().unwrap_or_default().to_owned();
                draft.finish(&chosen, (count, band))
            });
            let asked_percent = scene.wanted.error_percent;
            Err(NoPlan::Impossible(Box::new(Impossible { nearest, obstacles, asked_percent })))
        }
    }
}

/// A plan under way.
struct Composer<'a> {
    scene: &'a Scene,
    costs: &'a Costs,
    study: &'a Study,
    choices: Vec<Reason>,
    left: Vec<Reason>,
    warnings: Vec<String>,
    seed: u64,
    /// The true errors on the map of the scene, if they were asked for.
    solved: Option<CutErrors>,
}

fn percent(fraction: f64) -> String {
    let p = 100.0 * fraction;
    if p == 0.0 {
        "0 %".into()
    } else if p.abs() < 1e-9 {
        "next to nothing".into()
    } else if p.abs() < 0.001 {
        format!("{p:.0e} %")
    } else if p.abs() < 1.0 {
        format!("{p:.3} %")
    } else {
        format!("{p:.1} %")
    }
}

impl Composer<'_> {
    fn choose(&mut self, what: impl Into<String>, why: impl Into<String>) {
        self.choices.push(Reason { what: what.into(), why: why.into() });
    }

    fn leave(&mut self, what: impl Into<String>, why: impl Into<String>) {
        self.left.push(Reason { what: what.into(), why: why.into() });
    }

    fn bound(&self) -> f64 {
        self.scene.wanted.error_percent / 100.0
    }

    /// What is known of the surface.
    fn say_surface(&mut self) {
        let study = self.study;
        let alpha = study.law.figures.map(|f| f.alpha);
        if study.is_nominal {
            self.warnings.push(format!(
                "nothing is known of the surface: this is a plan for a typical width of slopes, {:.2}. Measure first, then plan with the fitted model",
                alpha.unwrap_or(0.0)
            ));
        }
        if let Some(lay) = study.law.lay.filter(|lay| *lay > 0.3) {
            self.warnings.push(format!(
                "the map has a direction (strength {lay:.2}); the plan is for the mean over azimuths"
            ));
        }
        if let Some(rigorous) = rigorous_error(study, self.scene, self.solved.as_ref()) {
            self.choose("true error of rays", rigorous);
        }
    }

    /// Whether waves are needed, and may be used.
    fn waves(&mut self) -> Result<(), NoPlan> {
        let Some((waves, error)) = self.study.waves(self.scene) else {
            if self.scene.source.coherent {
                self.warnings.push(
                    "rq_um is not known, so the light that stays coherent is not either; give rq_um for a laser".into(),
                );
            }
            return Ok(());
        };
        let Waves { coherent, phase, correlation, failing } = waves;
        let numbers = format!(
            "phase of the heights {:.2} to {:.2} rad rms{}, so {} of the light stays coherent",
            phase[0],
            phase[1],
            correlation
                .map(|l| format!(", correlation length {l:.1} wavelengths"))
                .unwrap_or_default(),
            percent(coherent)
        );
        if error.abs() <= RAYS * self.bound() {
            self.choose(
                "rays, no waves",
                format!("{numbers}: waves would move the quantity by {}", percent(error.abs())),
            );
            self.leave(
                "waves (measured-wave, measured-hybrid)",
                format!("would add {}", percent(error.abs())),
            );
            return Ok(());
        }
        // waves it has to be: what is in their way?
        let asked_percent = self.scene.wanted.error_percent;
        let nm = self.scene.source.wavelength_nm[0];
        let need = format!("rays alone err by {}, for {numbers}", percent(error.abs()));
        let mut obstacles = vec![need];
        match (&self.scene.surface, self.study.law.pixel_um) {
            (Surface::Map { .. }, Some(pixel)) if pixel > nm / 2000.0 => obstacles.push(format!(
                "a map with pixels of {pixel} um holds the scatter of waves up to {:.1} deg from the specular direction only: measure one with \
                 pixels of {:.2} um or less (an AFM or an interference microscope), or give a scan to fit a law to",
                Waves::reach_deg(pixel, nm / 1000.0),
                nm / 2000.0
            )),
            (Surface::Map { .. }, _) => {}
            _ => obstacles.push(format!(
                "waves need a height map, and there is none: measure one with pixels of {:.2} um or less",
                nm / 2000.0
            )),
        }
        let failing = failing.into_iter().filter_map(|f| self.failure(f));
        obstacles.extend(failing.map(|why| format!("Kirchhoff's approximation fails: {why}")));
        if KIRCHHOFF_PERCENT > asked_percent {
            obstacles.push(format!(
                "where Kirchhoff's approximation passes its rule it is known to {KIRCHHOFF_PERCENT} % of the peak, no better"
            ));
        }
        if obstacles.len() == 1 {
            obstacles.push("plans of waves stop here: fit measured-wave to the map and a scan, then plan with that model".into());
        }
        let nearest = Some(self.nearest_by_rays(error));
        Err(NoPlan::Impossible(Box::new(Impossible { nearest, obstacles, asked_percent })))
    }

    /// Why waves fail in a lobe: by the rule, unless they were found to hold on cuts of the map.
    fn failure(&self, by_rule: Failing) -> Option<String> {
        let found = self.solved.as_ref().and_then(|errors| of_lobe(errors, by_rule.lobe));
        let Some(found) = found else { return Some(by_rule.why) };
        (found.waves.holds() != Some(true)).then(|| {
            format!(
                "{} at {:.0} deg: off by {} on cuts of the map",
                lobe_words(by_rule.lobe),
                found.incidence_deg,
                found.waves.text()
            )
        })
    }

    /// The plan of rays that errs by what waves do.
    fn nearest_by_rays(&mut self, error: f64) -> Plan {
        let chosen = Chosen {
            all_bounces: true,
            is_single: false,
            lobes: LobeSet::ALL,
            table_bytes: None,
            export: None,
            bytes: None,
            cost: self.costs.of(&self.study.law.method, Way::Double),
            error: (error, 0.0),
            why: "its formula in double precision: the nearest without waves".into(),
        };
        self.finish(&chosen, (1, 0.0))
    }

    /// The lobes that matter.
    fn lobes(&mut self) -> LobeSet {
        let study = self.study;
        let most = LOBES * self.bound();
        let sets = (1..16_usize).map(|bits| {
            let each = LobeSet::ORDER.into_iter().enumerate();
            let kept = each.filter(|(k, _)| bits >> k & 1 == 1);
            kept.fold(LobeSet::NONE, |set, (_, (side, lobe))| set | LobeSet::of(side, lobe))
        });
        let error =
            |set: LobeSet| study.error(None, set).map_or(f64::INFINITY, |(off, _)| off.abs());
        let near = sets.filter(|set| error(*set) <= most);
        let order =
            |a: &LobeSet, b: &LobeSet| a.len().cmp(&b.len()).then(error(*a).total_cmp(&error(*b)));
        let kept = near.min_by(order).unwrap_or(LobeSet::ALL);
        for (k, which) in LobeSet::ORDER.into_iter().enumerate() {
            let lobe = LobeSet::of(which.0, which.1);
            let weights = study.estimate.weights[k];
            let all: f64 = weights.iter().sum();
            let name = lobe_words(which);
            if kept.contains(lobe) {
                let (from, to) = middle(&weights);
                self.choose(
                    format!("lobe {name}"),
                    format!(
                        "the light of the quantity meets it {all:.2} times, two thirds at {from} to {to} deg of incidence ({:.2} times between 50 and 80)",
                        study.weight(k, [50, 80])
                    ),
                );
            } else if all == 0.0 {
                self.leave(
                    format!("lobe {name}"),
                    "the scene never sees it: it would add 0 %".to_owned(),
                );
            } else {
                let without = without(kept | lobe, lobe);
                let added = study.error(None, kept | lobe).map_or(0.0, |e| e.0)
                    - study.error(None, without).map_or(0.0, |e| e.0);
                self.leave(format!("lobe {name}"), format!("would add {}", percent(added)));
            }
        }
        kept
    }

    /// The number of wavelengths, and what they err.
    fn wavelengths(&mut self) -> Result<(usize, f64), String> {
        let [from, to] = self.scene.source.wavelength_nm;
        if to <= from {
            self.choose(format!("1 wavelength, {from} nm"), "the light is a line");
            return Ok((1, 0.0));
        }
        if self.scene.body.abbe.is_none() {
            let middle = f64::midpoint(from, to);
            self.choose(
                format!("1 wavelength, {middle} nm"),
                "rays depend on the wavelength by the index alone, and there is no abbe number",
            );
            return Ok((1, 0.0));
        }
        let bound = WAVELENGTHS * self.bound();
        let mut chosen = (BAND, 0.0);
        let mut one = None;
        for count in [1, 3] {
            let (off, spread) = self.study.band(self.scene, count)?;
            one = one.or(Some(off));
            if off.abs() + 2.0 * spread <= bound {
                chosen = (count, off);
                break;
            }
        }
        let (count, off) = chosen;
        self.choose(
            format!("{count} of {BAND} wavelengths"),
            format!(
                "dispersion over {from} to {to} nm moves the quantity by {}",
                percent(off.abs())
            ),
        );
        if count < BAND {
            self.leave(
                format!("{} more wavelengths", BAND - count),
                format!("would add {}", percent(-off)),
            );
        }
        Ok(chosen)
    }

    /// The plan of what is chosen.
    fn finish(&mut self, chosen: &Chosen, (count, band): (usize, f64)) -> Plan {
        let (scene, study) = (self.scene, self.study);
        self.bounces(chosen);
        self.choose(format!("target {}", scene.target.kind.word()), chosen.why.clone());
        let precision = if chosen.is_single { "f32" } else { "f64" };
        if let Some((off, _)) = study.error(Some(Reduced::AllSingle), LobeSet::ALL) {
            self.choose(
                format!("precision {precision}"),
                format!("single precision moves the quantity by {}", percent(off.abs())),
            );
        }
        self.choose("no azimuths of the light", "the law has no direction: one azimuth tells all");
        let measure = self.schedule();
        let value = study.value();
        let error_percent = 100.0 * (chosen.error.0 + band);
        let costs = CostRecord {
            bytes: chosen.bytes,
            instructions: chosen.cost.instructions,
            eval_ns: chosen.cost.eval_ns,
            fit_s: self.costs.fit_s(&study.law.method),
            measure_h: measure.as_ref().map(|m| measuring::usual_hours() - m.hours_saved),
        };
        Plan {
            asperity: FORMAT,
            kind: "plan".into(),
            scene: SceneRecord { name: scene.name.clone(), sha256: scene.sha256.clone() },
            version: env!("CARGO_PKG_VERSION").into(),
            seed: self.seed,
            method: study.law.method.clone(),
            bounces: study.law.has_bounces().then(|| {
                if chosen.all_bounces { Bounces::All } else { Bounces::One }.word().to_owned()
            }),
            lobes: words(chosen.lobes),
            ior: scene.body.ior,
            wavelengths_nm: spectrum::nodes(&scene.source, count)
                .into_iter()
                .map(|(nm, _)| nm)
                .collect(),
            precision: precision.into(),
            table_bytes: chosen.table_bytes,
            export: chosen.export.clone(),
            measure,
            predicted: Predicted {
                value,
                error_percent,
                std_percent: 100.0 * chosen.error.1,
                asked_percent: scene.wanted.error_percent,
            },
            costs,
            everything: everything(scene, study, self.costs),
            choices: std::mem::take(&mut self.choices),
            left_out: std::mem::take(&mut self.left),
            warnings: std::mem::take(&mut self.warnings),
        }
    }

    fn bounces(&mut self, chosen: &Chosen) {
        let study = self.study;
        if !study.law.has_bounces() {
            return;
        }
        let Some((off, _)) = study.error(Some(Reduced::One), chosen.lobes) else { return };
        let what = format!("light of later bounces moves the quantity by {}", percent(off.abs()));
        if chosen.all_bounces {
            self.choose("all bounces", what);
        } else {
            self.choose("one bounce", what);
            self.leave("later bounces", format!("would add {}", percent(-off)));
        }
    }

    fn schedule(&mut self) -> Option<super::record::Measure> {
        let study = self.study;
        if matches!(self.scene.surface, Surface::Model(_)) {
            self.leave("a measurement", "the model is there already");
            return None;
        }
        let wider = study.law.wider(1.0 + STEP)?.at(study.eta.get(), Bounces::One).ok()?;
        let nm = self.scene.source.wavelength_nm;
        let line = (nm[0] >= nm[1]).then_some(nm[0]);
        let found = measuring::shortest([&study.one, &wider], self.scene.body.ior, line)?;
        let draft = &found.schedule;
        let sigmas: Vec<String> = draft.sigma_deg.iter().flatten().map(f64::to_string).collect();
        self.choose(
            format!(
                "measure sigma {}, theta {} to {} in steps of {} deg, aperture {} deg",
                sigmas.join(", "),
                draft.theta_from_deg.unwrap_or(-90.0),
                draft.theta_to_deg.unwrap_or(90.0),
                draft.theta_step_deg.unwrap_or(0.1),
                draft.aperture_deg.unwrap_or(0.6)
            ),
            format!(
                "{} points tell the width {:.2} times as uncertain as 9005 do; {:.2} h less",
                found.points, found.error_ratio, found.hours_saved
            ),
        );
        if let Some(sensitivity) = study.sensitivity() {
            let allowed = (1.0 - USED) * self.bound() / sensitivity.abs().max(1e-6);
            let known = if allowed < 0.5 {
                format!("alpha has to be known to {}", percent(allowed))
            } else {
                "alpha hardly matters".to_owned()
            };
            self.choose(
                "precision of the width",
                format!(
                    "1 % of alpha moves the quantity by {}: {known}",
                    percent(sensitivity / 100.0)
                ),
            );
        }
        self.leave(
            format!("{} of 9005 readings", 9005_usize.saturating_sub(found.points)),
            format!("would make the width {:.2} times as certain", found.error_ratio),
        );
        Some(found)
    }
}

/// A set without one lobe.
fn without(set: LobeSet, lobe: LobeSet) -> LobeSet {
    let each = set.iter().map(|(side, lobe)| LobeSet::of(side, lobe));
    each.filter(|one| *one != lobe).fold(LobeSet::NONE, |all, one| all | one)
}

/// The angles between which two thirds of weights lie, degrees.
fn middle(weights: &[f64]) -> (usize, usize) {
    let all: f64 = weights.iter().sum();
    let at = |share: f64| {
        let mut left = share * all;
        let found = weights.iter().position(|w| {
            left -= w;
            left <= 0.0
        });
        5 * found.unwrap_or(weights.len() - 1)
    };
    (at(1.0 / 6.0), at(5.0 / 6.0) + 5)
}
