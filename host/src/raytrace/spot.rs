//! Points of the surface, and its facets one by one.

use asperity_core::direction::Direction;

use super::walk::gradient;
use super::{Field, Triangle};

/// A point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spot {
    /// The facet it is on.
    pub(crate) triangle: Triangle,
    /// Where it is: x and y in cells, z in pitches from the middle of the heights.
    pub(crate) point: [f32; 3],
    /// Slopes of the facet, along x and y.
    pub(crate) slope: [f32; 2],
}

impl Spot {
    /// The unit normal of the facet, upward.
    #[inline]
    pub(crate) fn normal(&self) -> Direction<f32> {
        let [x, y] = self.slope;
        let scale = 1.0 / (x * x + y * y + 1.0).sqrt();
        Direction::from_unit(-x * scale, -y * scale, scale)
    }
}

/// Two neighbouring rows of nodes, and the cells between them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'a> {
    /// Heights of the nodes of the row, one more than cells, and of the next.
    pub(crate) heights: [&'a [f32]; 2],
    /// Pitch along x over that along y.
    pub(crate) inverse_aspect: f32,
}

impl Field {
    /// The point above a place; both coordinates from 0 to 1 across the map.
    #[inline]
    pub(crate) fn spot(&self, place: [f64; 2]) -> Spot {
        let mut cell = [0_i32; 2];
        let mut within = [0.0_f32; 2];
        for k in 0..2 {
            let at = place[k] * f64::from(self.cells[k]);
            cell[k] = (at as i32).clamp(0, self.cells[k] - 1);
            within[k] = ((at - f64::from(cell[k])) as f32).clamp(0.0, 1.0);
        }
        let [u, v] = within;
        let triangle = Triangle { cell, upper: v > u };
        let spot = self.corner(triangle);
        let [gx, gy] = [spot.slope[0], spot.slope[1] * self.aspect];
        let [x, y] = [cell[0] as f32 + u, cell[1] as f32 + v];
        Spot { point: [x, y, spot.point[2] + gx * u + gy * v], ..spot }
    }

    /// A facet, at the first node of its cell.
    #[inline]
    pub(crate) fn corner(&self, triangle: Triangle) -> Spot {
        let [x, y] = triangle.cell;
        let h = self.corners(x, y);
        let [gx, gy] = gradient(h, triangle.upper);
        Spot { triangle, point: [x as f32, y as f32, h[0]], slope: [gx, gy / self.aspect] }
    }

    /// The cells of a row.
    pub(crate) fn rows(&self, y: usize) -> Rows<'_> {
        let [low, high] = [y, y + 1].map(|y| self.nodes(y));
        Rows { heights: [low, high], inverse_aspect: 1.0 / self.aspect }
    }

    /// Pitch along y over that along x.
    pub(crate) fn aspect(&self) -> f32 {
        self.aspect
    }

    /// The largest height over the middle of the heights, pitches.
    pub(crate) fn half_range(&self) -> f32 {
        self.highest.abs().max(self.lowest.abs())
    }
}

#[cfg(test)]
mod tests {
    use crate::raytrace::Field;
    use crate::surface::{Edges, HeightMap};

    #[test]
    fn a_spot_lies_on_the_surface_and_its_slopes_are_those_of_its_facet() {
        let heights = (0..12 * 9).map(|k| f64::from(k * k % 17) * 0.1).collect();
        let map = HeightMap::new((12, 9), (1.0, 2.0), heights).unwrap();
        for edges in [Edges::Periodic, Edges::Mirrored] {
            let field = Field::new(&map, edges).unwrap();
            for k in 0..200 {
                let place = [f64::from(k * 37 % 200) / 200.0, f64::from(k) / 200.0];
                let spot = field.spot(place);
                let [x, y, z] = spot.point;
                assert!((field.height(x, y) - z).abs() < 1e-5);
                let d = 1e-3;
                let [cx, cy] = spot.triangle.cell;
                let (u, v) = (x - cx as f32, y - cy as f32);
                // inside of the facet, away from its edges
                if (u - v).abs() > 0.01 && u.min(v) > 0.01 && u.max(v) < 0.99 {
                    let along_x = (field.height(x + d, y) - z) / d;
                    let along_y = (field.height(x, y + d) - z) / d / 2.0;
                    assert!((along_x - spot.slope[0]).abs() < 5e-3, "{along_x} {spot:?}");
                    assert!((along_y - spot.slope[1]).abs() < 5e-3, "{along_y} {spot:?}");
                }
            }
        }
    }
}
