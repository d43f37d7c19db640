//! Sessions, sequence numbers, owners, silence.

use super::bench::{Bench, SESSION, quick};
use crate::{Config, Instant, MachineFault, Simulator};
use asperity_core::protocol::{
    Axis, DeviceError, Diagnostics, Event, Fault, MachineState, Microdegrees, Request, Response,
    VERSION,
};
use rand_pcg::Pcg32;
use rand_pcg::rand_core::Rng as _;
use std::vec::Vec;

const OTHER: u16 = 99;

#[test]
fn a_request_sent_again_is_answered_again_and_not_carried_out_again() {
    let mut bench = Bench::homed(quick());
    let bytes = Bench::frame(SESSION, 500, Request::Move(Axis::Theta, Microdegrees(5_000_000)));
    let first = bench.raw(&bytes);
    bench.finish();
    assert_eq!(bench.simulator.status().theta.0, 5_000_000);
    bench.sequence = 500;
    bench.travel(Axis::Theta, 1_000_000);
    // now an old one
    assert!(bench.raw(&bytes).is_empty());
    assert_eq!(bench.simulator.state(), MachineState::Idle);

    // the answer to a reading of the clock would differ if it were asked again
    let bytes = Bench::frame(SESSION, 600, Request::Diagnostics);
    let first_diagnostics = bench.raw(&bytes);
    bench.wait(100_000);
    assert_eq!(bench.raw(&bytes), first_diagnostics);
    // the first answer and the event of the change of state
    assert!(first.len() > first_diagnostics.len() / 2);
    let again = Bench::frame(SESSION, 601, Request::Move(Axis::Theta, Microdegrees(2_000_000)));
    let answer = bench.raw(&again);
    let repeated = bench.raw(&again);
    assert!(answer.starts_with(&repeated) && !repeated.is_empty());
}

#[test]
fn sequence_numbers_wrap_around() {
    let mut bench = Bench::new(quick());
    bench.sequence = 32_000;
    bench.status();
    bench.sequence = 64_000;
    bench.status();
    assert_eq!(bench.answer_to(SESSION, 63_999, Request::Status), None);
    bench.sequence = u16::MAX;
    bench.status();
    assert_eq!(bench.sequence, 0);
    assert_eq!(bench.answer_to(SESSION, u16::MAX, Request::Status), None);
}

#[test]
fn a_late_copy_of_the_claim_does_not_open_the_door_to_old_requests() {
    let mut bench = Bench::homed(quick());
    let claim = Bench::frame(SESSION, 1, Request::Claim);
    bench.travel(Axis::Theta, 3_000_000);
    let old = bench.sequence - 1;
    assert!(bench.raw(&claim).is_empty());
    assert_eq!(bench.answer_to(SESSION, old, Request::Home), None);
    assert_eq!(bench.simulator.state(), MachineState::Idle);
    // a new claim by the owner starts anew
    bench.sequence = 9999;
    bench.accept(Request::Claim);
    assert_eq!(bench.answer_to(SESSION, 3, Request::Claim), Some(Ok(Response::Accepted)));
    assert!(bench.answer_to(SESSION, 4, Request::Status).is_some());
}

#[test]
fn one_session_owns_and_the_others_may_look_and_stop() {
    let mut bench = Bench::homed(quick());
    let other = |bench: &mut Bench, k, request| bench.answer_to(OTHER, k, request).unwrap();
    assert_eq!(other(&mut bench, 1, Request::Claim), Err(DeviceError::InUse));
    assert!(
        matches!(other(&mut bench, 2, Request::Status), Ok(Response::Status(s)) if s.owner == Some(SESSION))
    );
    assert!(other(&mut bench, 3, Request::Identify).is_ok());
    assert!(other(&mut bench, 4, Request::Diagnostics).is_ok());
    for request in [
        Request::Release,
        Request::Home,
        Request::Move(Axis::Theta, Microdegrees(0)),
        Request::Aperture(Microdegrees(1)),
        Request::Lamp(false),
        Request::Read,
        Request::LastReading,
        Request::Stop,
        Request::ClearFault,
        Request::Continue { segment: 1, next: 0, credit: 1 },
    ] {
        assert_eq!(other(&mut bench, 5, request), Err(DeviceError::NotOwner), "{request:?}");
    }
    bench.events.clear();
    assert_eq!(other(&mut bench, 6, Request::EmergencyStop), Ok(Response::Accepted));
    // the owner hears of it
    let stop = Fault::EmergencyStop;
    assert_eq!(bench.events, [Event::Fault(stop), Event::State(MachineState::Fault)]);
    assert_eq!(bench.refused(Request::Home), DeviceError::Faulted(stop));
    assert_eq!(bench.answer_to(0, 1, Request::Claim), Some(Err(DeviceError::BadValue)));
}

#[test]
fn who_releases_or_is_silent_gives_way() {
    let mut bench = Bench::new(quick());
    bench.accept(Request::Release);
    let release = Bench::frame(SESSION, bench.sequence, Request::Release);
    // its answer may have been lost
    let again = bench.raw(&release);
    assert!(!again.is_empty());
    assert_eq!(bench.answer_to(OTHER, 1, Request::Claim), Some(Ok(Response::Accepted)));
    bench.wait(4_999_999);
    assert_eq!(bench.answer_to(SESSION, 50, Request::Claim), Some(Err(DeviceError::InUse)));
    bench.wait(1);
    assert_eq!(bench.answer_to(SESSION, 51, Request::Claim), Some(Ok(Response::Accepted)));
    assert_eq!(bench.answer_to(OTHER, 2, Request::Stop), Some(Err(DeviceError::NotOwner)));
}

