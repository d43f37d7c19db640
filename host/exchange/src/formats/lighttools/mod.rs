//! Text BSDF of `LightTools` (Mini-Diff and the like).
//!
//! Layout and meaning: the reader of libbsdf, for no public file is known. Keywords as those of Zemax, then a block for each incidence, side, lobe
//! and tristimulus value. Angles are absolute: `AOI` from the normal of the front, beyond 90 from the back; `ScatterRadial` from the
//! normal of the side the light leaves to (beyond 90 is taken as 180 less the angle), `ScatterAzimuth` about the sample, whose
//! source is at azimuth 90 where there is one `POI` only (libbsdf), else at `POI`. Front is the air. Assumed: the program interpolates linearly.

mod read;
mod write;

use std::f64::consts::FRAC_PI_2;

use super::{Format, Writer};
use crate::interpolation::Interpolation;
use crate::law::{Coordinates, Layout};
use crate::plan::plan;

const NAME: &str = "LightTools";

pub(super) const FORMAT: Format = Format {
    name: "lighttools",
    title: "LightTools text BSDF",
    extensions: &["bsdf"],
    sniff: |source| {
        let text = source.start();
        text.contains("ScatterRadial") && !text.contains("SampleRotation")
    },
    read: Some(read::read),
    write: Some(Writer {
        sample: |law, subject, options| Ok(plan(law, subject, LAYOUT, options)),
        encode: write::encode,
        notes: &["AOI beyond 90 is the back, the inside of the body; the front is the air"],
    }),
};

const LAYOUT: Layout = Layout {
    coordinates: Coordinates::Absolute,
    own_grids: false,
    interpolation: Interpolation::Linear,
};

/// Where libbsdf and the program have the source.
const SOURCE: f64 = FRAC_PI_2;

/// The names of tristimulus values.
const TRISTIMULUS: [&str; 3] = ["TrisX", "TrisY", "TrisZ"];
