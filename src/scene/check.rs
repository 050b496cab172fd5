//! Whether a scene's parts fit each other, so that drawing it reads nothing that is not there.

use super::{Material, Mesh, Scene, Texture, TextureRef};
use crate::{Error, Result};
use rayon::prelude::*;

impl Scene {
    /// Whether the parts fit each other: every index names something that is there, triangles have three
    /// corners, polygons are numbered from 1 on without gaps in 32 bits, and textures have the mip
    /// levels and texels of their size. Whatever draws a scene asks for it; scenes that were loaded
    /// or built pass.
    ///
    /// # Errors
    /// [`Error::Input`] with the first part that does not fit.
    pub fn check(&self) -> Result<()> {
        self.check_parts().map_err(|fault| Error::input(&self.path, fault))
    }

    fn check_parts(&self) -> Result<(), String> {
        for (number, texture) in self.textures.iter().enumerate() {
            let fault = |fault| format!("texture {number} '{}': {fault}", texture.name);
            check_texture(texture).map_err(fault)?;
        }
        for (number, material) in self.materials.iter().enumerate() {
            let fault = |fault| format!("material {number} '{}': {fault}", material.name);
            check_material(material, self.textures.len()).map_err(fault)?;
        }
        for (number, mesh) in self.meshes.iter().enumerate() {
            let fault = |fault| format!("mesh {number} '{}': {fault}", mesh.name);
            check_mesh(mesh, self.materials.len()).map_err(fault)?;
        }
        self.check_instances()
    }

    fn check_instances(&self) -> Result<(), String> {
        let mut next = 1u32;
        for (number, instance) in self.instances.iter().enumerate() {
            let fault = |fault| format!("instance {number} '{}': {fault}", instance.name);
            let mesh = self.meshes.get(instance.mesh as usize);
            let mesh = mesh.ok_or_else(|| fault(format!("there is no mesh {}", instance.mesh)))?;
            if instance.first_polygon != next {
                let has = instance.first_polygon;
                return Err(fault(format!("its first polygon is {has}, not {next}")));
            }
            next = next
                .checked_add(mesh.triangles())
                .ok_or_else(|| fault("more than 2^32 polygons with those before".into()))?;
        }
        Ok(())
    }
}

fn check_mesh(mesh: &Mesh, materials: usize) -> Result<(), String> {
    let (indices, vertices) = (mesh.indices.len(), mesh.vertices.len());
    if mesh.material as usize >= materials {
        return Err(format!("there is no material {}", mesh.material));
    }
    if !indices.is_multiple_of(3) || indices / 3 > u32::MAX as usize {
        return Err(format!("{indices} indices are no triangles"));
    }
    match mesh.indices.par_iter().max() {
        Some(&most) if most as usize >= vertices => {
            Err(format!("there is no vertex {most}, as there are {vertices}"))
        }
        _ => Ok(()),
    }
}

fn check_material(material: &Material, textures: usize) -> Result<(), String> {
    let used = [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
        material.emissive_texture,
    ];
    for TextureRef { texture, uv_set, .. } in used.into_iter().flatten() {
        if texture as usize >= textures {
            return Err(format!("there is no texture {texture}"));
        }
        if uv_set > 1 {
            return Err(format!("there is no texture coordinate set {uv_set}"));
        }
    }
    Ok(())
}

fn check_texture(texture: &Texture) -> Result<(), String> {
    let Some(first) = texture.levels.first() else { return Err("it has no level".into()) };
    let mut expected = Some([first.width, first.height]);
    for (number, level) in texture.levels.iter().enumerate() {
        let (size, texels) = ([level.width, level.height], level.texels.len());
        let [width, height] = size;
        if expected != Some(size) || size.contains(&0) {
            return Err(format!("level {number} must not have {width}x{height} texels"));
        }
        if texels as u64 != u64::from(width) * u64::from(height) {
            return Err(format!("level {number} of {width}x{height} has {texels} texels"));
        }
        expected = (size != [1, 1]).then(|| size.map(|side| (side / 2).max(1)));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::{Instance, TextureLevel, Vertex, Wrap};
    use super::*;
    use bytemuck::Zeroable;
    use glam::DMat4;

    fn level(width: u32, height: u32) -> TextureLevel {
        TextureLevel { width, height, texels: vec![[255; 4]; (width * height) as usize] }
    }

    /// Two instances of two triangles, with a texture of 5x2 texels.
    fn scene() -> Scene {
        let instance = |first_polygon| Instance {
            name: "part".into(),
            mesh: 0,
            world: DMat4::IDENTITY,
            first_polygon,
        };
        let textured = Some(TextureRef::new(0));
        Scene {
            path: "example".into(),
            meshes: vec![Mesh {
                vertices: vec![Vertex::zeroed(); 4],
                indices: vec![0, 1, 2, 2, 1, 3],
                ..Mesh::default()
            }],
            materials: vec![Material { normal_texture: textured, ..Material::default() }],
            textures: vec![Texture {
                name: "bumps".into(),
                srgb: false,
                wrap: [Wrap::Repeat; 2],
                levels: vec![level(5, 2), level(2, 1), level(1, 1)],
            }],
            instances: vec![instance(1), instance(3)],
            ..Scene::default()
        }
    }

    fn material(scene: &mut Scene) -> &mut TextureRef {
        scene.materials[0].normal_texture.as_mut().expect("a texture")
    }

    #[test]
    fn scenes_whose_parts_do_not_fit_are_refused() {
        scene().check().expect("a scene that fits");
        Scene::default().check().expect("a scene of nothing");
        type Fault = fn(&mut Scene);
        let faults: [(&str, Fault); 14] = [
            ("instance 1 'part': there is no mesh 1", |s| s.instances[1].mesh = 1),
            ("its first polygon is 0, not 1", |s| s.instances[0].first_polygon = 0),
            ("its first polygon is 4, not 3", |s| s.instances[1].first_polygon = 4),
            ("there is no material 1", |s| s.meshes[0].material = 1),
            ("there is no vertex 4", |s| s.meshes[0].indices[5] = 4),
            ("5 indices are no triangles", |s| s.meshes[0].indices.truncate(5)),
            ("material 0 '': there is no texture 1", |s| material(s).texture = 1),
            ("coordinate set 2", |s| material(s).uv_set = 2),
            ("texture 0 'bumps': it has no level", |s| s.textures[0].levels.clear()),
            ("level 0 of 5x2 has 9", |s| s.textures[0].levels[0].texels.truncate(9)),
            ("level 1 must not have 3x1", |s| s.textures[0].levels[1] = level(3, 1)),
            ("level 3 must not have 1x1", |s| s.textures[0].levels.push(level(1, 1))),
            ("level 0 must not have 0x0", |s| s.textures[0].levels = vec![level(0, 0)]),
            ("there is no mesh 0", |s| s.meshes.clear()),
        ];
        for (expected, break_it) in faults {
            let mut broken = scene();
            break_it(&mut broken);
            let error = broken.check().expect_err(expected);
            assert!(error.is_input() && error.to_string().contains(expected), "{error}");
        }
    }
}
