//! What it would cost to model everything.

use asperity_core::bsdf::LobeSet;

use super::cost::{Costs, Way};
use super::decide::incidences;
use super::evaluator::{Grid, files, table, writer};
use super::measuring;
use super::record::CostRecord;
use super::scene::{Scene, TargetKind};
use super::study::Study;

/// What it costs to model everything.
pub(super) fn everything(scene: &Scene, study: &Study, costs: &Costs) -> CostRecord {
    let method = &study.law.method;
    let fits = ["ggx", "normals", "heights", "measured-ray", "measured-wave"];
    let fit_s = fits.iter().filter_map(|m| costs.fit_s(m)).sum();
    let mut all = CostRecord {
        bytes: None,
        instructions: None,
        eval_ns: costs.of(method, Way::Double).eval_ns,
        fit_s: Some(fit_s),
        measure_h: Some(measuring::usual_hours()),
    };
    match scene.target.kind {
        TargetKind::CortexM4f => {
            let double = costs.of(method, Way::Double);
            let lookup = costs.of("", Way::Table);
            if double.code_bytes.is_some() {
                (all.bytes, all.instructions) = (double.code_bytes, double.instructions);
            } else {
                all.bytes = table(&study.full, LobeSet::ALL, 1 << 15)
                    .ok()
                    .zip(lookup.code_bytes)
                    .map(|(made, code)| made.bytes() + code);
                all.instructions = lookup.instructions;
            }
        }
        TargetKind::Zemax | TargetKind::Radiance => {
            let grid = Grid { incidences_deg: incidences(5.0, 85.0), tolerance_percent: 0.5 };
            let format = scene.target.kind.format().unwrap_or_default();
            let made = writer(format).map(|writer| {
                let each = LobeSet::ORDER.into_iter().filter_map(|(side, lobe)| {
                    let lobes = LobeSet::of(side, lobe);
                    files(&study.full, lobes, (&writer, &grid), 550.0).ok()
                });
                each.map(|files| files.bytes).sum()
            });
            all.bytes = made;
        }
        TargetKind::Host | TargetKind::Mitsuba => {}
    }
    all
}
