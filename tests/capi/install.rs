//! The library as it is installed, used as README.md of `host/capi` says: its own commands, in a folder of their own.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use asperity_core::bsdf::{Bsdf, Ggx};
use asperity_core::direction::Direction;
use asperity_core::math::Fast;
use asperity_core::quantity::{Alpha, RelativeIor};
use asperity_needs::absent;

use crate::tools::{capi, run};

/// Where the library is installed, once; the folder is never removed before the tests end.
fn prefix() -> &'static Path {
    static PREFIX: OnceLock<PathBuf> = OnceLock::new();
    PREFIX.get_or_init(|| {
        let prefix = Path::new(env!("CARGO_TARGET_TMPDIR")).join("installed");
        drop(std::fs::remove_dir_all(&prefix));
        let mut install = Command::new("bash");
        install.arg(capi().join("install")).arg(&prefix).env("CARGO", env!("CARGO"));
        // the folder of the other builds for these tests
        install
            .env("CARGO_TARGET_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("capi"));
        for name in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_TARGET", "DESTDIR"] {
            install.env_remove(name);
        }
        run(&mut install, "bash").unwrap();
        prefix
    })
}

fn readme() -> String {
    std::fs::read_to_string(capi().join("README.md")).unwrap()
}

/// The blocks of the README in a language.
fn blocks(language: &str) -> Vec<String> {
    let text = readme();
    let fence = format!("```{language}\n");
    let found = text.split(&fence).skip(1).filter_map(|rest| rest.split_once("```"));
    found.map(|(block, _)| block.to_owned()).collect()
}

/// A program that a test needs.
fn is_there(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output().is_ok();
    if !found {
        absent(&format!("no {program}; on Debian: apt-get install {program}"));
    }
    found
}

/// What the README's program prints.
fn expected() -> String {
    let law = Ggx::new(Alpha::new(Fast(0.25_f32)).unwrap(), RelativeIor::new(Fast(1.49)).unwrap());
    let direction = |[x, y, z]: [f32; 3]| Direction::new(Fast(x), Fast(y), Fast(z)).unwrap();
    let f = law.eval(direction([0.6, 0.0, 0.8]), direction([-0.4, 0.0, -0.9])).0;
    format!("f = {f:.4} 1/sr\n")
}

#[test]
fn the_commands_of_the_readme_compile_and_run() {
    if !is_there("pkg-config") || !is_there("cc") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("demo.c"), &blocks("c")[0]).unwrap();
    let commands = blocks("sh");
    let (install, uses) = commands.split_first().unwrap();
    assert!(install.contains("bash host/capi/install \"$PREFIX\""), "{install}");
    assert_eq!(uses.len(), 2, "shared and static");
    let setting = install.lines().last().unwrap();
    for commands in uses {
        let mut shell = Command::new("sh");
        shell.args(["-ec", &format!("{setting}\n{commands}")]).current_dir(folder.path());
        let out = run(shell.env("PREFIX", prefix()), "pkg-config").unwrap();
        assert_eq!(String::from_utf8_lossy(&out.stdout), expected(), "{commands}");
    }
}

#[test]
fn an_installed_library_may_be_moved() {
    if !is_there("pkg-config") || !is_there("cc") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let moved = folder.path().join("else where");
    let mut copy = Command::new("cp");
    run(copy.arg("-a").arg(prefix()).arg(&moved), "coreutils").unwrap();
    std::fs::write(folder.path().join("demo.c"), &blocks("c")[0]).unwrap();
    // a path with a space needs the quotes that `eval` undoes
    let commands = "eval \"cc demo.c -o demo $(pkg-config --cflags --libs asperity)\"; ./demo";
    let mut shell = Command::new("sh");
    shell.args(["-ec", commands]).current_dir(folder.path());
    let out = run(shell.env("PKG_CONFIG_PATH", moved.join("lib/pkgconfig")), "pkg-config").unwrap();
    assert_eq!(String::from_utf8_lossy(&out.stdout), expected());
}

#[test]
fn cmake_finds_the_library() {
    if !is_there("cmake") || !is_there("cc") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("demo.c"), &blocks("c")[0]).unwrap();
    let shared = &blocks("cmake")[0];
    for (name, lists) in [
        ("shared", shared.clone()),
        ("static", shared.replace("asperity::asperity", "asperity::static")),
    ] {
        std::fs::write(folder.path().join("CMakeLists.txt"), lists).unwrap();
        let mut configure = Command::new("cmake");
        configure.current_dir(folder.path()).args(["-S", ".", "-B", name]);
        run(configure.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix().display())), "cmake").unwrap();
        let mut build = Command::new("cmake");
        run(build.current_dir(folder.path()).args(["--build", name]), "cmake").unwrap();
        let out = run(&mut Command::new(folder.path().join(name).join("demo")), "").unwrap();
        assert_eq!(String::from_utf8_lossy(&out.stdout), expected(), "{name}");
    }
}
