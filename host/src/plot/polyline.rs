//! Lines in pixels: cut to a frame, thinned to what can be seen, cut into dashes.

/// A position on the picture in pixels, y downwards.
pub(super) type Pixel = (f64, f64);

/// An upright rectangle in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Frame {
    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(super) fn bottom(&self) -> f64 {
        self.top + self.height
    }

    pub(super) fn contains(&self, (x, y): Pixel) -> bool {
        self.left <= x && x <= self.right() && self.top <= y && y <= self.bottom()
    }

    /// The part of a straight line inside, by Liang and Barsky (1984).
    fn clip(&self, a: Pixel, b: Pixel) -> Option<(Pixel, Pixel)> {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        let borders = [
            (-dx, a.0 - self.left),
            (dx, self.right() - a.0),
            (-dy, a.1 - self.top),
            (dy, self.bottom() - a.1),
        ];
        for (outwards, room) in borders {
            if outwards < 0.0 {
                enter = enter.max(room / outwards);
            } else if outwards > 0.0 {
                leave = leave.min(room / outwards);
            } else if room < 0.0 {
                return None;
            }
        }
        let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
        // the ends themselves where nothing is cut, so that neighbours join exactly
        let from = if enter > 0.0 { at(enter) } else { a };
        let to = if leave < 1.0 { at(leave) } else { b };
        (enter <= leave).then_some((from, to))
    }
}

/// The visible runs of a line with gaps (`None`): cut at the frame, thinned to about a tenth of a pixel.
///
/// A run of one point is a point with no neighbour, which the caller may want to draw as a dot.
pub(super) fn visible_runs(
    points: impl Iterator<Item = Option<Pixel>>,
    frame: Frame,
) -> Vec<Vec<Pixel>> {
    let mut runs = Vec::new();
    let mut run: Vec<Pixel> = Vec::new();
    let mut last: Option<Pixel> = None;
    for point in points {
        match (last, point) {
            (_, None) => end(&mut run, &mut runs),
            (None, Some(p)) => {
                if frame.contains(p) {
                    run.push(p);
                }
            }
            (Some(a), Some(b)) => match frame.clip(a, b) {
                None => end(&mut run, &mut runs),
                Some((from, to)) => {
                    if run.last() != Some(&from) {
                        end(&mut run, &mut runs);
                        run.push(from);
                    }
                    run.push(to);
                }
            },
        }
        last = point;
    }
    end(&mut run, &mut runs);
    runs
}

/// Cuts a line into the pieces that dashes of these lengths leave. No dashes: the line itself.
pub(super) fn dashed(line: &[Pixel], dashes: &[f64]) -> Vec<Vec<Pixel>> {
    if dashes.iter().sum::<f64>() <= 0.0 || line.is_empty() {
        return vec![line.to_vec()];
    }
    let mut pieces = Vec::new();
    let mut piece = vec![line[0]];
    let (mut which, mut left) = (0, dashes[0]);
    for pair in line.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let length = (b.0 - a.0).hypot(b.1 - a.1);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let t = done / length;
            let cut = (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
            if which % 2 == 0 {
                piece.push(cut);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece = vec![cut];
            }
            which = (which + 1) % dashes.len();
            left = dashes[which];
        }
        left -= length - done;
        if which % 2 == 0 {
            piece.push(b);
        }
    }
    if piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

/// Points kept of one run before the exact thinning, far more than there are columns of pixels.
const MOST_POINTS: usize = 2000;

/// Largest distance of a point left out from the line drawn, in pixels.
const TOLERANCE: f64 = 0.1;

fn end(run: &mut Vec<Pixel>, runs: &mut Vec<Vec<Pixel>>) {
    if !run.is_empty() {
        runs.push(thinned(&envelope(std::mem::take(run))));
    }
}

