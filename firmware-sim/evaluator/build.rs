//! Links the bare-metal program by cortex-m-rt's script and the board's `memory.x`; nothing on a host.

fn main() {
    println!("cargo:rerun-if-changed=../memory.x");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        let here = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
        println!("cargo:rustc-link-search={here}/..");
        println!("cargo:rustc-link-arg-bins=-Tlink.x");
    }
}
