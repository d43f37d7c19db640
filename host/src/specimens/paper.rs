//! The eight acrylic samples of the paper: its Table 1, with correlation lengths.

use crate::surface::HeightFigures;

/// A sample as it is printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperSample {
    /// Its number, 1 to 8.
    pub number: u8,
    /// Points along x and y.
    pub size: (usize, usize),
    /// Side of the measured square, mm.
    pub side_mm: f64,
    /// The figures that a virtual sample is made of.
    pub figures: HeightFigures,
    /// The mean height Ra, um; a virtual sample comes within 2 % of it.
    pub ra_um: f64,
    /// Lag at which the autocorrelation is 1/e, um. The paper does not print it: 14 um and 55 um are those of samples 5 and 8.
    /// Below sample 5 it stays in the same ratio to Rq, which keeps the slopes; between 5 and 8 the ratio is a power of Rq.
    pub length_um: f64,
}

const fn sample(
    number: u8,
    (size, side_mm): ((usize, usize), f64),
    [ra_um, rq_um]: [f64; 2],
    [rv_um, rp_um]: [f64; 2],
    [rsk, rku]: [f64; 2],
    length_um: f64,
) -> PaperSample {
    let figures = HeightFigures { rq_um, rsk, rku, rv_um, rp_um };
    PaperSample { number, size, side_mm, figures, ra_um, length_um }
}

/// All of them, in the order of their numbers.
pub const PAPER: [PaperSample; 8] = [
    sample(1, ((1024, 1024), 0.37), [0.178, 0.232], [1.754, 0.594], [-0.786, 5.156], 2.2),
    sample(2, ((1333, 1333), 0.95), [0.456, 0.581], [2.908, 1.613], [-0.700, 3.654], 5.5),
    sample(3, ((1330, 1330), 0.95), [0.668, 0.866], [5.870, 3.380], [-0.839, 4.482], 8.3),
    sample(4, ((1332, 1332), 0.95), [0.738, 0.956], [5.400, 2.369], [-0.928, 4.492], 9.1),
    sample(5, ((1024, 1024), 0.37), [1.170, 1.466], [5.726, 3.588], [-0.560, 3.275], 14.0),
    sample(6, ((1332, 1332), 0.95), [2.038, 2.669], [13.731, 7.817], [-0.643, 4.279], 20.0),
    sample(7, ((1331, 1333), 0.95), [2.596, 3.308], [16.889, 7.847], [-0.658, 3.920], 23.0),
    sample(8, ((667, 677), 0.95), [10.724, 13.456], [33.913, 40.7834], [0.012, 2.813], 55.0),
];

impl PaperSample {
    /// The sample of a number.
    pub fn numbered(number: u8) -> Option<Self> {
        PAPER.into_iter().find(|sample| sample.number == number)
    }

    /// Distance of columns and of rows, um.
    pub fn pitches_um(&self) -> (f64, f64) {
        let pitch = |count: usize| 1e3 * self.side_mm / count as f64;
        (pitch(self.size.0), pitch(self.size.1))
    }
}
