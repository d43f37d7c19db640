//! Deviations that these tests allow, each with its reason; candidates for the common table.

use asperity_tests::tolerance::Tolerance;

macro_rules! limit {
    ($($name:ident = $allowed:expr, $quantity:literal, $reason:literal;)*) => {
        $(
            #[doc = concat!($quantity, ": ", $reason, ".")]
            pub(crate) const $name: Tolerance =
                Tolerance { quantity: $quantity, allowed: $allowed, reason: $reason };
        )*
    };
}

/// Factor on all readings of an instrument out of calibration.
pub(crate) const CALIBRATED: f64 = 0.8;

limit! {
    RECOVERED_ALPHA = 0.01, "GGX width fitted to a Monte Carlo scan, relative",
        "several standard errors at the number of rays used, see the margins printed";
    RECOVERED_ALPHA_WITHIN = 0.04, "GGX width of a back face seen in reflection, relative",
        "a twenty-fifth of the light comes back: three standard errors at the number of rays used";
    RECOVERED_IOR = 0.01, "refractive index fitted to a Monte Carlo scan, absolute",
        "several standard errors at the number of rays used";
    RECOVERED_DELTA = 0.02, "width of a law of normals fitted to a Monte Carlo scan, relative",
        "delta and n of a law are correlated: twice what a width alone is allowed";
    RECOVERED_EXPONENT = 0.03, "exponent of a law of normals fitted to a Monte Carlo scan, relative",
        "delta and n of a law are correlated";
    RECOVERED_GAIN = 0.01, "calibration factor fitted to a Monte Carlo scan, relative",
        "several standard errors at the number of rays used";
    RECOVERED_LAMBERT = 0.03, "Lambert floor fitted to a Monte Carlo scan, relative",
        "the floor is the weak part of the readings";
    PULL = 4.0, "fitted value from the truth, in its own standard errors",
        "6e-5 two-sided a value if errors are normal, and the seeds are fixed";
    PULL_RMS = 2.2, "rms of the pulls of repeated fits, or its inverse",
        "few dozen effective readings leave a third to a standard error, 16 fits a fifth to the rms";
    BEST = 2e-3, "error a fit ends at above that of the truth, relative",
        "a fit stops when its simplex is flat to 1e-6 of the error, the forward model jumps by 1e-4 %";
    SAMPLE_5_ALPHA = 0.03, "alpha of sample 5 against an independent fit, relative",
        "that fit follows one pass through the plate, ours all";
    SAMPLE_8_ALPHA = 0.04, "alpha of sample 8 against an independent fit, relative",
        "that fit follows one pass through the plate, ours all";
    METAL_ALPHA = 0.02, "alpha of measured metals against an independent fit, relative",
        "that fit lets no reading be left out and may take a boundary of the floor";
    METAL_ERROR = 0.02, "error of measured metals above that of an independent fit, relative",
        "the same model and readings: both are at the least squares";
    SMOOTH_PLATE = 1e-3, "reading of a nearly smooth plate against (1 - F) / (1 + F), absolute",
        "2e-4 of the beam may be neglected, and a share (alpha / aperture)^2 lies in the tail";
    WIDE_LOBE = 2e-3, "reading over solid angle, between apertures, relative",
        "curvature of the lobe: (a / width)^2 / 8 at the largest aperture";
    INSIDE = 0.03, "reading of light that met the rough face more than once, beyond noise, relative",
        "64 (transmission) or 2048 (reflection) rays of the internal rule, and a cubic between directions";
    NEGLECTED_FLUX = 1e-3, "flux neglected in the internal passes, of the beam",
        "what the forward model promises: 2e-4, and dropped rays of 1e-4 of an even share each";
    NEGLECTED_READING = 5e-5, "bound of what a reading may miss, of the largest, transmission",
        "a twentieth of the noise of a good scan, 0.1 %; what is really missing is less than the bound";
    SMOOTH_TRANSMISSION = 1e-4, "second difference of the error of eq. (18) in %, at steps of 1e-4 in ln alpha",
        "moves the minimum of an error of 1 % by less than 3e-4 in ln alpha";
    SMOOTH_REFLECTION = 2e-3, "the same in reflection",
        "half of the light has been inside: one of 2048 rays there turns up or is lost at a kink";
}

/// Whether `found` is within a share of `exact`.
pub(crate) fn near(found: f64, exact: f64, limit: Tolerance) -> bool {
    (found / exact - 1.0).abs() <= limit.allowed
}
