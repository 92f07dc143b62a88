#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| atas_fuzz::run_one("remote-frames", input));
