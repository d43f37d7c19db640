//! Files of means over patches beside the law.

use crate::compare::Row;
use crate::formats::seen;
use crate::law::Law;
use crate::sampled::SampledBsdf;

/// Files of patches beside the law: flux against its mean over the incident patch, values against means over both; `None` for other files.
///
/// The largest values are those of means too.
pub fn compare_patches(file: &SampledBsdf, law: &dyn Law) -> Option<Vec<Row>> {
    let seen = seen(file, law)?;
    let row = |(k, seen): (usize, &crate::patches::Seen)| {
        let incidence = &file.incidences[k];
        let values = file.band(k, 0);
        let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        let distance = |(a, b): (&f64, &f64)| (a - b).abs();
        let worst = values.iter().zip(&seen.means).map(distance).fold(0.0, f64::max);
        let peak_law = most(&seen.means);
        Row {
            incidence_deg: incidence.theta.to_degrees(),
            rotation_deg: incidence.phi.to_degrees(),
            nodes: values.len(),
            node_error_percent: if peak_law > 0.0 { 100.0 * worst / peak_law } else { 0.0 },
            flux_law: seen.flux,
            flux_file: file.flux(k, 0),
            flux_stated: None,
            peak_law,
            peak_file: most(values),
        }
    };
    Some(seen.iter().enumerate().map(row).collect())
}
