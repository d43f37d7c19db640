//! The part of the beam that a simulation takes.
//!
//! A beam is uniform over every plane. Of a periodic map all of it is taken. On a finite one rays aim at points of the middle plane so
//! far from the edge that the heights do not reach over it, as [`Field::scatter`] has them.

use super::beam::Beam;
use crate::forward::Effort;
use crate::raytrace::{Field, Spot};
use crate::surface::Edges;

/// A rectangle of the middle plane, in cells; a point of the surface belongs to it if a ray of the beam that aims there meets
/// that point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    /// `None`: all of the map.
    bounds: Option<[[f32; 2]; 2]>,
    /// What a height moves the aim by, cells a pitch.
    shift: [f32; 2],
    /// The area of the map over that of the rectangle.
    pub(super) scale: f64,
    /// One row of cells in so many is taken.
    stride: usize,
}

/// The largest margin, as a share of the side of the map: a beam that needs more reaches over the edge.
const MOST_MARGIN: f64 = 0.25;

impl Window {
    /// `None` if heights reach over the edge of the map. A fit takes a part of the rows of a
    /// large map, a draft fewer.
    pub(super) fn of(field: &Field, beam: &Beam<'_>, effort: Effort) -> Option<Self> {
        let [x, y, z] = beam.wi.xyz();
        let shift = [x / z, y / z / field.aspect()];
        let (nx, ny) = field.size();
        let most_rows = (effort.cells() / nx).max(1);
        let stride = (ny / most_rows).max(1);
        if field.edges() == Edges::Periodic {
            return Some(Self { bounds: None, shift, scale: 1.0, stride });
        }
        let mut bounds = [[0.0_f32; 2]; 2];
        let mut scale = 1.0;
        for (k, n) in [nx as f64, ny as f64].into_iter().enumerate() {
            let margin = f64::from((field.half_range() * shift[k]).abs());
            if margin > MOST_MARGIN * n {
                return None;
            }
            bounds[k] = [margin as f32, (n - margin) as f32];
            scale *= n / (n - 2.0 * margin);
        }
        Some(Self { bounds: Some(bounds), shift, scale, stride })
    }

    /// The rows of cells that are taken.
    pub(super) fn rows(&self, field: &Field) -> Vec<usize> {
        (0..field.size().1).step_by(self.stride).collect()
    }

    /// The point above a place in those rows, whose coordinates go from 0 to 1.
    #[inline]
    pub(super) fn spot(&self, field: &Field, [x, y]: [f64; 2]) -> Spot {
        if self.stride == 1 {
            return field.spot([x, y]);
        }
        let rows = field.size().1;
        let taken = rows.div_ceil(self.stride);
        let at = y * taken as f64;
        let row = (at as usize).min(taken - 1);
        field.spot([x, ((row * self.stride) as f64 + (at - row as f64)) / rows as f64])
    }

    /// Whether it is all of the map.
    fn is_all(&self) -> bool {
        self.bounds.is_none()
    }

    /// Whether a point of the surface belongs to it.
    #[inline]
    pub(super) fn holds(&self, [x, y, z]: [f32; 3]) -> bool {
        let Some([along_x, along_y]) = self.bounds else { return true };
        let within = |at: f32, [low, high]: [f32; 2]| at >= low && at <= high;
        within(x - z * self.shift[0], along_x) && within(y - z * self.shift[1], along_y)
    }

    /// Whether a facet counts as belonging to it as a whole, whichever of its points is meant.
    #[inline]
    pub(super) fn holds_facet(&self, field: &Field, spot: &Spot) -> bool {
        self.is_all() || self.holds(field.corner(spot.triangle).point)
    }
}
