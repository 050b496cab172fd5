//! Scenes: from a glTF file, or from an engine's arrays.

use super::edge::{
    Fault, Opaque, Outcome, array, body, call, choice, destroy, free_call, given, make, numbers,
    optional, put, text,
};
use super::error::klieg_status;
use crate::scene::build::{MeshData, SceneBuilder, TextureData};
use crate::scene::load::FileAccess;
use crate::scene::{Material, Scene, TextureRef, Wrap, load, view};
use ash::vk;
use glam::DMat4;
use std::ffi::{CString, c_char};
use std::path::Path;

/// A scene. One thread at a time; evaluators that are made of it do not need it any more.
pub struct klieg_scene(());

/// A scene, or the parts of one.
pub(super) enum SceneBody {
    Parts(SceneBuilder, CString),
    /// The scene, its warnings, and which files it may name where it was loaded from one.
    Whole(Scene, CString, Option<FileAccess>),
}

impl Opaque for klieg_scene {
    type Body = SceneBody;
}

impl SceneBody {
    fn whole(scene: Scene, access: Option<FileAccess>) -> Self {
        let warnings = CString::new(scene.warnings.join("\n")).unwrap_or_default();
        Self::Whole(scene, warnings, access)
    }

    /// The scene and which files it may name, where it was loaded from one.
    pub fn loaded(&self) -> Outcome<(&Scene, FileAccess)> {
        match self {
            Self::Whole(scene, _, Some(access)) => Ok((scene, *access)),
            _ => Err(Fault::argument(
                "the scene was not loaded from a file: apply klieg_lights_in_world to it instead",
            )),
        }
    }

    pub fn finished(&self) -> Outcome<&Scene> {
        match self {
            Self::Whole(scene, ..) => Ok(scene),
            Self::Parts(..) => Err(Fault::argument("the scene is not finished")),
        }
    }

    fn parts(&mut self) -> Outcome<&mut SceneBuilder> {
        match self {
            Self::Parts(builder, _) => Ok(builder),
            Self::Whole(..) => Err(Fault::argument("the scene is finished: nothing can be added")),
        }
    }
}

/// Which files a scene may name: one of `KLIEG_FILES_...`.
pub type klieg_file_access = i32;
/// Files in the folder of the scene's own file, and below; for scenes of unknown origin.
pub const KLIEG_FILES_IN_SCENE_FOLDER: klieg_file_access = 0;
/// All files that the program may read.
pub const KLIEG_FILES_ANYWHERE: klieg_file_access = 1;

/// How a texture continues outside 0..1: one of `KLIEG_WRAP_...`.
pub type klieg_wrap = i32;
/// Tiled.
pub const KLIEG_WRAP_REPEAT: klieg_wrap = 0;
/// Tiled, every other tile mirrored.
pub const KLIEG_WRAP_MIRROR: klieg_wrap = 1;
/// The border's texel.
pub const KLIEG_WRAP_CLAMP: klieg_wrap = 2;

/// A texture's texels and how they are read.
#[repr(C)]
pub struct klieg_texture {
    /// UTF-8, for people; may be `NULL`.
    pub name: *const c_char,
    /// Texels in a row, 1..16384.
    pub width: u32,
    /// Rows, 1..16384.
    pub height: u32,
    /// RGBA, 8 bits each, rows from the top: 4·`width`·`height` bytes. Copied.
    pub texels: *const u8,
    /// `VK_TRUE` where RGB is sRGB-encoded, as base colours and emitted light usually are.
    pub srgb: vk::Bool32,
    /// Horizontal and vertical wrap.
    pub wrap: [klieg_wrap; 2],
}

/// A material's use of a texture.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct klieg_texture_ref {
    /// The number that `klieg_scene_add_texture` gave, or `KLIEG_NO_TEXTURE`.
    pub texture: u32,
    /// Which of the vertices' coordinate sets, 0 or 1.
    pub uv_set: u32,
    /// Transform of the coordinates, two rows: u' = row 0 · (u, v, 1), v' = row 1 · (u, v, 1).
    pub transform: [[f32; 3]; 2],
}

