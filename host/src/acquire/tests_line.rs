//! Clients on lines that lose, garble, repeat and invent bytes.

use std::time::Duration;

use asperity_core::protocol::{
    Axis, DeviceError, Message, Microdegrees, Request, Response, Text16,
};

use super::mock::{Device, Fate};
use super::transport::{InProcess, Peer, Transport};
use super::{Client, LinkError, Patience, Trouble};

type Line = InProcess<Device>;

fn connect(device: Device) -> Result<Client<'static, Line>, LinkError> {
    Client::connect(InProcess::new(device), Patience::default())
}

fn trouble<T>(result: Result<T, LinkError>) -> Trouble {
    match result {
        Ok(_) => panic!("no trouble"),
        Err(e) => *e.trouble,
    }
}

/// Says the same for ever, as fast as the line goes.
struct Babbler(&'static [u8]);

impl Peer for Babbler {
    fn exchange(&mut self, _: &[u8], _: Duration, out: &mut Vec<u8>) {
        out.extend_from_slice(self.0);
    }

    fn poll_at(&self) -> Option<Duration> {
        Some(Duration::ZERO)
    }
}

#[test]
fn a_request_is_sent_again_as_the_same_bytes_until_it_is_answered() {
    let fates = [Fate::Pass, Fate::Drop, Fate::Corrupt, Fate::Drop, Fate::Twice];
    let fate = move |k: u64, _: &mut _| fates.get(k as usize).copied().unwrap_or(Fate::Pass);
    let mut client = connect(Device::tampered(fate)).unwrap();
    client.claim().unwrap();
    client.ask(Request::Lamp(true)).unwrap();
    let heard = &client.line().peer().heard;
    assert_eq!(heard.len(), 1 + 4 + 1);
    assert!(heard[1..5].iter().all(|frame| *frame == heard[1]), "{heard:?}");
    assert_eq!(heard[5].sequence, heard[1].sequence + 1);
    assert_eq!(client.recoveries(), 0);
}

#[test]
fn a_stranger_is_told_from_silence_in_the_stated_time() {
    for said in [&b"HELLO\r\n"[..], b"\0\0\0\0", b"\0\x05abcd\0", &[0xff; 5000]] {
        let line = InProcess::new(Babbler(said));
        let mut link = super::link::Link::new(line, Patience::default());
        let found = link.identify(Duration::from_secs(5)).unwrap_err();
        let took = link.line.now().as_secs_f64();
        assert!((5.0..6.0).contains(&took), "{took} s");
        let Trouble::NotAnInstrument { bytes, first, .. } = found else { panic!("{found}") };
        assert!(bytes > 10_000 && first.len() <= 32, "{bytes} {first}");
    }
    let mut link = super::link::Link::new(InProcess::new(Babbler(b"")), Patience::default());
    let found = link.identify(Duration::from_secs(5)).unwrap_err();
    assert!(matches!(found, Trouble::Silent { .. }), "{found}");
    assert!((5.0..5.1).contains(&link.line.now().as_secs_f64()));
}

#[test]
fn another_version_is_refused() {
    let mut device = Device::new();
    device.ident.protocol = 7;
    let found = trouble(connect(device));
    assert!(matches!(found, Trouble::Version { theirs: 7, ours: 1 }), "{found}");
}

#[test]
fn a_lost_line_is_found_again_and_a_long_loss_is_the_end() {
    let cut = |k, _: &mut _| if k == 2 { Fate::Cut } else { Fate::Pass };
    let mut client = connect(Device::tampered(cut)).unwrap();
    client.claim().unwrap();
    client.home().unwrap();
    client.move_to(Axis::Theta, Microdegrees(5)).unwrap();
    assert_eq!(client.recoveries(), 1);
    let mut device = Device::tampered(cut);
    device.outage = Duration::from_hours(1);
    let mut client = connect(device).unwrap();
    client.claim().unwrap();
    let before = client.line().now();
    let found = trouble(client.home());
    assert!(matches!(found, Trouble::Lost { seconds: 30.0, cause: Some(_) }), "{found}");
    assert!(client.line().now() < before + Duration::from_secs(40));
}

#[test]
fn after_a_loss_another_instrument_is_refused() {
    let mut client = connect(Device::new()).unwrap();
    client.claim().unwrap();
    let device = client.line_mut().peer_mut();
    (device.ident.serial, device.ident.model) = (43, Text16::new("GP-300"));
    device.down = Some(Duration::ZERO);
    let found = trouble(client.status());
    let Trouble::OtherInstrument { found, expected } = found else { panic!("{found}") };
    assert_eq!((found.as_str(), expected.as_str()), ("GP-300 43", "GP-200 42"));
}

#[test]
fn a_restarted_instrument_is_claimed_again() {
    let restart = |k, _: &mut _| if k == 2 { Fate::Restart } else { Fate::Pass };
    let mut client = connect(Device::tampered(restart)).unwrap();
    client.claim().unwrap();
    client.home().unwrap();
    assert!(client.recoveries() >= 1);
    assert_eq!(client.status().unwrap().owner, Some(client.session()));
}

#[test]
fn what_is_in_use_is_said_so_after_a_while() {
    let mut device = Device::new();
    device.status.owner = Some(0);
    let mut client = connect(device).unwrap();
    assert!(matches!(trouble(client.claim_now()), Trouble::InUse));
    assert!(matches!(trouble(client.claim()), Trouble::InUse));
    let waited = client.line().now().as_secs_f64();
    assert!((6.0..7.0).contains(&waited), "{waited}");
    client.line_mut().peer_mut().status.owner = None;
    client.claim().unwrap();
    let refused = trouble(client.move_to(Axis::Theta, Microdegrees(5)));
    assert!(matches!(refused, Trouble::Refused { why: DeviceError::NotHomed, .. }), "{refused}");
}

#[test]
fn a_calibration_that_cannot_be_is_refused() {
    for reference in [f32::NAN, f32::INFINITY, 0.5, 5.0] {
        let spoil = move |_, frame: &mut asperity_core::protocol::Frame| {
            if let Message::Response(Response::Calibration(values)) = &mut frame.message {
                values.reference = reference;
            }
            Fate::Pass
        };
        let mut client = connect(Device::tampered(spoil)).unwrap();
        client.claim().unwrap();
        let found = trouble(client.calibrate());
        let weak = matches!(found, Trouble::WeakBeam { .. });
        assert!(weak || matches!(found, Trouble::Nonsense(_)), "{reference} {found}");
        assert_eq!(weak, reference.is_finite());
    }
}
