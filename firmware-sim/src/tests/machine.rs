//! Motion, settings, faults.

use super::bench::{Bench, quick, segment};
use crate::{Config, MachineFault, Simulator};
use asperity_core::protocol::{
    Axis, CalibrationKind, DeviceError, Event, Fault, MachineState, Microdegrees, Range, Request,
    Response,
};

#[test]
fn it_fits_the_memory_of_a_small_device() {
    let size = size_of::<Simulator>();
    assert!(size <= 11 * 1024, "{size}");
}

#[test]
fn nothing_moves_before_homing_and_homing_takes_its_time() {
    let mut bench = Bench::new(quick());
    for request in [
        Request::Move(Axis::Theta, Microdegrees(0)),
        Request::Read,
        Request::Calibrate(CalibrationKind::Dark),
        Request::Scan(segment(0, 1, 1)),
    ] {
        assert_eq!(bench.refused(request), DeviceError::NotHomed);
    }
    let start = bench.now;
    bench.accept(Request::Home);
    assert_eq!(bench.events, [Event::State(MachineState::Homing)]);
    assert_eq!(bench.refused(Request::Home), DeviceError::Busy(MachineState::Homing));
    assert_eq!(bench.refused(Request::Lamp(true)), DeviceError::Busy(MachineState::Homing));
    bench.finish();
    // 96 degrees down and up again at 20 degrees a second, and 2 ms
    assert_eq!(bench.now.since(start), 9_602_000);
    let status = bench.status();
    assert!(status.homed && status.sigma.0 == 0 && status.theta.0 == 0);
}

#[test]
fn a_stop_while_homing_loses_the_zeros_and_one_while_moving_does_not() {
    let mut bench = Bench::homed(quick());
    bench.accept(Request::Move(Axis::Sigma, Microdegrees(50_000_000)));
    bench.wait(2_000_000);
    bench.accept(Request::Stop);
    assert_eq!(bench.events, [Event::State(MachineState::Idle)]);
    let status = bench.status();
    assert_eq!((status.homed, status.sigma.0), (true, 20_000_000));
    bench.accept(Request::Home);
    bench.wait(1_000_000);
    bench.accept(Request::Stop);
    assert!(!bench.status().homed);
    assert_eq!(bench.refused(Request::Read), DeviceError::NotHomed);
}

#[test]
fn beyond_the_limits_nothing_moves() {
    let mut bench = Bench::homed(quick());
    for (axis, to) in [
        (Axis::Sigma, -1),
        (Axis::Sigma, 85_000_001),
        (Axis::Theta, -95_000_001),
        (Axis::Theta, 95_000_001),
        (Axis::Theta, i32::MIN),
    ] {
        assert_eq!(
            bench.refused(Request::Move(axis, Microdegrees(to))),
            DeviceError::SoftLimit(axis)
        );
        assert_eq!(bench.simulator.state(), MachineState::Idle);
    }
    for (axis, to) in
        [(Axis::Sigma, 85_000_000), (Axis::Theta, -95_000_000), (Axis::Theta, 95_000_000)]
    {
        bench.travel(axis, to);
    }
    let status = bench.status();
    assert_eq!((status.sigma.0, status.theta.0), (85_000_000, 95_000_000));
}

#[test]
fn a_motion_takes_its_time() {
    let mut bench = Bench::homed(quick());
    let start = bench.now;
    bench.travel(Axis::Theta, 30_000_000);
    assert_eq!(bench.now.since(start), 1_502_000);
    bench.travel(Axis::Sigma, 30_000_000);
    assert_eq!(bench.now.since(start), 1_502_000 + 3_002_000);
}

#[test]
fn settings_have_domains_and_drop_what_they_spoil() {
    let mut bench = Bench::homed(quick());
    for request in [
        Request::Aperture(Microdegrees(0)),
        Request::Aperture(Microdegrees(10_000_001)),
        Request::Range(Range::Fixed(6)),
        Request::Integration(99),
        Request::Integration(10_000_001),
    ] {
        assert_eq!(bench.refused(request), DeviceError::BadValue, "{request:?}");
    }
    let drops = |request: Request, calibration: bool, reading: bool, needs: bool| {
        let mut bench = Bench::homed(Config { rays: 100, ..quick() });
        bench.calibrate();
        bench.read();
        bench.accept(request);
        bench.finish();
        let status = bench.status();
        assert_eq!(status.calibration.is_none(), calibration, "{request:?}");
        assert_eq!(bench.ask(Request::LastReading).is_err(), reading, "{request:?}");
        bench.accept(Request::Lamp(true));
        let again = bench.ask(Request::Calibrate(CalibrationKind::Reference));
        assert_eq!(again.is_err(), needs, "{request:?}");
    };
    drops(Request::Aperture(Microdegrees(1_000_000)), true, true, false);
    drops(Request::Aperture(Microdegrees(600_000)), false, false, false);
    drops(Request::Range(Range::Fixed(2)), false, true, false);
    drops(Request::Integration(20_000), true, true, true);
    drops(Request::Lamp(false), true, true, false);
    drops(Request::Move(Axis::Theta, Microdegrees(5)), false, false, false);
}

