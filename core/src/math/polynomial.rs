//! Elementary functions as short polynomials without branches: the fast tier.
//!
//! `libm`'s single-precision sine and cosine compute in double precision, two thousand instructions on a
//! Cortex-M4F; these take some forty, and loops over them become vector instructions. Every argument is
//! reduced to a short interval (Cody and Waite; `ln` and `atan` by quotients), where a polynomial
//! takes over whose coefficients minimise the largest relative error (Lawson's
//! weights, 40 digits). The tests hold the bounds and visit every region and its edges.

#![allow(
    clippy::excessive_precision,
    clippy::approx_constant,
    reason = "coefficients as they were fitted"
)]

/// `c0 + c1 x + c2 x^2 + ...`
macro_rules! horner {
    ($x:expr; $c0:expr) => { $c0 };
    ($x:expr; $c0:expr, $($c:expr),+) => { $c0 + $x * horner!($x; $($c),+) };
}

macro_rules! functions {
    (
        $module:ident, $t:ident, $bits:ident, $signed:ident, $digits:expr, $bias:expr,
        round: $round:expr, widest_exp: $most_exp:expr, least_exp: $least_exp:expr, last_power: $last_power:expr,
        two_over_pi: $two_over_pi:expr, half_pi: $half_pi:expr, log2_e: $log2_e:expr, ln_2: $ln_2:expr,
        subnormal: $subnormal:expr, subnormal_log: $subnormal_log:expr,
        sin: [$($sin:expr),+], cos: [$($cos:expr),+], exp: [$($exp:expr),+], halved: [$($halved:expr),+], asin: [$($asin:expr),+],
        atan: [$($atan:expr),+], squared: [$($squared:expr),+], ln: [$($ln:expr),+]
    ) => {
        #[doc = concat!("For `", stringify!($t), "`.")]
        pub(super) mod $module {
            use crate::math::Real;

            /// The nearest integer, and the low bits of its two's complement; right up to `2^(digits - 2)`.
            #[inline(always)]
            fn nearest(x: $t) -> ($t, $bits) {
                let shifted = x + $round;
                (shifted - $round, shifted.to_bits())
            }

            /// Sine and cosine. Beyond some 8000 turns they lose their digits, never their bounds.
            #[inline(always)]
            pub(in crate::math) fn sin_cos(x: $t) -> ($t, $t) {
                let (turns, quadrant) = nearest(x * $two_over_pi);
                let [a, b, c]: [$t; 3] = $half_pi;
                let quarter = core::f64::consts::FRAC_PI_4 as $t;
                // NaN and infinity come out as NaN, a lost reduction stays in the interval
                let r = ((x - turns * a) - turns * b) - turns * c;
                let r = if r > quarter { quarter } else { r };
                let r = if r < -quarter { -quarter } else { r };
                let z = r * r;
                let sine = r + r * z * (horner!(z; $($sin),+));
                let cosine = 1.0 - 0.5 * z + z * z * (horner!(z; $($cos),+));
                let swap = quadrant & 1 != 0;
                let (s, c) = if swap { (cosine, sine) } else { (sine, cosine) };
                let s = if quadrant & 2 != 0 { -s } else { s };
                let c = if quadrant.wrapping_add(1) & 2 != 0 { -c } else { c };
                (s, c)
            }

            /// Exponential; 0 and infinity beyond the range.
            #[inline(always)]
            pub(in crate::math) fn exp(x: $t) -> $t {
                let held = if x > $most_exp { $most_exp } else { x };
                let held = if held < $least_exp { $least_exp } else { held };
                let (power, _) = nearest(held * $log2_e);
                let [a, b]: [$t; 2] = $ln_2;
                let r = (held - power * a) - power * b;
                let value = 1.0 + (r + r * r * (horner!(r; $($exp),+)));
                // two factors, so that neither leaves the normal numbers
                let power = power as $signed;
                let first = power >> 1;
                let factor = |p: $signed| $t::from_bits(((p + $bias) as $bits) << $digits);
                value * factor(first) * factor(power - first)
            }

            /// `2^-x` for `x >= 0`; 0 where that is next to the smallest normal number.
            #[inline(always)]
            pub(in crate::math) fn halved(x: $t) -> $t {
                if x >= $last_power {
                    return 0.0;
                }
                let (power, count) = nearest(-x);
                let rest = x + power;
                let value = 1.0 + rest * (horner!(rest; $($halved),+));
                // the power of two goes straight to the exponent: no subnormal number is left
                $t::from_bits(value.to_bits().wrapping_add(count << $digits))
            }

            /// Natural logarithm; minus infinity of 0, NaN of negatives.
            #[inline(always)]
            pub(in crate::math) fn ln(x: $t) -> $t {
                let small = x < $t::MIN_POSITIVE;
                let scaled = if small { x * $subnormal } else { x };
                let bits = scaled.to_bits();
                // mantissa in [sqrt(1/2), sqrt(2))
                let half_root = (core::f64::consts::FRAC_1_SQRT_2 as $t).to_bits();
                let shifted = bits.wrapping_sub(half_root);
                let power = (shifted as $signed) >> $digits;
                let mantissa = $t::from_bits(bits.wrapping_sub((power << $digits) as $bits));
                let s = (mantissa - 1.0) / (mantissa + 1.0);
                let z = s * s;
                let power = power as $t - if small { $subnormal_log } else { 0.0 };
                let [a, b]: [$t; 2] = $ln_2;
                let value = (s + s) + (s * z * (horner!(z; $($ln),+)) + power * b) + power * a;
                let value = if x > 0.0 { value } else { $t::NAN };
                let value = if x == 0.0 { $t::NEG_INFINITY } else { value };
                if x < $t::INFINITY { value } else { x }
            }

            /// Arc cosine; NaN outside [-1, 1].
            #[inline(always)]
            pub(in crate::math) fn acos(x: $t) -> $t {
                let (size, half_turn) = (x.abs(), core::f64::consts::PI as $t);
                let outer = size > 0.5;
                let z = if outer { 0.5 - 0.5 * size } else { size * size };
                let s = if outer { Real::sqrt(z) } else { size };
                let arc = s + s * z * (horner!(z; $($asin),+));
                // acos x = pi/2 - asin x; 2 asin sqrt((1 - |x|) / 2); pi less that for negatives
                let positive = if outer { arc + arc } else { 0.5 * half_turn - arc };
                let negative = if outer { half_turn - (arc + arc) } else { 0.5 * half_turn + arc };
                if x < 0.0 { negative } else { positive }
            }

            /// Arc sine; NaN outside [-1, 1].
            #[inline(always)]
            pub(in crate::math) fn asin(x: $t) -> $t {
                let size = x.abs();
                let outer = size > 0.5;
                let z = if outer { 0.5 - 0.5 * size } else { size * size };
                let s = if outer { Real::sqrt(z) } else { size };
                let arc = s + s * z * (horner!(z; $($asin),+));
                let value =
                    if outer { core::f64::consts::FRAC_PI_2 as $t - (arc + arc) } else { arc };
                value.copysign(x)
            }

            /// Angle of the point (`x`, `y`).
            #[inline(always)]
            pub(in crate::math) fn atan2(y: $t, x: $t) -> $t {
                let (rise, run) = (y.abs(), x.abs());
                let steep = rise > run;
                let (least, most) = if steep { (run, rise) } else { (rise, run) };
                // beyond tan(pi/8): atan t = pi/4 + atan((t - 1) / (t + 1))
                let far = least > most * (0.41421356237309503 as $t);
                let upper = if far { least - most } else { least };
                let lower = if far { least + most } else { most };
                let t = if lower > 0.0 { upper / lower } else { 0.0 };
                let z = t * t;
                let arc = t + t * z * (horner!(z; $($atan),+));
                let arc = if far { core::f64::consts::FRAC_PI_4 as $t + arc } else { arc };
                let arc = if steep { core::f64::consts::FRAC_PI_2 as $t - arc } else { arc };
                let left = x.is_sign_negative();
                let arc = if left { core::f64::consts::PI as $t - arc } else { arc };
                // NaN comes through
                (arc + 0.0 * (y + x)).copysign(y)
            }

            /// Square of `atan2(sqrt(y2), sqrt(x2))`, without roots where the point is near the axis.
            #[inline(always)]
            pub(in crate::math) fn angle_squared(y2: $t, x2: $t) -> $t {
                // tan^2(pi/8)
                if y2 <= x2 * (0.17157287525380990 as $t) {
                    let z = y2 / x2;
                    z * (1.0 + z * (horner!(z; $($squared),+)))
                } else {
                    let arc = atan2(Real::sqrt(y2), Real::sqrt(x2));
                    arc * arc
                }
            }

            /// Power of a positive number, by `exp(exponent ln x)`; 0 of 0 for a positive exponent.
            #[inline(always)]
            pub(in crate::math) fn pow(x: $t, exponent: $t) -> $t {
                let value = exp(exponent * ln(x));
                if exponent == 0.0 { 1.0 } else { value }
            }
        }
    };
}

