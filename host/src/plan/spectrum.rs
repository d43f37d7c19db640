//! Wavelengths of a scene, and the index of its body at them.

use asperity_core::quadrature::gauss_legendre_node;

use super::scene::{Body, Source};

/// Lines of Fraunhofer that the Abbe number is of, nm: F, d, C.
const LINES: [f64; 3] = [486.13, 587.56, 656.27];

/// Wavelengths that stand for the whole band, nm, with their weights: the rule of Gauss of so many nodes.
pub(super) fn nodes(source: &Source, count: usize) -> Vec<(f64, f64)> {
    let [from, to] = source.wavelength_nm;
    if to <= from {
        return vec![(from, 1.0)];
    }
    let node = |k| gauss_legendre_node(count, k);
    (0..count).map(node).map(|(x, weight)| (from + (to - from) * x, weight)).collect()
}

/// The index at a wavelength: that of the scene, with Cauchy's dispersion where there is an Abbe number.
pub(super) fn index(body: &Body, nm: f64) -> f64 {
    let Some(abbe) = body.abbe else { return body.ior };
    let [f, d, c] = LINES.map(|nm| 1.0 / (nm * nm));
    let slope = (body.ior - 1.0) / (abbe * (f - c));
    body.ior + slope * (1.0 / (nm * nm) - d)
}

#[cfg(test)]
mod tests {
    use super::{LINES, index};
    use crate::plan::scene::{Behind, Body, BodyKind, Face};

    #[test]
    fn the_abbe_number_comes_back() {
        let body = Body {
            kind: BodyKind::Plate,
            ior: 1.492,
            abbe: Some(57.4),
            rough: Face::Source,
            behind: Behind::Air,
            thickness_mm: 0.0,
            length_mm: 0.0,
        };
        let [f, d, c] = LINES.map(|nm| index(&body, nm));
        assert!(((d - 1.0) / (f - c) - 57.4).abs() < 1e-9 && (d - 1.492).abs() < 1e-12);
    }
}
