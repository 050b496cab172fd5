//! Buffer views: where they lie in their buffers, and elements and images read from them.

use super::Parsed;
use super::files::{Buffer, FilePart};
use gltf::json::buffer::View;
use gltf::json::{Index, Root};
use std::borrow::Cow;
use std::ops::Range;

/// Bytes that are read from a file together where only some of them are kept.
const WINDOW: usize = 1 << 20;

/// The bytes of a whole buffer view, of the `unread` ones that may still be read.
pub fn view_bytes<'a>(
    root: &Root,
    buffers: &'a [Buffer],
    index: Index<View>,
    unread: &mut u64,
) -> Parsed<Cow<'a, [u8]>> {
    let (buffer, start, length) = place(root, buffers, index)?;
    *unread = unread.checked_sub(length).ok_or("the file reads the same bytes too often")?;
    match buffer {
        Buffer::Memory(bytes) => Ok(bytes[start as usize..(start + length) as usize].into()),
        Buffer::File(part) => part.read(start, length).map(Cow::Owned),
    }
}

/// A buffer view's buffer, where it begins there and its length in bytes.
pub fn place<'a>(
    root: &Root,
    buffers: &'a [Buffer],
    index: Index<View>,
) -> Parsed<(&'a Buffer, u64, u64)> {
    let view =
        root.get(index).ok_or_else(|| format!("bufferViews[{}] is not there", index.value()))?;
    let (offset, length) = (view.byte_offset.map_or(0, |offset| offset.0), view.byte_length.0);
    let buffer = part(buffers, view.buffer.value(), offset, length)
        .map_err(|fault| format!("bufferViews[{}]: {fault}", index.value()))?;
    Ok((buffer, offset, length))
}

/// A buffer that has `length` bytes at `offset`.
pub fn part(buffers: &[Buffer], number: usize, offset: u64, length: u64) -> Parsed<&Buffer> {
    let buffer = buffers.get(number).ok_or_else(|| format!("buffers[{number}] is not there"))?;
    let end = offset.checked_add(length).filter(|&end| end <= buffer.len());
    end.ok_or_else(|| format!("lies outside buffers[{number}] of {} bytes", buffer.len()))?;
    Ok(buffer)
}

/// Where `count` elements of `size` bytes, `stride` apart, lie in a view of `length` bytes if the first
/// stands at `offset`, and their stride.
pub fn within(
    view: Index<View>,
    length: u64,
    offset: u64,
    count: usize,
    size: usize,
    stride: usize,
) -> Parsed<(Range<u64>, usize)> {
    if stride < size {
        return Err(format!("elements of {size} bytes overlap at a byteStride of {stride}"));
    }
    let span = (count as u64)
        .checked_sub(1)
        .map_or(Some(0), |last| last.checked_mul(stride as u64)?.checked_add(size as u64));
    let end = span.and_then(|span| span.checked_add(offset));
    let (Some(span), Some(0..)) = (span, end.and_then(|end| length.checked_sub(end))) else {
        return Err(format!(
            "{count} elements at byte {offset} do not fit in bufferViews[{}] of {length} bytes",
            view.value(),
        ));
    };
    // With no elements the offset may lie anywhere; with one, its stride means nothing.
    let offset = if count == 0 { 0 } else { offset };
    Ok((offset..offset + span, if count > 1 { stride } else { size }))
}

/// Elements of a file, all within it, copied out of their stride.
pub fn tight_from_file(
    part: &FilePart,
    offset: u64,
    stride: usize,
    size: usize,
    count: usize,
) -> Parsed<Vec<u8>> {
    if stride == size {
        return part.read(offset, count as u64 * size as u64);
    }
    let mut tight = Vec::with_capacity(count * size);
    let together = WINDOW.div_ceil(stride).min(count);
    let mut window = vec![0; (together - 1) * stride + size];
    for first in (0..count).step_by(together) {
        let number = together.min(count - first);
        let window = &mut window[..(number - 1) * stride + size];
        part.fill(offset + first as u64 * stride as u64, window)?;
        for element in window.chunks(stride) {
            tight.extend_from_slice(&element[..size]);
        }
    }
    Ok(tight)
}

/// Elements in memory copied out of their stride.
pub fn tight(bytes: &[u8], stride: usize, size: usize, count: usize) -> Parsed<Vec<u8>> {
    let length = count.checked_mul(size).ok_or("its count is too great")?;
    let mut tight = Vec::with_capacity(length);
    for i in 0..count {
        tight.extend_from_slice(&bytes[i * stride..][..size]);
    }
    Ok(tight)
}
