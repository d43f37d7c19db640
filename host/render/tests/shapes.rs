//! Rays against every shape: where they meet it by other means, and that none gets out of a closed one.
#![allow(clippy::unwrap_used, reason = "a test may fail")]
#![allow(clippy::disallowed_methods, reason = "oracles use the platform's mathematics")]

use std::fmt::Write as _;
use std::path::Path;

use asperity_core::math::Real;
use asperity_render::ray::Ray;
use asperity_render::shape::{Cuboid, Cylinder, Mesh, OpenFaces, Shape, Sphere, Torus};
use glam::DVec3;
use rand_pcg::Pcg64Mcg;

fn direction(numbers: &mut Pcg64Mcg) -> DVec3 {
    loop {
        let v = DVec3::from_array([(); 3].map(|()| 2.0 * f64::uniform(numbers) - 1.0));
        let square = v.length_squared();
        if square > 0.01 && square < 1.0 {
            return v / square.sqrt();
        }
    }
}

/// The surface of a shape as a function: above 0 outside.
type Implicit = fn(DVec3) -> f64;

const RING: f64 = 0.055;
const TUBE: f64 = 0.022;

fn torus(p: DVec3) -> f64 {
    let radial = p.x.hypot(p.y) - RING;
    radial.hypot(p.z) - TUBE
}

fn sphere(p: DVec3) -> f64 {
    p.length() - 0.06
}

fn cylinder(p: DVec3) -> f64 {
    (p.x.hypot(p.y) - 0.03).max(p.z.abs() - 0.05)
}

fn cuboid(p: DVec3) -> f64 {
    (p.abs() - DVec3::new(0.07, 0.005, 0.05)).max_element()
}

fn shapes() -> Vec<(Shape, Implicit)> {
    let corner = DVec3::new(0.07, 0.005, 0.05);
    let ends = [DVec3::new(0.0, 0.0, -0.05), DVec3::new(0.0, 0.0, 0.05)];
    vec![
        (Shape::Torus(Torus::new(DVec3::ZERO, DVec3::Z, RING, TUBE).unwrap()), torus),
        (Shape::Sphere(Sphere { centre: DVec3::ZERO, radius: 0.06 }), sphere),
        (Shape::Cylinder(Cylinder::new(ends, 0.03, true).unwrap()), cylinder),
        (
            Shape::Cuboid(Cuboid { lower: -corner, upper: corner, open: OpenFaces::default() }),
            cuboid,
        ),
    ]
}

/// Of a million rays each first meeting is on the surface, and nothing of the surface lies before it.
#[test]
fn first_meetings_are_on_the_surface_and_none_is_before_them() {
    for (shape, implicit) in shapes() {
        let mut numbers = Pcg64Mcg::new(17);
        let mut hits = 0;
        for k in 0..1_000_000 {
            let aim =
                0.1 * DVec3::from_array([(); 3].map(|()| 2.0 * f64::uniform(&mut numbers) - 1.0));
            let d = direction(&mut numbers);
            let ray = Ray { origin: aim - d, direction: d };
            let found = shape.nearest(&ray, f64::INFINITY);
            if let Some(near) = found {
                hits += 1;
                let surface = shape.surface(&ray, near);
                assert!(implicit(surface.point).abs() < 1e-15, "{shape:?} {ray:?}");
                assert!(
                    (surface.point - ray.at(near.distance)).length() < 1e-9,
                    "{shape:?} {ray:?}"
                );
                assert!(surface.normal.dot(d) < 1e-6, "{shape:?} {ray:?}: met from inside");
                assert!((surface.normal.length() - 1.0).abs() < 1e-12);
            }
            // by marching: the distance to the surface is at least that to its first meeting
            if k % 100 == 0 {
                let mut at = 0.0;
                let end = found.map_or(2.0, |near| near.distance - 1e-7);
                for _ in 0..2000 {
                    let gap = implicit(ray.at(at));
                    assert!(gap > 0.0, "{shape:?} {ray:?}: inside at {at} before {found:?}");
                    at += gap.max(1e-6);
                    if at >= end {
                        break;
                    }
                }
            }
        }
        assert!(hits > 100_000, "{hits}");
    }
}