#[test]
fn nothing_moves_for_a_client_that_has_gone() {
    let mut bench = Bench::homed(quick());
    bench.travel(Axis::Theta, -90_000_000);
    bench.accept(Request::Move(Axis::Theta, Microdegrees(90_000_000)));
    let begun = bench.now;
    bench.wait(4_900_000);
    assert_eq!(bench.simulator.state(), MachineState::Moving);
    bench.wait(5_000_000);
    assert_eq!(bench.simulator.state(), MachineState::Idle);
    // 5 s at 20 degrees a second; it stopped then, although asked later
    let status = bench.simulator.status();
    assert_eq!((status.theta.0, status.homed), (10_000_000, true));
    assert_eq!(bench.events.last(), Some(&Event::State(MachineState::Idle)));
    // late by the clock of the caller: the same
    bench.accept(Request::Move(Axis::Theta, Microdegrees(90_000_000)));
    bench.now = begun.after(60_000_000);
    bench.raw(&[]);
    assert_eq!(bench.simulator.status().theta.0, 90_000_000, "it was there before 5 s");
    bench.accept(Request::Home);
    bench.now = bench.now.after(6_000_000);
    bench.raw(&[]);
    assert!(!bench.simulator.status().homed && bench.simulator.state() == MachineState::Idle);
}

#[test]
fn any_good_frame_of_the_owner_breaks_the_silence() {
    let mut bench = Bench::homed(quick());
    bench.travel(Axis::Theta, -90_000_000);
    bench.accept(Request::Move(Axis::Theta, Microdegrees(90_000_000)));
    let again = Bench::frame(SESSION, bench.sequence, Request::Status);
    bench.wait(3_000_000);
    // the same sequence again
    bench.raw(&again);
    bench.wait(3_000_000);
    assert_eq!(bench.simulator.state(), MachineState::Moving);
}

#[test]
fn a_lost_connection_stops_and_releases() {
    let mut bench = Bench::homed(quick());
    bench.accept(Request::Move(Axis::Theta, Microdegrees(90_000_000)));
    bench.wait(1_000_000);
    bench.simulator.disconnected(bench.now);
    let status = bench.simulator.status();
    assert_eq!((status.state, status.owner), (MachineState::Idle, None));
    assert_eq!(status.theta.0, 20_000_000);
    assert_eq!(bench.answer_to(OTHER, 1, Request::Claim), Some(Ok(Response::Accepted)));
}

#[test]
fn it_says_who_it_is_and_how_it_fares() {
    let mut bench = Bench::new(Config { serial: 77, acceleration: 10, ..quick() });
    let Ok(Response::Ident(ident)) = bench.ask(Request::Identify) else { panic!() };
    assert_eq!(
        (ident.protocol, ident.serial, ident.model.as_str()),
        (VERSION, 77, "GP-200 simulator")
    );
    assert_eq!((ident.theta.speed, ident.theta.most.0), (200_000_000, 95_000_000));
    bench.simulator.set_stack_bytes(1234);
    bench.raw(b"\0\x03garbage\0");
    let Ok(Response::Diagnostics(diagnostics)) = bench.ask(Request::Diagnostics) else { panic!() };
    let expected = Diagnostics { frames: 3, bad_frames: 1, stack_bytes: 1234, uptime_ms: 1000 };
    assert_eq!(diagnostics, expected);
}

#[test]
fn no_bytes_whatever_make_it_panic_or_talk_nonsense() {
    let mut dice = Pcg32::new(5, 5);
    let mut simulator = Simulator::new(Config { rays: 300, acceleration: 50, ..Config::demo() });
    let mut now = Instant(0);
    let requests = [
        Request::Claim,
        Request::Home,
        Request::Read,
        Request::Status,
        Request::Stop,
        Request::ClearFault,
        Request::Lamp(true),
        Request::Continue { segment: 42, next: 3, credit: 200 },
        Request::Scan(super::bench::segment(-90_000_000, 100_000, 1801)),
        Request::Move(Axis::Sigma, Microdegrees(i32::MAX)),
        Request::Release,
    ];
    for k in 0..20_000_u16 {
        let length = (dice.next_u32() % 40) as usize;
        let mut bytes: Vec<u8> = (0..length).map(|_| dice.next_u32() as u8).collect();
        if dice.next_u32().is_multiple_of(2) {
            let request = requests[dice.next_u32() as usize % requests.len()];
            bytes = Bench::frame(SESSION, k, request);
            if dice.next_u32().is_multiple_of(8) {
                let at = dice.next_u32() as usize % bytes.len();
                bytes[at] ^= 1 << (dice.next_u32() % 8);
            }
        }
        match dice.next_u32() % 2000 {
            0 => simulator.inject(MachineFault::StalledAxis(Axis::Theta)),
            1 => simulator.inject(MachineFault::LampOff),
            2 => simulator.disconnected(now),
            _ => {}
        }
        now = now.after(u64::from(dice.next_u32() % 20_000));
        simulator.handle(&bytes, now, &mut |_: &[u8]| {});
        assert!(simulator.poll_at().is_none_or(|at| at >= now));
        let status = simulator.status();
        assert_eq!(status.fault.is_some(), status.state == MachineState::Fault);
    }
    assert!(simulator.diagnostics().frames > 1000 && simulator.diagnostics().bad_frames > 1000);
}
