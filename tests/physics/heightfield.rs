//! Rays on a height map against brute force over all triangles, and against what must hold.

use std::sync::Arc;

use asperity::raytrace::{Fate, Field, Ray, TracedBoundary};
use asperity::surface::{Edges, HeightMap};
use asperity_core::bsdf::Scatter;
use asperity_core::direction::Direction;
use asperity_core::fresnel;
use asperity_core::math::Real;
use asperity_core::quantity::RelativeIor;
use rand_pcg::Pcg64Mcg;

/// Heights drawn from a seeded generator, scaled to a given largest slope between neighbours.
fn rough(nx: usize, ny: usize, pitch: (f64, f64), slope: f64, seed: u64) -> HeightMap {
    let mut generator = Pcg64Mcg::new(u128::from(seed));
    let heights = (0..nx * ny).map(|_| f64::uniform(&mut generator) * slope * pitch.0).collect();
    HeightMap::new((nx, ny), pitch, heights).unwrap()
}

type Vector = [f64; 3];

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Distance to a triangle by Cramer's rule, if the ray meets it ahead.
fn triangle(o: Vector, d: Vector, [a, b, c]: [Vector; 3]) -> Option<f64> {
    let (e1, e2, s) = (minus(b, a), minus(c, a), minus(o, a));
    let p = cross(d, e2);
    let determinant = dot(p, e1);
    let q = cross(s, e1);
    let (u, v, t) = (dot(p, s) / determinant, dot(q, d) / determinant, dot(q, e2) / determinant);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

/// Nearest triangle over many copies of the grid; distances in pitches along x.
fn brute_force(map: &HeightMap, middle: f64, o: Vector, d: Vector, copies: i64) -> Option<f64> {
    let (nx, ny) = (map.nx() as i64, map.ny() as i64);
    let aspect = map.dy_um() / map.dx_um();
    let node = |x: i64, y: i64| {
        let h = map.height_um(x.rem_euclid(nx) as usize, y.rem_euclid(ny) as usize).unwrap();
        [x as f64, y as f64 * aspect, (h - middle) / map.dx_um()]
    };
    let mut nearest: Option<f64> = None;
    for y in -copies * ny..(copies + 1) * ny {
        for x in -copies * nx..(copies + 1) * nx {
            let [a, b, c, e] = [node(x, y), node(x + 1, y), node(x, y + 1), node(x + 1, y + 1)];
            for corners in [[a, b, e], [a, c, e]] {
                if let Some(t) = triangle(o, d, corners) {
                    nearest = Some(nearest.map_or(t, |n: f64| n.min(t)));
                }
            }
        }
    }
    nearest
}

#[test]
fn rays_from_above_and_below_meet_what_brute_force_finds() {
    let mut generator = Pcg64Mcg::new(5);
    let mut uniform = || f64::uniform(&mut generator);
    for (nx, ny, pitch, slope) in
        [(8, 8, (1.0, 1.0), 0.7), (7, 5, (0.5, 0.8), 2.0), (2, 3, (2.0, 1.0), 0.3)]
    {
        let map = rough(nx, ny, pitch, slope, 9);
        let field = Field::new(&map, Edges::Periodic).unwrap();
        let (low, high) = map
            .points()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.2), b.max(p.2)));
        let (middle, top) = (0.5 * (low + high), 0.5 * (high - low) / map.dx_um());
        for _ in 0..400 {
            let above = uniform() < 0.5;
            let side = if above { 1.0 } else { -1.0 };
            let theta = 1.2 * uniform();
            let phi = std::f64::consts::TAU * uniform();
            let direction = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), -side * theta.cos()];
            let cells = [uniform() * nx as f64, uniform() * ny as f64];
            let ray = Ray {
                origin: [cells[0] as f32, cells[1] as f32, (side * top) as f32],
                direction: direction.map(|c| c as f32),
                above,
                from: None,
            };
            let aspect = map.dy_um() / map.dx_um();
            let origin = [
                f64::from(ray.origin[0]),
                f64::from(ray.origin[1]) * aspect,
                // from a little outside, so that a start on a peak counts
                f64::from(ray.origin[2]) + side * 1e-9,
            ];
            let far = brute_force(&map, middle, origin, ray.direction.map(f64::from), 4).unwrap();
            let Fate::Hits(hit) = field.follow(&ray) else { panic!("{ray:?} went through") };
            // compare heights: x and y may have gone around the grid
            let z = origin[2] + far * f64::from(ray.direction[2]);
            assert!((f64::from(hit.point[2]) - z).abs() < 1e-4, "{nx} {ray:?} {hit:?} {z}");
        }
    }
}

