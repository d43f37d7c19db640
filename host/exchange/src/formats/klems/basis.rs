//! The bases of Klems: rings and their patches.

use std::f64::consts::TAU;

use crate::formats::window::Ring;
use crate::patches::projected;

/// One of the three bases of the format.
pub(super) struct Known {
    pub(super) name: &'static str,
    /// Upper edge of each ring, degrees, and its patches.
    pub(super) rings: &'static [(f64, usize)],
}

pub(super) static FULL_BASIS: Known = Known {
    name: "LBNL/Klems Full",
    rings: &[
        (5.0, 1),
        (15.0, 8),
        (25.0, 16),
        (35.0, 20),
        (45.0, 24),
        (55.0, 24),
        (65.0, 24),
        (75.0, 16),
        (90.0, 12),
    ],
};
/// Named unlike the built-in one of Radiance, which has 73 patches in versions up to 2021 and 77 in later ones: this name is read by the
/// definition in the file.
pub(super) static HALF_BASIS: Known = Known {
    name: "LBNL/Klems Half 73",
    rings: &[(6.5, 1), (19.5, 8), (32.5, 12), (46.5, 16), (61.5, 20), (76.5, 12), (90.0, 4)],
};
/// The name without a definition, as Radiance of 2021 has it.
static OLD_HALF: Known = Known { name: "LBNL/Klems Half", rings: HALF_BASIS.rings };
/// The same of later versions (table of pyradiance 1.3.1).
static NEW_HALF: Known = Known {
    name: "LBNL/Klems Half",
    rings: &[(6.5, 1), (19.5, 8), (32.5, 12), (45.5, 16), (58.5, 20), (71.5, 12), (90.0, 8)],
};
/// Named unlike the built-in one of Radiance, whose rings end at 46 and 66 degrees in versions up to 2021 and at 45 and 63 in later ones.
pub(super) static QUARTER_BASIS: Known = Known {
    name: "LBNL/Klems Quarter 41",
    rings: &[(9.0, 1), (27.0, 8), (46.0, 12), (66.0, 12), (90.0, 8)],
};
static NEW_QUARTER: Known = Known {
    name: "LBNL/Klems Quarter",
    rings: &[(9.0, 1), (27.0, 8), (45.0, 12), (63.0, 12), (90.0, 8)],
};
pub(super) static BASES: [&Known; 3] = [&FULL_BASIS, &HALF_BASIS, &QUARTER_BASIS];
/// What names mean without a definition.
pub(super) static NAMED: [&Known; 4] = [&FULL_BASIS, &OLD_HALF, &NEW_HALF, &NEW_QUARTER];

/// A patch of a basis: polar angles of its edges, azimuth of its centre, and its width.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) ring: usize,
    pub(super) edges: [f64; 2],
    pub(super) azimuth: f64,
    /// Place in its ring and number of patches there.
    pub(super) place: [usize; 2],
}

impl Piece {
    /// Polar angle of the centre.
    pub(super) fn theta(self) -> f64 {
        if self.place[1] == 1 && self.edges[0] == 0.0 {
            0.0
        } else {
            f64::midpoint(self.edges[0], self.edges[1])
        }
    }

    pub(super) fn projected(self) -> f64 {
        projected(self.edges) / self.place[1] as f64
    }
}

/// A part of a full turn; the same number from whichever ring it comes.
pub(super) fn turn(k: usize, count: usize) -> f64 {
    let (mut a, mut b) = (k, count);
    while b > 0 {
        (a, b) = (b, a % b);
    }
    TAU * (k / a.max(1)) as f64 / (count / a.max(1)) as f64
}

pub(super) fn pieces(rings: &[Ring]) -> Vec<Piece> {
    let of_ring = |(ring, r): (usize, &Ring)| {
        let r = *r;
        (0..r.count).map(move |k| Piece {
            ring,
            edges: r.edges,
            azimuth: turn(k, r.count),
            place: [k, r.count],
        })
    };
    rings.iter().enumerate().flat_map(of_ring).collect()
}

impl Known {
    pub(super) fn rings(&self) -> Vec<Ring> {
        let mut lower = 0.0;
        let ring = |(upper, count): &(f64, usize)| {
            let edges = [lower, upper.to_radians()];
            lower = edges[1];
            Ring { edges, count: *count }
        };
        self.rings.iter().map(ring).collect()
    }

    pub(super) fn count(&self) -> usize {
        self.rings.iter().map(|r| r.1).sum()
    }
}
