//! Trees of cells: flux and peak.

use super::*;

/// Outgoing directions that count for a peak: cells at the horizon are too wide in angle.
const HIGHEST: f64 = 1.2;

/// A tree beside its law: flux of incidences against sums over a fine square, the largest value against the law.
fn check_tree(name: &str, alpha: f64, which: usize, allowed: &Allowed) {
    let format = Format::of_name(name).unwrap();
    let (law, subject) = lobes(alpha).remove(which);
    let title = format!("{name} {alpha} {:?} {:?}", subject.side, subject.lobe);
    let write = format.write.unwrap();
    let sampled = (write.sample)(&law, &subject, &Options::default()).unwrap();
    let bytes = (write.encode)(std::slice::from_ref(&sampled)).unwrap();
    let (found, read) = read_bytes("file", &bytes).unwrap();
    assert_eq!(found.name, name);
    let [one] = &read[..] else { panic!("{title}: {} lobes", read.len()) };
    assert_eq!((one.side, one.lobe, one.index), (subject.side, subject.lobe, subject.index));
    assert_eq!((one.symmetry, &one.bands[0]), (subject.symmetry, &subject.band));
    assert_eq!(one.incidences.len(), sampled.incidences.len());
    let n = one.incidences.len();
    for k in (0..n).step_by(n / 7 + 1) {
        let incidence = &one.incidences[k];
        let from = [incidence.theta, incidence.phi];
        let (mut flux, mut peak) = (0.0, 0.0_f64);
        // rings about the ray, closer where the lobe is
        let ray = one.specular(incidence.theta);
        let frame = ray
            .map_or(crate::frame::Frame::Absolute, |theta| crate::frame::Frame::Specular { theta });
        let radii: Vec<f64> =
            (0..400).map(|i| 3.2 * ((f64::from(i) + 0.5) / 400.0).powi(3)).collect();
        for (i, r) in radii.iter().enumerate() {
            let edge = |i: f64| 3.2 * (i / 400.0).powi(3);
            let width = edge(i as f64 + 1.0) - edge(i as f64);
            for j in 0..240 {
                let at = frame.absolute([*r, std::f64::consts::PI * (f64::from(j) + 0.5) / 120.0]);
                if at[0] < std::f64::consts::FRAC_PI_2 {
                    let v = law.value(from, at);
                    if at[0] < HIGHEST {
                        peak = peak.max(v);
                    }
                    flux += v * at[0].cos() * r.sin() * width * std::f64::consts::PI / 120.0;
                }
            }
        }
        let is = one.flux(k, 0);
        let centres = incidence.nodes.directions();
        let below = centres.iter().zip(&incidence.values).filter(|(at, _)| at[0] < HIGHEST);
        let top = below.map(|(_, v)| *v).fold(0.0, f64::max);
        let (flux_error, peak_error) = (100.0 * (is / flux - 1.0), 100.0 * (top / peak - 1.0));
        println!(
            "{title}: {:.1} deg {} cells, flux {flux:.5} {flux_error:.4} %, peak {peak_error:.3} %",
            incidence.theta.to_degrees(),
            centres.len()
        );
        if flux > 1e-6 && incidence.theta < 1.4 {
            assert!(flux_error.abs() < allowed.flux, "{title} {flux_error}");
            // beyond 50 degrees the balance of the flux takes more from the few cells of the peak
            let most = if incidence.theta < 0.87 { allowed.peak } else { 6.0 * allowed.peak };
            assert!(peak_error.abs() < most, "{title} {peak_error}");
        }
    }
}

#[test]
fn tensortree3() {
    check_tree("tensortree3", 0.2, 1, &Allowed { node: 0.0, flux: 0.1, peak: 0.5, is_slow: false });
    // a peak at the horizon is none that cells of direction cosines can hold
    check_tree(
        "tensortree3",
        0.6,
        0,
        &Allowed { node: 0.0, flux: 0.1, peak: f64::INFINITY, is_slow: false },
    );
}

#[test]
fn tensortree3_narrow() {
    if std::env::var_os("ASPERITY_EXTENSIVE").is_none() {
        return;
    }
    for which in 0..4 {
        check_tree(
            "tensortree3",
            0.02,
            which,
            &Allowed { node: 0.0, flux: 0.2, peak: 1.0, is_slow: false },
        );
    }
}

#[test]
fn tensortree4() {
    check_tree(
        "tensortree4",
        0.6,
        0,
        &Allowed { node: 0.0, flux: 0.5, peak: f64::INFINITY, is_slow: false },
    );
}
