//! The one table of tolerances: quantity, allowed deviation, reason. Tests take theirs from here.

/// How far a quantity may be from what it should be, and why that far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// What is compared.
    pub quantity: &'static str,
    /// The deviation allowed, relative or absolute as the quantity says.
    pub allowed: f64,
    /// Where the figure comes from.
    pub reason: &'static str,
}

macro_rules! table {
    ($($name:ident = $allowed:expr, $quantity:literal, $reason:literal;)*) => {
        $(
            #[doc = concat!($quantity, ": ", $reason, ".")]
            pub const $name: Tolerance =
                Tolerance { quantity: $quantity, allowed: $allowed, reason: $reason };
        )*
        /// Every entry.
        pub const ALL: &[Tolerance] = &[$($name),*];
    };
}

table! {
    FORWARD_TAIL = 0.03, "readings down to a millionth of the peak by quadrature against rays, beyond noise, relative",
        "nodes of the polar angle inside a tenth apart, facets that begin to mirror totally between them; the goal is 0.01, not yet reached everywhere";
    FORWARD_MODEL = 2e-3, "width fitted by quadrature to a scan by rays, relative, noise aside",
        "nodes of the polar angle inside a tenth apart; 0.001 was seen";
    TRACED_FLUX = 1e-3, "transmitted flux of a traced plate against the independent tracer, absolute",
        "2e6 rays in strata err by 1e-4, the reference's figures are rounded to 1e-4";
    TRACED_SAMPLE_5 = 0.25, "eq. (18) of a traced scan of sample 5 against the independent tracer, %",
        "the reference has 0.12 % of noise, 2e6 rays in strata some 0.15 %";
    TRACED_SAMPLE_8 = 0.9, "eq. (18) of a traced scan of sample 8 against the independent tracer, %",
        "the reference has 0.17 % of noise, 2e6 rays some 0.8 %; with 1e7 rays 0.3 % was seen";
    TRACED_SMALL_MAP = 0.6, "eq. (18) of a traced scan of the small map of the tree against the independent tracer, %",
        "that tracer has 0.1 % of noise, 5e5 rays some 0.3 %";
    SCALE_OF_SMALL_MAP = 0.02, "vertical scale fitted to the scan of that map, absolute", "what the method promises";
    RECOVERED_HEIGHTS = 0.03, "width of a law of heights fitted with other heights than the scan's, relative",
        "as many facets are seen of either, and few rays; 0.004 was seen with more";
    DIRECT_SUM_SCAN = 0.5, "eq. (18) of measured-wave fitted to a scan of the same map made by direct sums, %",
        "the direct sums leave out internal passes, some 0.2 %; the method promises 1 %";
    SCALE_OF_MAP = 0.02, "vertical scale fitted to the scan of the very map, absolute",
        "what the method promises; 0.002 was seen with ten times the rays";
    ACQUIRED_ALPHA = 0.02, "width fitted to an acquired scan against the instrument's own, relative",
        "what acquisition promises; 3e5 rays an incidence leave some 0.4 % of noise";
    TABLE_8_KIB = 1.0, "eq. (18) of a table for a microcontroller of 8 KiB against its model, %",
        "what the table promises";
    TABLE_32_KIB = 0.3, "eq. (18) of a table of 32 KiB against its model, %",
        "what the table promises";
    TABLE_PEAK_16_KIB = 0.06, "rms of f cos of a lobe of a table of 16 KiB against its model, over the peak of any incidence",
        "what the table promises";
    TABLE_PEAK_32_KIB = 0.02, "the same of 32 KiB", "what the table promises";
    TABLE_VALUES = 0.01, "f and f cos of a table of 32 KiB against its model, over the peak of the lobe",
        "what the table promises";
    TABLE_FLUX = 0.005, "flux of a lobe of a table of 32 KiB against its model, absolute",
        "what the table promises";
    TABLE_FLUX_8 = 0.01, "flux of a lobe of a table of 8 KiB against its model, absolute",
        "fewer incidences";
    TABLE_GAIN = 5e-4, "R + T of a table beyond 1, absolute",
        "the table is lowered to 0.9998 by sums over facets; the lattice errs by as much";
    TABLE_RECIPROCITY = 0.02, "mean difference of a table and itself the other way, relative",
        "both ways are interpolated from nodes of their own";
    GAMMA = 2e-11, "incomplete gamma function, relative",
        "cancellation of a ln x - x - ln gamma(a) at a = 500, and known values given to 12 digits";
    SIGNIFICANCE = 0.01, "chance that a right sampler fails any of a family of tests",
        "convention; divided among the tests by Sidak's rule";
    MONTE_CARLO = 4.5, "Monte Carlo mean, in standard errors",
        "7e-6 two-sided a comparison, and the seeds are fixed";
    FRESNEL = 1e-13, "Fresnel coefficients, absolute, times 1 + 1 / g",
        "g = eta cos theta_t is a root of a difference: its error is that of the difference over g";
    FRESNEL_NEAR_ONE = 1e-9, "relative error of reflectances of indices that differ by 1e-6",
        "eta - 1 keeps ten digits of eta's sixteen";
    BREWSTER = 1e-13, "r_p at Brewster's angle, absolute", "cos of an arc tangent is right to 1e-16";
    CROSS_CHECK = 1e-6, "f cos against the published cross-check table, relative",
        "the table has seven digits: half a unit of the last is 5e-7 of 1.0";
    TEXTBOOK = 1e-12, "f against the textbook formulas, relative, plus input conditioning",
        "some thirty operations of 1e-16, cancellation in theta and in 1 - sin^2 magnifies a hundredfold";
    F32 = 2e-5, "f in f32 against f64 on the same inputs, relative",
        "what an embedded evaluator promises: 300 half-units of rounding";
    F32_CONDITIONING = 1.0, "allowed share of one f32 ulp of every input, on top of F32",
        "the sum of two directions is itself rounded: half an ulp a component, either way";
    PRECISION = 1e-4, "f32 and fast f32 against f64 on the same numbers, relative, where the value matters",
        "what an embedded evaluator promises: a few ten roundings, and powers that magnify them";
    PRECISION_F64 = 1e-9, "fast f64 against f64, the same", "polynomials of some hundred epsilon, magnified by powers";
    MATTERS = 1e-6, "what matters: share of the peak of the lobe", "convention: six decades, as a good instrument sees";
    SMOOTH_LIMIT = 1e-5, "median distance of a sampled direction from Snell's or the mirror's, alpha 1e-6",
        "the facets' median slope is alpha, magnified by two in reflection and by the obliquity";
    SMOOTH_FLUX = 1e-6, "R at alpha 1e-6 against Fresnel, absolute",
        "second order in alpha, magnified by 1 / cos near grazing and by the tail of the slopes";
    ENERGY = 1e-9, "R + T above 1, absolute",
        "error of the quadrature over facets, measured as its deviation from the area of all visible ones";
    ENERGY_BRUTE = 2e-3, "R and T of brute force over directions against quadrature over facets, absolute",
        "brute force meets kinks (horizon, total reflection) off its grid";
    ENERGY_TABLE = 4e-3, "R and T against the published energy table, absolute",
        "the table is a Monte Carlo estimate with 0.003 noise";
    RECIPROCITY = 1e-12, "reciprocity of f / n^2, relative",
        "some fifty roundings of 1e-16, and the sum of directions, counted apart";
    RECIPROCITY_CONDITIONING = 0.1, "roundings of the half vector, each magnified by its conditioning",
        "h = n_i wi + n_o wo is the same to the last bit both ways, so its conditioning hardly counts";
    NORMALISATION = 1e-6, "integral of a density of normals, absolute",
        "eight-point panels against half a million midpoints";
    FACET_REFERENCE = 2e-5, "facet BSDF against the reference file, relative",
        "the closed form of the file is given to nine digits at angles rounded to 1e-3 degrees";
    NORMALS_FLUX = 2e-3, "R and T of quadrature of ars against sampling, beyond the noise, absolute",
        "brute-force grid, table of the visible share (5e-4)";
    NORMALS_TAIL = 2e-5, "share of normals drawn from far out, absolute",
        "the last cell of the 256-node quantile table holds 3 / 255^2 = 4.6e-5 and is drawn from a cubic";
    REFRACTED = 8.0, "cos^2 of a refracted direction, absolute, in epsilon",
        "1 - sin^2 in units of 1, and a normalisation; relative to a small cosine it is much more";
    UNIT = 4.0, "length of a direction from 1, in epsilon", "one normalisation";
    WEIGHT = 16.0, "weight of a sample above 1, in epsilon", "a quotient of two sums";
    PLATE_F64 = 1e-12, "R + T + lost of a plate from 1, f64", "sums of up to 4096 passes";
    PLATE_F32 = 1e-5, "R + T + lost of a plate from 1, f32", "sums of up to 4096 passes at 6e-8, roulette";
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
        "nodes of the polar angle inside a tenth apart, facets that begin to mirror totally between them";
    NEGLECTED_FLUX = 1e-3, "flux neglected in the internal passes, of the beam",
        "what the forward model promises: 2e-4, and dropped rays of 1e-4 of an even share each";
    NEGLECTED_READING = 5e-5, "bound of what a reading may miss, of the largest, transmission",
        "a twentieth of the noise of a good scan, 0.1 %; what is really missing is less than the bound";
    RAY_PLACE = 2e-6, "shift of a ray on a height map that explains what it meets, of the map's size",
        "places and heights are single: a few roundings of 6e-8 at each way around the map";
    RAY_TIES = 2e-3, "share of rays that meet the neighbour of the triangle brute force names, or need the shift",
        "a strip of the width of the shift along every edge";
    FLAT = 1e-6, "x, y and z^2 of a direction from a flat map against the smooth boundary's, absolute",
        "some ten roundings of 6e-8: a traced ray is single, the smooth boundary double";
    FLAT_PLATE = 1e-5, "the same, and fluxes, in a plate, absolute",
        "several passes, and at grazing incidence fluxes change with the cosine";
    STATED_ERROR = 1.5, "error a Monte Carlo reading states over its scatter between seeds, at most",
        "found from neighbours, which start in different places: too large, up to this on smooth maps";
    FACETS_TRACED = 6.0, "flux in a cone from traced maps against single facets, in standard errors",
        "the error is estimated from the scatter of eight maps: Student's t of 7 degrees";
    FACETS_TRACED_MEAN = 0.01, "the same, weighted mean of all cones, relative",
        "the slopes of a map of 51 correlation lengths are Gaussian to a percent";
    UPRIGHT_LOST = 1e-4, "share of rays lost on white noise of rms slope 10 to 100",
        "single precision places a hit on an upright wall to a few millionths of its height only";
    KIRCHHOFF_SERIES = 1e-6, "series of Gaussian surfaces against the reference file, relative",
        "the file has nine digits at angles rounded to 1e-6 degrees, and its quadrature 1e-8";
    COHERENT = 0.01, "coherent part of normal heights above 1e-3 against exp(-g), relative",
        "what the method promises; quantiles of a law have no noise, 1e-3 was seen";
    COHERENT_DARK = 1e-5, "the same below 1e-3, absolute",
        "independent heights in a few thousand places";
    DIFFUSE_DENSITY = 0.03, "diffuse density of Gaussian maps against the series, relative",
        "what the method promises; speckle of 1500 orders of 16 maps leaves 0.7 to 1 %";
    DIFFUSE_TAIL = 0.12, "the same below a hundredth of the peak and above a thousandth, relative",
        "that light comes from several strong waves at once, of which a map has few";
    DIFFUSE_POWER = 3e-3, "coherent and diffuse light of a mean law at one q_z, from 1",
        "interpolation between rings and between q_z a tenth apart";
    GRATING = 1e-3, "orders of sinusoidal gratings against Bessel functions, absolute",
        "what the method promises; 1e-5 of the field was seen";
    GRATING_RIGOROUS = 0.01, "orders of sinusoidal gratings against a rigorous solution, absolute",
        "Kirchhoff's own error at slopes up to 0.5";
    LITTLE_ROUGHNESS = 0.02, "diffuse light of little roughness against g, relative",
        "obliquity over a lobe of 0.1 rad is second order in it";
    PERTURBATION = 0.05, "mean law near the specular direction against first-order perturbation, relative",
        "Kirchhoff's obliquity is right at the specular direction only, 5 degrees from it by a few per cent";
    FLAT_WAVE = 2e-5, "coherent light of a flat map against Fresnel, absolute",
        "1e-5 of the field by the stack over q_z, single precision";
    SHORT_WAVES = 0.03, "mean law of short waves against single facets, relative",
        "what the method promises: 1/g is 1 %, as is the speckle of 1500 orders of a few maps";
    REAL_COHERENT = 0.005, "coherent share of a measured surface, absolute", "given to three digits";
    REAL_PIECE = 0.02, "the same without a window, absolute",
        "the map is 13 by 20 correlation lengths: another weight of its points is another sample";
    REAL_WIDTH = 0.05, "angles of half and nine tenths of its diffuse light, relative",
        "one map: speckle, and windows differ";
    VERDICT_OF_MAPS = 6.0, "lobes of the atlas, of 504, that a map judges otherwise than its surface in closed form",
        "400 correlation lengths know the slope to 4 % and the share of the facets beyond three of it to a third";
    WAVE_ENERGY = 0.01, "R + T of orders above 1, absolute", "Kirchhoff's own error at rms slopes of 0.07";
    NOISE_FLOOR = 0.15, "noise floor beside a fit against the noise that was added, relative",
        "noise that grows with a narrow lobe is that of some twenty readings";
    LIT_ORDERS = 0.03, "orders of a map that alone is lit against sums over its tangent planes, rms relative",
        "heights at the rim are those half a pixel inside: 2.5e-3, 0.02 beyond the critical angle, where all light is little";
    LIT_LITTLE_Q_Z = 0.1, "the same of those orders alone whose momentum is nearly level",
        "all of their light is the rim's, by up to 0.07; |A|^2 over h_z^2 has no bound there";
    LIT_FLAT = 2e-3, "flux of a flat map that alone is lit below Fresnel's, absolute",
        "diffracted beyond the horizon, or where no facet leads";
    LIT_GRAZING = 0.01, "the same at 75 degrees", "80 um wide: 0.8 % is diffracted beyond the horizon";
    LIT_ENERGY = 0.01, "R + T of a map that alone is lit against its mean law, absolute",
        "what is asked for; 0.005 was seen";
    ROWS = 1e-6, "flux of a corrugated surface of 8, 64 and 512 equal rows, relative", "single precision";
    PLAIN_SUM = 1e-4, "the same against a direct sum over its orders, relative",
        "1e-5 of the field by the stack over q_z";
    MEAN_LAW_FLUX = 3e-3, "flux of a lobe of the mean law against that of the orders of the map, absolute",
        "one map: speckle; 0.0018 was seen, 0.01 where light was counted beyond what the pixel carries";
    WAVE_RECIPROCITY = 1e-9, "reciprocity of the mean law, and weight times density, relative",
        "the momentum is the same to rounding, ln D has steep flanks";
    SMOOTH_TRANSMISSION = 1e-4, "second difference of the error of eq. (18) in %, at steps of 1e-4 in ln alpha",
        "moves the minimum of an error of 1 % by less than 3e-4 in ln alpha";
    SMOOTH_REFLECTION = 2e-3, "the same in reflection",
        "half of the light has been inside; rules have a whole number of nodes";
}

/// Whether `found` is within a share of `exact`.
pub fn near(found: f64, exact: f64, limit: Tolerance) -> bool {
    (found / exact - 1.0).abs() <= limit.allowed
}
