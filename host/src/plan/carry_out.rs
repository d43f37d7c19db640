//! A plan carried out on its scene: the quantity with the planned model beside that with everything on.
//!
//! Both are computed path by path with the same numbers, the planned one by its own evaluator, which draws its own rays; several
//! shifts of the lattice tell the error of the difference. Nothing of the prediction enters.

use asperity_core::bsdf::LobeSet;
use asperity_core::quantity::RelativeIor;

use super::detect::{MOST_PARTS, Parts};
use super::estimate::estimate;
use super::evaluator::{FileRough, Grid, files, of_table, table, writer};
use super::law::SceneLaw;
use super::record::Plan;
use super::refusal::NoPlan;
use super::rough::{Masked, Rough, single};
use super::scene::{Scene, TargetKind};
use super::spectrum;
use super::study::{BAND, setting};
use crate::method::Bounces;

/// Shifts of the lattice.
const SHIFTS: u64 = 4;

/// What a plan does in truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Actual {
    /// The quantity with everything on.
    pub full: f64,
    /// With the planned model.
    pub planned: f64,
    /// Error of the latter, %, as the plan predicts it.
    pub error_percent: f64,
    /// Its standard error, %.
    pub std_percent: f64,
}

/// Computes the quantity both ways; `paths` of each of four shifts.
///
/// # Errors
/// [`NoPlan::Bad`] if the plan is not one of this scene, or its law cannot be had.
pub fn carry_out(scene: &Scene, plan: &Plan, paths: u64, seed: u64) -> Result<Actual, NoPlan> {
    if plan.scene.sha256 != scene.sha256 {
        return Err(NoPlan::Bad("the plan is of another scene; plan this one".into()));
    }
    let law = SceneLaw::of(&scene.surface).map_err(NoPlan::Bad)?.ok_or_else(|| {
        NoPlan::Bad("nothing is known of the surface; there is no model to compare".into())
    })?;
    let mut rows = Vec::new();
    for shift in 0..SHIFTS {
        let at = (paths, seed.wrapping_mul(1009).wrapping_add(shift));
        let full = full(scene, &law, at).map_err(NoPlan::Bad)?;
        let planned = planned(scene, plan, &law, at).map_err(NoPlan::Bad)?;
        rows.push((full, planned));
    }
    let detector = super::detect::Detector::of(&scene.wanted.quantity);
    let mean = |of: &dyn Fn(&(Parts, Parts)) -> Parts| {
        let mut sum = [0.0; MOST_PARTS];
        for row in &rows {
            sum.iter_mut().zip(of(row)).for_each(|(a, b)| *a += b / rows.len() as f64);
        }
        sum
    };
    let (full, planned) = (mean(&|row| row.0), mean(&|row| row.1));
    let each: Vec<f64> = rows.iter().map(|(f, p)| detector.error(f, p)).collect();
    let error = detector.error(&full, &planned);
    let centre = each.iter().sum::<f64>() / each.len() as f64;
    let square: f64 = each.iter().map(|e| (e - centre).powi(2)).sum();
    let n = each.len() as f64;
    Ok(Actual {
        full: detector.value(&full),
        planned: detector.value(&planned),
        error_percent: 100.0 * error,
        std_percent: 100.0 * (square / (n * (n - 1.0))).sqrt(),
    })
}

/// Everything on: all lobes and bounces, double precision, the whole band.
fn full(scene: &Scene, law: &SceneLaw, at: (u64, u64)) -> Result<Parts, String> {
    let nodes = spectrum::nodes(&scene.source, if scene.body.abbe.is_some() { BAND } else { 1 });
    over(scene, &nodes, |index, eta| {
        let boundary = law.at(index, Bounces::All)?;
        Ok(estimate(&setting(scene, eta), &boundary, &[], at).full)
    })
}

/// As planned.
fn planned(scene: &Scene, plan: &Plan, law: &SceneLaw, at: (u64, u64)) -> Result<Parts, String> {
    let nodes = spectrum::nodes(&scene.source, plan.wavelengths_nm.len());
    let planned = plan.lobe_set().ok_or("the plan names a lobe that is none")?;
    // Mitsuba's material has all four
    let lobes = if scene.target.kind == TargetKind::Mitsuba { LobeSet::ALL } else { planned };
    over(scene, &nodes, |index, eta| {
        let bounces =
            if plan.bounces.as_deref() == Some("one") { Bounces::One } else { Bounces::All };
        let boundary = law.at(index, bounces)?;
        let setting = setting(scene, eta);
        let run = |law: &dyn Rough| estimate(&setting, &Masked { law, lobes }, &[], at).full;
        if let Some(bytes) = plan.table_bytes {
            return Ok(run(&of_table(table(&boundary, lobes, bytes)?)));
        }
        if let Some(export) =
            plan.export.as_ref().filter(|_| scene.target.kind != TargetKind::Mitsuba)
        {
            let writer =
                writer(&export.format).ok_or("the plan names a format that is not written")?;
            let grid = Grid {
                incidences_deg: export.incidences_deg.clone(),
                tolerance_percent: export.tolerance_percent,
            };
            let files = files(&boundary, lobes, (&writer, &grid), plan.wavelengths_nm[0])?;
            return Ok(run(&FileRough::new(&files, &boundary)));
        }
        match single(&boundary).filter(|_| plan.precision == "f32") {
            Some(law) => Ok(run(&*law)),
            None => Ok(run(&boundary)),
        }
    })
}

/// The weighted mean over wavelengths.
fn over(
    scene: &Scene,
    nodes: &[(f64, f64)],
    at: impl Fn(f64, RelativeIor<f64>) -> Result<Parts, String>,
) -> Result<Parts, String> {
    let mut sum = [0.0; MOST_PARTS];
    for (nm, weight) in nodes {
        let index = spectrum::index(&scene.body, *nm);
        let eta = RelativeIor::new(index).map_err(|e| format!("ior {index} is {e}"))?;
        let parts = at(index, eta)?;
        sum.iter_mut().zip(parts).for_each(|(a, b)| *a += weight * b);
    }
    Ok(sum)
}