#[cfg(feature = "f32")]
functions!(
    single, f32, u32, i32, 23, 127,
    round: 12_582_912.0, widest_exp: 89.0, least_exp: -104.0, last_power: 126.0,
    two_over_pi: core::f32::consts::FRAC_2_PI,
    half_pi: [1.570_312_5, 4.837_513e-4, 7.549_79e-8],
    log2_e: core::f32::consts::LOG2_E, ln_2: [0.693_359_4, -2.121_944_4e-4],
    subnormal: 33_554_432.0, subnormal_log: 25.0,
    sin: [-0.16666664630785383, 0.008332743815792958, -0.00019587107448614492],
    cos: [0.04166666463740154, -0.001388829979471526, 2.4547354618175733e-05],
    exp: [0.499999995501703, 0.16666576962210722, 0.04166685409521095, 0.008363200057952432,
        0.0013901309732001002],
    halved: [-0.6931469775872127, 0.24022242077583798, -0.05550733760390795, 0.009671512997040514,
        -0.0013264722046182421],
    asin: [0.1666667274707789, 0.07498810955301766, 0.045010437156026845, 0.026495372234773988,
        0.038205425221781664],
    atan: [-0.3333333177839995, 0.19999542930488437, -0.14264006040674937, 0.10744014079449671, -0.06452215792046669],
    squared: [-0.6666534911218302, 0.5103502079501109, -0.4051457646598456, 0.25315789789828757],
    ln: [0.666666852122811, 0.3998871822958476, 0.2958258692153881]
);