/// No texture.
pub const KLIEG_NO_TEXTURE: u32 = 0xffff_ffff;
/// glTF's default material, for `klieg_mesh::material`.
pub const KLIEG_DEFAULT_MATERIAL: u32 = 0xffff_ffff;

/// A metallic-roughness material, as glTF has it.
#[repr(C)]
pub struct klieg_material {
    /// UTF-8, for people; may be `NULL`.
    pub name: *const c_char,
    /// Linear base colour and alpha, multiplied by texture and vertex colour; by default 1.
    pub base_color: [f32; 4],
    /// 0..1, multiplied by the texture's blue component; by default 1.
    pub metallic: f32,
    /// 0..1, multiplied by the texture's green component; by default 1.
    pub roughness: f32,
    /// Linear emitted radiance; by default 0.
    pub emissive: [f32; 3],
    /// Scale of the normal texture's x and y; by default 1.
    pub normal_scale: f32,
    /// Pixels whose alpha is below are not drawn; by default 0, for opaque materials.
    pub alpha_cutoff: f32,
    /// `VK_TRUE` where back faces are drawn; by default `VK_FALSE`.
    pub double_sided: vk::Bool32,
    /// Base colour and alpha.
    pub base_color_texture: klieg_texture_ref,
    /// Linear; roughness in green, metallic in blue.
    pub metallic_roughness_texture: klieg_texture_ref,
    /// Linear tangent-space normals.
    pub normal_texture: klieg_texture_ref,
    /// Emitted light.
    pub emissive_texture: klieg_texture_ref,
}

/// A mesh's arrays, with an entry for each vertex. All are copied.
#[repr(C)]
pub struct klieg_mesh {
    /// UTF-8, for people; may be `NULL`.
    pub name: *const c_char,
    /// Vertices.
    pub vertices: usize,
    /// Positions in the mesh's own space, 3 numbers each.
    pub positions: *const f32,
    /// Normals of any length, 3 numbers each; `NULL` for flat triangles.
    pub normals: *const f32,
    /// Tangents and the bitangents' signs (1 or -1), 4 numbers each; `NULL` to have them computed where a normal texture
    /// needs them.
    pub tangents: *const f32,
    /// Texture coordinate sets 0 and 1, 2 numbers each, (0, 0) at the texture's first texel; `NULL` where there is none.
    pub uvs: [*const f32; 2],
    /// Linear vertex colours, 4 bytes each (RGBA), 255 = 1; `NULL` for white.
    pub colors: *const u8,
    /// Entries of `indices`, a multiple of 3.
    pub index_count: usize,
    /// Three vertices for each triangle, counter-clockwise seen from the front; `NULL` where every three
    /// vertices are a triangle.
    pub indices: *const u32,
    /// The number that `klieg_scene_add_material` gave, or `KLIEG_DEFAULT_MATERIAL`.
    pub material: u32,
}

/// Loads a glTF 2.0 file, `.glb` or `.gltf`, or a PLY, STL or OBJ file, as `klieg_scene_load_with` does with
/// `KLIEG_FILES_IN_SCENE_FOLDER`. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_load(
    path: *const c_char,
    scene: *mut *mut klieg_scene,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        make(scene, || {
            let path = text(path, "path")?;
            let access = FileAccess::SceneFolder;
            Ok(SceneBody::whole(load::load_with(Path::new(path), access)?, Some(access)))
        })
    }
}

/// Loads a glTF 2.0 file, `.glb` or `.gltf`, or a PLY, STL or OBJ file, that may name the files which `access` allows; `path` is
/// UTF-8. The scene is finished. Any thread.
///
/// `KLIEG_ERROR_INPUT` for a file that cannot be used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_load_with(
    path: *const c_char,
    access: klieg_file_access,
    scene: *mut *mut klieg_scene,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        make(scene, || {
            let path = text(path, "path")?;
            let accesses = [FileAccess::SceneFolder, FileAccess::Anywhere];
            let access = choice(&accesses, access, "access")?;
            Ok(SceneBody::whole(load::load_with(Path::new(path), access)?, Some(access)))
        })
    }
}

