//! Empty replacement of the crate `bindgen`.
//!
//! The build scripts of iceoryx2 call bindgen on QNX hosts only, but Cargo builds it on every
//! host. This crate saves 14 crates and about a minute of processor time. On another host than
//! Linux, remove `[patch.crates-io]` from the workspace manifest.
