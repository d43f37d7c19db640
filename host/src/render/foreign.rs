//! A scene in the languages of other renderers.
//!
//! What they hold: all shapes (a torus as a mesh), diffuse and smooth materials, lamps, and GGX facets with one bounce as their own rough
//! dielectric, with the separable shadowing of this project in Mitsuba and the correlated one in pbrt. What they do not hold is written as a
//! smooth material and said: laws of other kinds go to Mitsuba as a grid by `asperity export`.

mod mitsuba;
mod pbrt;

use std::f64::consts::TAU;
use std::fmt::Write as _;

use asperity_render::glam::DVec3;
use asperity_render::scene::{Material, Scene};
use asperity_render::shape::{Mesh, Torus};

/// A renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Renderer {
    /// Mitsuba 3.
    Mitsuba,
    /// pbrt, version 4.
    Pbrt,
}

/// GGX facets with one bounce, as other renderers know them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughGlass {
    /// Width of the slopes.
    pub alpha: f64,
    /// Index of the dielectric over that of air.
    pub ior: f64,
}

/// Files of a scene, and what they do not hold.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Foreign {
    /// Names and contents; the first is the scene, the others are what it names.
    pub files: Vec<(String, String)>,
    /// Sentences about what is left out.
    pub missing: Vec<String>,
}

/// The scene for another renderer; `glass` says which materials are GGX facets with one bounce, by their place.
pub fn foreign(
    scene: &Scene,
    renderer: Renderer,
    glass: &dyn Fn(usize) -> Option<RoughGlass>,
) -> Foreign {
    let mut foreign = Foreign::default();
    for (place, material) in scene.materials.iter().enumerate() {
        if matches!(material, Material::Rough(_)) && glass(place).is_none() {
            foreign.missing.push(format!(
                "material {place} is no GGX with one bounce: it is written as smooth glass; `asperity export` writes its law as a grid"
            ));
        }
    }
    match renderer {
        Renderer::Mitsuba => mitsuba::write(scene, glass, &mut foreign),
        Renderer::Pbrt => pbrt::write(scene, glass, &mut foreign),
    }
    foreign
}

/// Steps along ring and tube of the mesh of a torus.
const RING_STEPS: u32 = 256;
const TUBE_STEPS: u32 = 128;

/// A torus as PLY, with normals.
fn torus_ply(torus: &Torus) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        RING_STEPS * TUBE_STEPS,
        2 * RING_STEPS * TUBE_STEPS
    );
    for i in 0..RING_STEPS {
        for j in 0..TUBE_STEPS {
            let angle = |k: u32, n: u32| TAU * f64::from(k) / f64::from(n);
            let (p, n) = torus.at([angle(i, RING_STEPS), angle(j, TUBE_STEPS)]);
            // writing to a string cannot fail
            let _ = writeln!(text, "{} {}", numbers(p), numbers(n));
        }
    }
    for i in 0..RING_STEPS {
        for j in 0..TUBE_STEPS {
            let at = |i: u32, j: u32| i % RING_STEPS * TUBE_STEPS + j % TUBE_STEPS;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let _ = writeln!(text, "3 {a} {b} {c}\n3 {a} {c} {d}");
        }
    }
    text
}

/// Triangles as PLY, flat.
fn mesh_ply(mesh: &Mesh) -> String {
    let count = mesh.len();
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {count}\nproperty list uchar int vertex_indices\nend_header\n",
        3 * count
    );
    for p in mesh.corners().iter().flatten() {
        let _ = writeln!(text, "{}", numbers(*p));
    }
    for k in 0..count {
        let _ = writeln!(text, "3 {} {} {}", 3 * k, 3 * k + 1, 3 * k + 2);
    }
    text
}

fn numbers(v: DVec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}
