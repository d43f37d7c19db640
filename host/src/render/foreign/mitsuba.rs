//! Mitsuba 3.

use std::fmt::Write as _;

use asperity_render::camera::Projection;
use asperity_render::glam::DVec3;
use asperity_render::scene::{Material, Scene};
use asperity_render::shape::{Face, Rectangle, Shape};

use super::{Foreign, RoughGlass, mesh_ply, torus_ply};

pub(super) fn write(
    scene: &Scene,
    glass: &dyn Fn(usize) -> Option<RoughGlass>,
    foreign: &mut Foreign,
) {
    let mut xml = String::from(
        "<!-- written by asperity; grey radiances, use a mono variant; the aspect of the film is that of the pixels -->\n\
         <scene version=\"3.0.0\">\n  <integrator type=\"path\"><integer name=\"max_depth\" value=\"64\"/></integrator>\n",
    );
    sensor(scene, &mut xml);
    if scene.surroundings > 0.0 {
        let _ = writeln!(
            xml,
            "  <emitter type=\"constant\"><spectrum name=\"radiance\" value=\"{}\"/></emitter>",
            scene.surroundings
        );
    }
    for body in &scene.bodies {
        match &body.shape {
            Shape::Cuboid(cuboid) => {
                for face in Face::ALL {
                    if let Some(rectangle) = cuboid.face(face) {
                        let place = body.material_of(face.number());
                        let text = rectangle_transform(&rectangle);
                        shape(&mut xml, "rectangle", &text, &material(scene, place, glass));
                    }
                }
            }
            other => {
                let inner = material(scene, body.material, glass);
                let (kind, text) = match other {
                    Shape::Rectangle(r) => ("rectangle", rectangle_transform(r)),
                    Shape::Sphere(s) => (
                        "sphere",
                        format!(
                            "{}<float name=\"radius\" value=\"{}\"/>",
                            point("center", s.centre),
                            s.radius
                        ),
                    ),
                    Shape::Cylinder(c) => {
                        if c.is_closed() {
                            foreign
                                .missing
                                .push(format!("{}: its end discs are left out", body.name));
                        }
                        let (from, axis) = c.axis();
                        let ends = point("p0", from) + &point("p1", from + c.length() * axis);
                        (
                            "cylinder",
                            format!("{ends}<float name=\"radius\" value=\"{}\"/>", c.radius()),
                        )
                    }
                    Shape::Torus(_) | Shape::Mesh(_) | Shape::Cuboid(_) => {
                        let name = format!("{}.ply", body.name.replace(' ', "-"));
                        let content = match other {
                            Shape::Torus(torus) => torus_ply(torus),
                            Shape::Mesh(mesh) => mesh_ply(mesh),
                            _ => continue,
                        };
                        let text = format!("<string name=\"filename\" value=\"{name}\"/>");
                        foreign.files.push((name, content));
                        ("ply", text)
                    }
                };
                shape(&mut xml, kind, &text, &inner);
            }
        }
    }
    xml.push_str("</scene>\n");
    foreign.files.insert(0, ("scene.xml".to_owned(), xml));
}

fn sensor(scene: &Scene, xml: &mut String) {
    let [eye, forward, up] = scene.camera.frame();
    let look = |v: DVec3| format!("{}, {}, {}", v.x, v.y, v.z);
    let (kind, lens, scale) = match scene.camera.projection() {
        Projection::Pinhole { field } => (
            "perspective",
            format!(
                "<string name=\"fov_axis\" value=\"x\"/><float name=\"fov\" value=\"{}\"/>",
                field.to_degrees()
            ),
            String::new(),
        ),
        Projection::Orthographic { width } => (
            "orthographic",
            String::new(),
            format!("<scale x=\"{}\" y=\"{}\"/>", 0.5 * width, 0.5 * width),
        ),
    };
    let [across, down] = scene.camera.pixels();
    let _ = writeln!(
        xml,
        "  <sensor type=\"{kind}\">{lens}\n    <transform name=\"to_world\">{scale}<lookat origin=\"{}\" target=\"{}\" up=\"{}\"/></transform>\n    \
         <sampler type=\"independent\"><integer name=\"sample_count\" value=\"256\"/></sampler>\n    \
         <film type=\"hdrfilm\"><integer name=\"width\" value=\"{across}\"/><integer name=\"height\" value=\"{down}\"/>\
         <rfilter type=\"box\"/></film>\n  </sensor>",
        look(eye),
        look(eye + forward),
        look(up)
    );
}

fn shape(xml: &mut String, kind: &str, text: &str, inner: &str) {
    let _ = writeln!(xml, "  <shape type=\"{kind}\">{text}{inner}</shape>");
}

fn point(name: &str, p: DVec3) -> String {
    format!("<point name=\"{name}\" x=\"{}\" y=\"{}\" z=\"{}\"/>", p.x, p.y, p.z)
}

/// Mitsuba's rectangle is -1..1 in x and y with its normal along z.
fn rectangle_transform(rectangle: &Rectangle) -> String {
    let (corner, [a, b]) = rectangle.corner_and_edges();
    let middle = corner + 0.5 * (a + b);
    let normal = a.cross(b).normalize_or_zero();
    let (a, b) = (0.5 * a, 0.5 * b);
    let row = |f: fn(DVec3) -> f64| format!("{} {} {} {}", f(a), f(b), f(normal), f(middle));
    format!(
        "<transform name=\"to_world\"><matrix value=\"{} {} {} 0 0 0 1\"/></transform>",
        row(|v| v.x),
        row(|v| v.y),
        row(|v| v.z)
    )
}

fn material(scene: &Scene, place: usize, glass: &dyn Fn(usize) -> Option<RoughGlass>) -> String {
    let smooth = |ior: f64| {
        format!(
            "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"{ior}\"/><float name=\"ext_ior\" value=\"1\"/></bsdf>"
        )
    };
    match (&scene.materials[place], glass(place)) {
        (Material::Lambert { reflectance }, _) => format!(
            "<bsdf type=\"twosided\"><bsdf type=\"diffuse\"><spectrum name=\"reflectance\" value=\"{reflectance}\"/></bsdf></bsdf>"
        ),
        (Material::Lamp { radiance }, _) => format!(
            "<bsdf type=\"diffuse\"><spectrum name=\"reflectance\" value=\"0\"/></bsdf>\
             <emitter type=\"area\"><spectrum name=\"radiance\" value=\"{radiance}\"/></emitter>"
        ),
        (Material::Smooth { ior }, _) => smooth(*ior),
        (Material::Rough(_), Some(RoughGlass { alpha, ior })) => format!(
            "<bsdf type=\"roughdielectric\"><string name=\"distribution\" value=\"ggx\"/><float name=\"alpha\" value=\"{alpha}\"/>\
             <float name=\"int_ior\" value=\"{ior}\"/><float name=\"ext_ior\" value=\"1\"/></bsdf>"
        ),
        (Material::Rough(_), None) => smooth(1.5),
    }
}
