//! The energy test of a fit: where the flux goes from both sides, and whether it is more than there is.

use asperity_core::direction::Side;

use crate::boundary::Boundary;
use crate::energy::{balances, side_name};
use crate::fit::Fit;
use crate::forward::Rays;
use crate::kirchhoff::validity::MOST_EXCESS;
use crate::measurement::{Measurement, Quantity, Reading};
use crate::method::{Body, Method};
use crate::model::Flux;
use crate::watch::Watch;

use super::super::task::Task;

/// Angles of incidence in the medium the light comes from, degrees.
const INCIDENCES: [f64; 5] = [0.0, 30.0, 45.0, 60.0, 75.0];
/// Those of waves, which cost more.
const OF_WAVES: [f64; 2] = [0.0, 45.0];
/// Rays per incidence, of what is traced.
const RAYS: Rays = Rays { count: 20_000, seed: 7 };
/// What a balance by quadrature may miss.
const TOLERANCE: f64 = 5e-3;
/// Angles are equal to this, degrees.
const SAME_DEG: f64 = 1e-6;
/// Standard errors of a level by which it may be too bright.
const ERRORS: f64 = 2.0;

/// The fluxes of a boundary; none if stopped.
pub(in crate::reconstruct) fn fluxes(boundary: &Boundary, watch: Watch<'_>) -> Vec<Flux> {
    let sides: &[Side] = match boundary.eta() {
        Some(_) if !boundary.is_sheet() => &[Side::Air, Side::Dielectric],
        _ => &[Side::Air],
    };
    let angles: &[f64] = if matches!(boundary, Boundary::Wave(_) | Boundary::Hybrid(_)) {
        &OF_WAVES
    } else {
        &INCIDENCES
    };
    let beams: Vec<(Side, f64)> =
        sides.iter().flat_map(|side| angles.iter().map(move |deg| (*side, *deg))).collect();
    let found = balances(boundary, &beams, RAYS, watch.quiet()).unwrap_or_default();
    found.into_iter().map(Flux::from).collect()
}

/// The fluxes of a fit, with the uncertainty that its values give them where the law is in closed form.
pub(in crate::reconstruct) fn fluxes_of(
    method: &dyn Method,
    fit: &Fit,
    task: &Task<'_>,
    watch: Watch<'_>,
) -> Vec<Flux> {
    let mut all = fluxes(&fit.boundary, watch);
    // of a law of knots that takes as long as all the rest
    if method.is_traced() || method.wave().is_some() || method.is_free_form() {
        return all;
    }
    let mut slopes: Vec<[Vec<f64>; 2]> = vec![Default::default(); all.len()];
    for name in &fit.errors.names {
        let moved = moved(method, fit, task, (&all, name), watch);
        for (k, slope) in slopes.iter_mut().enumerate() {
            let [r, t] = moved.as_ref().and_then(|m| m.get(k).copied()).unwrap_or_default();
            slope[0].push(r);
            slope[1].push(t);
        }
    }
    for (flux, [r, t]) in all.iter_mut().zip(&slopes) {
        flux.std_reflected = fit.errors.propagated(r);
        flux.std_transmitted = fit.errors.propagated(t);
    }
    all
}

/// Derivatives of R and T at each incidence with respect to a parameter: between the fluxes half a standard error off on either
/// side, or from those of the fit where one side is out of the domain. One side alone would add the curvature to the slope.
fn moved(
    method: &dyn Method,
    fit: &Fit,
    task: &Task<'_>,
    (centre, name): (&[Flux], &str),
    watch: Watch<'_>,
) -> Option<Vec<[f64; 2]>> {
    let own = method.parameters();
    if name != "ior" && !own.iter().any(|p| p.name == name) {
        return None; // of the instrument: it moves no flux
    }
    let step = 0.5 * fit.parameters.iter().find(|p| p.name == name)?.std_error?;
    if !(step > 0.0 && step.is_finite()) {
        return None;
    }
    let at = |by: f64| {
        let at = |p: &crate::fit::Fitted| if p.name == name { p.value + by } else { p.value };
        let values: Vec<f64> = fit.parameters.iter().take(own.len()).map(at).collect();
        let ior = fit.ior.map(|ior| if name == "ior" { ior + by } else { ior });
        let body = ior.map_or(task.options.body, |ior| Body::Dielectric { ior });
        Some((by, fluxes(&method.boundary(&values, body).ok()?, watch)))
    };
    let (above, below) = match (at(step), at(-step)) {
        (Some(above), Some(below)) => (above, below),
        (Some(one), None) | (None, Some(one)) => (one, (0.0, centre.to_vec())),
        (None, None) => return None,
    };
    let by = above.0 - below.0;
    let slope = |(a, b): (&Flux, &Flux)| {
        [a.reflected - b.reflected, a.transmitted - b.transmitted].map(|d| d / by)
    };
    Some(above.1.iter().zip(&below.1).map(slope).collect())
}