/// Begins a scene that is made of arrays; `name` is UTF-8, for people, and may be `NULL`. Add textures,
/// then the materials that use them, then meshes, then instances; then finish it. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_create(
    name: *const c_char,
    scene: *mut *mut klieg_scene,
) -> klieg_status {
    // SAFETY: the caller's pointers.
    unsafe {
        make(scene, || {
            let name = CString::new(text(name, "name")?).unwrap_or_default();
            Ok(SceneBody::Parts(SceneBuilder::default(), name))
        })
    }
}

/// Ends the scene; `NULL` is left alone.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_destroy(scene: *mut klieg_scene) {
    // SAFETY: the caller's handle.
    unsafe { destroy(scene) };
}

/// Adds a texture, and makes its mip levels; gives its number for `klieg_texture_ref::texture`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_add_texture(
    scene: *mut klieg_scene,
    texture: *const klieg_texture,
    number: *mut u32,
) -> klieg_status {
    let add = |scene: &mut SceneBody| {
        // SAFETY: the caller's pointers.
        unsafe {
            let texture = given(texture, "texture")?;
            let count = u64::from(texture.width) * u64::from(texture.height);
            let count = usize::try_from(count).unwrap_or(usize::MAX);
            let wraps = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
            let wrap = |at: usize| choice(&wraps, texture.wrap[at], "wrap");
            let added = scene.parts()?.add_texture(&TextureData {
                name: text(texture.name, "the texture's name")?,
                width: texture.width,
                height: texture.height,
                texels: array(texture.texels.cast(), count, "texels")?,
                srgb: texture.srgb != vk::FALSE,
                wrap: [wrap(0)?, wrap(1)?],
            })?;
            put(number, added, "number")
        }
    };
    // SAFETY: the caller's handle.
    unsafe { call(scene, add) }
}

/// Sets glTF's default material, without textures. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_material_defaults(material: *mut klieg_material) -> klieg_status {
    let none =
        klieg_texture_ref { texture: KLIEG_NO_TEXTURE, uv_set: 0, transform: TextureRef::UNMOVED };
    let default = Material::default();
    let defaults = klieg_material {
        name: std::ptr::null(),
        base_color: default.base_color,
        metallic: default.metallic,
        roughness: default.roughness,
        emissive: default.emissive,
        normal_scale: default.normal_scale,
        alpha_cutoff: default.alpha_cutoff,
        double_sided: default.double_sided.into(),
        base_color_texture: none,
        metallic_roughness_texture: none,
        normal_texture: none,
        emissive_texture: none,
    };
    // SAFETY: the caller's pointer.
    free_call(|| unsafe { put(material, defaults, "material") })
}

/// Adds a material; gives its number for `klieg_mesh::material`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_add_material(
    scene: *mut klieg_scene,
    material: *const klieg_material,
    number: *mut u32,
) -> klieg_status {
    let add = |scene: &mut SceneBody| {
        // SAFETY: the caller's pointers.
        unsafe {
            let material = as_material(given(material, "material")?)?;
            put(number, scene.parts()?.add_material(material)?, "number")
        }
    };
    // SAFETY: the caller's handle.
    unsafe { call(scene, add) }
}

/// Adds a mesh; gives its number for `klieg_scene_add_instance`.
///
/// `KLIEG_ERROR_ARGUMENT` names the mesh and what is wrong: no triangles, an index out of range, a number
/// that is not finite, a material that was not added before, missing coordinates of its textures.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_add_mesh(
    scene: *mut klieg_scene,
    mesh: *const klieg_mesh,
    number: *mut u32,
) -> klieg_status {
    let add = |scene: &mut SceneBody| {
        // SAFETY: the caller's pointers.
        unsafe {
            let mesh = given(mesh, "mesh")?;
            let count = mesh.vertices;
            let added = scene.parts()?.add_mesh(&MeshData {
                name: text(mesh.name, "the mesh's name")?,
                positions: array(mesh.positions.cast(), count, "positions")?,
                normals: optional(mesh.normals.cast(), count, "normals")?,
                tangents: optional(mesh.tangents.cast(), count, "tangents")?,
                uvs: [
                    optional(mesh.uvs[0].cast(), count, "texture coordinates")?,
                    optional(mesh.uvs[1].cast(), count, "texture coordinates")?,
                ],
                colors: optional(mesh.colors.cast(), count, "colours")?,
                indices: optional(mesh.indices, mesh.index_count, "indices")?,
                material: (mesh.material != KLIEG_DEFAULT_MATERIAL).then_some(mesh.material),
            })?;
            put(number, added, "number")
        }
    };
    // SAFETY: the caller's handle.
    unsafe { call(scene, add) }
}

