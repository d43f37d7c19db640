//! What is wrong in a call from C comes back as a status, without a step outside its memory.

use std::process::Command;

use asperity_needs::absent;

use crate::tools::{program, run};

#[test]
fn hostile_calls_come_back_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let source = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("capi/hostile.c");
    let binary = folder.path().join("hostile");
    if let Err(remedy) = program(&source, &binary) {
        return absent(&remedy);
    }
    run(&mut Command::new(&binary), "").unwrap();
    if let Err(remedy) = valgrind(&binary) {
        absent(&remedy);
    }
}

/// Runs a program under Valgrind, which must find neither an error nor a leak.
pub(crate) fn valgrind(binary: &std::path::Path) -> Result<String, String> {
    let mut command = Command::new("valgrind");
    command.args(["--error-exitcode=99", "--leak-check=full", "--show-leak-kinds=all"]);
    command.args(["--errors-for-leak-kinds=all", "--track-origins=yes"]).arg(binary);
    let out = run(&mut command, "valgrind")?;
    Ok(String::from_utf8_lossy(&out.stderr).into_owned())
}
