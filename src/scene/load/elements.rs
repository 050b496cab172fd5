//! The elements of an accessor as numbers (glTF 2.0, 3.6.2.2).

use gltf::json::accessor::ComponentType;
use std::ops::{Deref, Range};
use std::sync::Arc;

/// Bytes of elements.
pub enum Bytes<'a> {
    /// Of a buffer in memory.
    Borrowed(&'a [u8]),
    /// Read for several uses.
    Shared(Arc<Vec<u8>>),
    /// A part of what several uses share.
    Part(Arc<Vec<u8>>, Range<usize>),
}

impl Deref for Bytes<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Borrowed(bytes) => bytes,
            Self::Shared(bytes) => bytes,
            Self::Part(bytes, range) => &bytes[range.clone()],
        }
    }
}

/// The elements of an accessor.
pub struct Elements<'a> {
    /// All elements lie within.
    pub bytes: Bytes<'a>,
    /// Bytes from one element to the next.
    pub stride: usize,
    /// Number of elements.
    pub count: usize,
    /// Components of an element.
    pub width: usize,
    /// Their type.
    pub component: ComponentType,
    /// Whether integers stand for 0..1 or −1..1.
    pub normalized: bool,
}

impl Elements<'_> {
    /// Number of elements.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of components of an element.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The first `N` components of element `at` as numbers.
    pub fn floats<const N: usize>(&self, at: usize) -> [f32; N] {
        let element = &self.bytes[at * self.stride..];
        let bytes = |k: usize| &element[k * self.component.size()..];
        let one = |k| [bytes(k)[0]];
        let two = |k| [bytes(k)[0], bytes(k)[1]];
        let four = |k| [bytes(k)[0], bytes(k)[1], bytes(k)[2], bytes(k)[3]];
        // glTF 2.0, 3.6.2.2.
        let scale = |limit: f32| if self.normalized { limit } else { 1.0 };
        let low = if self.normalized { -1.0 } else { f32::NEG_INFINITY };
        std::array::from_fn(|k| match self.component {
            ComponentType::F32 => f32::from_le_bytes(four(k)),
            ComponentType::U8 => f32::from(one(k)[0]) / scale(255.0),
            ComponentType::U16 => f32::from(u16::from_le_bytes(two(k))) / scale(65535.0),
            ComponentType::I8 => (f32::from(i8::from_le_bytes(one(k))) / scale(127.0)).max(low),
            ComponentType::I16 => (f32::from(i16::from_le_bytes(two(k))) / scale(32767.0)).max(low),
            ComponentType::U32 => u32::from_le_bytes(four(k)) as f32,
        })
    }

    /// The first `N` components of element `at` as whole numbers.
    pub fn integers<const N: usize>(&self, at: usize) -> [u32; N] {
        let element = &self.bytes[at * self.stride..];
        std::array::from_fn(|k| {
            let bytes = &element[k * self.component.size()..];
            match self.component.size() {
                1 => u32::from(bytes[0]),
                2 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
                _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
            }
        })
    }

    /// Element `at` as an index.
    pub fn index(&self, at: usize) -> u32 {
        self.integers::<1>(at)[0]
    }
}