/// Draws a mesh once more. `world` leads from the mesh's own space into the world: 16 numbers, column
/// after column, affine. `name` is UTF-8, for people, and may be `NULL`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_add_instance(
    scene: *mut klieg_scene,
    name: *const c_char,
    mesh: u32,
    world: *const f64,
) -> klieg_status {
    let add = |scene: &mut SceneBody| {
        // SAFETY: the caller's pointers.
        let (name, world) = unsafe { (text(name, "name")?, numbers(world, "world")?) };
        Ok(scene.parts()?.add_instance(name, mesh, DMat4::from_cols_array(&world))?)
    };
    // SAFETY: the caller's handle.
    unsafe { call(scene, add) }
}

/// Finishes a scene that was made of arrays: now it can be used, and nothing can be added any more.
///
/// `KLIEG_ERROR_ARGUMENT` when nothing is drawn, or nothing that has any extent; the scene is then empty
/// and can be begun anew.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_finish(scene: *mut klieg_scene) -> klieg_status {
    let finish = |scene: &mut SceneBody| {
        let parts = std::mem::take(scene.parts()?);
        if let SceneBody::Parts(_, name) = scene {
            let made = parts.finish(&name.to_string_lossy())?;
            *scene = SceneBody::whole(made, None);
        }
        Ok(())
    };
    // SAFETY: the caller's handle.
    unsafe { call(scene, finish) }
}

/// Gives the centre of a finished scene's bounding box (3 numbers), the largest distance of a vertex from it (both
/// world units), and the number of triangles, instances counted each. Each pointer may be `NULL`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_bounds(
    scene: *mut klieg_scene,
    center: *mut f64,
    radius: *mut f64,
    triangles: *mut u32,
) -> klieg_status {
    let tell = |scene: &mut SceneBody| {
        let scene = scene.finished()?;
        let (middle, reach) = view::bounds(scene)?;
        // SAFETY: the caller's pointers.
        unsafe {
            if let Some(center) = center.cast::<[f64; 3]>().as_mut() {
                *center = middle.to_array();
            }
            if let Some(radius) = radius.as_mut() {
                *radius = reach;
            }
            if let Some(triangles) = triangles.as_mut() {
                *triangles = scene.polygons();
            }
        }
        Ok(())
    };
    // SAFETY: the caller's handle.
    unsafe { call(scene, tell) }
}

/// What was left out or replaced in making a finished scene, for people: lines of UTF-8, often none.
/// Valid until the scene is destroyed; never `NULL`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn klieg_scene_warnings(scene: *const klieg_scene) -> *const c_char {
    // SAFETY: the caller's handle.
    match unsafe { body(scene, "scene") } {
        Ok(SceneBody::Whole(_, warnings, _)) => warnings.as_ptr(),
        _ => c"".as_ptr(),
    }
}

fn as_texture(given: &klieg_texture_ref) -> Option<TextureRef> {
    let &klieg_texture_ref { texture, uv_set, transform } = given;
    (texture != KLIEG_NO_TEXTURE).then_some(TextureRef { texture, uv_set, transform })
}

/// # Safety
/// The material is valid.
unsafe fn as_material(given: &klieg_material) -> Outcome<Material> {
    Ok(Material {
        // SAFETY: the caller's promise.
        name: unsafe { text(given.name, "the material's name") }?.to_owned(),
        base_color: given.base_color,
        metallic: given.metallic,
        roughness: given.roughness,
        emissive: given.emissive,
        base_color_texture: as_texture(&given.base_color_texture),
        metallic_roughness_texture: as_texture(&given.metallic_roughness_texture),
        normal_texture: as_texture(&given.normal_texture),
        normal_scale: given.normal_scale,
        emissive_texture: as_texture(&given.emissive_texture),
        alpha_cutoff: given.alpha_cutoff,
        double_sided: given.double_sided != vk::FALSE,
    })
}
