//! What scenes are put together from, wherever they come from: triangles, materials, instances.

use super::{Instance, Material, Mesh, Parsed, Scene, Vertex, tangents};
use glam::{DMat4, DVec3, DVec4, Vec3};
use rayon::prelude::*;

/// Stands for glTF's default material until the number of the others is known.
pub(super) const DEFAULT: u32 = u32::MAX;

/// Most drawings of meshes in a scene.
const MAX_INSTANCES: usize = 1 << 22;

/// Most warnings that are listed.
const MAX_WARNINGS: usize = 100;

/// Where a mesh's tangents come from.
pub(super) enum Tangents {
    /// There are none, as its material has no normal texture.
    Unused,
    /// Its vertices have them.
    Given,
    /// They are computed for a texture coordinate set.
    Computed { uv_set: usize },
}

/// Triangles, and the source's vertices that they use.
pub(super) struct Triangles {
    /// Numbers of the source's vertices.
    from: Vec<u32>,
    /// Indices into `from`.
    indices: Vec<u32>,
}

impl Triangles {
    /// The triangles whose `corners` are numbers of the source's vertices, all below `count`.
    pub fn new(corners: Vec<u32>, count: usize, has_normals: bool) -> Self {
        // Without normals every triangle is flat, and so has its own vertices.
        let (from, indices) = match has_normals {
            true => weld(corners, count),
            false => {
                let count = corners.len() as u32;
                (corners, (0..count).collect())
            }
        };
        Self { from, indices }
    }

    /// Number of vertices that are used.
    pub fn vertices(&self) -> usize {
        self.from.len()
    }

    /// The mesh whose vertices `vertex` gives by their numbers in the source.
    pub fn mesh(
        self,
        tangents: Tangents,
        vertex: impl Fn(usize) -> Parsed<Vertex> + Sync,
    ) -> Parsed<Mesh> {
        let Self { from, indices } = self;
        // Collecting would hold the vertices twice.
        let mut vertices: Vec<Vertex> = zeros(from.len())?;
        vertices.par_iter_mut().zip(from).try_for_each(|(place, at)| {
            *place = vertex(at as usize)?;
            Parsed::Ok(())
        })?;
        let mut mesh = Mesh { vertices, indices, ..Mesh::default() };
        repair_normals(&mut mesh)?;
        match tangents {
            Tangents::Unused => {}
            Tangents::Given => tangents::repair(&mut mesh.vertices),
            Tangents::Computed { uv_set } => tangents::generate(&mut mesh, uv_set),
        }
        Ok(mesh)
    }
}

/// All `indices` must be those of `count` vertices.
pub(super) fn check_indices(indices: &[u32], count: usize) -> Parsed<()> {
    match indices.iter().position(|&index| index as usize >= count) {
        Some(at) => Err(format!(
            "indices: index {} at {at} is out of range: there are {count} vertices",
            indices[at]
        )),
        None => Ok(()),
    }
}

impl Vertex {
    /// Vertex `at` of its source, with a normal of unit length (zero where it has no direction), a
    /// sign of ±1, and no texture coordinate that is not finite. Its position must be finite.
    pub(super) fn checked(self, at: usize) -> Parsed<Self> {
        let Self { position, normal, tangent: [x, y, z, sign], uv, color } = self;
        if !Vec3::from(position).is_finite() {
            return Err(format!("position of vertex {at} is not finite"));
        }
        Ok(Self {
            position,
            normal: normalized(normal.into()).to_array(),
            tangent: [x, y, z, if sign < 0.0 { -1.0 } else { 1.0 }],
            uv: uv.map(|set| set.map(|value| if value.is_finite() { value } else { 0.0 })),
            color,
        })
    }
}

/// Unit length, or zero where it has no direction.
pub(super) fn normalized(v: Vec3) -> Vec3 {
    // In double precision, as the square of a short or long vector may not be a single one.
    v.as_dvec3().normalize_or_zero().as_vec3()
}

/// The vertices that are used, in the file's order, and `corners` renumbered to them.
fn weld(mut corners: Vec<u32>, count: usize) -> (Vec<u32>, Vec<u32>) {
    // Primitives may share one large buffer of which each uses a part: no table of all of it.
    if count / 8 > corners.len() {
        let mut from = corners.clone();
        from.sort_unstable();
        from.dedup();
        for corner in &mut corners {
            *corner = from.partition_point(|at| at < corner) as u32;
        }
        return (from, corners);
    }
    let mut number = vec![0u32; count];
    for &corner in &corners {
        number[corner as usize] = 1;
    }
    let mut from = Vec::new();
    for (at, number) in number.iter_mut().enumerate() {
        if *number == 1 {
            *number = from.len() as u32;
            from.push(at as u32);
        }
    }
    for corner in &mut corners {
        *corner = number[*corner as usize];
    }
    (from, corners)
}

