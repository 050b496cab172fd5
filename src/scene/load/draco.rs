//! Primitives compressed by `KHR_draco_mesh_compression`.

use super::Parsed;
use super::guard::guarded;
use draco_core::{DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute};
use gltf::json::Root;
use gltf::json::accessor::ComponentType;
use gltf::json::mesh::Primitive;
use gltf::json::validation::Checked;
use serde::Deserialize;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// The extension's name.
pub const EXTENSION: &str = "KHR_draco_mesh_compression";

/// Bytes that decoding a triangle takes beside its attributes.
const BYTES_OF_FACE: u64 = 24;

/// How a primitive is stored.
#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Compressed {
    /// Index of the buffer view with the stream.
    pub buffer_view: u32,
    /// Numbers of the stream's attributes by the primitive's.
    pub attributes: BTreeMap<String, u32>,
}

/// What takes the place of an accessor's content: `count` elements without padding, as the accessor
/// declares them.
#[derive(Clone)]
pub struct Content {
    /// The elements' bytes.
    pub bytes: Arc<Vec<u8>>,
    /// Number of elements.
    pub count: usize,
}

/// The contents of a primitive's accessors, by index, that a stream decodes to, and their bytes; no more
/// than `most` are decoded.
pub fn decode(
    root: &Root,
    primitive: &Primitive,
    compressed: &Compressed,
    stream: &[u8],
    most: u64,
) -> Parsed<(HashMap<usize, Content>, u64)> {
    let limits = DecodeLimits::default()
        .with_max_points(most / BYTES_OF_FACE)
        .with_max_faces(most / BYTES_OF_FACE)
        .with_max_decoded_bytes(most);
    let decode = || {
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(stream).with_limits(limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh).map_err(|error| error.to_string())?;
        Ok(mesh)
    };
    let mesh = guarded(decode)?;
    let mut contents = HashMap::new();
    for (name, &number) in &compressed.attributes {
        let is_named = |semantic: &Checked<_>| match semantic {
            Checked::Valid(semantic) => gltf::json::mesh::Semantic::to_string(semantic) == *name,
            Checked::Invalid => false,
        };
        let accessor = primitive.attributes.iter().find(|(semantic, _)| is_named(semantic));
        let Some((_, &accessor)) = accessor else { continue };
        let attribute = mesh.attribute_by_unique_id(number);
        let attribute =
            attribute.ok_or_else(|| format!("its stream has no attribute {number} for {name}"))?;
        let json = root.get(accessor).ok_or("an accessor is not there")?;
        let (Checked::Valid(component), Checked::Valid(element)) =
            (json.component_type, json.type_)
        else {
            return Err(format!("{name} has a type or component type that is none of glTF's"));
        };
        let bytes = values(attribute, mesh.num_points(), element.multiplicity(), component.0);
        let content = Content { bytes: Arc::new(bytes), count: mesh.num_points() };
        contents.insert(accessor.value(), content);
    }
    if let Some(accessor) = primitive.indices {
        let json = root.get(accessor).ok_or("its indices are not there")?;
        let Checked::Valid(component) = json.component_type else {
            return Err("its indices have a component type that is none of glTF's".into());
        };
        let corners = mesh.faces().as_flattened().iter().map(|point| point.0);
        let mut bytes = Vec::with_capacity(3 * component.0.size() * mesh.num_faces());
        for corner in corners {
            if component.0.size() < 4 && corner >> (8 * component.0.size()) != 0 {
                return Err(format!("index {corner} of its stream does not fit its accessor"));
            }
            bytes.extend_from_slice(&corner.to_le_bytes()[..component.0.size()]);
        }
        let content = Content { bytes: Arc::new(bytes), count: 3 * mesh.num_faces() };
        contents.insert(accessor.value(), content);
    }
    let decoded = contents.values().map(|content| content.bytes.len() as u64).sum();
    Ok((contents, decoded))
}

/// An attribute's values for all points, `width` components of a type each. Integers stand in the stream as
/// they are, of at most 16 bits.
fn values(
    attribute: &PointAttribute,
    points: usize,
    width: usize,
    component: ComponentType,
) -> Vec<u8> {
    let values = attribute.read_f32s(points, width);
    match component {
        ComponentType::F32 => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        ComponentType::U8 => values.iter().map(|&value| value as u8).collect(),
        ComponentType::I8 => values.iter().map(|&value| value as i8 as u8).collect(),
        ComponentType::U16 => values.iter().flat_map(|&v| (v as u16).to_le_bytes()).collect(),
        ComponentType::I16 => values.iter().flat_map(|&v| (v as i16).to_le_bytes()).collect(),
        ComponentType::U32 => values.iter().flat_map(|&v| (v as u32).to_le_bytes()).collect(),
    }
}
