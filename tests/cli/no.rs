//! Exit status 1: the work was done, what was found is written, and the answer is no.

use std::fmt::Write as _;

use crate::program::Folder;

#[test]
fn a_fit_that_did_not_converge_is_written_and_refused() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o m.json").ok();
    folder.run("scan m.json --sigma 0,30 --step 1 -o scan.csv").ok();
    let done = folder.run("fit scan.csv --method ggx --max-evaluations 5 -o fit.json").with_code(1);
    assert!(done.err.starts_with("no: not converged after"), "{}", done.err);
    assert!(done.err.contains("--max-evaluations"), "{}", done.err);
    assert!(done.out.contains("alpha"), "{}", done.out);
    let fit = folder.json("fit.json");
    assert_eq!(fit["termination"], "max_evaluations");
    assert!(fit["validity"][0].as_str().unwrap().contains("not converged"), "{fit}");
    // what was found is a model all the same
    folder.run("check fit.json --incidence 0").ok();
    assert_eq!(folder.names(), ["fit.json", "m.json", "scan.csv"]);
}

/// Readings of an opaque surface with a narrow and a very wide lobe; the narrow one grows with the
/// angle of incidence, as that of a lapped metal does.
fn two_lobes() -> String {
    let mut text =
        String::from("# geometry: reflection\n# quantity: bsdf\nsigma_deg,theta_deg,reading\n");
    for (sigma, narrow) in [(0_i32, 0.5), (30, 2.0), (60, 20.0)] {
        for theta in -85..=85 {
            let lobe = |width: f64| (-0.5 * (f64::from(theta - sigma) / width).powi(2)).exp();
            let reading = narrow * lobe(2.0) + 0.5 * lobe(20.0);
            writeln!(text, "{sigma},{theta},{reading:e}").unwrap();
        }
    }
    text
}

#[test]
fn a_surface_with_two_lobes_is_not_claimed_to_have_one() {
    let folder = Folder::new();
    folder.write("two.csv", two_lobes());
    let line = "fit two.csv --method ggx --opaque -o fit.json";
    let done = folder.run(line).with_code(1);
    assert!(done.err.contains("no: the model does not describe this surface"), "{}", done.err);
    assert!(done.err.contains("at sigma 0 deg") && done.err.contains("lobe"), "{}", done.err);
    let fit = folder.json("fit.json");
    assert_eq!(fit["termination"], "converged");
    // eq. (18) over all incidences alone would have passed for a good fit
    assert!(fit["rmsd_percent"].as_f64().unwrap() < 5.0, "{fit}");
    assert!(fit["incidences"][0]["rmsd_percent"].as_f64().unwrap() > 15.0, "{fit}");
    assert!(fit["validity"][0].as_str().unwrap().contains("does not describe"), "{fit}");
    // who knows better may say so
    folder.run(&format!("{line} --max-misfit 60")).ok();
}

#[test]
fn a_body_that_gives_more_than_it_receives_fails_the_check() {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 gain=3 lambert=0.01 --opaque -o m.json").ok();
    let done = folder.run("check m.json --json").with_code(1);
    assert!(done.err.starts_with("no: the model gives more flux"), "{}", done.err);
    let answer: serde_json::Value = serde_json::from_str(&done.out).unwrap();
    assert_eq!(answer["conserves_energy"], false);
    assert!(answer["energy"][0]["lost"].as_f64().unwrap() < -1.0, "{answer}");
}
