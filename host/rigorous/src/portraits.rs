//! One profile by all methods: the rigorous solution, Kirchhoff's integral, rays and single facets, lobe by lobe.
//!
//! An order counts as spread over the angles between its neighbours, and rays are gathered in the same cells: what a short period
//! blurs, it blurs in all curves alike. So it is in the atlas.

use std::ops::ControlFlow;

use num_complex::Complex64;

use crate::accuracy::solve;
use crate::angles::{Angles, Gathered};
use crate::cells::Cells;
use crate::ensemble::{EnsembleWatcher, Light};
use crate::facets::{Facets, gather};
use crate::kirchhoff::kirchhoff;
use crate::problem::{Incidence, Problem, RigorousError, Side};
use crate::question::{KINDS, LIGHTS, Piece, Question, WINDOW_DEG, angles};
use crate::rays::follow;
use crate::stage::Stage;
use crate::sums::{Record, Sample};
use crate::waves::{Kind, Order, Response};

/// Everything about one profile.
pub(crate) struct Portrait {
    pub(crate) incidences_deg: Vec<f64>,
    /// Lobe by lobe, in the order of [`crate::Verdicts::lobes`].
    pub(crate) samples: Vec<Sample>,
    /// Of a solved profile, lobe by lobe.
    pub(crate) single_orders_percent: Vec<f64>,
    pub(crate) energy_error: f64,
    pub(crate) nodes: usize,
    pub(crate) rays_lost: f64,
}

impl Portrait {
    pub(crate) fn of(
        piece: &Piece,
        question: &Question,
        watcher: EnsembleWatcher<'_>,
    ) -> Result<Self, RigorousError> {
        let Piece { ref profile, is_solved, block } = *piece;
        let problem = Problem::new(profile.clone(), question.index, question.wavelength_um)?;
        let order = |&(side, angle_deg): &(Side, f64)| {
            let sine = if angle_deg.abs() < 90.0 { angle_deg.to_radians().sin() } else { 2.0 };
            Incidence { side, order: (sine / problem.sine(side, 1)).round() as i32 }
        };
        let incidences: Vec<Incidence> = question.incidences.iter().map(order).collect();
        let stage = |stage: Stage| watcher(if stage.run == 1 { stage.done } else { 1.0 });
        let solution = is_solved
            .then(|| solve(&problem, &incidences, question.accuracy, &stage))
            .transpose()?;
        let waves = kirchhoff(&problem, &incidences)?;
        let facets = Facets::new(&problem);
        let mut portrait = Self {
            incidences_deg: Vec::new(),
            samples: Vec::new(),
            single_orders_percent: Vec::new(),
            energy_error: solution.as_ref().map_or(0.0, |s| s.energy_error),
            nodes: solution.as_ref().map_or(0, |s| s.nodes),
            rays_lost: 0.0,
        };
        for (at, incidence) in incidences.iter().enumerate() {
            if watcher(1.0) == ControlFlow::Break(()) {
                return Err(RigorousError::Stopped);
            }
            let rays = follow(&problem, &facets, *incidence, question.rays)?;
            portrait.rays_lost = rays.lost.iter().copied().fold(portrait.rays_lost, f64::max);
            let single = gather(&problem, &facets, *incidence)?;
            let sine = problem.sine(incidence.side, incidence.order);
            portrait.incidences_deg.push(sine.asin().to_degrees());
            let views = Views {
                block,
                rigorous: solution.as_ref().map(|s| &s.responses[at]),
                kirchhoff: &waves[at],
                rays: &rays.gathered,
                facets: &single,
            };
            for kind in KINDS {
                for light in LIGHTS {
                    portrait.samples.push(views.sample(kind, light));
                    portrait.single_orders_percent.extend(views.single_orders(kind, light));
                }
            }
        }
        Ok(portrait)
    }
}

/// One incidence on one profile, by all methods.
struct Views<'a> {
    block: usize,
    rigorous: Option<&'a Response>,
    kirchhoff: &'a Response,
    /// TE, TM, unpolarised.
    rays: &'a [Gathered; 3],
    facets: &'a [Gathered; 3],
}

impl Views<'_> {
    fn sample(&self, kind: Kind, light: Light) -> Sample {
        let cells = Cells::new(&self.kirchhoff.te, kind, self.kirchhoff.incidence.order);
        let at = match light {
            Light::Te => 0,
            Light::Tm => 1,
            Light::Unpolarised => 2,
        };
        let of_waves = |response: &Response| of_orders(response, &cells, shares(light));
        Sample {
            block: self.block,
            rigorous: self.rigorous.map(of_waves),
            approximations: [
                of_waves(self.kirchhoff),
                of_rays(self.rays[at].of(kind), &cells),
                of_rays(self.facets[at].of(kind), &cells),
            ],
        }
    }

    /// Rms over the orders of what Kirchhoff is off by, % of the strongest.
    fn single_orders(&self, kind: Kind, light: Light) -> Option<f64> {
        let rigorous = self.rigorous?;
        let powers = |response: &Response| -> Vec<f64> {
            let pairs = response.te.iter().zip(&response.tm).filter(|pair| pair.0.kind == kind);
            pairs.map(|(te, tm)| power(te, tm, shares(light))).collect()
        };
        let (exact, found) = (powers(rigorous), powers(self.kirchhoff));
        let peak = exact.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let square: f64 = exact.iter().zip(&found).map(|(a, b)| (a - b).powi(2)).sum();
        Some(100.0 * (square / exact.len().max(1) as f64).sqrt() / peak)
    }
}

/// Of TE and TM.
pub(crate) fn shares(light: Light) -> [f64; 2] {
    match light {
        Light::Te => [1.0, 0.0],
        Light::Tm => [0.0, 1.0],
        Light::Unpolarised => [0.5, 0.5],
    }
}

fn power(te: &Order, tm: &Order, [of_te, of_tm]: [f64; 2]) -> f64 {
    of_te * te.efficiency() + of_tm * tm.efficiency()
}

fn of_orders(response: &Response, cells: &Cells, shares: [f64; 2]) -> Record {
    let [te, tm] = [&response.te, &response.tm].map(|orders| &orders[cells.range.clone()]);
    let powers: Vec<f64> = te.iter().zip(tm).map(|(te, tm)| power(te, tm, shares)).collect();
    let mut alone = vec![0.0; powers.len()];
    let mut specular = [Complex64::ZERO; 2];
    if let Some(at) = cells.specular {
        alone[at] = 1.0;
        specular = [te[at].amplitude, tm[at].amplitude];
    }
    let curve =
        |powers: &[f64]| angles().map(|angle| cells.density(powers, angle, WINDOW_DEG)).collect();
    Record { curve: curve(&powers), cell: curve(&alone), total: powers.iter().sum(), specular }
}

fn of_rays(rays: &Angles, cells: &Cells) -> Record {
    let powers: Vec<f64> =
        cells.edges_deg.windows(2).map(|cell| rays.between(cell[0], cell[1])).collect();
    let curve = angles().map(|angle| cells.density(&powers, angle, WINDOW_DEG)).collect();
    Record { curve, cell: Vec::new(), total: rays.total(), specular: [Complex64::ZERO; 2] }
}
