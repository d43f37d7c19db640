//! Libraries, compilers and programs of these tests. An `Err` is a missing tool, with its remedy.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// The device.
pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";

/// The folder of the crate.
pub(crate) fn capi() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("host").join("capi")
}

/// Runs a command that must end well.
pub(crate) fn run(command: &mut Command, package: &str) -> Result<Output, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let out = match command.output() {
        Ok(out) => out,
        Err(e) if e.kind() == ErrorKind::NotFound => {
            return Err(format!("no {name}; on Debian: apt-get install {package}"));
        }
        Err(e) => panic!("cannot start {name}: {e}"),
    };
    let said = [&out.stdout, &out.stderr].map(|text| String::from_utf8_lossy(text));
    assert!(out.status.success(), "{command:?} failed:\n{}{}", said[0], said[1]);
    Ok(out)
}

/// Builds the static library once for this machine.
pub(crate) fn host_library() -> &'static Path {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let dir = build(&["--release"], "");
        dir.join("release").join("libasperity_capi.a")
    })
}

/// What a library for the device answers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Scope {
    /// Both lobes from both sides.
    Whole,
    /// What a detector behind a plate sees: light from the air, transmitted.
    Transmission,
}

/// Builds it once for the device, with 16-bit tables.
pub(crate) fn device_library(scope: Scope) -> Result<&'static Path, String> {
    static LIBRARIES: OnceLock<Result<[PathBuf; 2], String>> = OnceLock::new();
    let built = LIBRARIES.get_or_init(|| {
        let settings = std::env::var("ASPERITY_DEVICE_ENV").unwrap_or_default();
        if settings.is_empty() && !target_is_installed() {
            return Err(format!("no Rust target {TARGET}; install it: rustup target add {TARGET}"));
        }
        let one = |name: &str, scope: &str| {
            let features = format!("panic-handler,table-u16,{scope}");
            let profile = ["--profile", "firmware", "--target", TARGET];
            let choice = ["--no-default-features", "--features", &features];
            let dir = build(&[&profile[..], &choice[..]].concat(), &settings);
            // the next one has the same name
            let own = dir.join(name);
            let made = dir.join(TARGET).join("firmware").join("libasperity_capi.a");
            std::fs::copy(made, &own).unwrap();
            own
        };
        Ok([
            one("whole.a", "air,dielectric,reflection,transmission"),
            one("transmission.a", "air,transmission"),
        ])
    });
    let [whole, transmission] = built.as_ref().map_err(String::clone)?;
    Ok(match scope {
        Scope::Whole => whole,
        Scope::Transmission => transmission,
    })
}

fn build(arguments: &[&str], settings: &str) -> PathBuf {
    // A directory of its own: the outer cargo holds the lock of the other one.
    let dir = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("capi");
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .current_dir(capi())
        .args(["rustc", "--lib", "--crate-type", "staticlib", "--target-dir"])
        .arg(&dir)
        .args(arguments)
        .envs(settings.split_whitespace().filter_map(|s| s.split_once('=')));
    // flags meant for the tests, such as those of a coverage run
    for name in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET"] {
        cargo.env_remove(name);
    }
    run(&mut cargo, "cargo").unwrap();
    dir
}

fn target_is_installed() -> bool {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let out = Command::new(rustc).args(["--print", "target-libdir", "--target", TARGET]).output();
    out.is_ok_and(|o| Path::new(String::from_utf8_lossy(&o.stdout).trim()).is_dir())
}

/// A compiler with the strictest settings and the headers of the crate.
pub(crate) fn compiler(name: &str, standard: &str) -> Command {
    let mut compiler = Command::new(name);
    compiler
        .arg(format!("-std={standard}"))
        .args(["-Wall", "-Wextra", "-Werror", "-pedantic"])
        .arg("-I")
        .arg(capi().join("include"))
        .arg("-I")
        .arg(capi().join("examples"));
    compiler
}

/// Compiles a source file for this machine and links the library.
pub(crate) fn program(source: &Path, to: &Path) -> Result<(), String> {
    let cpp = source.extension().is_some_and(|e| e == "cpp");
    let (name, standard) = if cpp { ("c++", "c++11") } else { ("cc", "c99") };
    let mut compiler = compiler(name, standard);
    compiler.args(["-O1", "-g"]).arg(source).arg("-o").arg(to).arg(host_library());
    run(compiler.args(["-lm", "-lpthread", "-ldl"]), "g++").map(drop)
}
