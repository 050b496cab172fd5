//! A checksum of a few lines, for the build script and the library alike.

/// 64-bit FNV-1a (Fowler, Noll and Vo) of `bytes`; goes on from `start`, at first [`FNV_START`].
pub fn fnv1a(start: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(start, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

/// The offset basis of FNV-1a.
pub const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;