#[test]
fn in_the_dark_there_is_nothing_to_read() {
    let mut bench = Bench::homed(quick());
    bench.accept(Request::Lamp(false));
    assert_eq!(bench.refused(Request::Read), DeviceError::LampOff);
    assert_eq!(bench.refused(Request::Scan(segment(0, 1, 1))), DeviceError::LampOff);
    bench.accept(Request::Calibrate(CalibrationKind::Dark));
    bench.finish();
    let reference = Request::Calibrate(CalibrationKind::Reference);
    assert_eq!(bench.refused(reference), DeviceError::LampOff);
    bench.accept(Request::Lamp(true));
    bench.accept(reference);
}

/// What a fault is told as, once.
fn told(bench: &mut Bench, fault: Fault) {
    bench.finish();
    let faults: std::vec::Vec<_> =
        bench.events.iter().filter(|e| matches!(e, Event::Fault(_))).collect();
    assert_eq!(faults, [&Event::Fault(fault)]);
    assert_eq!(bench.events.last(), Some(&Event::State(MachineState::Fault)));
    let status = bench.status();
    assert_eq!((status.state, status.fault), (MachineState::Fault, Some(fault)));
    for request in [Request::Home, Request::Read, Request::Lamp(true)] {
        assert_eq!(bench.refused(request), DeviceError::Faulted(fault));
    }
    bench.accept(Request::Stop);
    assert_eq!(bench.simulator.state(), MachineState::Fault);
    bench.accept(Request::ClearFault);
    assert_eq!(bench.events, [Event::State(MachineState::Idle)]);
}

#[test]
fn a_stalled_axis_and_an_end_switch_stop_half_way_and_lose_the_zeros() {
    for axis in [Axis::Sigma, Axis::Theta] {
        for (injected, fault) in [
            (MachineFault::StalledAxis(axis), Fault::AxisStalled(axis)),
            (MachineFault::LimitSwitch(axis), Fault::LimitSwitch(axis)),
        ] {
            let mut bench = Bench::homed(quick());
            bench.simulator.inject(injected);
            bench.wait(1_000_000);
            assert_eq!(bench.simulator.state(), MachineState::Idle, "not before it moves");
            bench.accept(Request::Move(axis, Microdegrees(40_000_000)));
            told(&mut bench, fault);
            let status = bench.status();
            assert!(!status.homed && status.sigma.0 + status.theta.0 == 20_000_000);
            assert_eq!(bench.refused(Request::Read), DeviceError::NotHomed);
            // once
            bench.accept(Request::Home);
            bench.finish();
            bench.travel(axis, 40_000_000);
            // while homing
            bench.simulator.inject(injected);
            bench.accept(Request::Home);
            told(&mut bench, fault);
        }
    }
}

#[test]
fn a_stall_in_a_scan_leaves_its_points() {
    let mut bench = Bench::homed(quick());
    bench.accept(Request::Scan(segment(5_000_000, 100_000, 100)));
    bench.wait(800_000);
    let count = bench.points().len() as u16;
    bench.simulator.inject(MachineFault::StalledAxis(Axis::Theta));
    bench.events.clear();
    told(&mut bench, Fault::AxisStalled(Axis::Theta));
    let (_, measured) = bench.status().segment.unwrap();
    assert!(measured >= count && measured < 100);
    bench.accept(Request::Continue { segment: 42, next: 0, credit: 100 });
    bench.wait(10_000);
    assert_eq!(bench.points().len(), usize::from(measured));
}

#[test]
fn too_much_light_and_a_lamp_that_goes_out() {
    for request in
        [Request::Read, Request::Calibrate(CalibrationKind::Dark), Request::Scan(segment(0, 1, 9))]
    {
        let mut bench = Bench::homed(quick());
        bench.simulator.inject(MachineFault::OverRange);
        bench.accept(request);
        told(&mut bench, Fault::OverRange);
        assert!(bench.status().homed, "the zeros are known");
    }
    let mut bench = Bench::homed(quick());
    bench.calibrate();
    bench.events.clear();
    bench.simulator.inject(MachineFault::LampOff);
    assert!(bench.turn(), "it wants to be called at once");
    told(&mut bench, Fault::LampFailed);
    let status = bench.status();
    assert_eq!((status.lamp, status.homed, status.calibration), (false, true, None));
    assert_eq!(bench.refused(Request::Read), DeviceError::LampOff);
    bench.accept(Request::Lamp(true));
    bench.read();
}

#[test]
fn an_emergency_stop_cuts_everything_and_the_first_fault_stays() {
    let mut bench = Bench::homed(quick());
    bench.accept(Request::Move(Axis::Theta, Microdegrees(40_000_000)));
    bench.wait(500_000);
    assert_eq!(bench.ask(Request::EmergencyStop), Ok(Response::Accepted));
    let stop = Fault::EmergencyStop;
    assert_eq!(bench.events, [Event::Fault(stop), Event::State(MachineState::Fault)]);
    let status = bench.status();
    assert_eq!((status.theta.0, status.homed), (10_000_000, false));
    bench.simulator.inject(MachineFault::LampOff);
    bench.wait(1000);
    let status = bench.status();
    assert_eq!((status.fault, status.lamp), (Some(stop), false));
    bench.accept(Request::ClearFault);
    assert_eq!(bench.refused(Request::Move(Axis::Theta, Microdegrees(0))), DeviceError::NotHomed);
}

#[test]
fn an_idle_instrument_wants_nothing() {
    let mut bench = Bench::homed(quick());
    bench.wait(60_000_000);
    assert_eq!(bench.simulator.poll_at(), None);
}