/// Why the readings of a BSDF cannot be, whatever the law: the light that they carry by themselves; `None` if they can.
///
/// A lobe falls from the azimuth of its peak to that across, so the lesser reading of two at the same angle on both sides of the normal
/// is the least of all azimuths there: `2 pi` times its integral over `f cos(theta) sin(theta)` is less than the light that leaves.
pub(super) fn excess_of_readings(scan: &Measurement) -> Option<String> {
    if scan.quantity() != Quantity::Bsdf || scan.is_relative() {
        return None;
    }
    let least = scan.by_plane().filter(|plane| plane.phi_deg.abs() <= 0.0).map(|plane| {
        let at = |theta: f64| {
            let from = plane.readings.partition_point(|r| r.theta_deg <= theta - SAME_DEG);
            plane.readings.get(from).filter(|r| r.theta_deg < theta + SAME_DEG).map(|r| r.value)
        };
        let both = |r: &Reading| Some((r.theta_deg.to_radians(), r.value.min(at(-r.theta_deg)?)));
        let sides = plane.readings.iter().filter(|r| r.theta_deg >= 0.0).filter_map(both);
        let powers: Vec<(f64, f64)> = sides
            .map(|(theta, f)| (theta, std::f64::consts::PI * f * (2.0 * theta).sin()))
            .collect();
        let part = |pair: &[(f64, f64)]| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0);
        (plane.sigma_deg, powers.windows(2).map(part).sum::<f64>())
    });
    let (sigma, sum) = least.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (sum > 1.0 + 10.0 * TOLERANCE).then(|| {
        format!(
            "the readings at sigma {sigma} deg alone carry at least {sum:.2} times the light that there is:{}",
            unit_of(sum).trim_start_matches([';', ','])
        )
    })
}

/// Why the fluxes cannot be: where most is too much, and what readings would explain it; `None` if they can.
pub(super) fn excess(fit: &Fit, fluxes: &[Flux]) -> Option<String> {
    let level = fit
        .parameters
        .iter()
        .filter(|p| matches!(p.name.strip_suffix('2').unwrap_or(p.name), "gain" | "A" | "b0"));
    let relative = level.filter_map(|p| Some(p.std_error? / p.value)).fold(0.0, f64::max);
    let tolerance = match &fit.boundary {
        Boundary::Wave(_) => MOST_EXCESS,
        _ => TOLERANCE + ERRORS * relative.min(0.05),
    };
    let counts = |f: &&Flux| match &fit.boundary {
        Boundary::Wave(wave) => wave.validity(&[f.incidence_deg]).is_ok_and(|validity| {
            let mine = validity.lobes.iter().filter(|l| side_name(l.side) == f.side);
            mine.clone().count() > 0 && mine.clone().all(|l| l.passes)
        }),
        // where its waves hold is told for its lobes together: its warnings say it
        Boundary::Hybrid(_) => false,
        _ => true,
    };
    let is_too_much = |f: &&Flux| !(f.lost >= -tolerance && f.lost.is_finite());
    let worst =
        fluxes.iter().filter(counts).filter(is_too_much).max_by(|a, b| {
            (a.reflected + a.transmitted).total_cmp(&(b.reflected + b.transmitted))
        })?;
    let sum = worst.reflected + worst.transmitted;
    let normal = fluxes.iter().find(|f| f.side == "air").map_or(sum, |f| f.reflected);
    let what = if worst.transmitted > 0.0 { "R + T" } else { "R" };
    let mut said = format!(
        "{what} = {sum:.3} at {} deg from the {}: more light than there is",
        worst.incidence_deg, worst.side
    );
    if fit.ior.is_none() {
        said += unit_of(normal.max(sum));
    }
    Some(said)
}

/// What readings would make the reflectance of an opaque body so large.
fn unit_of(reflected: f64) -> &'static str {
    if reflected <= std::f64::consts::PI * 1.02 {
        "; divide by pi? Reflectance factors, 1 for white, are pi times the BSDF: --quantity factor; if the readings are \
         percent, divide by 100"
    } else {
        "; are the readings percent (divide by 100; reflectance factors in percent by 100 pi), or counts of a detector \
         (--quantity counts)?"
    }
}
