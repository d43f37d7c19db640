//! One entry to all engines: quadrature if the boundary can be evaluated, plus the coherent light of waves and
//! tables; else Monte Carlo.

use super::facets;
use super::quadrature::Neglected;
use super::{
    Angles, Effort, Incidence, MonteCarlo, Rays, Readings, Setup, coherent, monte_carlo,
    quadrature, wave,
};
use crate::boundary::{Boundary, with_boundary};
use crate::watch::Watch;

/// Simulates a scan; only a traced boundary uses `rays`.
///
/// `None` if it was stopped before the end of a Monte Carlo simulation. Rays of the same seed are the same for every
/// boundary: two simulations differ by the surface, not by chance.
pub fn simulate(
    boundary: &Boundary,
    setup: &Setup,
    plan: &Angles,
    effort: Effort,
    rays: Rays,
    watch: Watch<'_>,
) -> Option<Readings> {
    if boundary.is_anisotropic() {
        return turned(boundary, setup, plan, effort, watch);
    }
    if let Boundary::Traced(t) = boundary {
        return counted(plan, |angles| {
            facets::read(t, setup, angles, (effort, rays), watch.quiet())
        });
    }
    if let Boundary::Wave(b) = boundary {
        return wave(b, setup, plan, effort, watch.quiet());
    }
    let effort = match (boundary, effort) {
        (Boundary::Table(_), Effort::Full) => Effort::Fine,
        _ => effort,
    };
    let mut readings = with_boundary!(boundary,
    b => quadrature(b, setup, plan, effort),
    traced t => {
        let rays = rays.for_draft(effort);
        return counted(plan, |angles| monte_carlo(t, setup, angles, rays, watch.quiet()));
    });
    if matches!(boundary, Boundary::Table(_)) || boundary.keeps_direction() {
        coherent::add_all(setup, plan, &mut readings.values, |wi| boundary.coherent(wi));
    }
    Some(readings)
}

/// One incidence of a scan by rays: of a traced surface also by a sum over its facets.
///
/// `None` if it was stopped before the end. `watch` is told of more rays.
pub fn by_rays(
    boundary: &Boundary,
    setup: &Setup,
    angles: &Incidence,
    rays: Rays,
    watch: Watch<'_>,
) -> Option<MonteCarlo> {
    match boundary {
        Boundary::Traced(t) => facets::read(t, setup, angles, (Effort::Full, rays), watch),
        other => monte_carlo(other, setup, angles, rays, watch),
    }
}

/// Readings of one incidence after the other; `None` if one of them is not there.
fn counted(plan: &Angles, one: impl Fn(&Incidence) -> Option<MonteCarlo>) -> Option<Readings> {
    let (mut values, mut std_errors, mut halves) =
        (Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
    for angles in &plan.incidences {
        let done = one(angles)?;
        values.extend(done.values);
        std_errors.extend(done.std_errors);
        halves.iter_mut().zip(done.halves).for_each(|(all, half)| all.extend(half));
    }
    Some(Readings {
        values,
        neglected: Neglected::default(),
        std_errors: Some(std_errors),
        halves: Some(halves),
    })
}

/// The same of a law with a direction, rotation by rotation of the sample.
fn turned(
    boundary: &Boundary,
    setup: &Setup,
    plan: &Angles,
    effort: Effort,
    watch: Watch<'_>,
) -> Option<Readings> {
    let same = |a: &Incidence, b: &Incidence| a.rotation_deg.total_cmp(&b.rotation_deg).is_eq();
    let mut all = Readings {
        values: Vec::new(),
        neglected: Neglected::default(),
        std_errors: None,
        halves: None,
    };
    for planes in plan.incidences.chunk_by(same) {
        if watch.is_stopped() {
            return None;
        }
        let there = boundary.turned(setup.turn_deg(planes[0].rotation_deg));
        let part = Angles { incidences: planes.to_vec() };
        let mut found = with_boundary!(&*there,
            law => quadrature(law, setup, &part, effort), traced _t => return None);
        if there.keeps_direction() {
            coherent::add_all(setup, &part, &mut found.values, |wi| there.coherent(wi));
        }
        all.values.extend(found.values);
        all.neglected = all.neglected.or_more(found.neglected);
    }
    Some(all)
}
