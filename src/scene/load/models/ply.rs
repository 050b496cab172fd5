//! PLY, as text and binary of either byte order.

use super::Part;
use super::color::{encoded, triangulated, unstripped};
use crate::scene::load::{Parsed, quoted};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use std::io::BufRead;

/// Reads the vertices, faces and triangle strips of a file; what else it holds is left out.
pub fn read(source: &mut impl BufRead) -> Parsed<Part> {
    let fault = |error: std::io::Error| format!("is not valid PLY: {error}");
    let mut source = Reader::new(source);
    let header = Parser::<Other>::new().read_header(&mut source).map_err(|e| fault(e.into()))?;
    let mut part = Part { name: "PLY".into(), ..Part::default() };
    let (mut faces, mut strips) = (Vec::new(), Vec::new());
    for (name, element) in &header.elements {
        if element.properties.is_empty() && element.count > 0 {
            return Err(format!("is not valid PLY: {} has no properties", quoted(name)));
        }
        let has = |property: &str| element.properties.contains_key(property);
        match name.as_str() {
            "vertex" => {
                let parser = Parser::<Vertex>::new();
                let vertices = parser.read_payload_for_element(&mut source, element, &header);
                let vertices = vertices.map_err(|e| fault(e.into()))?;
                part.positions = vertices.iter().map(|vertex| vertex.position).collect();
                if has("nx") && has("ny") && has("nz") {
                    part.normals = vertices.iter().map(|vertex| vertex.normal).collect();
                }
                if has("red") || has("diffuse_red") {
                    part.colors = vertices.iter().map(|vertex| encoded(vertex.color)).collect();
                }
            }
            "face" | "tristrips" => {
                let parser = Parser::<Face>::new();
                let read = parser.read_payload_for_element(&mut source, element, &header);
                let read = read.map_err(|e| fault(e.into()))?;
                if name == "face" { faces = read } else { strips = read }
            }
            _ => {
                let parser = Parser::<Other>::new();
                let read = parser.read_payload_for_element(&mut source, element, &header);
                read.map_err(|e| fault(e.into()))?;
            }
        }
    }
    if faces.is_empty() && strips.is_empty() {
        return Err("has points but no faces: klieg needs triangles".into());
    }
    for face in faces {
        triangulated(face.corners(), &mut part.indices);
    }
    for strips in strips {
        // -1 stands between them.
        for strip in strips.corners().split(|&corner| corner == u32::MAX) {
            unstripped(strip, &mut part.indices);
        }
    }
    if part.indices.is_empty() {
        return Err("has no triangles: its faces have fewer than three corners".into());
    }
    Ok(part)
}

struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    /// sRGB and alpha, 0..1.
    color: [f32; 4],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: [0.0; 3], normal: [0.0; 3], color: [1.0; 4] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        // Integers of colours have all their bits for 1.
        let (value, one) = match property {
            Property::Char(value) => (f64::from(value), 127.0),
            Property::UChar(value) => (f64::from(value), 255.0),
            Property::Short(value) => (f64::from(value), 32767.0),
            Property::UShort(value) => (f64::from(value), 65535.0),
            Property::Int(value) => (f64::from(value), 255.0),
            Property::UInt(value) => (f64::from(value), 255.0),
            Property::Float(value) => (f64::from(value), 1.0),
            Property::Double(value) => (value, 1.0),
            _ => return PropertyAccessResult::Ignored,
        };
        let (place, value) = match name {
            "x" => (&mut self.position[0], value),
            "y" => (&mut self.position[1], value),
            "z" => (&mut self.position[2], value),
            "nx" => (&mut self.normal[0], value),
            "ny" => (&mut self.normal[1], value),
            "nz" => (&mut self.normal[2], value),
            "red" | "diffuse_red" => (&mut self.color[0], value / one),
            "green" | "diffuse_green" => (&mut self.color[1], value / one),
            "blue" | "diffuse_blue" => (&mut self.color[2], value / one),
            "alpha" => (&mut self.color[3], value / one),
            _ => return PropertyAccessResult::Ignored,
        };
        *place = value as f32;
        PropertyAccessResult::Set
    }
}

enum Face {
    Triangle([u32; 3]),
    Polygon(Vec<u32>),
}

impl Face {
    fn corners(&self) -> &[u32] {
        match self {
            Self::Triangle(corners) => corners,
            Self::Polygon(corners) => corners,
        }
    }
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::Polygon(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        // What is negative is out of range later, but for the -1 of strips.
        let one = |corner: i64| corner as u32;
        let corners: Vec<u32> = match property {
            Property::ListChar(list) => list.iter().map(|&i| one(i.into())).collect(),
            Property::ListUChar(list) => list.iter().map(|&i| i.into()).collect(),
            Property::ListShort(list) => list.iter().map(|&i| one(i.into())).collect(),
            Property::ListUShort(list) => list.iter().map(|&i| i.into()).collect(),
            Property::ListInt(list) => list.iter().map(|&i| one(i.into())).collect(),
            Property::ListUInt(list) => list,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        *self = match corners[..] {
            [a, b, c] => Self::Triangle([a, b, c]),
            _ => Self::Polygon(corners),
        };
        PropertyAccessResult::Set
    }
}

/// What is not looked at.
struct Other;

impl PropertyAccess for Other {
    fn new() -> Self {
        Self
    }
}
