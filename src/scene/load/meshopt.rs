//! Buffer views compressed by `EXT_meshopt_compression` or `KHR_meshopt_compression`.

use super::Parsed;
use meshoptimizer_rs::{Limits, Workspace, codec};
use serde::Deserialize;

/// The extensions, of which the second adds to the first a newer vertex codec and the filter `COLOR`.
pub const EXTENSIONS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// How a buffer view is stored.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Compressed {
    /// Index of the buffer with the stream.
    pub buffer: usize,
    /// Where the stream begins there, in bytes.
    #[serde(default)]
    pub byte_offset: u64,
    /// Bytes of the stream.
    pub byte_length: u64,
    /// Bytes of a decoded element.
    pub byte_stride: usize,
    /// Number of elements.
    pub count: usize,
    /// What the elements are.
    pub mode: Mode,
    /// What was done to them before.
    #[serde(default)]
    pub filter: Filter,
}

/// What the elements of a stream are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
pub enum Mode {
    /// Of vertices or instances.
    Attributes,
    /// Corners of triangles.
    Triangles,
    /// Indices of any meaning.
    Indices,
}

/// What a decoded stream goes through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Default)]
#[serde(rename_all = "UPPERCASE")]
pub enum Filter {
    /// Nothing.
    #[default]
    None,
    /// Unit vectors.
    Octahedral,
    /// Rotations.
    Quaternion,
    /// Floats.
    Exponential,
    /// Colours.
    Color,
}

/// Undoes a filter in place, for a number of elements of so many bytes.
type Undo = fn(&mut [u8], usize, usize, &mut Workspace) -> Result<(), meshoptimizer_rs::Error>;

impl Compressed {
    /// Bytes that it decodes to, at most `most`.
    pub fn decoded_length(&self, most: u64) -> Parsed<u64> {
        let length = (self.count as u64).checked_mul(self.byte_stride as u64);
        length.filter(|&length| length <= most).ok_or_else(|| {
            let Self { count, byte_stride, .. } = self;
            format!("{count} elements of {byte_stride} bytes are more than klieg decodes of the file's size")
        })
    }

    /// Decodes the stream; its size must have been checked.
    pub fn decode(&self, stream: &[u8]) -> Parsed<Vec<u8>> {
        let limits = Limits { max_bytes: usize::MAX, max_work: u64::MAX };
        let workspace = &mut Workspace::new(limits);
        let Self { count, byte_stride: stride, .. } = *self;
        let decode = match self.mode {
            Mode::Attributes => codec::decode_vertex_buffer,
            Mode::Triangles => codec::decode_index_buffer,
            Mode::Indices => codec::decode_index_sequence,
        };
        let filter: Option<Undo> = match self.filter {
            Filter::None => None,
            Filter::Octahedral => Some(codec::decode_filter_oct),
            Filter::Quaternion => Some(codec::decode_filter_quat),
            Filter::Exponential => Some(codec::decode_filter_exp),
            Filter::Color => Some(codec::decode_filter_color),
        };
        let fault = |error| format!("its compressed stream cannot be decoded: {error}");
        let mut bytes = decode(count, stride, stream, workspace).map_err(fault)?;
        if let Some(filter) = filter {
            filter(&mut bytes, count, stride, workspace).map_err(fault)?;
        }
        Ok(bytes)
    }
}
