//! The header is what `cbindgen` makes of the crate.

use crate::tools::capi;

#[test]
fn the_header_in_the_repository_is_that_of_the_crate() {
    let config = cbindgen::Config::from_file(capi().join("cbindgen.toml")).unwrap();
    let bindings = cbindgen::generate_with_config(capi(), config).unwrap();
    let mut fresh = Vec::new();
    bindings.write(&mut fresh);
    let path = capi().join("include/asperity.h");
    if std::env::var_os("ASPERITY_BLESS").is_some() {
        std::fs::write(&path, &fresh).unwrap();
    }
    let kept = std::fs::read(&path).unwrap_or_default();
    assert!(
        kept == fresh,
        "include/asperity.h is not that of the crate; make it anew: \
         ASPERITY_BLESS=1 cargo test -p asperity-tests --test capi header"
    );
}