#[test]
fn a_flat_map_is_the_smooth_boundary() {
    let map = HeightMap::new((4, 3), (1.0, 1.5), vec![2.5; 12]).unwrap();
    let field = Arc::new(Field::new(&map, Edges::Periodic).unwrap());
    let eta = RelativeIor::new(1.49).unwrap();
    let boundary = TracedBoundary { field, eta };
    let mut generator = Pcg64Mcg::new(3);
    for (z, n) in [(0.9, 1.49), (0.3, 1.49), (-0.9, 1.0 / 1.49), (-0.4, 1.0 / 1.49)] {
        let x: f64 = -Real::sqrt(1.0 - z * z);
        let wi = Direction::from_unit(x, 0.0, z);
        let expected = fresnel::dielectric(f64::abs(z), n).reflected;
        let (mut reflected, rays) = (0.0, 20_000);
        for _ in 0..rays {
            let ray = boundary.sample(wi, &mut || f64::uniform(&mut generator)).unwrap();
            let stays = (ray.wo.z() > 0.0) == (z > 0.0);
            reflected += f64::from(u8::from(stays));
            let sine = if stays { -x } else { -x / n };
            assert!((ray.wo.x() - sine).abs() < 1e-6, "{z} {ray:?}");
        }
        let sigma = (expected * (1.0 - expected) / f64::from(rays)).sqrt();
        assert!((reflected / f64::from(rays) - expected).abs() <= 4.0 * sigma + 1e-9, "{z}");
    }
}

#[test]
fn no_ray_is_lost_on_steep_surfaces_at_grazing_incidence() {
    let eta = RelativeIor::new(1.49).unwrap();
    let mut generator = Pcg64Mcg::new(8);
    for (slope, seed) in [(0.3, 1), (1.0, 2), (3.0, 3)] {
        let map = rough(64, 48, (1.0, 1.0), slope, seed);
        let field = Arc::new(Field::new(&map, Edges::Periodic).unwrap());
        let boundary = TracedBoundary { field, eta };
        for theta in [0.0_f64, 45.0, 85.0, 89.99] {
            for side in [1.0, -1.0] {
                let (s, c) = theta.to_radians().sin_cos();
                let wi = Direction::from_unit(-s * 0.8, -s * 0.6, side * c);
                let lost = (0..20_000)
                    .filter(|_| boundary.sample(wi, &mut || f64::uniform(&mut generator)).is_none())
                    .count();
                assert_eq!(lost, 0, "slope {slope}, {theta} deg, side {side}");
            }
        }
    }
}

#[test]
fn spikes_and_tiny_maps_neither_panic_nor_hang() {
    let eta = RelativeIor::new(1.49).unwrap();
    let mut generator = Pcg64Mcg::new(4);
    let mut spike = vec![0.0; 256];
    spike[100] = 1e4;
    for heights in [spike, vec![0.0; 256], (0..256).map(|k| f64::from(k % 2)).collect()] {
        let map = HeightMap::new((16, 16), (1.0, 1.0), heights).unwrap();
        let field = Arc::new(Field::new(&map, Edges::Periodic).unwrap());
        let boundary = TracedBoundary { field, eta };
        for z in [1.0, 0.1, 1e-4, -1e-4, -1.0] {
            let wi = Direction::new(-1.0 + f64::abs(z), 0.1, z).unwrap();
            for _ in 0..200 {
                if let Some(ray) = boundary.sample(wi, &mut || f64::uniform(&mut generator)) {
                    assert!((ray.wo.dot(ray.wo) - 1.0).abs() < 1e-9 && ray.weight <= 1.0);
                }
            }
        }
    }
    let small = HeightMap::new((2, 1), (1.0, 1.0), vec![0.0; 2]).unwrap();
    assert!(Field::new(&small, Edges::Periodic).is_err());
    let holed = HeightMap::new((2, 2), (1.0, 1.0), vec![0.0, f64::NAN, 1.0, 2.0]).unwrap();
    assert!(Field::new(&holed, Edges::Periodic).is_err());
}
