//! Frames on a bad line: nothing wrong is ever taken for right, and the decoder finds its feet again.

use asperity_core::protocol::{
    Axis, Decoder, Event, Frame, MAX_ENCODED, Message, Microdegrees, Point, Reading, Request,
    Response, encode,
};
use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;

/// A number below `limit`.
fn below(generator: &mut Pcg64Mcg, limit: usize) -> usize {
    (generator.next_u64() % limit.max(1) as u64) as usize
}

/// Mostly points, as in a scan, with requests and short answers among them.
fn frame(generator: &mut Pcg64Mcg) -> Frame {
    let bits = generator.next_u64();
    let message = match bits % 8 {
        0 => Message::Request(Request::Move(Axis::Theta, Microdegrees(bits as i32))),
        1 => Message::Response(Response::Accepted),
        _ => Message::Event(Event::Point(Point {
            segment: (bits >> 20) as u32,
            index: (bits >> 40) as u16 % 1801,
            theta: Microdegrees((bits >> 11) as i32 % 90_000_000),
            reading: Reading {
                signal: (bits >> 33) as f32 * 1e-7,
                dark: 0.02,
                range: (bits >> 8) as u8 % 6,
                over: false,
                under: bits & 256 != 0,
            },
        })),
    };
    Frame { session: (bits >> 48) as u16, sequence: (bits >> 16) as u16, message }
}

/// One way to harm bytes.
fn harm(bytes: &mut Vec<u8>, generator: &mut Pcg64Mcg) {
    let at = below(generator, bytes.len());
    match below(generator, 8) {
        0 => bytes[at] ^= 1 << below(generator, 8),
        1 => bytes[at] = generator.next_u32() as u8,
        2 => drop(bytes.remove(at)),
        3 => bytes.insert(at, generator.next_u32() as u8),
        4 => bytes.insert(at, 0),
        5 => bytes.truncate(at.max(1)),
        6 => {
            let end = at + below(generator, bytes.len() - at + 1);
            let piece = bytes[at..end].to_vec();
            bytes.splice(at..at, piece);
        }
        _ => {
            // a tenth of the bytes
            for byte in bytes.iter_mut() {
                if below(generator, 10) == 0 {
                    *byte = generator.next_u32() as u8;
                }
            }
        }
    }
}

#[test]
#[allow(clippy::print_stdout, reason = "shown with --nocapture")]
fn a_million_corrupted_frames_and_not_one_wrong_value() {
    let mut generator = Pcg64Mcg::new(0xc0ffee);
    let (mut corrupted, mut survived, mut harmed_and_read) = (0_u32, 0_u32, 0_u32);
    let mut decoder = Decoder::new();
    while corrupted < 1_200_000 {
        let sent = frame(&mut generator);
        let clean = encode(&sent).as_bytes().to_vec();
        let mut bytes = clean.clone();
        for _ in 0..=below(&mut generator, 3) {
            harm(&mut bytes, &mut generator);
            if bytes.is_empty() {
                bytes.push(0);
            }
        }
        corrupted += u32::from(bytes != clean);
        // a whole frame afterwards is read, after what was left open ends at its first zero
        let after = frame(&mut generator);
        let line = [&bytes, encode(&after).as_bytes()].concat();
        let (mut rest, mut last) = (&line[..], None);
        while let Some(result) = decoder.next(&mut rest) {
            if let Some(Ok(early)) = last.replace(result) {
                assert_eq!(early, sent, "accepted from {bytes:02x?}");
                harmed_and_read += 1;
            }
        }
        assert_eq!(last, Some(Ok(after)), "not found again after {bytes:02x?}");
        survived += 1;
    }
    assert_eq!(decoder.good(), survived + harmed_and_read);
    println!("{corrupted} corrupted frames: {} thrown away, none wrong", decoder.bad());
    println!("{harmed_and_read} read all the same: a copy or an untouched frame beside the harm");
}

#[test]
fn any_cut_of_the_stream_gives_the_same_frames() {
    let mut generator = Pcg64Mcg::new(5);
    let frames: Vec<Frame> = (0..500).map(|_| frame(&mut generator)).collect();
    let line: Vec<u8> = frames.iter().flat_map(|f| encode(f).as_bytes().to_vec()).collect();
    for most in [1, 2, 3, 7, 64, 4096] {
        let (mut decoder, mut found, mut rest) = (Decoder::new(), Vec::new(), &line[..]);
        while !rest.is_empty() {
            let (mut piece, more) =
                rest.split_at((1 + below(&mut generator, most)).min(rest.len()));
            rest = more;
            while let Some(result) = decoder.next(&mut piece) {
                found.push(result.unwrap());
            }
        }
        assert_eq!(found, frames);
    }
}

#[test]
fn noise_without_end_yields_no_frame_and_takes_no_memory() {
    let mut generator = Pcg64Mcg::new(6);
    let mut decoder = Decoder::new();
    for zeros in [0, 1, 16, 255] {
        for _ in 0..4000 {
            let noise: Vec<u8> = (0..256)
                .map(|_| generator.next_u32())
                .map(|bits| if bits >> 24 < zeros { 0 } else { bits as u8 | 1 })
                .collect();
            let mut rest = &noise[..];
            while let Some(result) = decoder.next(&mut rest) {
                assert!(result.is_err());
            }
        }
    }
    assert!(decoder.bad() > 10_000);
    assert!(size_of::<Decoder>() < MAX_ENCODED + 64);
}
