//! What the targets assert: no panic, no more points than the file can account for, and the same
//! result when read again. Time and memory are watched by libFuzzer, see `README.md`.

use std::io::{Cursor, Write};

use asperity::measurement::{ColumnMap, Import, Selection, Stated, csv};
use asperity::model::Model;
use asperity::surface::io::{FORMATS, MapFault, OpenOptions, RawMap, parse};
use asperity::surface::{Form, Roughness};
use asperity_core::protocol::{Decoder, Text16, encode, scpi};
use asperity_firmware_sim::{Config, Instant, Simulator};
use zip::CompressionMethod::Stored;
use zip::write::{SimpleFileOptions, ZipWriter};

/// Formats that are packed: a point may take much less than a byte.
const PACKED: [&str; 8] =
    ["MountainsMap mnt", "Sensofar plux", "Keyence vk", "x3p", "npy/npz", "PNG", "TIFF", "Digital Surf sur"];
/// Maps of at most so many points are also put to use.
const SMALL: usize = 10_000;

/// Gives bytes to the reader of a format, claimed or not.
pub fn reader(name: &str, bytes: &[u8]) {
    let format = FORMATS.iter().find(|f| f.name() == name).expect("a format");
    format.detect(bytes);
    let none = OpenOptions::default();
    let unit = "nm".parse().ok();
    let all = OpenOptions { z_um: Some(0.01), xy_unit: unit, ignore_checksum: true, ..none };
    for options in [none, all] {
        judge(bytes, PACKED.contains(&name), || format.read(bytes, &options));
    }
}

/// Gives bytes to the reader that claims them first.
pub fn open(bytes: &[u8]) {
    judge(bytes, true, || parse(bytes, &OpenOptions::default()));
}

/// Gives an x3p file whose `main.xml`, points and mask are parts of the bytes to its reader.
pub fn x3p_content(bytes: &[u8]) {
    // parts end at bytes that are rare in all of them
    let mut parts = bytes.splitn(3, |b| *b == 0xfd);
    let mut part = || parts.next().unwrap_or_default();
    let files = [("main.xml", part()), ("bindata/data.bin", part()), ("bindata/valid.bin", part())];
    reader("x3p", &stored(&files));
}

/// Gives an npz file whose array is the bytes to its reader.
pub fn npz_content(bytes: &[u8]) {
    reader("npy/npz", &stored(&[("heights.npy", bytes)]));
}

/// Gives a zip file that holds the bytes beside a text to the reader of what is packed.
pub fn zip_content(bytes: &[u8]) {
    let archive = stored(&[("readme.txt", b"a map"), ("map", bytes)]);
    judge(&archive, true, || parse(&archive, &OpenOptions::default()));
}

fn stored(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(*name, SimpleFileOptions::default().compression_method(Stored))
            .expect("a zip");
        zip.write_all(bytes).expect("memory");
    }
    zip.finish().expect("a zip").into_inner()
}

fn judge(bytes: &[u8], packed: bool, read: impl Fn() -> Result<RawMap, MapFault>) {
    let (first, again) = (read(), read());
    match (first, again) {
        (Ok(map), Ok(again)) => {
            // xyz fills a grid with sixteen times its points at most, of six bytes each
            let freely = if packed { (64 << 20) + 256 * bytes.len() } else { 64 + 4 * bytes.len() };
            assert!(map.heights_um.len() <= freely, "{} x {}", map.nx, map.ny);
            assert_eq!(Some(map.heights_um.len()), map.nx.checked_mul(map.ny));
            same(&map, &again);
            usable(map);
        }
        (Err(first), Err(again)) => {
            let text = first.to_string();
            assert_eq!(text, again.to_string());
            assert!(text.len() < 2000 && !text.chars().any(char::is_control), "{text:?}");
        }
        (first, again) => panic!("{first:?} and then {again:?}"),
    }
}

/// Equality by bits, as missing points are NaN.
fn same(a: &RawMap, b: &RawMap) {
    let bits = |map: &RawMap| -> Vec<u64> { map.heights_um.iter().map(|h| h.to_bits()).collect() };
    assert_eq!((a.nx, a.ny, a.dx_um, a.dy_um), (b.nx, b.ny, b.dx_um, b.dy_um));
    assert_eq!(bits(a), bits(b));
    assert_eq!(a.instrument, b.instrument);
}

/// What a reader gives must not break what follows.
fn usable(map: RawMap) {
    if map.heights_um.len() > SMALL {
        return;
    }
    if let Ok(map) = map.into_map(Some(1.0)) {
        let figures = Roughness::of(&Form::Quadratic.removed(&map));
        assert!((0.0..1.0).contains(&figures.missing_fraction));
    }
}

