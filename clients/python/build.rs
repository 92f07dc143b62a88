//! The library goes into a wheel, where nobody looks for lines: without symbols it is a fifth of the size. It is told here and not to
//! maturin, whose own way would have this crate compiled anew each time that cargo and maturin take turns.

fn main() {
    println!("cargo::rustc-cdylib-link-arg=-s");
    println!("cargo::rerun-if-changed=build.rs");
}
