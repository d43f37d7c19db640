//! Version and texts.

use core::ffi::c_char;

use crate::status;

/// Version of the library, as text.
#[unsafe(no_mangle)]
pub extern "C" fn asperity_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}

/// One line of English for a status, also for a number that is none.
#[unsafe(no_mangle)]
pub extern "C" fn asperity_status_text(status: i32) -> *const c_char {
    status::text(status).as_ptr()
}