/// Zeros for each of `count` vertices.
fn zeros<T: bytemuck::Zeroable>(count: usize) -> Parsed<Vec<T>> {
    bytemuck::allocation::try_zeroed_vec(count)
        .map_err(|()| format!("its {count} vertices need more memory than there is"))
}

/// Gives vertices without a normal that of their triangles, weighted by area.
fn repair_normals(mesh: &mut Mesh) -> Parsed<()> {
    let lacks = |vertex: &Vertex| vertex.normal == [0.0; 3];
    if !mesh.vertices.iter().any(lacks) {
        return Ok(());
    }
    let mut sums: Vec<DVec3> = zeros(mesh.vertices.len())?;
    for triangle in mesh.indices.chunks_exact(3) {
        let corner = |k: usize| triangle[k] as usize;
        let lacking = (0..3).any(|k| lacks(&mesh.vertices[corner(k)]));
        if lacking {
            let [a, b, c] =
                [0, 1, 2].map(|k| Vec3::from(mesh.vertices[corner(k)].position).as_dvec3());
            let area = (b - a).cross(c - a);
            (0..3).for_each(|k| sums[corner(k)] += area);
        }
    }
    for (vertex, sum) in mesh.vertices.iter_mut().zip(sums) {
        if lacks(vertex) {
            vertex.normal = sum.normalize_or(DVec3::Z).as_vec3().to_array();
        }
    }
    Ok(())
}

/// World from mesh space, as glTF has it: the last row of `matrix` must be 0 0 0 1.
pub(super) fn affine(mut matrix: DMat4) -> Parsed<DMat4> {
    if !matrix.row(3).abs_diff_eq(DVec4::W, 1e-3) {
        return Err("its matrix has a last row other than 0 0 0 1".into());
    }
    for (axis, value) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
        matrix.col_mut(axis).w = value;
    }
    Ok(matrix)
}

impl Scene {
    /// Draws `mesh` once more. What is scaled to nothing is left out, with a warning that begins with
    /// `title`.
    pub(super) fn place(
        &mut self,
        name: &str,
        mesh: u32,
        world: DMat4,
        title: impl FnOnce() -> String,
    ) -> Parsed<()> {
        let determinant = world.determinant();
        if determinant == 0.0 || !determinant.is_finite() {
            let fault = "is scaled to nothing: left out";
            warn(&mut self.warnings, format!("{} {fault}", title()));
            return Ok(());
        }
        if self.instances.len() == MAX_INSTANCES {
            return Err(format!("the scene draws more than {MAX_INSTANCES} meshes"));
        }
        let before = self.polygons();
        // The last colour code, and one beyond it, must be 32-bit numbers.
        (before.checked_add(self.meshes[mesh as usize].triangles()))
            .filter(|&count| count < u32::MAX - 1)
            .ok_or("the scene draws more triangles than 32-bit numbers can tell apart")?;
        let (name, first_polygon) = (name.to_owned(), before + 1);
        self.instances.push(Instance { name, mesh, world, first_polygon });
        Ok(())
    }

    /// Puts glTF's default material last, and gives it to the meshes of material [`DEFAULT`].
    pub(super) fn add_default_material(&mut self) {
        let default = self.materials.len() as u32;
        self.materials.push(Material::default());
        for mesh in self.meshes.iter_mut().filter(|mesh| mesh.material == DEFAULT) {
            mesh.material = default;
        }
    }
}

impl Material {
    /// Numbers must be finite; factors are brought into their ranges.
    pub(super) fn checked(mut self) -> Parsed<Self> {
        let Material {
            base_color, emissive, metallic, roughness, normal_scale, alpha_cutoff, ..
        } = &mut self;
        let factors = [*metallic, *roughness, *normal_scale, *alpha_cutoff];
        let all = base_color.iter().chain(emissive.iter()).chain(&factors);
        if !all.clone().all(|value| value.is_finite()) {
            return Err("a factor is not finite".into());
        }
        base_color.iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
        emissive.iter_mut().for_each(|value| *value = value.max(0.0));
        *metallic = metallic.clamp(0.0, 1.0);
        *roughness = roughness.clamp(0.0, 1.0);
        *alpha_cutoff = alpha_cutoff.max(0.0);
        Ok(self)
    }
}

/// Adds a warning unless it, or more than anyone reads, has been given.
pub(super) fn warn(warnings: &mut Vec<String>, warning: String) {
    match warnings.len() {
        0..MAX_WARNINGS if !warnings.contains(&warning) => warnings.push(warning),
        MAX_WARNINGS => warnings.push("further warnings are left out".into()),
        _ => {}
    }
}

/// A name as it is kept: short, so that a long one cannot be multiplied by its uses.
pub(super) fn label(name: Option<&str>) -> String {
    name.unwrap_or_default().chars().take(200).collect()
}

/// A name or URI for messages: short, and without control characters.
pub(super) fn quoted(name: &str) -> String {
    let mut short: String = name.chars().take(100).flat_map(char::escape_debug).collect();
    if name.chars().nth(100).is_some() {
        short.push('…');
    }
    format!("'{short}'")
}
