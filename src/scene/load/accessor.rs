//! Accessors (glTF 2.0, 3.6.2), every bound checked before anything is read. Buffers that lie in files
//! are read accessor by accessor, so that a scene and its file are never in memory together.

use super::Parsed;
use super::files::{Buffer, FilePart};
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::buffer::View;
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::ops::Deref;
use std::sync::Arc;

/// Most vertices and indices that a file's meshes may read, each use counted. That a file may not
/// read many times what its buffers hold bounds time and memory for those in which a few bytes
/// stand for much, as shared and sparse accessors can.
const MAX_ELEMENTS: u64 = 1 << 29;
/// The same for each byte of its buffers, and without any.
const ELEMENTS_OF_BYTES: (u64, u64) = (8, 1 << 22);

/// Most bytes read from a file, for each that it has: a vertex's attributes may lie side by side, and
/// each is read by itself.
const READS_OF_BYTES: u64 = 64;

/// Bytes that are read from a file together where only some of them are kept.
const WINDOW: usize = 1 << 20;

/// Components of attributes, KHR_mesh_quantization included.
pub const NUMBERS: &[ComponentType] = &[
    ComponentType::F32,
    ComponentType::I8,
    ComponentType::U8,
    ComponentType::I16,
    ComponentType::U16,
];
/// Components of indices.
pub const INDICES: &[ComponentType] = &[ComponentType::U8, ComponentType::U16, ComponentType::U32];

/// Reads the accessors of a file.
pub struct Accessors<'a> {
    root: &'a Root,
    buffers: &'a [Buffer],
    /// Elements that may still be used.
    left: Cell<u64>,
    /// Bytes that may still be read from files.
    unread: Cell<u64>,
    /// How often each slice is used.
    uses: HashMap<Slice, u32>,
    /// What has been read from files to be used again.
    shared: RefCell<HashMap<Slice, Arc<Vec<u8>>>>,
}

/// Elements of a buffer view.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Slice {
    view: usize,
    offset: u64,
    count: usize,
    /// Bytes of an element.
    size: usize,
}

/// Bytes of elements.
enum Bytes<'a> {
    Borrowed(&'a [u8]),
    Shared(Arc<Vec<u8>>),
}

impl Deref for Bytes<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Borrowed(bytes) => bytes,
            Self::Shared(bytes) => bytes,
        }
    }
}

/// What a use of an accessor asks of it.
pub struct Wanted<'w> {
    /// Element types.
    pub types: &'w [Type],
    /// Component types.
    pub components: &'w [ComponentType],
    /// Whether integers stand for 0..1 or −1..1 even where the accessor does not say so.
    pub normalized: bool,
}

/// The elements of an accessor.
pub struct Elements<'a> {
    bytes: Bytes<'a>,
    stride: usize,
    count: usize,
    width: usize,
    component: ComponentType,
    normalized: bool,
}

impl<'a> Accessors<'a> {
    /// Accessors of a file whose buffers are `buffers`.
    pub fn new(root: &'a Root, buffers: &'a [Buffer]) -> Self {
        let bytes: u64 = buffers.iter().map(Buffer::len).sum();
        let (each, least) = ELEMENTS_OF_BYTES;
        Self {
            root,
            buffers,
            left: Cell::new(MAX_ELEMENTS.min(each * bytes + least)),
            unread: Cell::new(READS_OF_BYTES * bytes),
            uses: uses(root),
            shared: RefCell::default(),
        }
    }

    /// Takes `count` elements off what may still be read.
    pub fn charge(&self, count: usize) -> Parsed<()> {
        let left = self.left.get().checked_sub(count as u64).ok_or_else(|| {
            "the file's meshes have more vertices and indices than klieg reads of its size"
                .to_owned()
        })?;
        self.left.set(left);
        Ok(())
    }

