//! Bytes a second through the decoder: a scan's points, requests, and noise; and one frame encoded.

use std::hint::black_box;
use std::time::Duration;

use asperity_core::protocol::{
    Decoder, Event, Frame, Message, Microdegrees, Point, Reading, Request, checksum, encode,
};
use criterion::{Criterion, Throughput};
use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;

fn point(index: u16) -> Frame {
    let reading = Reading {
        signal: f32::from(index) * 0.37,
        dark: 0.021,
        range: 2,
        over: false,
        under: false,
    };
    let theta = Microdegrees(i32::from(index) * 100_000 - 90_000_000);
    let message = Message::Event(Event::Point(Point { segment: 70_000, index, theta, reading }));
    Frame { session: 0x1234, sequence: index, message }
}

fn request(sequence: u16) -> Frame {
    Frame { session: 0x1234, sequence, message: Message::Request(Request::Status) }
}

fn line(frames: impl Iterator<Item = Frame>) -> Vec<u8> {
    frames.flat_map(|frame| encode(&frame).as_bytes().to_vec()).collect()
}

fn main() {
    let mut c = Criterion::default()
        .measurement_time(Duration::from_secs(2))
        .warm_up_time(Duration::from_millis(500))
        .configure_from_args();
    let mut generator = Pcg64Mcg::new(1);
    let noise = (0..100_000).map(|_| generator.next_u32() as u8).collect();
    let streams = [
        ("points", line((0..1801).map(point))),
        ("requests", line((0..9000).map(request))),
        ("noise", noise),
    ];
    let mut group = c.benchmark_group("protocol decode");
    for (name, bytes) in &streams {
        group.throughput(Throughput::Bytes(bytes.len() as u64));
        group.bench_function(*name, |bencher| {
            let mut decoder = Decoder::new();
            bencher.iter(|| {
                let mut rest = black_box(&bytes[..]);
                while let Some(result) = decoder.next(&mut rest) {
                    let _ = black_box(result);
                }
            });
        });
    }
    group.throughput(Throughput::Bytes(streams[0].1.len() as u64));
    group.bench_function("checksum alone", |b| b.iter(|| checksum(black_box(&streams[0].1))));
    group.finish();
    c.bench_function("protocol encode a point", |b| b.iter(|| encode(black_box(&point(900)))));
    c.final_summary();
}
