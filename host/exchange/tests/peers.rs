//! Files as programs of others read them; `ASPERITY_PEERS=1`, for it needs these programs: see `tests/peers/run`.

#![allow(clippy::print_stdout, reason = "what was compared, and why nothing was")]

use std::path::Path;
use std::process::Command;

#[test]
fn programs_of_others_read_what_was_written() {
    if std::env::var_os("ASPERITY_PEERS").is_none_or(|v| v != "1") {
        println!("skipped: ASPERITY_PEERS=1 has Radiance, Mitsuba and libbsdf read the files");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let written = Command::new(env!("CARGO"))
        .args(["test", "-p", "asperity-exchange", "--lib", "for_peers"])
        .env("ASPERITY_PEER_FILES", folder.path())
        .current_dir(&root)
        .status()
        .unwrap();
    assert!(written.success(), "the files for the other programs were not written");
    let status = Command::new("sh").arg(root.join("tests/peers/run")).arg(folder.path()).status();
    match status.unwrap().code() {
        Some(0) => {}
        Some(3) => panic!("no other program was found: install pyradiance and mitsuba with pip"),
        _ => panic!("another program reads other figures than were written; see above"),
    }
}
