//! What `trade` counts: the user's own model on the device, with the bits of this machine.

use asperity::boundary::Boundary;
use asperity::forward::Rays;
use asperity::model::Model;
use asperity::trade::{Device, Evaluator, NoDevice, Row, Subject, Work, rows};
use asperity::watch::Watch;

use asperity_needs::absent;

use crate::emulator::Firmware;
fn counted(boundary: &Boundary, table_kib: &[usize], device: &Device) -> Vec<Row> {
    let subject =
        Subject { method: "model", boundary, misfit_percent: None, fit_seconds: None, scan: None };
    let work = Work {
        table_kib,
        rays: Rays { count: 1000, seed: 1 },
        device: Some(device),
        watch: Watch::nobody(),
    };
    let (rows, notes) = rows(&subject, &work);
    // a note would say that the device computes other bits
    assert!(notes.is_empty(), "{notes:?}");
    rows
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn the_users_models_are_counted_on_a_cortex_m4f_with_the_same_bits() {
    let device = match Firmware::Trade.path().map(|elf| Device::open(&elf)) {
        Ok(Ok(device)) => device,
        Ok(Err(why @ NoDevice::Emulator)) => return absent(&why.to_string()),
        Ok(Err(why)) => panic!("{why}"),
        Err(remedy) => return absent(&remedy),
    };
    for text in [
        r#"{"asperity": 1, "method": "ggx", "ior": 1.49, "parameters": {"alpha": {"value": 0.23}}}"#,
        r#"{"asperity": 1, "method": "normals", "law": "cauchy", "ior": 1.42,
            "parameters": {"delta": {"value": 6.0}, "n": {"value": 2.5}, "theta0": {"value": 1.0}}}"#,
    ] {
        let (_, boundary) = Model::parse(text.as_bytes()).unwrap();
        let rows = counted(&boundary, &[8, 16], &device);
        assert_eq!(rows.len(), 6);
        for row in &rows {
            let (eval, sample) = (row.eval_instructions.unwrap(), row.sample_instructions.unwrap());
            println!("{}: {eval} a value, {sample} a sample", row.evaluator_text());
            // one that does nothing is no evaluator; in double precision every operation is a call
            let most = if row.precision == "f32" { 10_000 } else { 200_000 };
            assert!((50..most).contains(&eval) && (100..most).contains(&sample), "{row:?}");
            let (code, ram) = (row.code_bytes.unwrap(), row.ram_bytes.unwrap());
            assert!((500..60_000).contains(&code) && (8..4096).contains(&ram), "{row:?}");
            let is_table = matches!(row.evaluator, Evaluator::Table { .. });
            assert_eq!(row.data_bytes.is_some(), is_table);
        }
        // doubles are computed in software
        assert!(rows[0].eval_instructions > rows[3].eval_instructions.map(|n| 10 * n));
    }
}
