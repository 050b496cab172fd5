//! Triangle meshes, and the surfaces that have a parameter form.

use glam::{DVec2, DVec3, DVec4, Vec4Swizzles as _};

use super::curve::catmull_rom;

/// An indexed triangle mesh, counter-clockwise from outside. Optional attributes are empty, or as
/// long as `positions`.
#[derive(Clone, Default)]
pub struct Mesh {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub uvs: Vec<[f32; 2]>,
    /// Unit tangent along +u and the sign of the bitangent.
    pub tangents: Vec<[f32; 4]>,
    /// Linear RGBA, normalised bytes.
    pub colours: Vec<[u8; 4]>,
    pub indices: Vec<u32>,
}

impl Mesh {
    /// Adds a vertex with a unit normal.
    pub fn push(&mut self, position: DVec3, normal: DVec3) {
        self.positions.push(position.as_vec3().to_array());
        self.normals.push(normal.as_vec3().to_array());
    }

    pub fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.positions.iter().map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into()))
    }
}

/// The surface `point(u, v)`, `u, v ∈ [0, 1]`, on `columns × rows` squares with texture
/// coordinates, normals and tangents. ∂u × ∂v must point outwards; where ∂u vanishes, at a pole,
/// the normal comes from just beside it.
pub fn sheet(columns: u32, rows: u32, point: &impl Fn(DVec2) -> DVec3) -> Mesh {
    const STEP: f64 = 1e-4;
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let uv = DVec2::new(
                f64::from(column) / f64::from(columns),
                f64::from(row) / f64::from(rows),
            );
            let beside = DVec2::new(uv.x, uv.y.clamp(2.0 * STEP, 1.0 - 2.0 * STEP));
            let along = |axis: DVec2| point(beside + axis * STEP) - point(beside - axis * STEP);
            let (du, dv) = (along(DVec2::X), along(DVec2::Y));
            let normal = du.cross(dv).normalize();
            let tangent = (du - normal * du.dot(normal)).normalize();
            mesh.push(point(uv), normal);
            // glTF's texture coordinates run downwards.
            mesh.uvs.push([uv.x as f32, (1.0 - uv.y) as f32]);
            mesh.tangents.push(tangent.as_vec3().extend(1.0).to_array());
        }
    }
    let stride = columns + 1;
    for row in 0..rows {
        for column in 0..columns {
            let a = row * stride + column;
            let (b, c, d) = (a + 1, a + stride + 1, a + stride);
            for triangle in [[a, b, c], [a, c, d]] {
                let [p, q, r] = triangle.map(|i| mesh.positions[i as usize]);
                // At a pole one of the two triangles has no area.
                if p != q && q != r && r != p {
                    mesh.indices.extend(triangle);
                }
            }
        }
    }
    mesh
}

/// A closed body of revolution about +Y: its outline runs from the axis below, round the outside
/// and back to the axis, through `(radius, height)` knots by Catmull-Rom.
pub fn lathe(outline: &[[f64; 2]], columns: u32, per_span: usize) -> Mesh {
    let knots: Vec<DVec4> = outline.iter().map(|&[r, y]| DVec4::new(r, y, 0.0, 0.0)).collect();
    let samples: Vec<DVec2> =
        catmull_rom(&knots, per_span * 8).iter().map(|knot| knot.xy()).collect();
    let rows = ((outline.len() - 1) * per_span) as u32;
    sheet(columns, rows, &|uv: DVec2| {
        let place = uv.y * (samples.len() - 1) as f64;
        let from = (libm::floor(place) as usize).min(samples.len() - 2);
        let at = samples[from].lerp(samples[from + 1], place - from as f64);
        let angle = uv.x * 2.0 * std::f64::consts::PI;
        DVec3::new(libm::sin(angle) * at.x, at.y, libm::cos(angle) * at.x)
    })
}
