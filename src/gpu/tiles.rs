//! tiles
/// Invocations of a work group.
pub const GROUP: u32 = 256;