/// Gives bytes to the reader of the standard scan file.
pub fn scan(bytes: &[u8]) {
    let read = || csv::parse(bytes, "scan.csv").map_err(|e| e.to_string());
    assert_eq!(read(), read());
}

/// Gives bytes to the reader of foreign scan files.
pub fn foreign(bytes: &[u8]) {
    for map in ["sigma=a,theta=b,reading=c", "sigma=1,theta=2,reading=3"] {
        let columns: ColumnMap = map.parse().expect("a column map");
        for skip_missing in [false, true] {
            let import = Import {
                columns: columns.clone(),
                quantity: Some(Stated::Bsdf),
                said: Vec::new(),
                selection: Selection::default(),
                skip_missing,
            };
            let read = || import.parse(bytes, "foreign.csv").map_err(|e| e.to_string());
            assert_eq!(read(), read());
        }
    }
}

/// Gives bytes to the reader of model files; what it accepts survives being written.
pub fn model(bytes: &[u8]) {
    if let Ok((model, _)) = Model::parse(bytes) {
        let (again, _) =
            Model::parse(model.to_json().as_bytes()).expect("what was written is read");
        assert_eq!(model, again);
    }
}

/// Gives bytes to the decoder of frames, whole and in pieces; what it accepts encodes to what decodes to
/// the same again.
pub fn frames(bytes: &[u8]) {
    let (mut whole, mut rest) = (Decoder::new(), bytes);
    let (mut count, mut good) = (0, Vec::new());
    while let Some(result) = whole.next(&mut rest) {
        count += 1;
        if let Ok(frame) = result {
            let encoded = encode(&frame);
            let (mut decoder, mut again) = (Decoder::new(), encoded.as_bytes());
            // by its text, as readings may be NaN
            let decoded = decoder.next(&mut again).expect("a frame").expect("a good one");
            assert_eq!(format!("{decoded:?}"), format!("{frame:?}"));
            good.push(format!("{frame:?}"));
        }
    }
    assert!(rest.is_empty() && count <= bytes.len());
    let (mut pieces, mut found) = (Decoder::new(), Vec::new());
    for piece in bytes.chunks(1 + bytes.len() % 7) {
        let mut piece = piece;
        while let Some(result) = pieces.next(&mut piece) {
            found.extend(result.ok().map(|frame| format!("{frame:?}")));
        }
    }
    assert_eq!(found, good);
    assert_eq!((whole.good(), whole.bad()), (pieces.good(), pieces.bad()));
    let _ = Text16::new(&String::from_utf8_lossy(bytes)).as_str();
}

/// Gives a line to the parser of text commands.
pub fn text_command(bytes: &[u8]) {
    for line in bytes.split(|&b| b == b'\n') {
        match scpi::parse(line) {
            Ok(Some(scpi::Command::SetAngles(sigma, theta))) => {
                let line = format!("GON:ANG {:.6},{:.6}", sigma.degrees(), theta.degrees());
                assert_eq!(
                    scpi::parse(line.as_bytes()),
                    Ok(Some(scpi::Command::SetAngles(sigma, theta)))
                );
            }
            Ok(_) => {}
            Err(error) => assert!(error.code().0 < 0),
        }
    }
}

/// Gives bytes to the instrument, some time apart: pieces end at 0xfe, whose next byte says how long nothing comes.
pub fn instrument(bytes: &[u8]) {
    let config = Config { rays: 64, ..Config::demo() };
    let (mut instrument, mut now, mut said) = (Simulator::new(config), Instant(0), 0_usize);
    let mut pieces = bytes.split(|&byte| byte == 0xfe);
    while let Some(piece) = pieces.next() {
        instrument.handle(piece, now, &mut |bytes: &[u8]| said += bytes.len());
        let pause = u64::from(piece.last().copied().unwrap_or(1));
        let until = now.0 + pause * pause * 100;
        for _ in 0..400 {
            match instrument.poll_at() {
                Some(due) if due.0 <= until => {
                    now = Instant(due.0.max(now.0));
                    instrument.handle(&[], now, &mut |bytes: &[u8]| said += bytes.len());
                }
                _ => break,
            }
        }
        now = Instant(until.max(now.0));
    }
    // an answer for a request, points on credit: nothing goes on talking by itself for ever
    assert!(said <= 20_000 + 2000 * bytes.len(), "{said} bytes");
}

/// A file of scatter: never a panic, and what is read has a flux that is a number.
pub fn scatter(bytes: &[u8]) {
    for name in ["file", "file.brdf", "file.ddt"] {
        if let Ok((_, lobes)) = asperity::exchange::read_bytes(name, bytes) {
            for lobe in lobes {
                for incidence in 0..lobe.incidences.len().min(4) {
                    let _ = lobe.flux(incidence, 0);
                }
            }
        }
    }
}
