//! Colours and dashes. Curves differ in both, so that prints without colour stay readable.

/// Red, green and blue, 0 to 255.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rgb(pub(super) u8, pub(super) u8, pub(super) u8);

/// Text, ticks and frames.
pub(super) const INK: Rgb = Rgb(0x26, 0x26, 0x26);
/// Grid lines.
pub(super) const GRID: Rgb = Rgb(0xe6, 0xe6, 0xe6);
/// Circles on a map in colours, seen on its darkest and on [`BELOW_SCALE`].
pub(super) const RING: Rgb = Rgb(0x96, 0x96, 0x96);
/// The broad line of a densely measured curve: light enough for any fit to show on it.
pub(super) const MEASURED_LINE: Rgb = Rgb(0xb4, 0xb4, 0xb4);
/// The rim of a sparsely measured point.
pub(super) const MEASURED_RIM: Rgb = Rgb(0x4d, 0x4d, 0x4d);

/// A third of a colour on paper.
pub(super) fn light(Rgb(r, g, b): Rgb) -> Rgb {
    let third = |c: u8| ((u16::from(c) + 2 * 255) / 3) as u8;
    Rgb(third(r), third(g), third(b))
}

/// Values of a map in colours that are below its scale.
pub(super) const BELOW_SCALE: Rgb = Rgb(0xec, 0xe6, 0xf2);

/// What is not part of a picture.
pub(super) const PAPER: Rgb = Rgb(0xff, 0xff, 0xff);
/// Points of a map without a value.
pub(super) const MISSING: Rgb = Rgb(0xb0, 0xb0, 0xb0);

/// The colour map viridis, perceptually uniform and legible in grey and under colour deficiencies, at 0 to 1.
pub(super) fn viridis(t: f64) -> Rgb {
    let last = VIRIDIS.len() - 1;
    let place = t.clamp(0.0, 1.0) * last as f64;
    let low = (place as usize).min(last - 1);
    let (a, b, share) = (VIRIDIS[low], VIRIDIS[low + 1], place - low as f64);
    let between =
        |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    Rgb(between(a.0, b.0), between(a.1, b.1), between(a.2, b.2))
}

/// Every sixteenth part of it \[van der Walt and Smith 2015, CC0\].
const VIRIDIS: [Rgb; 17] = [
    Rgb(0x44, 0x01, 0x54),
    Rgb(0x48, 0x18, 0x6a),
    Rgb(0x47, 0x2d, 0x7b),
    Rgb(0x42, 0x40, 0x86),
    Rgb(0x3b, 0x52, 0x8b),
    Rgb(0x33, 0x63, 0x8d),
    Rgb(0x2c, 0x72, 0x8e),
    Rgb(0x26, 0x82, 0x8e),
    Rgb(0x21, 0x91, 0x8c),
    Rgb(0x1f, 0xa0, 0x88),
    Rgb(0x28, 0xae, 0x80),
    Rgb(0x3f, 0xbc, 0x73),
    Rgb(0x5e, 0xc9, 0x62),
    Rgb(0x84, 0xd4, 0x4b),
    Rgb(0xad, 0xdc, 0x30),
    Rgb(0xd8, 0xe2, 0x19),
    Rgb(0xfd, 0xe7, 0x25),
];

/// Colours of differences, at 0 to 1: blue where too low, white at one half, red where too high.
pub(super) fn difference(t: f64) -> Rgb {
    let (from, to) = (Rgb(0x21, 0x66, 0xac), Rgb(0xb2, 0x18, 0x2b));
    let off = (2.0 * t.clamp(0.0, 1.0) - 1.0).abs();
    let Rgb(r, g, b) = if t < 0.5 { from } else { to };
    let towards = |c: u8| (255.0 + off * (f64::from(c) - 255.0)).round() as u8;
    Rgb(towards(r), towards(g), towards(b))
}

/// The style of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    pub(super) color: Rgb,
    /// In pixels.
    pub(super) width: f64,
    /// Lengths drawn and skipped in turn, in pixels; empty for a solid line.
    pub(super) dashes: &'static [f64],
}

/// The broad line under the fits.
pub(super) const MEASURED: Stroke = Stroke { color: MEASURED_LINE, width: 6.0, dashes: &[] };

/// Colours of Okabe and Ito (2008), distinct under all common colour deficiencies; the last two in place of their black and yellow,
/// one near that of the axes, the other dark enough for a line. The page of a comparison has the same in this order (`report.css`).
const COLORS: [Rgb; 8] = [
    Rgb(0x00, 0x72, 0xb2), // blue
    Rgb(0xd5, 0x5e, 0x00), // vermilion
    Rgb(0x00, 0x9e, 0x73), // bluish green
    Rgb(0xcc, 0x79, 0xa7), // reddish purple
    Rgb(0xe6, 0x9f, 0x00), // orange
    Rgb(0x56, 0xb4, 0xe9), // sky blue
    Rgb(0x3a, 0x40, 0x48), // slate
    Rgb(0x8f, 0x86, 0x00), // olive
];

const DASHES: [&[f64]; 8] = [
    &[],
    &[12.0, 5.0],
    &[2.5, 4.0],
    &[12.0, 4.0, 2.5, 4.0],
    &[6.0, 3.0],
    &[20.0, 5.0],
    &[12.0, 4.0, 2.5, 4.0, 2.5, 4.0],
    &[2.5, 7.0],
];

/// The line number `index`: 64 different ones, then they repeat.
pub(super) fn fitted(index: usize) -> Stroke {
    let round = index / COLORS.len();
    Stroke {
        color: COLORS[index % COLORS.len()],
        width: 2.4,
        dashes: DASHES[(index + round) % DASHES.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eight_lines_differ_in_colour_and_in_dashes() {
        for i in 0..8 {
            for j in 0..i {
                assert_ne!(fitted(i).color, fitted(j).color);
                assert_ne!(fitted(i).dashes, fitted(j).dashes);
            }
        }
    }

    #[test]
    fn a_colour_that_returns_has_other_dashes() {
        assert_eq!(fitted(0).color, fitted(8).color);
        assert_ne!(fitted(0).dashes, fitted(8).dashes);
    }
}
