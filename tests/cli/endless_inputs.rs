//! Folders, devices without an end and pipes that go on for ever, given where a file is wanted: an error in a line
//! or two, in little memory.

use std::io::Write as _;
use std::process::{Command, Stdio};

use crate::program::{Done, Folder, program};

/// Most address space of the program, KiB.
const MOST_KIB: u32 = 1 << 20;

/// Every place where a file is read, with `@` for it; text and numbers, maps apart, may come through a pipe.
const READERS: [&str; 13] = [
    "acquire --dry-run --schedule @",
    "check @",
    "eval @ --input pairs.csv",
    "eval model.json --input @",
    "scan @ --sigma 0 -o out.csv",
    "fit @ --method ggx --ior 1.49",
    "compare @ -o out",
    "tabulate @ --bytes 4096 -o out.bsdft",
    "trade @",
    "stats @",
    "fit scan.csv --map @ --pixel-um 1 --method measured-ray --ior 1.49",
    "compare scan.csv --map @ --ior 1.49 -o out",
    "check --map @ --pixel-um 1 --ior 1.49",
];

fn folder() -> Folder {
    let folder = Folder::new();
    folder.run("model ggx --set alpha=0.2 --ior 1.49 -o model.json").ok();
    folder.run("scan model.json --sigma 0 -o scan.csv").ok();
    folder.write("pairs.csv", "wix,wiy,wiz,wox,woy,woz\n0,0,1,0,0,1\n");
    folder
}

/// A run in little memory; what is fed to its `/dev/stdin`, again and again.
fn run(folder: &Folder, line: &str, fed: &[u8]) -> Done {
    let script = format!("ulimit -v {MOST_KIB}; exec \"$0\" {line}");
    let mut command = Command::new("sh");
    command.args(["-c", &script]).arg(program()).current_dir(folder.path(""));
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let fed = fed.to_vec();
    // ends when nobody reads any more
    let feeder =
        std::thread::spawn(move || while !fed.is_empty() && pipe.write_all(&fed).is_ok() {});
    let done = Done::from(child.wait_with_output().unwrap());
    feeder.join().unwrap();
    done
}

fn refused(folder: &Folder, line: &str, file: &str, fed: &[u8]) {
    let line = line.replace('@', file);
    let before = folder.names();
    let done = run(folder, &line, fed).with_code(2);
    assert!(done.err.contains(file), "`{line}`: {}", done.err);
    assert!(done.err.trim().lines().count() <= 2 && done.err.len() < 500, "`{line}`: {}", done.err);
    assert!(!done.err.contains("memory"), "`{line}`: {}", done.err);
    assert_eq!(folder.names(), before, "`{line}`");
}

#[test]
fn devices_without_an_end_and_folders_are_no_files() {
    let folder = folder();
    for line in READERS {
        refused(&folder, line, "/dev/zero", &[]);
        refused(&folder, line, "/", &[]);
    }
}

#[test]
fn a_pipe_that_goes_on_for_ever_ends_at_the_limit_of_what_is_read() {
    let folder = folder();
    let lines = b"# a line of a plan, a scan or a model that goes on for ever\n".repeat(500);
    for line in &READERS[..3] {
        refused(&folder, line, "/dev/stdin", &lines);
    }
}
