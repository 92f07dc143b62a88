//! Strips the symbols of the library, which makes the wheel five times smaller.
//!
//! The flag is set here and not in maturin, because maturin's own flag would recompile this crate
//! at each alternation with cargo.

fn main() {
    println!("cargo::rustc-cdylib-link-arg=-s");
    println!("cargo::rerun-if-changed=build.rs");
}
