//! Accessors (glTF 2.0, 3.6.2), every bound checked before anything is read. Buffers that lie in files
//! are read accessor by accessor, so that a scene and its file are never in memory together.

use super::Parsed;
use super::document::Document;
use super::draco::{self, Content};
use super::elements::{Bytes, Elements};
use super::files::Buffer;
use super::meshopt::{Compressed, Mode};
use super::views::{part, place, tight, tight_from_file, view_bytes, within};
use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::buffer::View;
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use std::cell::{Cell, RefCell};
use std::collections::HashMap;
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

/// Most bytes that compressed streams may decode to, for each of the buffers', and without any: geometry
/// rarely shrinks to less than a thirtieth.
const DECODED_OF_BYTES: (u64, u64) = (64, 1 << 26);

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
    compressed: &'a HashMap<usize, Compressed>,
    /// Elements that may still be used.
    left: Cell<u64>,
    /// Bytes that may still be read from files.
    unread: Cell<u64>,
    /// Bytes that may still be decoded.
    undecoded: Cell<u64>,
    /// Compressed views that have been decoded.
    decoded: RefCell<HashMap<usize, Arc<Vec<u8>>>>,
    /// What takes the place of the content of accessors, by index.
    replaced: RefCell<HashMap<usize, Content>>,
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

/// What a use of an accessor asks of it.
pub struct Wanted<'w> {
    /// Element types.
    pub types: &'w [Type],
    /// Component types.
    pub components: &'w [ComponentType],
    /// Whether integers stand for 0..1 or −1..1 even where the accessor does not say so.
    pub normalized: bool,
}

impl<'a> Accessors<'a> {
    /// Accessors of a file whose buffers are `buffers`.
    pub fn new(document: &'a Document, buffers: &'a [Buffer]) -> Self {
        let root = &document.root;
        let bytes: u64 = buffers.iter().map(Buffer::len).sum();
        let (each, least) = ELEMENTS_OF_BYTES;
        let (decoded_each, decoded_least) = DECODED_OF_BYTES;
        Self {
            root,
            buffers,
            compressed: &document.extensions.compressed,
            undecoded: Cell::new(decoded_each * bytes + decoded_least),
            decoded: RefCell::default(),
            replaced: RefCell::default(),
            left: Cell::new(MAX_ELEMENTS.min(each * bytes + least)),
            unread: Cell::new(READS_OF_BYTES * bytes),
            uses: uses(root),
            shared: RefCell::default(),
        }
    }

    /// Has the accessors of a primitive give what its compressed stream decodes to, and all others their own
    /// content.
    pub fn decompress(&self, mesh: usize, index: usize, document: &Document) -> Parsed<()> {
        self.replaced.borrow_mut().clear();
        let Some(compressed) = document.extensions.draco.get(&(mesh, index)) else {
            return Ok(());
        };
        let decode = || {
            let primitive = &self.root.meshes[mesh].primitives[index];
            let mut unread = self.unread.get();
            let view = Index::new(compressed.buffer_view);
            let stream = view_bytes(self.root, self.buffers, view, &mut unread)?;
            self.unread.set(unread);
            let most = self.undecoded.get();
            let (contents, decoded) =
                draco::decode(self.root, primitive, compressed, &stream, most)?;
            self.undecoded.set(most.saturating_sub(decoded));
            self.replaced.replace(contents);
            Ok(())
        };
        decode().map_err(|fault: String| format!("{}: {fault}", draco::EXTENSION))
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
        let normalized = accessor.normalized || wanted.normalized;
        let content = self.replaced.borrow().get(&index.value()).cloned();
        if let Some(Content { bytes, count }) = content {
            let bytes = Bytes::Shared(bytes);
            return Ok(Elements { bytes, stride: size, count, width, component, normalized });
        }
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
        if let Some(compressed) = self.compressed.get(&view.value()) {
            let bytes = self.decoded(view, compressed)?;
            let stride = match compressed.mode {
                Mode::Attributes => compressed.byte_stride,
                Mode::Triangles | Mode::Indices => size,
            };
            let (range, stride) = within(view, bytes.len() as u64, offset, count, size, stride)?;
            let range = range.start as usize..range.end as usize;
            return Ok((Bytes::Part(bytes, range), stride));
        }
        let (buffer, start, length) = place(self.root, self.buffers, view)?;
        let stride = self.root.get(view).and_then(|view| view.byte_stride).map_or(size, |s| s.0);
        let (range, stride) = within(view, length, offset, count, size, stride)?;
        let (offset, span) = (start + range.start, range.end - range.start);
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
                self.charge_reading(span)?;
                let bytes = Arc::new(tight_from_file(part, offset, stride, size, count)?);
                if self.uses.get(&slice).is_some_and(|&uses| uses > 1) {
                    self.shared.borrow_mut().insert(slice, bytes.clone());
                }
                Ok((Bytes::Shared(bytes), size))
            }
        }
    }

    /// Takes `bytes` off what may still be read from files.
    fn charge_reading(&self, bytes: u64) -> Parsed<()> {
        let unread = self.unread.get().checked_sub(bytes);
        self.unread.set(unread.ok_or("the file's accessors overlap too often")?);
        Ok(())
    }

    /// The content of a compressed view, which is decoded once.
    fn decoded(&self, view: Index<View>, compressed: &Compressed) -> Parsed<Arc<Vec<u8>>> {
        let known = self.decoded.borrow().get(&view.value()).cloned();
        if let Some(bytes) = known {
            return Ok(bytes);
        }
        let decode = || {
            let Compressed { buffer, byte_offset, byte_length, .. } = *compressed;
            let buffer = part(self.buffers, buffer, byte_offset, byte_length)?;
            let length = compressed.decoded_length(self.undecoded.get())?;
            self.undecoded.set(self.undecoded.get() - length);
            match buffer {
                Buffer::Memory(bytes) => {
                    let (start, end) = (byte_offset, byte_offset + byte_length);
                    compressed.decode(&bytes[start as usize..end as usize])
                }
                Buffer::File(part) => {
                    self.charge_reading(byte_length)?;
                    compressed.decode(&part.read(byte_offset, byte_length)?)
                }
            }
        };
        let bytes = decode().map_err(|fault| format!("bufferViews[{}]: {fault}", view.value()))?;
        let bytes = Arc::new(bytes);
        self.decoded.borrow_mut().insert(view.value(), bytes.clone());
        Ok(bytes)
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
