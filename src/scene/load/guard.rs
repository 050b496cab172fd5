//! Decoders of other crates.

use super::Parsed;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a decoder gives; should a broken stream make it panic, that is a fault of the stream.
pub fn guarded<T>(decode: impl FnOnce() -> Parsed<T>) -> Parsed<T> {
    // Nothing that `decode` has changed is looked at after a panic.
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| Err("its stream is broken".into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_fault() {
        assert_eq!(guarded(|| Ok(1)), Ok(1));
        assert!(guarded::<u32>(|| panic!("out of its bounds")).unwrap_err().contains("broken"));
    }
}
