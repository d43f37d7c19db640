//! Devices that are not what they should be: a clear error in the stated time, and no hang.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use asperity::acquire::Patience;
use asperity_core::protocol::{Decoder, Message, Request, checksum};
use rand_core::Rng as _;
use rand_pcg::Pcg64Mcg;

use crate::bench::folder;
use crate::programs::{Ended, Instrument, run, start, wait};

/// A device on a TCP port of its own; `serve` has each connection in turn.
fn device(serve: impl Fn(TcpStream) + Send + 'static) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = format!("tcp:{}", listener.local_addr().unwrap());
    std::thread::spawn(move || listener.incoming().flatten().for_each(serve));
    port
}

/// An acquisition from that device, which has to fail in time and in little memory.
fn refused(port: &str, words: &[&str]) -> Ended {
    let folder = folder();
    let done = run(folder.path(), &format!("acquire --port {port} -o scan.csv"));
    assert_eq!(done.code, Some(1), "{done:?}");
    for word in words {
        assert!(done.err.contains(word), "no `{word}` in {done:?}");
    }
    assert!(done.err.trim().lines().count() <= 2, "{done:?}");
    // what is stated, and a second for a busy machine
    let limit = Patience::default().identify + Duration::from_secs(1);
    assert!(done.time < limit, "{done:?}");
    assert!(done.memory < 48 << 20, "{done:?}");
    assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none(), "it left files");
    done
}

#[test]
fn a_device_of_another_kind() {
    let port = device(|mut stream| {
        let mut buffer = [0; 256];
        while stream.read(&mut buffer).is_ok_and(|n| n > 0) {
            drop(stream.write_all(b"ERROR 17: unknown command\r\n"));
        }
    });
    refused(&port, &[&port, "no instrument of this kind", "ERROR 17", "--baud"]);
}

#[test]
fn a_device_that_echoes() {
    let port = device(|mut stream| {
        let mut buffer = [0; 256];
        while let Ok(count @ 1..) = stream.read(&mut buffer) {
            drop(stream.write_all(&buffer[..count]));
        }
    });
    refused(&port, &[&port, "no instrument of this kind"]);
}

#[test]
fn a_device_that_never_answers() {
    let port = device(|mut stream| {
        let mut buffer = [0; 256];
        while stream.read(&mut buffer).is_ok_and(|n| n > 0) {}
    });
    let done = refused(&port, &[&port, "no answer within 5", "cable"]);
    assert!(done.time > Duration::from_secs(4), "it gave up early: {done:?}");
}

#[test]
fn a_device_that_streams_garbage_at_full_speed() {
    let port = device(|mut stream| {
        let mut generator = Pcg64Mcg::new(9);
        let garbage: Vec<u8> = (0..1 << 20).map(|_| generator.next_u32() as u8).collect();
        while stream.write_all(&garbage).is_ok() {}
    });
    refused(&port, &[&port, "no instrument of this kind", "broken frames"]);
}

/// A frame by hand: the library cannot make one of another version.
fn frame(payload: &[u8]) -> Vec<u8> {
    let whole = [payload, &checksum(payload).to_le_bytes()].concat();
    let mut out = vec![0];
    for block in whole.split(|&byte| byte == 0) {
        out.push(block.len() as u8 + 1);
        out.extend_from_slice(block);
    }
    out.push(0);
    out
}

/// postcard's varint.
fn varint(mut n: u16) -> Vec<u8> {
    let mut out = Vec::new();
    while n > 127 {
        out.push(n as u8 | 128);
        n >>= 7;
    }
    out.push(n as u8);
    out
}

#[test]
fn a_device_of_another_version() {
    let port = device(|mut stream| {
        let (mut decoder, mut buffer) = (Decoder::new(), [0; 256]);
        while let Ok(count @ 1..) = stream.read(&mut buffer) {
            let mut rest = &buffer[..count];
            while let Some(result) = decoder.next(&mut rest) {
                let Ok(asked) = result else { continue };
                if asked.message == Message::Request(Request::Identify) {
                    let head = [varint(asked.session), varint(asked.sequence)].concat();
                    let body = [&head[..], &[1, 0], &varint(7), b"laid out otherwise"].concat();
                    drop(stream.write_all(&frame(&body)));
                }
            }
        }
    });
    let done = refused(&port, &[&port, "protocol version 7", "this program version 1"]);
    assert!(done.time < Duration::from_secs(2), "{done:?}");
}

#[test]
fn a_port_that_is_not_there() {
    let folder = folder();
    for port in ["/dev/no-such-port", "tcp:127.0.0.1:1", "tcp:nowhere", ""] {
        let arguments = ["acquire", "--port", port, "-o", "scan.csv"];
        let mut command = crate::programs::asperity(folder.path(), "");
        let child = command.args(arguments).spawn().unwrap();
        let done = wait(child, port);
        assert!(matches!(done.code, Some(1 | 2)), "{done:?}");
        assert!(done.err.contains(port) && done.time < Duration::from_secs(6), "{done:?}");
    }
}

/// A slow scan in one client, and another one that comes in between.
fn two_clients(line: &str, word: &str) {
    let (folder, instrument) =
        (folder(), Instrument::start(&format!("{line} --rays 2000 --acceleration 4")));
    let folder = folder.path();
    let schedule = "--sigma 0 --theta-range -10:10 --step 0.2 --integration-ms 300 --sample two \
                --ior 1.49 --rough-side source";
    let first =
        start(folder, &format!("acquire --port {} -o first.csv {schedule}", instrument.port));
    let begun = Instant::now();
    while !folder.join("first.csv.journal").exists() {
        assert!(begun.elapsed() < Duration::from_secs(20), "the first client does not begin");
        std::thread::sleep(Duration::from_millis(5));
    }
    let second = run(folder, &format!("acquire --port {} -o second.csv", instrument.port));
    assert_eq!(second.code, Some(1), "{second:?}");
    assert!(second.err.contains(word), "no `{word}` in {second:?}");
    assert!(second.time < Duration::from_secs(7), "{second:?}");
    let first = wait(first, "the first client").ok();
    assert!(first.err.is_empty() && folder.join("first.csv").exists(), "{first:?}");
    assert!(!folder.join("second.csv").exists() && !folder.join("second.csv.journal").exists());
}

#[test]
fn two_clients_on_one_terminal() {
    two_clients("--pty", "in use by another program");
}

#[test]
fn two_clients_of_one_network_port() {
    two_clients("--tcp 127.0.0.1:0", "another client is using the instrument");
}
