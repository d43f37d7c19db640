//! A client with patience on a line with faults.

use super::bench::{Bench, SESSION, quick, segment};
use crate::fault::{Direction, Link, LinkFaults};
use crate::{Instant, Simulator};
use asperity_core::protocol::{
    Axis, Decoder, Event, Frame, Message, Microdegrees, Point, Request, Response, Segment, Status,
};
use std::boxed::Box;
use std::vec::Vec;

/// Sends until there is an answer, and asks again for points that did not come.
struct Client {
    simulator: Box<Simulator>,
    link: Box<Link>,
    decoder: Decoder,
    now: Instant,
    sequence: u16,
    points: Vec<Point>,
    retries: u32,
}

impl Client {
    /// A tenth of a second of both ends.
    fn wait(&mut self, sequence: u16) -> Option<Message> {
        let end = self.now.after(100_000);
        let mut answer = None;
        while self.now < end && answer.is_none() {
            self.now = self.now.after(1000);
            let (mut down, mut up) = (Vec::new(), Vec::new());
            self.link.receive(Direction::ToInstrument, self.now, &mut |b: &[u8]| {
                down.extend_from_slice(b);
            });
            self.simulator.handle(&down, self.now, &mut |b: &[u8]| up.extend_from_slice(b));
            self.link.send(Direction::ToClient, &up, self.now);
            up.clear();
            self.link.receive(Direction::ToClient, self.now, &mut |b: &[u8]| {
                up.extend_from_slice(b);
            });
            let mut bytes = &up[..];
            while let Some(frame) = self.decoder.next(&mut bytes) {
                match frame {
                    Ok(Frame { message: Message::Event(Event::Point(point)), .. })
                        if usize::from(point.index) == self.points.len() =>
                    {
                        self.points.push(point);
                    }
                    Ok(Frame { message: Message::Event(_), .. }) | Err(_) => {}
                    Ok(frame) if frame.sequence == sequence => answer = Some(frame.message),
                    Ok(_) => {}
                }
            }
        }
        answer
    }

    fn ask(&mut self, request: Request) -> Message {
        self.sequence += 1;
        let bytes = Bench::frame(SESSION, self.sequence, request);
        for _ in 0..200 {
            self.link.send(Direction::ToInstrument, &bytes, self.now);
            if let Some(answer) = self.wait(self.sequence) {
                return answer;
            }
            self.retries += 1;
        }
        panic!("no answer to {request:?}");
    }

    fn status(&mut self) -> Status {
        match self.ask(Request::Status) {
            Message::Response(Response::Status(status)) => status,
            other => panic!("{other:?}"),
        }
    }

    fn finish(&mut self) {
        while self.status().state != asperity_core::protocol::MachineState::Idle {
            self.wait(0);
        }
    }
}

#[test]
fn every_request_is_carried_out_once_and_every_point_is_right() {
    let whole = segment(20_000_000, 100_000, 120);
    let mut bench = Bench::homed(quick());
    bench.travel(Axis::Sigma, 30_000_000);
    bench.travel(Axis::Theta, 10_000_000);
    let expected = bench.scan(whole);
    let (mut retries, accepted) = (0, Message::Response(Response::Accepted));
    for seed in 0..20 {
        let faults = LinkFaults { disconnect: 0.0, ..LinkFaults::rate(0.05) };
        let mut client = Client {
            simulator: Box::new(Simulator::new(quick())),
            link: Box::new(Link::new(faults, seed)),
            decoder: Decoder::new(),
            now: Instant(0),
            sequence: 0,
            points: Vec::new(),
            retries: 0,
        };
        for request in [
            Request::Claim,
            Request::Home,
            Request::Move(Axis::Sigma, Microdegrees(30_000_000)),
            Request::Move(Axis::Theta, Microdegrees(10_000_000)),
            Request::Scan(Segment { credit: 20, ..whole }),
        ] {
            // a request carried out twice would be `Busy` the second time, or move again
            assert_eq!(client.ask(request), accepted, "{seed} {request:?}");
            if !matches!(request, Request::Scan(_)) {
                client.finish();
            }
        }
        while client.points.len() < 120 {
            client.wait(0);
            let next = client.points.len() as u16;
            let go_on = Request::Continue { segment: 42, next, credit: 20 };
            assert_eq!(client.ask(go_on), accepted, "{seed}");
        }
        assert_eq!(client.points, expected, "{seed}");
        retries += client.retries;
    }
    assert!(retries > 50, "the line was too good: {retries}");
}
