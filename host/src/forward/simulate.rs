//! One entry to all engines: quadrature if the boundary can be evaluated, plus the coherent light of waves and
//! tables; else Monte Carlo.

use super::quadrature::Neglected;
use super::{Angles, Effort, Rays, Readings, Setup, coherent, monte_carlo, quadrature, wave};
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
    if matches!(boundary, Boundary::Table(_) | Boundary::Tail(_)) {
        coherent::add_all(setup, plan, &mut readings.values, |wi| boundary.coherent(wi));
    }
    Some(readings)
}