#[cfg(feature = "f64")]
functions!(
    double, f64, u64, i64, 52, 1023,
    round: 6_755_399_441_055_744.0, widest_exp: 710.0, least_exp: -746.0, last_power: 1022.0,
    two_over_pi: core::f64::consts::FRAC_2_PI,
    half_pi: [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_711_166_5e-21],
    log2_e: core::f64::consts::LOG2_E,
    ln_2: [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10],
    subnormal: 18_014_398_509_481_984.0, subnormal_log: 54.0,
    sin: [-0.1666666666666666, 0.008333333333329265, -0.0001984126983513169, 2.7557315461946706e-06,
        -2.505102190520725e-08, 1.5911327824252245e-10],
    cos: [0.041666666666666664, -0.0013888888888886723, 2.480158729693371e-05,
        -2.75573162216141e-07, 2.0875932257272307e-09, -1.136814657709019e-11],
    exp: [0.5, 0.16666666666666546, 0.041666666666634, 0.008333333333483108,
        0.0013888888913762085, 0.00019841269406454772, 2.4801525610011104e-05,
        2.755777488785914e-06, 2.761833379953205e-07, 2.491215543590233e-08],
    halved: [-0.69314718055994533, 0.24022650695910131, -0.055504108664820083, 0.009618129107589520,
        -0.0013333558146774631, 0.00015403530457112641, -1.5252733493118438e-5, 1.3215435282068186e-6,
        -1.0178199575306790e-7, 7.0737832854020625e-9, -4.4347708103775015e-10],
    asin: [0.16666666666661853, 0.07500000003800507, 0.04464285220353663, 0.03038219255353244,
        0.022365861949513552, 0.01744388354708465, 0.01317151245775007, 0.01574128659358492,
        -0.003081275587082417, 0.028034058967366854],
    atan: [-0.33333333333330945, 0.19999999997732762, -0.14285713930869098, 0.11111089650291991,
        -0.09090255483766514, 0.07681033286317306, -0.06550783609074944, 0.051682429350167966,
        -0.0272221086514396],
    squared: [-0.66666666666653059, 0.51111111107229853, -0.41904761520557534, 0.35746012858455788,
        -0.31302975587343064, 0.27921026200037340, -0.25164747001895154, 0.22317664598389116,
        -0.17518118427269229, 0.086754213302405579],
    ln: [0.6666666666666246, 0.40000000010258285, 0.28571424527605505, 0.2222280410038514,
        0.18144111843197966, 0.165004759126864, 0.01406859438454104]
);
