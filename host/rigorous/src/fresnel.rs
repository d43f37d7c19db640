//! Fresnel's shares at a plane facet.

/// The shares of the flux that a plane facet reflects, \[TE, TM\], for light that meets it at the cosine `cos` (0 to 1);
/// `eta` is the index of the medium beyond over that of the light. 1 on total reflection; the rest is transmitted.
pub(crate) fn reflected(cos: f64, eta: f64) -> [f64; 2] {
    let g2 = (eta - 1.0) * (eta + 1.0) + cos * cos;
    if g2 <= 0.0 {
        return [1.0; 2];
    }
    let g = g2.sqrt();
    let te = (cos - g) / (cos + g);
    let tm = (eta * eta * cos - g) / (eta * eta * cos + g);
    [te * te, tm * tm]
}

#[cfg(test)]
mod tests {
    use super::reflected;

    #[test]
    fn at_normal_incidence_at_brewsters_angle_and_beyond_the_critical_one() {
        let normal = (0.49f64 / 2.49).powi(2);
        assert!(reflected(1.0, 1.49).iter().all(|r| (r - normal).abs() < 1e-15));
        assert!(reflected(1.0, 1.0 / 1.49).iter().all(|r| (r - normal).abs() < 1e-15));
        assert!(reflected(1.49f64.atan().cos(), 1.49)[1] < 1e-30);
        assert!(reflected(0.7, 1.0 / 1.49).iter().all(|r| (r - 1.0).abs() < 1e-15));
    }
}
