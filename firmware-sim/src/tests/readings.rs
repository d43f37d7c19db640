//! Readings and calibrations.

use super::bench::{Bench, quick};
use crate::{Boundary, Config};
use asperity_core::protocol::{
    Axis, Calibration, CalibrationKind, DeviceError, Microdegrees, Range, Request, Response,
};

fn calibration(bench: &mut Bench) -> Calibration {
    match bench.ask(Request::LastCalibration) {
        Ok(Response::Calibration(calibration)) => calibration,
        other => panic!("{other:?}"),
    }
}

#[test]
fn calibration_is_two_runs_in_order_and_takes_its_time() {
    let mut bench = Bench::homed(quick());
    assert_eq!(bench.refused(Request::LastCalibration), DeviceError::Nothing);
    let needs = DeviceError::NeedsCalibration(CalibrationKind::Dark);
    assert_eq!(bench.refused(Request::Calibrate(CalibrationKind::Reference)), needs);
    bench.accept(Request::Calibrate(CalibrationKind::Dark));
    bench.finish();
    assert_eq!(bench.refused(Request::LastCalibration), DeviceError::Nothing);
    bench.travel(Axis::Theta, 20_000_000);
    let start = bench.now;
    bench.accept(Request::Calibrate(CalibrationKind::Reference));
    bench.finish();
    assert_eq!(bench.now.since(start), 2_015_000, "withdrawn, read, the range changed");
    assert_eq!(bench.status().theta.0, 20_000_000);
    let got = calibration(&mut bench);
    for (range, dark) in got.dark.into_iter().enumerate() {
        let step = 1000.0 / 10_f32.powi(range as i32) / 32767.0;
        let expected = 0.004 * (1.0 + 0.05 * range as f32);
        assert!((dark - expected).abs() < step + 1.2e-3, "{range} {dark}");
    }
    assert!((got.reference - 800.0).abs() < 0.5 && got.range == 0);
    assert_eq!(bench.status().calibration, Some(got.id));
    // where the arm stands does not matter, and what is repeated repeats its identity
    bench.calibrate();
    assert_eq!(calibration(&mut bench), got);
    bench.accept(Request::Aperture(Microdegrees(500_000)));
    bench.calibrate();
    assert_ne!(calibration(&mut bench).id, got.id);
    bench.accept(Request::Aperture(Microdegrees(600_000)));
    bench.calibrate();
    assert_eq!(calibration(&mut bench).id, got.id);
}

#[test]
fn a_reading_carries_the_dark_current_of_its_range() {
    let mut bench = Bench::homed(quick());
    bench.travel(Axis::Theta, 60_000_000);
    let before = bench.read();
    assert_eq!(before.dark.to_bits(), 0);
    bench.calibrate();
    let (after, calibration) = (bench.read(), calibration(&mut bench));
    assert_eq!(after.signal.to_bits(), before.signal.to_bits());
    assert_eq!(after.dark.to_bits(), calibration.dark[usize::from(after.range)].to_bits());
}

#[test]
fn a_smooth_plate_transmits_what_the_textbook_says() {
    let mut bench = Bench::homed(Config { boundary: Boundary::Smooth, rays: 20_000, ..quick() });
    bench.calibrate();
    let reading = bench.read();
    let calibration = calibration(&mut bench);
    let relative = (reading.signal - reading.dark) / (calibration.reference - calibration.dark[0]);
    // (1 - F) / (1 + F) with F = (0.49 / 2.49)^2
    assert!((relative - 0.9255).abs() < 5e-3, "{relative}");
    bench.travel(Axis::Theta, 1_000_000);
    let reading = bench.read();
    assert!(reading.range == 5 && (reading.signal - reading.dark).abs() < 2e-3, "{reading:?}");
}

#[test]
fn ranges_are_kept_and_their_errors_said() {
    let mut bench = Bench::homed(Config { boundary: Boundary::Smooth, ..quick() });
    let mut read = |range| {
        bench.accept(Request::Range(range));
        let reading = bench.read();
        (reading.range, reading.over, reading.under)
    };
    assert_eq!(read(Range::Auto), (0, false, false));
    assert_eq!(read(Range::Fixed(1)), (1, true, false));
    assert_eq!(read(Range::Fixed(0)), (0, false, false));
    bench.travel(Axis::Theta, 1_000_000);
    let mut read = |range| {
        bench.accept(Request::Range(range));
        let reading = bench.read();
        (reading.range, reading.over, reading.under)
    };
    assert_eq!(read(Range::Fixed(2)), (2, false, true));
    assert_eq!(read(Range::Auto), (5, false, false));
}

#[test]
fn there_is_no_reading_before_one_and_none_while_one_is_made() {
    let mut bench = Bench::homed(quick());
    assert_eq!(bench.refused(Request::LastReading), DeviceError::Nothing);
    bench.read();
    bench.accept(Request::Read);
    assert_eq!(bench.refused(Request::LastReading), DeviceError::Nothing);
    bench.accept(Request::Stop);
    assert_eq!(bench.refused(Request::LastReading), DeviceError::Nothing);
}
