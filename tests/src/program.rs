//! Where the programs of the workspace are.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::time::SystemTime;

/// The path of a program, `TARGET/PROFILE/NAME` beside the test executable `TARGET/PROFILE/deps/TEST-HASH`.
///
/// It is built first where it is missing or older than its sources: Cargo builds a binary for the
/// integration tests of its own package only.
///
/// # Errors
/// What went wrong, in words.
pub fn path(name: &str, test: &str) -> Result<PathBuf, String> {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _one = ONE_AT_A_TIME.lock();
    let executable = std::env::current_exe().map_err(|e| format!("where is this test? {e}"))?;
    let folder = executable.parent().filter(|f| f.ends_with("deps")).and_then(Path::parent);
    let folder =
        folder.ok_or_else(|| format!("{} is not in a deps folder", executable.display()))?;
    let path = folder.join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    let built = fs::metadata(&path).and_then(|m| m.modified()).ok();
    if built.is_some_and(|built| built >= newest_source()) {
        return Ok(path);
    }
    let profile = match folder.file_name().and_then(OsStr::to_str) {
        Some("debug") | None => "dev",
        Some(name) => name,
    };
    let target = folder.parent().ok_or("there is no target folder")?;
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    // Naming the workspace and this test gives the crates the features with which `cargo test` has built
    // them already: only the program itself is left to do.
    let done = Command::new(cargo)
        .args(["build", "--workspace", "--bin", name, "--test", test])
        .args(["--profile", profile, "--target-dir"])
        .arg(target)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .map_err(|e| format!("cargo cannot be run: {e}"))?;
    if done.status.success() && path.exists() {
        Ok(path)
    } else {
        let log = String::from_utf8_lossy(&done.stderr);
        Err(format!("the program {name} cannot be built:\n{log}"))
    }
}

/// When a file that the programs are made of was last changed; the epoch where there are none.
fn newest_source() -> SystemTime {
    fn newest(path: &Path) -> SystemTime {
        let Ok(meta) = fs::metadata(path) else { return SystemTime::UNIX_EPOCH };
        if meta.is_file() {
            return meta.modified().unwrap_or(SystemTime::UNIX_EPOCH);
        }
        let entries = fs::read_dir(path).into_iter().flatten().flatten();
        entries.map(|e| newest(&e.path())).max().unwrap_or(SystemTime::UNIX_EPOCH)
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."));
    let crates = ["core", "host", "firmware-sim"];
    let sources = crates.iter().flat_map(|c| [format!("{c}/Cargo.toml"), format!("{c}/src")]);
    let all = sources.chain(["Cargo.toml".to_owned(), "Cargo.lock".to_owned()]);
    all.map(|p| newest(&root.join(p))).max().unwrap_or(SystemTime::UNIX_EPOCH)
}