/// A million chords inside: each begins a little inside the surface, and ends on it.
#[test]
fn no_ray_leaks_out() {
    for (shape, implicit) in shapes() {
        let mut numbers = Pcg64Mcg::new(23);
        let start = Ray { origin: DVec3::new(1.0, 0.001, 0.002), direction: -DVec3::X };
        let near = shape.nearest(&start, f64::INFINITY).unwrap();
        let mut surface = shape.surface(&start, near);
        for _ in 0..1_000_000 {
            let d = direction(&mut numbers);
            let inwards = if d.dot(surface.normal) > 0.0 { -d } else { d };
            let ray = Ray { origin: surface.point - 1e-10 * surface.normal, direction: inwards };
            let near = shape.nearest(&ray, f64::INFINITY);
            let near = near.unwrap_or_else(|| panic!("{shape:?} {ray:?} leaks"));
            surface = shape.surface(&ray, near);
            assert!(implicit(surface.point).abs() < 1e-15);
            assert!(surface.normal.dot(inwards) > -1e-6, "{shape:?} {ray:?} from outside");
        }
    }
}

/// A sphere of triangles, as OBJ, and the same as PLY.
#[test]
fn meshes_of_files_are_met_as_their_shape() {
    let (around, down) = (64, 32);
    let mut points = Vec::new();
    for j in 0..=down {
        for i in 0..around {
            let (s, c) = (std::f64::consts::PI * f64::from(j) / f64::from(down)).sin_cos();
            let (sp, cp) = (std::f64::consts::TAU * f64::from(i) / f64::from(around)).sin_cos();
            points.push(DVec3::new(s * cp, s * sp, c));
        }
    }
    let mut faces = Vec::new();
    for j in 0..down {
        for i in 0..around {
            let at = |i: i32, j: i32| j * around + i % around;
            faces.push([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    let mut obj = String::new();
    let mut ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        faces.len()
    );
    for p in &points {
        writeln!(obj, "v {} {} {}", p.x, p.y, p.z).unwrap();
        writeln!(ply, "{} {} {}", p.x, p.y, p.z).unwrap();
    }
    for f in &faces {
        writeln!(obj, "f {} {} {} {}", f[0] + 1, f[1] + 1, f[2] + 1, f[3] + 1).unwrap();
        writeln!(ply, "4 {} {} {} {}", f[0], f[1], f[2], f[3]).unwrap();
    }
    let of = |name: &str, text: &str| Mesh::of_bytes(Path::new(name), text.as_bytes()).unwrap();
    let (obj, ply) = (of("ball.obj", &obj), of("ball.ply", &ply));
    assert_eq!(obj.len(), ply.len());
    let (obj, ply) = (Shape::Mesh(Box::new(obj)), Shape::Mesh(Box::new(ply)));
    let mut numbers = Pcg64Mcg::new(31);
    for _ in 0..100_000 {
        let aim = 0.9 * f64::uniform(&mut numbers) * direction(&mut numbers);
        let d = direction(&mut numbers);
        let ray = Ray { origin: aim - 3.0 * d, direction: d };
        let (a, b) = (obj.nearest(&ray, 10.0).unwrap(), ply.nearest(&ray, 10.0).unwrap());
        assert!((a.distance - b.distance).abs() < 1e-9);
        let surface = obj.surface(&ray, a);
        assert!(
            (0.99..1.0 + 1e-9).contains(&surface.point.length()) && surface.normal.dot(d) < 0.0
        );
        // and from inside there is a way out, but none through the surface unseen
        let inside = Ray { origin: aim, direction: d };
        assert!(obj.nearest(&inside, 10.0).is_some(), "{inside:?} leaks");
    }
    for (name, text) in
        [("a.stl", ""), ("a.obj", "v 0 0 0\n"), ("a.obj", "v 0 0 0\nf 1 2 3\n"), ("a.ply", "ply\n")]
    {
        assert!(Mesh::of_bytes(Path::new(name), text.as_bytes()).is_err(), "{name} {text}");
    }
}
