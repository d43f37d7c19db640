//! Wavelengths as colours of a screen.

use crate::law::Band;

/// Weights of bands of light for red, green and blue of linear sRGB: light of the same radiance in all bands is white, (1, 1, 1)
/// in the mean over the bands. One band, or none, is grey.
///
/// The colour-matching functions of CIE 1931 by their closest sums of lobes \[Wyman 2013, eq. 4\], the primaries of IEC 61966-2-1.
/// Bands that lie so close that one of the primaries gets nothing of them are grey, too.
pub(crate) fn weights(bands: &[Band]) -> Vec<[f64; 3]> {
    if bands.len() < 2 {
        return vec![[1.0; 3]];
    }
    let n = bands.len() as f64;
    let weighted = |band: &Band| linear_srgb(matching(band.nm)).map(|c| c * band.share * n);
    let raw: Vec<[f64; 3]> = bands.iter().map(weighted).collect();
    let sums = [0, 1, 2].map(|c| raw.iter().map(|w| w[c]).sum::<f64>() / n);
    if sums.iter().any(|sum| *sum <= 1e-3) {
        return bands.iter().map(|band| [band.share * n; 3]).collect();
    }
    raw.into_iter().map(|w| [w[0] / sums[0], w[1] / sums[1], w[2] / sums[2]]).collect()
}

/// x, y and z of CIE 1931 at a wavelength.
fn matching(nm: f64) -> [f64; 3] {
    let lobe = |peak: f64, below: f64, above: f64| {
        let t = (nm - peak) * if nm < peak { below } else { above };
        libm::exp(-0.5 * t * t)
    };
    [
        0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323)
            - 0.065 * lobe(501.1, 0.0490, 0.0382),
        0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322),
        1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725),
    ]
}

fn linear_srgb([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    ]
}

/// A value of linear sRGB, 1 for white, as a byte of an image (IEC 61966-2-1).
pub fn srgb_byte(linear: f64) -> u8 {
    let x = linear.clamp(0.0, 1.0);
    let encoded =
        if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * libm::pow(x, 1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}

#[cfg(test)]
mod tests {
    use super::{matching, srgb_byte, weights};
    use crate::law::Band;

    #[test]
    fn white_is_white_and_green_is_green() {
        // the peak of the luminous efficiency, 1 at 555 nm
        assert!((matching(555.0)[1] - 1.0).abs() < 0.02);
        let bands = |list: &[f64]| -> Vec<Band> {
            list.iter().map(|&nm| Band { nm, share: 1.0 / list.len() as f64 }).collect()
        };
        let list = weights(&bands(&[450.0, 550.0, 620.0]));
        for c in 0..3 {
            assert!((list.iter().map(|w| w[c]).sum::<f64>() / 3.0 - 1.0).abs() < 1e-12);
        }
        assert!(list[0][2] > list[0][0] && list[1][1] > list[1][2] && list[2][0] > list[2][1]);
        assert_eq!(weights(&bands(&[550.0])), vec![[1.0; 3]]);
        assert_eq!(weights(&bands(&[550.0, 551.0])), vec![[1.0; 3]; 2]);
    }

    #[test]
    fn bytes_are_those_of_the_standard() {
        // half of the light is 188 of 255
        assert_eq!([0.0, 0.5, 1.0, 7.0].map(srgb_byte), [0, 188, 255, 255]);
    }
}
