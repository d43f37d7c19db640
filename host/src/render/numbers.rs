//! What is seen of each body, in numbers.

use asperity_render::image::Image;
use asperity_render::scene::Scene;
use serde::Serialize;

/// Sines between ray and normal that part a body from its middle to its limb.
const LIMB: [f64; 6] = [0.0, 0.5, 0.8, 0.9, 0.95, 1.0];

/// What is seen of a body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyNumbers {
    /// Its name.
    pub body: String,
    /// Mean radiance over it, in the scene's unit.
    pub mean: f64,
    /// Its standard error.
    pub se: f64,
    /// From its middle to its limb.
    pub limb: Vec<LimbStep>,
    /// Against the reference; `None` of the reference itself and without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference: Option<Difference>,
}

/// A ring of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LimbStep {
    /// Sine between ray and normal, from.
    pub from: f64,
    /// To.
    pub to: f64,
    /// Mean radiance.
    pub mean: f64,
    /// Its standard error.
    pub se: f64,
}

/// Difference of a body from that in a reference, in % of its mean radiance there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Of the mean.
    pub mean_percent: f64,
    /// Root mean square over its pixels; the noise of both images is in it.
    pub rms_percent: f64,
    /// What noise alone would make of it.
    pub noise_percent: f64,
    /// The largest, in size.
    pub max_percent: f64,
}

/// The numbers of all bodies that are seen.
pub fn body_numbers(scene: &Scene, image: &Image, reference: Option<&Image>) -> Vec<BodyNumbers> {
    let seen = seen_first(scene, image.pixels);
    let mut all = Vec::new();
    for (number, body) in scene.bodies.iter().enumerate() {
        let sum = image.body(number);
        if sum.all().count < 2.0 {
            continue;
        }
        let (mean, se) = sum.all().mean();
        let ring = |pair: &[f64]| {
            let step = sum.between(pair[0], pair[1]);
            let (mean, se) = step.mean();
            (step.count >= 2.0).then_some(LimbStep { from: pair[0], to: pair[1], mean, se })
        };
        let limb = LIMB.windows(2).filter_map(ring).collect();
        let difference = reference.and_then(|reference| {
            let places: Vec<[u32; 2]> =
                seen.iter().filter(|(_, b)| *b == Some(number)).map(|(place, _)| *place).collect();
            difference(image, reference, &places)
        });
        all.push(BodyNumbers { body: body.name.clone(), mean, se, limb, difference });
    }
    all
}

/// The body in the middle of each pixel.
fn seen_first(scene: &Scene, [across, down]: [u32; 2]) -> Vec<([u32; 2], Option<usize>)> {
    let camera = scene.camera.with_pixels([across, down]);
    let at = |[x, y]: [u32; 2]| {
        let ray = camera.ray([f64::from(x) + 0.5, f64::from(y) + 0.5]);
        scene.nearest(&ray, f64::INFINITY).map(|meeting| meeting.body)
    };
    let places = (0..down).flat_map(|y| (0..across).map(move |x| [x, y]));
    places.map(|place| (place, at(place))).collect()
}

fn difference(image: &Image, reference: &Image, places: &[[u32; 2]]) -> Option<Difference> {
    let n = places.len() as f64;
    let (mut ours, mut theirs, mut squares, mut noise, mut largest) = (0.0, 0.0, 0.0, 0.0, 0.0_f64);
    for [x, y] in places {
        let (a, b) = (image.pixel(*x, *y), reference.pixel(*x, *y));
        let (la, lb) = (a.radiance / a.count.max(1.0), b.radiance / b.count.max(1.0));
        ours += la;
        theirs += lb;
        squares += (la - lb) * (la - lb);
        noise += a.std_error().powi(2) + b.std_error().powi(2);
        largest = if (la - lb).abs() > largest.abs() { la - lb } else { largest };
    }
    let scale = 100.0 * n / theirs;
    (theirs > 0.0).then(|| Difference {
        mean_percent: 100.0 * (ours / theirs - 1.0),
        rms_percent: scale * (squares / n).sqrt(),
        noise_percent: scale * (noise / n).sqrt(),
        max_percent: scale * largest,
    })
}
