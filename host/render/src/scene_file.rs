//! A scene as a TOML file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;
use toml::Spanned;

use crate::camera::{Camera, Projection};
use crate::scene::{Body, Material, Scene};
use crate::shape::{Cuboid, Cylinder, Face, Mesh, OpenFaces, Rectangle, Shape, Sphere, Torus};

/// Scenes that the program has, by their names.
pub const BUILT_IN: [(&str, &str); 2] = [
    ("booth", include_str!("../scenes/booth.toml")),
    ("furnace", include_str!("../scenes/furnace.toml")),
];

/// What is wrong with a scene file.
#[derive(Debug, thiserror::Error)]
#[error("{file}:{line}: {what}")]
pub struct SceneFileError {
    /// The file.
    pub file: String,
    /// Its line, from 1.
    pub line: usize,
    /// What is wrong, and what to do.
    pub what: String,
}

/// A scene without its rough materials: those are models.
#[derive(Clone, Debug)]
pub struct Draft {
    file: SceneToml,
    path: PathBuf,
    text: String,
}

/// A material that is a model.
#[derive(Clone, Debug, PartialEq)]
pub enum Wanted {
    /// The one that is rendered.
    Model,
    /// The one of a file, its path relative to the scene's folder.
    File(PathBuf),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneToml {
    #[serde(default)]
    surroundings: f64,
    camera: Spanned<CameraToml>,
    materials: BTreeMap<String, Spanned<MaterialToml>>,
    bodies: Vec<Spanned<BodyToml>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraToml {
    eye: [f64; 3],
    at: [f64; 3],
    #[serde(default = "upwards")]
    up: [f64; 3],
    field_deg: Option<f64>,
    width: Option<f64>,
    pixels: [u32; 2],
}

fn upwards() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
enum MaterialToml {
    Lambert { reflectance: f64 },
    Smooth { ior: f64 },
    Model { file: Option<PathBuf> },
    Lamp { radiance: f64 },
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyToml {
    name: String,
    shape: ShapeName,
    material: Spanned<String>,
    #[serde(default)]
    faces: BTreeMap<Face, Spanned<String>>,
    #[serde(default)]
    open: Vec<Face>,
    from: Option<[f64; 3]>,
    to: Option<[f64; 3]>,
    centre: Option<[f64; 3]>,
    axis: Option<[f64; 3]>,
    edges: Option<[[f64; 3]; 2]>,
    radius: Option<f64>,
    ring: Option<f64>,
    tube: Option<f64>,
    closed: Option<bool>,
    file: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum ShapeName {
    Rectangle,
    Box,
    Sphere,
    Cylinder,
    Torus,
    Mesh,
}

impl Draft {
    /// From the text of a file; the path is for messages and for the files it names.
    ///
    /// # Errors
    /// [`SceneFileError`] with file, line, and what to do.
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneFileError> {
        let file: SceneToml = toml::from_str(text).map_err(|e| {
            let at = e.span().map_or(0, |span| span.start);
            let what =
                format!("{}; `asperity render --scene-example` prints a whole scene", e.message());
            fault(text, path, at, what)
        })?;
        let draft = Self { file, path: path.to_path_buf(), text: text.to_owned() };
        draft.check()?;
        Ok(draft)
    }

    /// A built-in scene.
    pub fn built_in(name: &str) -> Option<Self> {
        let (_, text) = BUILT_IN.iter().find(|(other, _)| *other == name)?;
        Self::parse(text, Path::new(name)).ok()
    }

    /// Places of its materials that are models, in the order of the scene's materials, and which.
    pub fn models(&self) -> Vec<(usize, Wanted)> {
        let all = self.file.materials.values().enumerate();
        all.filter_map(|(place, material)| match material.get_ref() {
            MaterialToml::Model { file } => Some((place, self.resolve(file.as_deref()))),
            _ => None,
        })
        .collect()
    }

    /// The models it asks for, each once.
    pub fn wanted(&self) -> Vec<Wanted> {
        let mut all = Vec::new();
        for material in self.file.materials.values() {
            if let MaterialToml::Model { file } = material.get_ref() {
                let wanted = self.resolve(file.as_deref());
                if !all.contains(&wanted) {
                    all.push(wanted);
                }
            }
        }
        all
    }

    /// The scene with its models, which `law` provides; `read` gives the content of the files of meshes.
    ///
    /// # Errors
    /// [`SceneFileError`] of a mesh that cannot be read, or is none.
    pub fn scene(
        &self,
        law: &dyn Fn(&Wanted) -> Material,
        read: &dyn Fn(&Path) -> Result<Vec<u8>, String>,
    ) -> Result<Scene, SceneFileError> {
        let names: Vec<&String> = self.file.materials.keys().collect();
        let material = |m: &MaterialToml| match m {
            MaterialToml::Lambert { reflectance } => {
                Material::Lambert { reflectance: *reflectance }
            }
            MaterialToml::Smooth { ior } => Material::Smooth { ior: *ior },
            MaterialToml::Lamp { radiance } => Material::Lamp { radiance: *radiance },
            MaterialToml::Model { file } => law(&self.resolve(file.as_deref())),
        };
        let place = |name: &Spanned<String>| {
            names.iter().position(|n| *n == name.get_ref()).unwrap_or_default()
        };
        let mut bodies = Vec::new();
        for spanned in &self.file.bodies {
            let body = spanned.get_ref();
            let shape = self.shape(spanned, read)?;
            let faces =
                body.faces.iter().map(|(face, name)| (face.number(), place(name))).collect();
            let name = body.name.clone();
            bodies.push(Body { name, shape, material: place(&body.material), faces });
        }
        Ok(Scene {
            bodies,
            materials: self.file.materials.values().map(|m| material(m.get_ref())).collect(),
            surroundings: self.file.surroundings,
            camera: self.camera()?,
        })
    }

    fn resolve(&self, file: Option<&Path>) -> Wanted {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        file.map_or(Wanted::Model, |file| Wanted::File(folder.join(file)))
    }

    fn camera(&self) -> Result<Camera, SceneFileError> {
        let camera = self.file.camera.get_ref();
        let at = self.file.camera.span().start;
        let projection = match (camera.field_deg, camera.width) {
            (Some(deg), None) if deg > 0.0 && deg < 179.0 => {
                Projection::Pinhole { field: deg.to_radians() }
            }
            (None, Some(width)) if width > 0.0 && width.is_finite() => {
                Projection::Orthographic { width }
            }
            _ => {
                let what = "the camera needs field_deg (0 to 179) or width (m, of parallel rays), one of them";
                return Err(self.fault(at, what));
            }
        };
        let frame = [camera.eye, camera.at, camera.up].map(DVec3::from);
        let pixels_are_good = camera.pixels.iter().all(|n| (1..=16_384).contains(n));
        let made = pixels_are_good.then(|| Camera::new(frame, projection, camera.pixels)).flatten();
        made.ok_or_else(|| {
            self.fault(at, "eye and at must be two points, up not along the line between them, pixels 1 to 16384")
        })
    }

    fn shape(
        &self,
        spanned: &Spanned<BodyToml>,
        read: &dyn Fn(&Path) -> Result<Vec<u8>, String>,
    ) -> Result<Shape, SceneFileError> {
        let (body, at) = (spanned.get_ref(), spanned.span().start);
        let lacks = |keys: &str| self.fault(at, format!("body {}: {keys}", body.name));
        let point = |p: Option<[f64; 3]>| p.map(DVec3::from).filter(|p| p.is_finite());
        let above_0 = |x: Option<f64>| x.filter(|x| *x > 0.0 && x.is_finite());
        let shape = match body.shape {
            ShapeName::Rectangle => (|| {
                let edges = body.edges?.map(DVec3::from);
                Rectangle::new(point(body.from)?, edges).map(Shape::Rectangle)
            })()
            .ok_or_else(|| lacks("a rectangle needs `from` (a corner) and `edges` (two vectors that span it)"))?,
            ShapeName::Box => (|| {
                let (lower, upper) = (point(body.from)?, point(body.to)?);
                let open = body.open.iter().fold(OpenFaces::default(), |open, f| open.with(*f));
                lower.cmplt(upper).all().then_some(Shape::Cuboid(Cuboid { lower, upper, open }))
            })()
            .ok_or_else(|| lacks("a box needs the corners `from` and `to`, each coordinate of the second the larger one"))?,
            ShapeName::Sphere => (|| {
                let (centre, radius) = (point(body.centre)?, above_0(body.radius)?);
                Some(Shape::Sphere(Sphere { centre, radius }))
            })()
            .ok_or_else(|| lacks("a sphere needs `centre` and `radius` (above 0)"))?,
            ShapeName::Cylinder => (|| {
                let ends = [point(body.from)?, point(body.to)?];
                let closed = body.closed.unwrap_or(true);
                Cylinder::new(ends, above_0(body.radius)?, closed).map(Shape::Cylinder)
            })()
            .ok_or_else(|| lacks("a cylinder needs `from` and `to` (the ends of its axis) and `radius` (above 0)"))?,
            ShapeName::Torus => (|| {
                let axis = point(body.axis.or(Some(upwards())))?;
                let (ring, tube) = (above_0(body.ring)?, above_0(body.tube)?);
                Torus::new(point(body.centre)?, axis, ring, tube).map(Shape::Torus)
            })()
            .ok_or_else(|| lacks("a torus needs `centre`, `ring` and `tube` (radii, 0 < tube < ring), and may have an `axis`"))?,
            ShapeName::Mesh => {
                let file = body.file.as_ref().ok_or_else(|| lacks("a mesh needs `file`, .obj or .ply"))?;
                let path = self.path.parent().unwrap_or(Path::new("")).join(file);
                let bytes = read(&path).map_err(|what| lacks(&what))?;
                let mesh = Mesh::of_bytes(&path, &bytes).map_err(|e| lacks(&e.to_string()))?;
                Shape::Mesh(Box::new(mesh))
            }
        };
        Ok(shape)
    }

    /// What the types of its keys do not hold.
    fn check(&self) -> Result<(), SceneFileError> {
        self.camera()?;
        if !(self.file.surroundings >= 0.0 && self.file.surroundings.is_finite()) {
            return Err(self.fault(0, "surroundings is a radiance: a finite number of at least 0"));
        }
        for (name, spanned) in &self.file.materials {
            let fails = match spanned.get_ref() {
                MaterialToml::Lambert { reflectance } if !(0.0..=1.0).contains(reflectance) => {
                    "reflectance is 0 to 1"
                }
                MaterialToml::Smooth { ior } if !(*ior > 0.1 && *ior < 10.0) => "ior is 0.1 to 10",
                MaterialToml::Lamp { radiance } if !(*radiance >= 0.0 && radiance.is_finite()) => {
                    "radiance is a finite number of at least 0"
                }
                _ => continue,
            };
            return Err(self.fault(spanned.span().start, format!("material {name}: {fails}")));
        }
        let known = self.file.materials.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        for spanned in &self.file.bodies {
            let (body, at) = (spanned.get_ref(), spanned.span().start);
            for name in std::iter::once(&body.material).chain(body.faces.values()) {
                if !self.file.materials.contains_key(name.get_ref()) {
                    let what =
                        format!("there is no material {}; there are {known}", name.get_ref());
                    return Err(self.fault(name.span().start, what));
                }
            }
            let is_box = body.shape == ShapeName::Box;
            let has_faces = !body.faces.is_empty() || !body.open.is_empty();
            if has_faces && !is_box {
                let what = format!("body {}: only a box has `faces` and `open`", body.name);
                return Err(self.fault(at, what));
            }
            let shines = |name: &Spanned<String>| {
                let material = self.file.materials.get(name.get_ref()).map(Spanned::get_ref);
                matches!(material, Some(MaterialToml::Lamp { .. }))
            };
            let can_shine = [ShapeName::Rectangle, ShapeName::Sphere, ShapeName::Cylinder]
                .contains(&body.shape);
            if (shines(&body.material) && !can_shine) || body.faces.values().any(shines) {
                let what =
                    format!("body {}: a lamp is a rectangle, a sphere or a cylinder", body.name);
                return Err(self.fault(at, what));
            }
            if body.shape != ShapeName::Mesh {
                self.shape(spanned, &|_| Err(String::new()))?;
            }
        }
        Ok(())
    }

    fn fault(&self, at: usize, what: impl Into<String>) -> SceneFileError {
        fault(&self.text, &self.path, at, what)
    }
}

fn fault(text: &str, path: &Path, at: usize, what: impl Into<String>) -> SceneFileError {
    let before = text.get(..at).unwrap_or_default();
    SceneFileError {
        file: path.display().to_string(),
        line: before.matches('\n').count() + 1,
        what: what.into(),
    }
}
