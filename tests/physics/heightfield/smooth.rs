//! A flat map is the smooth boundary, alone and in a plate.

use asperity::surface::HeightMap;
use asperity_core::bsdf::{Scatter, Scattered, Smooth};
use asperity_core::direction::Direction;
use asperity_core::plate::{Plate, RoughSide};
use asperity_tests::tolerance;

use super::maps::{EDGES, ETA, boundary, stream};
use crate::common::{Random, dir, incidence, ior};

fn flat() -> HeightMap {
    HeightMap::new((4, 3), (1.0, 1.5), vec![2.5; 12]).unwrap()
}

#[test]
fn a_flat_map_is_the_smooth_boundary() {
    let mut random = Random::new(3);
    let smooth = Smooth { eta: ior(ETA) };
    let (mut worst, mut total) = (0.0_f64, 0);
    for edges in EDGES {
        let boundary = boundary(&flat(), edges);
        // from the glass: below and beyond total reflection (42.16 deg)
        for degrees in [0.0, 10.0, 42.0, 42.3, 60.0, 85.0, 89.9] {
            for air in [true, false] {
                let wi = dir(incidence(degrees, air));
                for _ in 0..300 {
                    let u: [f64; 3] = [0; 3].map(|_| random.next());
                    let mut given = u.iter().copied();
                    let found = boundary.sample(wi, &mut || given.next().unwrap()).unwrap();
                    let f = smooth.fresnel(wi).reflected;
                    if (u[2] - f).abs() < tolerance::FLAT.allowed {
                        continue; // too near to say which way it goes
                    }
                    let expected = smooth.sample(wi, &mut || u[2]).unwrap();
                    assert!((found.weight - 1.0).abs() < 1e-12);
                    let apart = apart(found.wo, expected.wo);
                    assert!(
                        apart < tolerance::FLAT.allowed,
                        "{degrees} {air} {found:?} {expected:?}"
                    );
                    worst = worst.max(apart);
                    total += usize::from(!air && degrees > 42.2);
                    assert!(air || degrees < 42.2 || found.wo.z() < 0.0, "{degrees}");
                }
            }
        }
    }
    println!("worst deviation {worst:.1e}, {total} rays of total reflection");
}

/// Largest difference of two directions in x and y and in the square of z: near grazing a cosine is the
/// root of a rounded difference.
fn apart(a: Direction<f64>, b: Direction<f64>) -> f64 {
    let [ax, ay, az] = a.xyz();
    let [bx, by, bz] = b.xyz();
    let sides = if az * bz > 0.0 { 0.0 } else { 1.0 };
    sides + (ax - bx).abs().max((ay - by).abs()).max((az * az - bz * bz).abs())
}

/// The smooth face, which leaves out the two numbers that a traced one takes for the place.
struct Spared(Smooth<f64>);

impl Scatter<f64> for Spared {
    fn sample(
        &self,
        wi: Direction<f64>,
        uniform: &mut impl FnMut() -> f64,
    ) -> Option<Scattered<f64>> {
        let _place = [uniform(), uniform()];
        self.0.sample(wi, uniform)
    }
}

#[test]
fn a_plate_with_a_flat_traced_face_is_the_plate_with_two_smooth_faces() {
    let smooth = Smooth { eta: ior(ETA) };
    for side in [RoughSide::Source, RoughSide::Detector] {
        let flat = boundary(&flat(), EDGES[0]);
        let traced = Plate::new(flat, ior(ETA), side);
        let twin = Plate::new(Spared(smooth), ior(ETA), side);
        for degrees in [0.0, 30.0, 60.0, 85.0] {
            let wi = dir(incidence(degrees, true));
            for ray in 0..500 {
                let mut left = [Vec::new(), Vec::new()];
                let [a, b] = &mut left;
                let mut random = stream(ray);
                let one = traced.trace(wi, &mut || random.next(), &mut |w, f| a.push((w, f)));
                let mut random = stream(ray);
                let two = twin.trace(wi, &mut || random.next(), &mut |w, f| b.push((w, f)));
                let flux = (one.reflected - two.reflected).abs()
                    + (one.transmitted - two.transmitted).abs()
                    + (one.lost - two.lost).abs();
                let case = format!("{side:?} {degrees} ray {ray}: {one:?} {two:?}");
                // what is passed on to the smooth face is split there, by a single cosine
                assert!(flux < tolerance::FLAT_PLATE.allowed, "{case}");
                assert_eq!(left[0].len(), left[1].len(), "{case}");
                for (p, q) in left[0].iter().zip(&left[1]) {
                    assert!((p.1 - q.1).abs() < tolerance::FLAT_PLATE.allowed, "{case}");
                    assert!(apart(p.0, q.0) < tolerance::FLAT_PLATE.allowed, "{case}");
                }
            }
        }
    }
}
