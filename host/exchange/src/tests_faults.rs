//! Malformed files.
