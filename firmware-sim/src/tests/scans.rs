//! Segments: credit, lost points, the same bits every time, the play of the axis.

use super::bench::{Bench, quick, segment};
use crate::Config;
use asperity_core::protocol::{
    Axis, DeviceError, Event, MachineState, Microdegrees, Point, Request, Segment,
};
use std::vec::Vec;

fn bits(points: &[Point]) -> Vec<(u16, i32, u32, u8)> {
    points
        .iter()
        .map(|p| (p.index, p.theta.0, p.reading.signal.to_bits(), p.reading.range))
        .collect()
}

/// At 30 degrees, run up from below.
fn ready() -> Bench {
    let mut bench = Bench::homed(quick());
    bench.travel(Axis::Sigma, 30_000_000);
    bench.travel(Axis::Theta, 10_000_000);
    bench
}

#[test]
fn every_point_comes_once_and_in_order_then_it_is_idle() {
    let mut bench = ready();
    let points = bench.scan(segment(20_000_000, 100_000, 201));
    assert_eq!(points.len(), 201);
    for (k, point) in points.iter().enumerate() {
        assert_eq!((usize::from(point.index), point.segment), (k, 42));
        assert_eq!(point.theta.0, 20_000_000 + 100_000 * k as i32);
        assert!(point.reading.signal.is_finite() && !point.reading.over && !point.reading.under);
    }
    assert_eq!(bench.events.first(), Some(&Event::State(MachineState::Measuring)));
    assert_eq!(bench.events.last(), Some(&Event::State(MachineState::Idle)));
    let status = bench.status();
    assert_eq!((status.segment, status.theta.0), (Some((42, 201)), 40_000_000));
    assert!(points.iter().any(|p| p.reading.signal > 1.0), "there is light");
}

#[test]
fn the_whole_grid_of_the_gp200_fits() {
    let mut bench = Bench::homed(Config { acceleration: 1000, ..quick() });
    let points = bench.scan(segment(-90_000_000, 100_000, 1801));
    assert_eq!(points.len(), 1801);
    assert_eq!(points[1800].theta.0, 90_000_000);
}

#[test]
fn without_credit_it_neither_measures_nor_moves() {
    let mut bench = ready();
    let whole = segment(20_000_000, 100_000, 50);
    bench.accept(Request::Scan(Segment { credit: 10, ..whole }));
    bench.wait(3_000_000);
    assert_eq!(bench.points().len(), 10);
    let status = bench.status();
    assert_eq!((status.state, status.segment), (MachineState::Measuring, Some((42, 10))));
    assert_eq!(status.theta.0, 20_900_000);
    bench.wait(3_000_000);
    assert_eq!((bench.points().len(), bench.status().theta.0), (0, 20_900_000));
    bench.accept(Request::Continue { segment: 42, next: 10, credit: 25 });
    bench.wait(3_000_000);
    assert_eq!(
        bench.points().iter().map(|p| p.index).collect::<Vec<_>>(),
        (10..35).collect::<Vec<_>>()
    );
    bench.accept(Request::Continue { segment: 42, next: 35, credit: 1000 });
    bench.finish();
    assert_eq!(bench.points().len(), 15);
    // silent without credit is silent all the same
    bench.accept(Request::Scan(Segment { credit: 1, ..whole }));
    bench.wait(6_000_000);
    assert_eq!(bench.simulator.state(), MachineState::Idle);
}

#[test]
fn lost_points_come_again_with_the_same_bits() {
    let mut bench = ready();
    let whole = segment(25_000_000, 100_000, 60);
    bench.accept(Request::Scan(Segment { credit: 40, ..whole }));
    bench.wait(3_000_000);
    let first = bench.points();
    bench.accept(Request::Continue { segment: 42, next: 12, credit: 48 });
    bench.finish();
    let second = bench.points();
    assert_eq!(bits(&second[..28]), bits(&first[12..]));
    assert_eq!(second.len(), 48);
    // and when all is measured
    bench.accept(Request::Continue { segment: 42, next: 50, credit: 5 });
    bench.wait(1000);
    assert_eq!(bits(&bench.points()), bits(&second[38..43]));
    bench.accept(Request::Continue { segment: 42, next: 60, credit: 5 });
    bench.wait(1000);
    assert!(bench.points().is_empty());
    assert_eq!(
        bench.refused(Request::Continue { segment: 42, next: 61, credit: 5 }),
        DeviceError::BadValue
    );
    assert_eq!(
        bench.refused(Request::Continue { segment: 42, next: 6, credit: 0 }),
        DeviceError::BadValue
    );
    assert_eq!(
        bench.refused(Request::Continue { segment: 43, next: 0, credit: 5 }),
        DeviceError::NoSegment
    );
}

#[test]
fn the_end_of_a_segment_alone_is_the_same_bits() {
    let whole = segment(20_000_000, 100_000, 201);
    let all = ready().scan(whole);
    let mut bench = ready();
    let rest = bench.scan(Segment { first: 120, segment: 43, ..whole });
    assert_eq!(bits(&rest), bits(&all[120..]));
    assert_eq!(bench.status().segment, Some((43, 201)));
    // the points before it are not there
    let early = Request::Continue { segment: 43, next: 119, credit: 5 };
    assert_eq!(bench.refused(early), DeviceError::BadValue);
    // and the whole again
    bench.travel(Axis::Theta, 10_000_000);
    bench.travel(Axis::Theta, 15_000_000);
    assert_eq!(bits(&bench.scan(whole)), bits(&all));
}

