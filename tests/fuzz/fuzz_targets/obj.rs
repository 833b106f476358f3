//! Feeds any bytes to one of the readers.
#![no_main]

#[path = "../readers.rs"]
#[allow(dead_code, reason = "each target uses a part of this")]
mod readers;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    readers::obj(data);
});
