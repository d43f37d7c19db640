//! Every ray of the field against every triangle: from the far plane and from hit to hit, at both kinds of edges.

use asperity::raytrace::{Fate, Field, Ray};
use asperity::surface::{Edges, HeightMap};
use asperity_core::direction::Direction;
use asperity_tests::oracle::{Vec3, spherical};
use asperity_tests::{count, tolerance};

use super::maps::{EDGES, ETA, noise, waves};
use super::triangles::{Triangles, pair};
use crate::common::Random;

/// What became of the rays of one map.
#[derive(Debug, Default)]
struct Tally {
    rays: usize,
    hits: usize,
    /// From a triangle that was hit before.
    onward: usize,
    /// Reached by a way through an image of the map.
    images: usize,
    /// The same triangle and place.
    same: usize,
    /// The same place on the neighbour.
    neighbours: usize,
    /// What a ray meets that is moved by the tolerance.
    ties: usize,
    worst: f64,
}

const SHIFTS: [f64; 3] = [0.0, -1.0, 1.0];

/// Compares one ray; the field's answer must be the exact one of a ray moved by at most the tolerance.
fn compare(tally: &mut Tally, field: &Field, oracle: &Triangles, ray: &Ray) -> Fate {
    let fate = field.follow(ray);
    let exact = oracle.first(ray, [0.0; 3]);
    let size = oracle.cells[0].max(oracle.cells[1]) as f64 + oracle.top;
    let unit = tolerance::RAY_PLACE.allowed * size;
    tally.rays += 1;
    tally.onward += usize::from(ray.from.is_some());
    tally.hits += usize::from(matches!(fate, Fate::Hits(_)));
    match (&fate, &exact) {
        (Fate::Escapes, None) => {
            tally.same += 1;
            return fate;
        }
        // A ray that only grazes the triangle meets it farther off for the same shift.
        (Fate::Hits(hit), Some(found))
            if oracle.same(hit, found, unit / found.cosine.max(1e-3)) =>
        {
            if hit.triangle == found.triangle {
                tally.same += 1;
            } else {
                tally.neighbours += 1;
            }
            tally.images += usize::from(hit.mirrored != [false; 2]);
            let off = (f64::from(hit.point[2]) - found.point[2]).abs();
            tally.worst = tally.worst.max(off * found.cosine / size);
            return fate;
        }
        _ => {}
    }
    for x in SHIFTS {
        for y in SHIFTS {
            for z in SHIFTS {
                let moved: Vec3 = [x * unit, y * unit, z * unit];
                let agrees = match (&fate, oracle.first(ray, moved)) {
                    (Fate::Escapes, None) => true,
                    (Fate::Hits(hit), Some(f)) => {
                        oracle.same(hit, &f, 4.0 * unit / f.cosine.max(1e-3))
                    }
                    _ => false,
                };
                if agrees {
                    tally.ties += 1;
                    return fate;
                }
            }
        }
    }
    panic!("{ray:?}: {fate:?}, by brute force {exact:?}");
}

/// Rays from the far plane, each followed over some bounces.
fn run(map: &HeightMap, edges: Edges, rays: usize, random: &mut Random) -> Tally {
    let (field, oracle) = pair(map, edges);
    let mut tally = Tally::default();
    for _ in 0..rays {
        let mut above = random.next::<f64>() < 0.5;
        let side = if above { 1.0 } else { -1.0 };
        let theta = random.between(0.0, 1.0).sqrt() * 88.0_f64.to_radians();
        let [x, y, z] = spherical(theta, random.between(0.0, std::f64::consts::TAU));
        let mut travel = Direction::from_unit(x as f32, y as f32, (-side * z) as f32);
        let place = [0, 1].map(|k| random.between(0.0, oracle.cells[k] as f64) as f32);
        let top = (side * oracle.top) as f32;
        let mut ray =
            Ray { origin: [place[0], place[1], top], direction: travel.xyz(), above, from: None };
        for _ in 0..6 {
            let Fate::Hits(hit) = compare(&mut tally, &field, &oracle, &ray) else { break };
            let [mx, my, mz] = hit.normal();
            let m = Direction::from_unit(mx, my, mz);
            let [dx, dy, dz] = travel.xyz();
            let turn = |d: f32, k: usize| if hit.mirrored[k] { -d } else { d };
            let from = Direction::from_unit(-turn(dx, 0), -turn(dy, 1), -dz);
            let relative = if above { ETA as f32 } else { 1.0 / ETA as f32 };
            let through = if random.next::<f64>() < 0.5 { from.refract(m, relative) } else { None };
            above ^= through.is_some();
            travel = through.unwrap_or_else(|| from.reflect(m));
            ray =
                Ray { origin: hit.point, direction: travel.xyz(), above, from: Some(hit.triangle) };
        }
    }
    tally
}

#[test]
fn rays_meet_what_brute_force_over_all_triangles_finds() {
    let mut random = Random::new(5);
    let mut all = Tally::default();
    for (size, pitch) in
        [((7, 5), (0.5, 0.8)), ((17, 23), (1.0, 1.0)), ((64, 33), (2.0, 0.7)), ((2, 3), (1.0, 2.0))]
    {
        for slope in [0.3, 1.0, 3.0] {
            for (name, map) in
                [("noise", noise(size, pitch, slope, 9)), ("waves", waves(size, pitch, slope, 4))]
            {
                for edges in EDGES {
                    let tally = run(&map, edges, count(400), &mut random);
                    println!("{size:?} {name} {slope} {}: {tally:?}", edges.name());
                    all.rays += tally.rays;
                    all.onward += tally.onward;
                    all.images += tally.images;
                    all.ties += tally.ties;
                    all.neighbours += tally.neighbours;
                    all.worst = all.worst.max(tally.worst);
                }
            }
        }
    }
    println!("all: {all:?}");
    assert!(all.rays > 20_000 && all.onward > 10_000 && all.images > 1000, "{all:?}");
    let share = (all.ties + all.neighbours) as f64 / all.rays as f64;
    assert!(share < tolerance::RAY_TIES.allowed, "{all:?}");
}
