//! The grid of a law: angles that meet a tolerance under the interpolation of a reader.

use crate::frame::{Frame, specular};
use crate::law::{Capped, Coordinates, Law, Layout, Options, Subject};
use crate::refine::{At, Refined};
use crate::sampled::SampledBsdf;

/// Samples a law on a grid whose interpolation is as near to it as `options` ask, or as near as `most_nodes` allow.
pub fn plan(law: &dyn Law, subject: &Subject, layout: Layout, options: &Options) -> SampledBsdf {
    let law = &Capped(law);
    let mut sampled = subject.empty(layout.interpolation);
    let ratio = sampled.ratio();
    let mut frames = Vec::new();
    for &[theta, phi] in &options.incidences {
        let ray = specular(theta, ratio);
        let frame = match (layout.coordinates, ray) {
            (Coordinates::Absolute, _) => Frame::Absolute,
            (Coordinates::Specular, Some(theta)) => Frame::Specular { theta },
            (Coordinates::Cosines, Some(theta)) => Frame::Cosines { theta },
            (Coordinates::Specular | Coordinates::Cosines, None) => continue,
        };
        frames.push(At { incidence: [theta, phi], frame, ray });
    }
    let groups: Vec<&[At]> =
        if layout.own_grids { frames.chunks(1).collect() } else { vec![&frames[..]] };
    // text of more than a quarter is more than its readers like
    let share = options.most_nodes / 4 / groups.len().max(1);
    for group in groups.into_iter().filter(|g| !g.is_empty()) {
        let mut refined = Refined::new(law, group, subject.symmetry, layout, options);
        refined.refine(share);
        sampled.incidences.extend(refined.incidences());
    }
    sampled
}