    /// Opens an accessor; nothing is allocated but for sparse ones.
    pub fn open(&self, index: Index<Accessor>, wanted: &Wanted) -> Parsed<Elements<'a>> {
        self.open_checked(index, wanted)
            .map_err(|fault| format!("accessors[{}]: {fault}", index.value()))
    }

    fn open_checked(&self, index: Index<Accessor>, wanted: &Wanted) -> Parsed<Elements<'a>> {
        let accessor = self.root.get(index).ok_or("is not there")?;
        let (Checked::Valid(component), Checked::Valid(element)) =
            (accessor.component_type, accessor.type_)
        else {
            return Err("its type or component type is none of glTF's".into());
        };
        let component = component.0;
        if !wanted.components.contains(&component) || !wanted.types.contains(&element) {
            return Err(format!("elements {element:?} of {component:?} cannot be used here"));
        }
        let width = element.multiplicity();
        let size = width * component.size();
        let count = usize::try_from(accessor.count.0).map_err(|_| "its count is too great")?;
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let (mut bytes, mut stride) = match accessor.buffer_view {
            Some(view) => self.slice(view, offset, count, size)?,
            // Zeros: the same ones for all elements.
            None => (Bytes::Borrowed(&[0; 64][..]), 0),
        };
        if let Some(sparse) = &accessor.sparse {
            self.charge(count)?;
            let mut patched = tight(&bytes, stride, size, count)?;
            self.patch(&mut patched, sparse, size).map_err(|fault| format!("sparse: {fault}"))?;
            bytes = Bytes::Shared(patched.into());
            stride = size;
        }
        let normalized = accessor.normalized || wanted.normalized;
        Ok(Elements { bytes, stride, count, width, component, normalized })
    }

    /// The elements of a view, beginning at `offset`, and their stride; all `count` lie within.
    fn slice(
        &self,
        view: Index<View>,
        offset: u64,
        count: usize,
        size: usize,
    ) -> Parsed<(Bytes<'a>, usize)> {
        let (buffer, start, length) = place(self.root, self.buffers, view)?;
        let stride = self.root.get(view).and_then(|view| view.byte_stride).map_or(size, |s| s.0);
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
        let offset = start + if count == 0 { 0 } else { offset };
        let stride = if count > 1 { stride } else { size };
        match buffer {
            Buffer::Memory(bytes) => {
                let bytes = &bytes[offset as usize..(offset + span) as usize];
                Ok((Bytes::Borrowed(bytes), stride))
            }
            Buffer::File(part) => {
                let slice = Slice { view: view.value(), offset: offset - start, count, size };
                let shared = self.shared.borrow().get(&slice).cloned();
                if let Some(bytes) = shared {
                    return Ok((Bytes::Shared(bytes), size));
                }
                let unread = self.unread.get().checked_sub(span);
                self.unread.set(unread.ok_or("the file's accessors overlap too often")?);
                let bytes = Arc::new(tight_from_file(part, offset, stride, size, count)?);
                if self.uses.get(&slice).is_some_and(|&uses| uses > 1) {
                    self.shared.borrow_mut().insert(slice, bytes.clone());
                }
                Ok((Bytes::Shared(bytes), size))
            }
        }
    }

    /// Replaces the elements of `bytes` that a sparse accessor gives.
    fn patch(
        &self,
        bytes: &mut [u8],
        sparse: &gltf::json::accessor::sparse::Sparse,
        size: usize,
    ) -> Parsed<()> {
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err("its indices have a component type that is none of glTF's".into());
        };
        let component = component.0;
        let count = usize::try_from(sparse.count.0).map_err(|_| "its count is too great")?;
        let at = &sparse.indices;
        let (indices, stride) =
            self.slice(at.buffer_view, at.byte_offset.0, count, component.size())?;
        let indices =
            Elements { bytes: indices, stride, count, width: 1, component, normalized: false };
        let at = &sparse.values;
        let (values, stride) = self.slice(at.buffer_view, at.byte_offset.0, count, size)?;
        for i in 0..count {
            let index = indices.index(i) as usize;
            let target =
                index.checked_mul(size).and_then(|at| bytes.get_mut(at..)?.get_mut(..size));
            let target = target.ok_or_else(|| format!("index {index} is out of range"))?;
            target.copy_from_slice(&values[i * stride..][..size]);
        }
        Ok(())
    }
}

/// The bytes of a buffer view with an image, of the `unread` ones that images may still read.
pub fn view_bytes<'a>(
    root: &Root,
    buffers: &'a [Buffer],
    index: Index<View>,
    unread: &mut u64,
) -> Parsed<Cow<'a, [u8]>> {
    let (buffer, start, length) = place(root, buffers, index)?;
    *unread = unread.checked_sub(length).ok_or("the file's images overlap too often")?;
    match buffer {
        Buffer::Memory(bytes) => Ok(bytes[start as usize..(start + length) as usize].into()),
        Buffer::File(part) => part.read(start, length).map(Cow::Owned),
    }
}

/// A buffer view's buffer, where it begins there and its length in bytes.
fn place<'a>(
    root: &Root,
    buffers: &'a [Buffer],
    index: Index<View>,
) -> Parsed<(&'a Buffer, u64, u64)> {
    let view =
        root.get(index).ok_or_else(|| format!("bufferViews[{}] is not there", index.value()))?;
    let number = view.buffer.value();
    let buffer = buffers.get(number).ok_or_else(|| format!("buffers[{number}] is not there"))?;
    let (offset, length) = (view.byte_offset.map_or(0, |offset| offset.0), view.byte_length.0);
    let end = offset.checked_add(length).filter(|&end| end <= buffer.len());
    end.ok_or_else(|| {
        let (view, bytes) = (index.value(), buffer.len());
        format!("bufferViews[{view}] lies outside buffers[{number}] of {bytes} bytes")
    })?;
    Ok((buffer, offset, length))
}

/// How often primitives use each slice. Where skins or morph weights make several meshes of a
/// primitive, all that it uses counts as used again.
fn uses(root: &Root) -> HashMap<Slice, u32> {
    let several = !root.skins.is_empty() || root.nodes.iter().any(|node| node.weights.is_some());
    let mut uses = HashMap::new();
    for primitive in root.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let targets = primitive.targets.iter().flatten();
        let moved = targets.flat_map(|target| [target.positions, target.normals, target.tangents]);
        let used = primitive.attributes.values().copied().chain(primitive.indices);
        for slice in used.chain(moved.flatten()).filter_map(|index| slice(root.get(index)?)) {
            *uses.entry(slice).or_insert(u32::from(several)) += 1;
        }
    }
    uses
}

/// What an accessor with valid types reads of its view.
fn slice(accessor: &Accessor) -> Option<Slice> {
    let (Checked::Valid(component), Checked::Valid(element)) =
        (accessor.component_type, accessor.type_)
    else {
        return None;
    };
    Some(Slice {
        view: accessor.buffer_view?.value(),
        offset: accessor.byte_offset.map_or(0, |offset| offset.0),
        count: usize::try_from(accessor.count.0).ok()?,
        size: element.multiplicity() * component.0.size(),
    })
}

/// Elements of a file, all within it, copied out of their stride.
fn tight_from_file(
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
fn tight(bytes: &[u8], stride: usize, size: usize, count: usize) -> Parsed<Vec<u8>> {
    let length = count.checked_mul(size).ok_or("its count is too great")?;
    let mut tight = Vec::with_capacity(length);
    for i in 0..count {
        tight.extend_from_slice(&bytes[i * stride..][..size]);
    }
    Ok(tight)
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