#[test]
fn a_reading_is_the_point_at_its_angle() {
    let mut bench = ready();
    let all = bench.scan(segment(20_000_000, 100_000, 201));
    for index in [0, 57, 100, 200] {
        bench.travel(Axis::Theta, 10_000_000);
        bench.travel(Axis::Theta, 15_000_000);
        bench.travel(Axis::Theta, 20_000_000 + 100_000 * index);
        assert_eq!(bench.read(), all[index as usize].reading, "{index}");
    }
}

#[test]
fn the_play_shows_and_is_gone_after_a_run_up() {
    let fine = segment(28_000_000, 20_000, 6);
    let good = ready().scan(fine);
    // from above the arm hangs back by 0.05 degrees: the first points see where it is
    let mut bench = ready();
    bench.travel(Axis::Theta, 40_000_000);
    let bad = bench.scan(fine);
    assert_ne!(bits(&bad)[..3], bits(&good)[..3]);
    // 28.06 and on are above 28.05
    assert_eq!(bits(&bad)[3..], bits(&good)[3..]);
    // 28.00, 28.02, 28.04 are all read at 28.05, with the same noise
    assert_eq!(bad[0].reading, bad[2].reading);
    let mut bench = ready();
    bench.travel(Axis::Theta, 40_000_000);
    bench.travel(Axis::Theta, 27_900_000);
    assert_eq!(bits(&bench.scan(fine)), bits(&good));
    // none without play
    let mut bench = Bench::homed(Config { backlash: Microdegrees(0), ..quick() });
    bench.travel(Axis::Sigma, 30_000_000);
    bench.travel(Axis::Theta, 40_000_000);
    assert_eq!(bits(&bench.scan(fine)), bits(&good));
}

#[test]
fn a_reading_from_above_sees_the_arm_too() {
    let mut bench = ready();
    bench.travel(Axis::Theta, 28_050_000);
    let there = bench.read();
    bench.travel(Axis::Theta, 40_000_000);
    bench.travel(Axis::Theta, 28_000_000);
    assert_eq!(bench.read(), there);
}

#[test]
fn wrong_segments_are_refused_and_the_old_one_stays() {
    let mut bench = ready();
    let good = segment(20_000_000, 100_000, 20);
    let points = bench.scan(good);
    let bad = DeviceError::BadValue;
    let limit = DeviceError::SoftLimit(Axis::Theta);
    for (wrong, error) in [
        (Segment { step: Microdegrees(0), ..good }, bad),
        (Segment { step: Microdegrees(-5), ..good }, bad),
        (Segment { count: 0, ..good }, bad),
        (Segment { count: 1802, ..good }, bad),
        (Segment { first: 20, ..good }, bad),
        (Segment { credit: 0, ..good }, bad),
        (Segment { start: Microdegrees(-95_000_001), ..good }, limit),
        (Segment { start: Microdegrees(94_000_000), ..good }, limit),
        (Segment { step: Microdegrees(i32::MAX), ..good }, limit),
    ] {
        assert_eq!(bench.refused(Request::Scan(wrong)), error, "{wrong:?}");
    }
    bench.accept(Request::Continue { segment: 42, next: 0, credit: 20 });
    bench.wait(1000);
    assert_eq!(bits(&bench.points()), bits(&points));
}

#[test]
fn a_stopped_scan_keeps_what_it_has() {
    let mut bench = ready();
    bench.accept(Request::Scan(segment(20_000_000, 100_000, 100)));
    bench.wait(1_000_000);
    let sent = bench.points();
    bench.accept(Request::Stop);
    let status = bench.status();
    let count = sent.len() as u16;
    assert_eq!((status.state, status.segment), (MachineState::Idle, Some((42, count))));
    assert!((1..100).contains(&count));
    bench.accept(Request::Continue { segment: 42, next: 0, credit: 100 });
    bench.wait(2_000_000);
    assert_eq!(bits(&bench.points()), bits(&sent));
    // the rest is another scan, and joins without a seam
    bench.travel(Axis::Theta, 10_000_000);
    bench.travel(Axis::Theta, 15_000_000);
    let rest = bench.scan(Segment { first: count, ..segment(20_000_000, 100_000, 100) });
    let joined: Vec<_> = bits(&sent).into_iter().chain(bits(&rest)).collect();
    assert_eq!(joined, bits(&ready().scan(segment(20_000_000, 100_000, 100))));
}

#[test]
fn acceleration_changes_the_time_and_not_the_values() {
    let time = |acceleration| {
        let mut bench = Bench::homed(Config { acceleration, ..quick() });
        let start = bench.now;
        let points = bench.scan(segment(20_000_000, 100_000, 51));
        (bench.now.since(start), bits(&points))
    };
    let ((slow, values), (fast, same)) = (time(1), time(10));
    assert_eq!(values, same);
    // 25 degrees at 20 degrees a second, 51 times 12 ms, and the changes of range
    assert!((1_862_000..2_200_000).contains(&slow), "{slow}");
    assert!(fast.abs_diff(slow / 10) < 2000, "{fast}");
}
