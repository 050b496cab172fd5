#![no_main]
libfuzzer_sys::fuzz_target!(|data: &[u8]| klieg_fuzz::picture(data));
