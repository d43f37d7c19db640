//! Triangles of an OBJ or PLY file.

use std::io::Cursor;
use std::path::Path;

use glam::DVec3;
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};

use super::mesh::{Mesh, MeshError};

/// Why a file gives no mesh.
#[derive(Debug, thiserror::Error)]
pub enum MeshFileError {
    /// Neither `.obj` nor `.ply`.
    #[error("{0}: only .obj and .ply are read; convert the mesh")]
    Unknown(String),
    /// The reader of the format refuses it.
    #[error("{file}: {what}; correct the file")]
    Unreadable {
        /// The file.
        file: String,
        /// What its reader says.
        what: String,
    },
    /// It is no mesh.
    #[error("{0}: {1}")]
    NoMesh(String, MeshError),
}

impl Mesh {
    /// The mesh of a file's content, its lengths in metres; the extension of the path tells the format.
    ///
    /// Polygons are cut into triangles from their first corner. Normals are taken if every corner has one.
    ///
    /// # Errors
    /// [`MeshFileError`] with the file.
    pub fn of_bytes(path: &Path, bytes: &[u8]) -> Result<Self, MeshFileError> {
        let file = path.display().to_string();
        let unreadable = |what: String| MeshFileError::Unreadable { file: file.clone(), what };
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let (corners, normals) = match extension.as_str() {
            "obj" => of_obj(bytes).map_err(unreadable)?,
            "ply" => of_ply(bytes).map_err(unreadable)?,
            _ => return Err(MeshFileError::Unknown(file)),
        };
        Self::new(corners, normals).map_err(|e| MeshFileError::NoMesh(file, e))
    }
}

type Corners = Vec<[DVec3; 3]>;

fn of_obj(bytes: &[u8]) -> Result<(Corners, Corners), String> {
    let options =
        tobj::LoadOptions { triangulate: true, single_index: true, ..tobj::LoadOptions::default() };
    let no_materials = |_: &Path| Ok((Vec::new(), std::collections::HashMap::default()));
    let (models, _) = tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials)
        .map_err(|e| e.to_string())?;
    let all_have_normals = models.iter().all(|m| m.mesh.normals.len() == m.mesh.positions.len());
    let (mut corners, mut normals) = (Vec::new(), Vec::new());
    for model in &models {
        let mesh = &model.mesh;
        let at = |list: &[f64], index: u32| {
            let k = 3 * index as usize;
            list.get(k..k + 3)
                .map(DVec3::from_slice)
                .ok_or("a face names a vertex that is not there")
        };
        for three in mesh.indices.chunks_exact(3) {
            let pick = |list: &[f64]| -> Result<[DVec3; 3], &str> {
                Ok([at(list, three[0])?, at(list, three[1])?, at(list, three[2])?])
            };
            corners.push(pick(&mesh.positions)?);
            if all_have_normals {
                normals.push(pick(&mesh.normals)?);
            }
        }
    }
    Ok((corners, normals))
}

fn of_ply(bytes: &[u8]) -> Result<(Corners, Corners), String> {
    let ply = Parser::<DefaultElement>::new()
        .read_ply(&mut Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let empty = Vec::new();
    let list = |name: &str| ply.payload.get(name).unwrap_or(&empty);
    let vertices = list("vertex");
    let vector = |vertex: &DefaultElement, names: [&str; 3]| {
        let [x, y, z] = names.map(|name| vertex.get(name).and_then(number));
        Some(DVec3::new(x?, y?, z?))
    };
    let places: Option<Vec<DVec3>> = vertices.iter().map(|v| vector(v, ["x", "y", "z"])).collect();
    let places = places.ok_or("a vertex lacks x, y or z")?;
    let directions: Vec<DVec3> =
        vertices.iter().map_while(|v| vector(v, ["nx", "ny", "nz"])).collect();
    let (mut corners, mut normals) = (Vec::new(), Vec::new());
    for face in list("face") {
        let names = ["vertex_indices", "vertex_index"];
        let polygon = names.iter().find_map(|name| face.get(*name)).and_then(indices);
        let polygon = polygon.ok_or("a face lacks its list of vertices")?;
        for k in 2..polygon.len() {
            let three = [polygon[0], polygon[k - 1], polygon[k]];
            let pick = |list: &[DVec3]| {
                let at = |k: usize| list.get(three[k]).copied();
                Some([at(0)?, at(1)?, at(2)?])
            };
            corners.push(pick(&places).ok_or("a face names a vertex that is not there")?);
            normals.extend(pick(&directions));
        }
    }
    Ok((corners, normals))
}

/// A scalar of any kind.
fn number(property: &Property) -> Option<f64> {
    Some(match property {
        Property::Char(x) => f64::from(*x),
        Property::UChar(x) => f64::from(*x),
        Property::Short(x) => f64::from(*x),
        Property::UShort(x) => f64::from(*x),
        Property::Int(x) => f64::from(*x),
        Property::UInt(x) => f64::from(*x),
        Property::Float(x) => f64::from(*x),
        Property::Double(x) => *x,
        _ => return None,
    })
}

/// A list of whole numbers of any kind.
fn indices(property: &Property) -> Option<Vec<usize>> {
    fn all<T: Copy + TryInto<usize>>(list: &[T]) -> Option<Vec<usize>> {
        list.iter().map(|x| (*x).try_into().ok()).collect()
    }
    match property {
        Property::ListChar(list) => all(list),
        Property::ListUChar(list) => all(list),
        Property::ListShort(list) => all(list),
        Property::ListUShort(list) => all(list),
        Property::ListInt(list) => all(list),
        Property::ListUInt(list) => list.iter().map(|x| usize::try_from(*x).ok()).collect(),
        _ => None,
    }
}
