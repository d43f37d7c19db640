//! Triangles with a tree of boxes over them.
//!
//! The tree is obvhs', in single precision; its boxes are widened so that rounding loses no triangle, and the triangles
//! are met in double precision.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::ray::{Ray as TreeRay, RayHit};
use obvhs::{Boundable, BvhBuildParams};

use super::across;
use crate::ray::{Near, Ray, Surface};

/// Triangles, their normals outwards by the order of their corners.
#[derive(Clone)]
pub struct Mesh {
    corners: Vec<[DVec3; 3]>,
    /// Normals of the corners; none: every triangle is flat.
    normals: Vec<[DVec3; 3]>,
    tree: Bvh2,
    bounds: [DVec3; 2],
}

/// What makes a list of triangles no mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// No triangle.
    #[error("it has no triangle; give a file with faces")]
    Empty,
    /// A corner is not a number, or too far away for single precision.
    #[error("triangle {0} has a corner that is not a finite number of metres; correct the file")]
    NotFinite(usize),
    /// More triangles than numbers of 32 bits.
    #[error("it has more than 2^31 triangles; give a coarser one")]
    TooMany,
}

/// A box of the tree.
struct Padded(Aabb);

impl Boundable for Padded {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl std::fmt::Debug for Mesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Mesh").field("triangles", &self.corners.len()).finish_non_exhaustive()
    }
}

impl Mesh {
    /// From the corners of triangles, m, and the normals there (empty: flat triangles).
    ///
    /// # Errors
    /// [`MeshError`].
    pub fn new(corners: Vec<[DVec3; 3]>, normals: Vec<[DVec3; 3]>) -> Result<Self, MeshError> {
        let Some(first) = corners.first().map(|c| c[0]) else { return Err(MeshError::Empty) };
        if corners.len() >= 1 << 31 {
            return Err(MeshError::TooMany);
        }
        let is_good = |p: &DVec3| p.is_finite() && p.abs().max_element() < 1e12;
        if let Some(bad) = corners.iter().position(|c| !c.iter().all(is_good)) {
            return Err(MeshError::NotFinite(bad + 1));
        }
        let all = || corners.iter().flatten();
        let bounds = [all().fold(first, |a, p| a.min(*p)), all().fold(first, |a, p| a.max(*p))];
        let most = bounds[0].abs().max(bounds[1].abs()).max_element();
        let margin = (4.0 * f64::from(f32::EPSILON) * most) as f32;
        let padded = |c: &[DVec3; 3]| {
            let mut aabb = Aabb::empty();
            for p in c {
                let p = p.as_vec3a();
                aabb.extend(p - Vec3A::splat(margin));
                aabb.extend(p + Vec3A::splat(margin));
            }
            Padded(aabb)
        };
        let boxes: Vec<Padded> = corners.iter().map(padded).collect();
        let settings = BvhBuildParams { pre_split: false, ..BvhBuildParams::medium_build() };
        let tree = build_bvh2(&boxes, settings, &mut std::time::Duration::default());
        let normals = if normals.len() == corners.len() { normals } else { Vec::new() };
        Ok(Self { corners, normals, tree, bounds })
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Never: a mesh has a triangle.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Corners of the triangles, m.
    pub fn corners(&self) -> &[[DVec3; 3]] {
        &self.corners
    }

    pub(super) fn nearest(&self, ray: &Ray, most: f64) -> Option<Near> {
        let mut best: Option<Near> = None;
        let tree_ray = TreeRay::new(
            ray.origin.as_vec3a(),
            ray.direction.as_vec3a(),
            0.0,
            if most < 1e30 { (most * (1.0 + 1e-6)) as f32 } else { f32::INFINITY },
        );
        self.tree.ray_traverse(tree_ray, &mut RayHit::none(), |_, id| {
            let number = self.tree.primitive_indices[id];
            let limit = best.map_or(most, |near| near.distance);
            match meet(&self.corners[number as usize], ray) {
                Some(distance) if distance < limit => {
                    best = Some(Near { distance, part: number });
                    // a little farther, so that the tree does not pass over one that is nearer by less than it can tell
                    (distance * (1.0 + 1e-6)) as f32
                }
                _ => f32::INFINITY,
            }
        });
        best
    }

    pub(super) fn surface(&self, ray: &Ray, near: Near) -> Surface {
        let [a, b, c] = self.corners[near.part as usize];
        let normal = (b - a).cross(c - a).normalize();
        let point = ray.at(near.distance);
        let point = point - (point - a).dot(normal) * normal;
        let shading = match self.normals.get(near.part as usize) {
            Some(normals) => {
                let shares = shares([a, b, c], point);
                let mean: DVec3 = shares.iter().zip(normals).map(|(s, n)| *s * *n).sum();
                mean.try_normalize().unwrap_or(normal)
            }
            None => normal,
        };
        Surface { point, normal, shading, tangent: across(shading)[0] }
    }

    pub(super) fn bounds(&self) -> [DVec3; 2] {
        self.bounds
    }
}

/// Distance to a triangle \[Moeller and Trumbore 1997\].
#[inline(always)]
fn meet([a, b, c]: &[DVec3; 3], ray: &Ray) -> Option<f64> {
    let (u, v) = (*b - *a, *c - *a);
    let p = ray.direction.cross(v);
    let scale = 1.0 / u.dot(p);
    let from = ray.origin - *a;
    let x = from.dot(p) * scale;
    let q = from.cross(u);
    let y = ray.direction.dot(q) * scale;
    let distance = v.dot(q) * scale;
    // an edge belongs to both of its triangles: no ray slips through between them
    let tiny = 1e-12;
    (x >= -tiny && y >= -tiny && x + y <= 1.0 + tiny && distance > 0.0 && distance.is_finite())
        .then_some(distance)
}

/// Shares of the corners in a point of a triangle.
fn shares([a, b, c]: [DVec3; 3], point: DVec3) -> [f64; 3] {
    let cross = (b - a).cross(c - a);
    let scale = 1.0 / cross.length_squared();
    let second = (point - a).cross(c - a).dot(cross) * scale;
    let third = (b - a).cross(point - a).dot(cross) * scale;
    [1.0 - second - third, second, third]
}
