//! pbrt, version 4.

use std::fmt::Write as _;

use asperity_render::camera::Projection;
use asperity_render::scene::{Material, Scene};
use asperity_render::shape::{Face, Rectangle, Shape};

use super::{Foreign, RoughGlass, mesh_ply, numbers, torus_ply};

pub(super) fn write(
    scene: &Scene,
    glass: &dyn Fn(usize) -> Option<RoughGlass>,
    foreign: &mut Foreign,
) {
    let mut text = String::from("# written by asperity; grey radiances\n");
    camera(scene, &mut text);
    if scene.surroundings > 0.0 {
        let _ = writeln!(
            text,
            "LightSource \"infinite\" \"float illuminance\" [{}]",
            std::f64::consts::PI * scene.surroundings
        );
    }
    for body in &scene.bodies {
        let of = |part: u32| material(scene, body.material_of(part), glass);
        let shape = match &body.shape {
            Shape::Cuboid(cuboid) => {
                for face in Face::ALL {
                    if let Some(rectangle) = cuboid.face(face) {
                        let _ = writeln!(
                            text,
                            "AttributeBegin\n{}\n{}\nAttributeEnd",
                            of(face.number()),
                            rectangle_shape(&rectangle)
                        );
                    }
                }
                continue;
            }
            Shape::Rectangle(rectangle) => rectangle_shape(rectangle),
            Shape::Sphere(s) => {
                format!(
                    "Translate {}\nShape \"sphere\" \"float radius\" [{}]",
                    numbers(s.centre),
                    s.radius
                )
            }
            Shape::Cylinder(c) => {
                if c.is_closed() {
                    foreign.missing.push(format!("{}: its end discs are left out", body.name));
                }
                let (from, axis) = c.axis();
                let (x, y) = axis.any_orthonormal_pair();
                // columns of the matrix: where the axes of the cylinder go
                format!(
                    "Transform [{} 0 {} 0 {} 0 {} 1]\nShape \"cylinder\" \"float radius\" [{}] \"float zmin\" [0] \"float zmax\" [{}]",
                    numbers(x),
                    numbers(y),
                    numbers(axis),
                    numbers(from),
                    c.radius(),
                    c.length()
                )
            }
            Shape::Torus(_) | Shape::Mesh(_) => {
                let name = format!("{}.ply", body.name.replace(' ', "-"));
                let content = match &body.shape {
                    Shape::Torus(torus) => torus_ply(torus),
                    Shape::Mesh(mesh) => mesh_ply(mesh),
                    _ => continue,
                };
                foreign.files.push((name.clone(), content));
                format!("Shape \"plymesh\" \"string filename\" [\"{name}\"]")
            }
        };
        let _ = writeln!(text, "AttributeBegin\n{}\n{shape}\nAttributeEnd", of(0));
    }
    foreign.files.insert(0, ("scene.pbrt".to_owned(), text));
}

fn camera(scene: &Scene, text: &mut String) {
    let [eye, forward, up] = scene.camera.frame();
    let [across, down] = scene.camera.pixels();
    let shorter = f64::from(across.min(down)) / f64::from(across);
    // pbrt's pictures are mirrored: its x goes to the left of this frame
    let _ = writeln!(
        text,
        "Scale -1 1 1\nLookAt {}  {}  {}",
        numbers(eye),
        numbers(eye + forward),
        numbers(up)
    );
    let _ = match scene.camera.projection() {
        // the field is that of the shorter side
        Projection::Pinhole { field } => {
            let fov = 2.0 * ((0.5 * field).tan() * shorter).atan().to_degrees();
            writeln!(text, "Camera \"perspective\" \"float fov\" [{fov}]")
        }
        Projection::Orthographic { width } => {
            let (w, h) = (0.5 * width, 0.5 * width * f64::from(down) / f64::from(across));
            writeln!(text, "Camera \"orthographic\" \"float screenwindow\" [{} {w} {} {h}]", -w, -h)
        }
    };
    let _ = writeln!(
        text,
        "Film \"rgb\" \"integer xresolution\" [{across}] \"integer yresolution\" [{down}] \"string filename\" [\"scene.exr\"]\n\
         PixelFilter \"box\"\nSampler \"independent\" \"integer pixelsamples\" [256]\nIntegrator \"volpath\" \"integer maxdepth\" [64]\nWorldBegin"
    );
}

fn rectangle_shape(rectangle: &Rectangle) -> String {
    let (corner, [a, b]) = rectangle.corner_and_edges();
    let points: Vec<String> =
        [corner, corner + a, corner + a + b, corner + b].map(numbers).to_vec();
    format!(
        "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [{}]",
        points.join("  ")
    )
}

fn material(scene: &Scene, place: usize, glass: &dyn Fn(usize) -> Option<RoughGlass>) -> String {
    let dielectric = |roughness: f64, ior: f64| {
        format!(
            "Material \"dielectric\" \"float roughness\" [{roughness}] \"bool remaproughness\" [false] \"float eta\" [{ior}]"
        )
    };
    match (&scene.materials[place], glass(place)) {
        (Material::Lambert { reflectance: r }, _) => {
            format!("Material \"diffuse\" \"rgb reflectance\" [{r} {r} {r}]")
        }
        (Material::Lamp { radiance: l }, _) => {
            format!(
                "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\nAreaLightSource \"diffuse\" \"rgb L\" [{l} {l} {l}]"
            )
        }
        (Material::Smooth { ior }, _) => dielectric(0.0, *ior),
        (Material::Rough(_), Some(RoughGlass { alpha, ior })) => dielectric(alpha, ior),
        (Material::Rough(_), None) => dielectric(0.0, 1.5),
    }
}
