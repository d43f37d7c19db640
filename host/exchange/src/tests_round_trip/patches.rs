//! Matrices of patches: their means, and lobes too narrow for them.

use super::*;

/// The same of patches: means against those of midpoints, flux against the sum of the same; a lobe that is too narrow is refused.
fn check_klems(name: &str, edges: &[f64], counts: &[usize]) {
    let format = Format::of_name(name).unwrap();
    let write = format.write.unwrap();
    let options = Options::default();
    for (law, subject) in lobes(0.02) {
        let refused = (write.sample)(&law, &subject, &options);
        let is_direct = subject.side == Side::Air || subject.lobe == Lobe::Transmission;
        assert!(!is_direct || refused.unwrap_err().to_string().contains("tensortree3"));
    }
    let (law, subject) = lobes(0.6).remove(0);
    let sampled = (write.sample)(&law, &subject, &options).unwrap();
    let bytes = (write.encode)(std::slice::from_ref(&sampled)).unwrap();
    let (found, read) = read_bytes("file", &bytes).unwrap();
    assert_eq!(found.name, name);
    let [one] = &read[..] else { panic!("{} lobes", read.len()) };
    assert_eq!((one.side, one.lobe, one.index), (subject.side, subject.lobe, subject.index));
    assert_eq!(one.bands[0], subject.band);
    assert_eq!(one.incidences.len(), counts.iter().sum::<usize>());
    for ring in (0..counts.len()).step_by(3) {
        let upper = edges[ring + 1].to_radians();
        let lower = edges[ring].to_radians();
        // the incident patch about azimuth 0, whose source is at pi
        let of = |i: &crate::sampled::Incidence| {
            (lower..=upper).contains(&i.theta) && (i.phi - std::f64::consts::PI).abs() < 1e-9
        };
        let k = one.incidences.iter().position(of).unwrap();
        let incidence = &one.incidences[k];
        let most = one.peak(k, 0);
        let mut place = 0;
        let mut flux = 0.0;
        for (out, count) in counts.iter().enumerate() {
            for azimuth in 0..*count {
                let ought = midpoints(
                    &law,
                    incidence.phi,
                    [[ring, counts[ring], 0], [out, *count, azimuth]],
                    edges,
                );
                let is = incidence.values[place];
                assert!(
                    (is - ought).abs() < 1e-3 * ought + 1e-4 * most,
                    "{name} {ring} {out} {azimuth}: {is} {ought}"
                );
                let x = |k: usize| edges[k].to_radians().sin().powi(2);
                flux += ought * std::f64::consts::PI * (x(out + 1) - x(out)) / *count as f64;
                place += 1;
            }
        }
        let is = one.flux(k, 0);
        assert!((is / flux - 1.0).abs() < 1e-3, "{name} ring {ring}: flux {is} {flux}");
    }
}

/// Mean over a pair of patches `[ring, patches of the ring, place]` by midpoints of polar angles and azimuths.
fn midpoints(law: &Facets, phi: f64, pair: [[usize; 3]; 2], edges: &[f64]) -> f64 {
    use std::f64::consts::TAU;
    let points = |[ring, count, place]: [usize; 3]| {
        let n = if count < 8 { 40 } else { 16 };
        let m = if edges[ring + 1] > 89.0 { 40 } else { 8 };
        let [lower, upper] = [edges[ring].to_radians(), edges[ring + 1].to_radians()];
        let mut all = Vec::new();
        for i in 0..m {
            let theta = lower + (upper - lower) * (f64::from(i) + 0.5) / f64::from(m);
            for j in 0..n {
                let part = (f64::from(j) + 0.5) / f64::from(n) - 0.5;
                let phi = TAU * (place as f64 + part) / count as f64;
                all.push([theta, phi, (2.0 * theta).sin()]);
            }
        }
        all
    };
    let (into, out) = (points(pair[0]), points(pair[1]));
    let (mut sum, mut weights) = (0.0, 0.0);
    for a in &into {
        for b in &out {
            sum += a[2] * b[2] * law.value([a[0], phi], [b[0], b[1] - a[1]]);
            weights += a[2] * b[2];
        }
    }
    sum / weights
}

#[test]
fn klems() {
    let edges = [0.0, 5.0, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0, 90.0];
    check_klems("klems", &edges, &[1, 8, 16, 20, 24, 24, 24, 16, 12]);
}

#[test]
fn klems_half() {
    let edges = [0.0, 6.5, 19.5, 32.5, 46.5, 61.5, 76.5, 90.0];
    check_klems("klems-half", &edges, &[1, 8, 12, 16, 20, 12, 4]);
}

#[test]
fn klems_quarter() {
    check_klems("klems-quarter", &[0.0, 9.0, 27.0, 46.0, 66.0, 90.0], &[1, 8, 12, 12, 8]);
}
