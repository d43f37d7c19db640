//! Where the scene is seen from.

use glam::DVec3;

use crate::ray::Ray;

/// How points of the image become rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All from one point; the full angle that the width of the image takes, rad.
    Pinhole {
        /// Below pi.
        field: f64,
    },
    /// All parallel; the width of the image in m.
    Orthographic {
        /// Above 0.
        width: f64,
    },
}

/// A camera without a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    projection: Projection,
    /// Half of the width: of the image at a distance of 1, or of the image itself, m.
    half: f64,
    pixels: [u32; 2],
}

impl Camera {
    /// At a point, looking at another, with a direction that is up in the image, and the image's pixels across and down;
    /// `None` if the points are the same or up is the direction of view.
    pub fn new(
        [eye, at, up]: [DVec3; 3],
        projection: Projection,
        pixels: [u32; 2],
    ) -> Option<Self> {
        let forward = (at - eye).try_normalize()?;
        let right = forward.cross(up).try_normalize()?;
        let up = right.cross(forward);
        let half = match projection {
            Projection::Pinhole { field } => libm::tan(0.5 * field),
            Projection::Orthographic { width } => 0.5 * width,
        };
        Some(Self { eye, forward, right, up, projection, half, pixels })
    }

    /// Pixels across and down.
    pub fn pixels(&self) -> [u32; 2] {
        self.pixels
    }

    /// The same with other pixels; the width of the image shows the same.
    #[must_use]
    pub fn with_pixels(self, pixels: [u32; 2]) -> Self {
        Self { pixels, ..self }
    }

    /// Eye, direction of view and up, as vectors.
    pub fn frame(&self) -> [DVec3; 3] {
        [self.eye, self.forward, self.up]
    }

    /// Its projection.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// The ray of a point of the image, in pixels from its upper left corner to the right and down.
    #[inline]
    pub fn ray(&self, [x, y]: [f64; 2]) -> Ray {
        let [width, height] = self.pixels.map(f64::from);
        let across = 2.0 * x / width - 1.0;
        let down = (2.0 * y / height - 1.0) * height / width;
        let [across, down] = [across * self.half * self.right, down * self.half * self.up];
        match self.projection {
            Projection::Pinhole { .. } => {
                let direction = self.forward + across - down;
                Ray { origin: self.eye, direction: direction.normalize() }
            }
            Projection::Orthographic { .. } => {
                Ray { origin: self.eye + across - down, direction: self.forward }
            }
        }
    }
}
