//! One entry to all engines: quadrature if the boundary can be evaluated, plus the coherent light of waves and
//! tables; else Monte Carlo.

use super::quadrature::Neglected;
use super::{
    Angles, Effort, Incidence, Rays, Readings, Setup, coherent, monte_carlo, quadrature, wave,
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
        let (mut values, mut std_errors) = (Vec::new(), Vec::new());
        for angles in &plan.incidences {
            let done = monte_carlo(t, setup, angles, rays, watch.quiet())?;
            values.extend(done.values);
            std_errors.extend(done.std_errors);
        }
        return Some(Readings {
            values,
            neglected: Neglected::default(),
            std_errors: Some(std_errors),
        });
    });
    if matches!(boundary, Boundary::Table(_)) || boundary.keeps_direction() {
        coherent::add_all(setup, plan, &mut readings.values, |wi| boundary.coherent(wi));
    }
    Some(readings)
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
    let mut all =
        Readings { values: Vec::new(), neglected: Neglected::default(), std_errors: None };
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