/// First, lowest, highest and last point of each of `MOST_POINTS / 4` stretches: peaks survive.
fn envelope(run: Vec<Pixel>) -> Vec<Pixel> {
    if run.len() <= MOST_POINTS {
        return run;
    }
    let mut kept = Vec::with_capacity(MOST_POINTS);
    for stretch in run.chunks(run.len().div_ceil(MOST_POINTS / 4)) {
        let by_height = |i: &usize, j: &usize| stretch[*i].1.total_cmp(&stretch[*j].1);
        let low = (0..stretch.len()).min_by(by_height).unwrap_or(0);
        let high = (0..stretch.len()).max_by(by_height).unwrap_or(0);
        let mut picks = [0, low.min(high), low.max(high), stretch.len() - 1].to_vec();
        picks.dedup();
        kept.extend(picks.into_iter().map(|i| stretch[i]));
    }
    kept
}

/// Ramer (1972), Douglas and Peucker (1973): leaves out points that lie on the line without them.
fn thinned(run: &[Pixel]) -> Vec<Pixel> {
    let mut keep = vec![false; run.len()];
    let mut spans = vec![(0, run.len() - 1)];
    while let Some((first, last)) = spans.pop() {
        keep[first] = true;
        keep[last] = true;
        let farthest = (first + 1..last)
            .map(|i| (distance(run[i], run[first], run[last]), i))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((d, i)) = farthest
            && d > TOLERANCE
        {
            spans.extend([(first, i), (i, last)]);
        }
    }
    run.iter().zip(keep).filter_map(|(&p, keep)| keep.then_some(p)).collect()
}

/// Distance of `p` from the straight line between `a` and `b`, ends included.
fn distance(p: Pixel, a: Pixel, b: Pixel) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let squared = dx * dx + dy * dy;
    let t = if squared > 0.0 { ((p.0 - a.0) * dx + (p.1 - a.1) * dy) / squared } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    (p.0 - a.0 - t * dx).hypot(p.1 - a.1 - t * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Frame = Frame { left: 0.0, top: 0.0, width: 100.0, height: 100.0 };

    #[test]
    fn a_gap_and_the_frame_break_the_line() {
        let gap = [Some((0.0, 50.0)), Some((10.0, 60.0)), None, Some((20.0, 50.0)), None];
        assert_eq!(
            visible_runs(gap.into_iter(), UNIT),
            [vec![(0.0, 50.0), (10.0, 60.0)], vec![(20.0, 50.0)]]
        );
        let below = [Some((0.0, 50.0)), Some((10.0, 150.0)), Some((20.0, 50.0))];
        assert_eq!(
            visible_runs(below.into_iter(), UNIT),
            [vec![(0.0, 50.0), (5.0, 100.0)], vec![(15.0, 100.0), (20.0, 50.0)]]
        );
    }

    #[test]
    fn thinning_keeps_the_peak_and_drops_the_rest_of_a_long_curve() {
        let peak = 31_234;
        let curve = (0..50_000).map(|i| {
            Some((f64::from(i) * 0.002, if i == peak { 3.0 } else { 90.0 - f64::from(i) * 1e-4 }))
        });
        let runs = visible_runs(curve, UNIT);
        assert_eq!(runs.len(), 1);
        assert!(runs[0].len() < 20, "{} points", runs[0].len());
        assert!(runs[0].iter().any(|p| p.1 < 3.5));
    }

    #[test]
    fn dashes_run_on_over_the_corners() {
        let line = [(0.0, 0.0), (3.0, 0.0), (3.0, 4.0), (10.0, 4.0)];
        let pieces = dashed(&line, &[5.0, 4.0]);
        assert_eq!(pieces.len(), 2);
        assert_eq!(pieces[0], [(0.0, 0.0), (3.0, 0.0), (3.0, 2.0)]);
        assert_eq!(pieces[1], [(5.0, 4.0), (10.0, 4.0)]);
        assert_eq!(dashed(&line, &[]), [line.to_vec()]);
    }
}
