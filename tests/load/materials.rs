//! Materials and textures.

use crate::file::*;
use klieg::scene::framing::{Framing, frame};
use klieg::scene::view::View;
use klieg::scene::{Material, Scene, Wrap};
use serde_json::{Value, json};

/// The textured square with a material whose base colour texture is a picture.
pub fn pictured(picture: &[u8]) -> File {
    let mut file =
        File::textured(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}));
    let view = file.view(picture);
    file.push("images", json!({"bufferView": view, "mimeType": "image/png", "name": "picture"}));
    file.push("textures", json!({"source": 0}));
    file
}

#[test]
fn factors_and_flags() {
    let file = File::textured(json!({
        "name": "glow",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6
        },
        "emissiveFactor": [1.0, 0.5, 0.0],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
        "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
    }));
    let scene = file.scene();
    let material = &scene.materials[0];
    assert_eq!(material.name, "glow");
    assert_eq!(material.base_color, [0.1, 0.2, 0.3, 0.4]);
    assert_eq!((material.metallic, material.roughness), (0.5, 0.6));
    assert_eq!(material.emissive, [4.0, 2.0, 0.0]);
    assert!((material.alpha_cutoff - 0.25).abs() < 1e-3);
    assert!(material.double_sided);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

/// Object pixels of the square in a material with the given alpha and mode.
fn pixels(alpha: f32, mode: &str) -> usize {
    let scene = File::textured(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [1.0, 1.0, 1.0, alpha]},
        "alphaMode": mode, "doubleSided": true,
    }))
    .scene();
    let camera = frame(&scene, &Framing::default(), 1.0).unwrap();
    let view = View::new(&scene, camera, 101, 101).unwrap();
    let codes = klieg::cpu::visibility::draw(&scene, &view).code;
    codes.iter().filter(|&&code| code != 0).count()
}

#[test]
fn what_has_just_the_alpha_of_the_cutoff_is_solid() {
    let solid = pixels(1.0, "OPAQUE");
    assert!(solid > 1000);
    for mode in ["MASK", "BLEND"] {
        assert_eq!(pixels(0.5, mode), solid, "{mode}");
    }
    assert_eq!(pixels(0.498, "MASK"), 0);
    assert_eq!(pixels(0.498, "BLEND"), solid, "there is nothing else to see");
}

/// The square in the given material in front of one in the default material, or not.
fn beside(material: Value, has_default: bool) -> Scene {
    let mut file = File::textured(material);
    if has_default {
        let mut primitive = file.primitive().clone();
        primitive.as_object_mut().unwrap().remove("material");
        file.mesh(primitive);
    }
    file.scene()
}

#[test]
fn what_one_sees_through_is_drawn_only_where_there_is_nothing_else() {
    let glass = json!({"name": "glass",
        "extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.9}}});
    let veil = json!({"name": "veil", "alphaMode": "BLEND",
        "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.2]}});
    for material in [glass, veil] {
        let scene = beside(material.clone(), true);
        let drawn = &scene.materials[0];
        assert!(drawn.alpha_cutoff > drawn.base_color[3], "{material}");
        assert!(!scene.warnings.iter().any(|w| w.contains("as all else")), "{:?}", scene.warnings);
        let alone = beside(material, false);
        assert_eq!(alone.materials[0].alpha_cutoff, 0.0);
        assert!(alone.warnings[1].contains("transparent as all else"), "{:?}", alone.warnings);
    }
}

#[test]
fn what_is_unlit_shines_by_itself_unless_all_does() {
    let sign = json!({"name": "sign", "extensions": {"KHR_materials_unlit": {}},
        "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.4, 0.6, 1], "metallicFactor": 1}});
    let scene = beside(sign.clone(), true);
    let drawn = &scene.materials[0];
    assert_eq!((drawn.emissive, drawn.base_color), ([0.2, 0.4, 0.6], [0.0, 0.0, 0.0, 1.0]));
    assert_eq!((drawn.metallic, drawn.roughness), (0.0, 1.0));
    let alone = beside(sign, false);
    assert_eq!(alone.materials[0].base_color, [0.2, 0.4, 0.6, 1.0]);
    assert!(alone.warnings[0].contains("'sign' is unlit: drawn lit"), "{:?}", alone.warnings);
}

#[test]
fn extensions_change_the_factors() {
    let scene = beside(
        json!({"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {
            "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.2},
            "KHR_materials_sheen": {"sheenColorFactor": [0, 0, 0]},
            "KHR_materials_ior": {"ior": 1.45}, "KHR_materials_specular": {"specularFactor": 0.5}}}),
        false,
    );
    let drawn = &scene.materials[0];
    assert!((drawn.roughness - 0.2).abs() < 1e-6);
    assert_eq!((drawn.base_color, drawn.metallic), ([1.0; 4], 0.0));
    let broken = json!({"extensions": {"KHR_materials_ior": {"ior": "glass"}}});
    assert!(File::textured(broken).fault().contains("materials[0].extensions"));
}

#[test]
fn specular_and_glossiness_become_metallic_and_roughness() {
    let name = "KHR_materials_pbrSpecularGlossiness";
    let gold = json!({"diffuseFactor": [0, 0, 0, 0.7], "specularFactor": [0.9, 0.6, 0.2],
        "glossinessFactor": 0.8});
    let scene = beside(json!({"extensions": {name: gold}}), false);
    let drawn = &scene.materials[0];
    for (found, expected) in drawn.base_color.into_iter().zip([0.9, 0.6, 0.2, 0.7]) {
        assert!((found - expected).abs() < 1e-3, "{:?}", drawn.base_color);
    }
    assert!((drawn.metallic - 1.0).abs() < 1e-3 && (drawn.roughness - 0.2).abs() < 1e-6);

    // The left texel is a rough red plastic, the right one polished gold.
    let mut file = File::textured(json!({"extensions": {name: {
        "diffuseTexture": {"index": 0}, "specularGlossinessTexture": {"index": 1}}}}));
    for texels in [[200, 20, 20, 255, 0, 0, 0, 255], [56, 56, 56, 0, 240, 200, 100, 255]] {
        let view = file.view(&png(2, 1, &texels));
        let image = file.push("images", json!({"bufferView": view}));
        file.push("textures", json!({"source": image}));
    }
    let scene = file.scene();
    let drawn = &scene.materials[0];
    let texels = |texture: Option<klieg::scene::TextureRef>| {
        let texture = &scene.textures[texture.unwrap().texture as usize];
        (texture.srgb, texture.levels[0].texels.clone())
    };
    let (srgb, base) = texels(drawn.base_color_texture);
    assert!(srgb && base[0][0].abs_diff(200) <= 2 && base[1][1].abs_diff(200) <= 3, "{base:?}");
    let (srgb, rest) = texels(drawn.metallic_roughness_texture);
    assert!(!srgb && rest[0][1] == 255 && rest[1][1] == 0, "{rest:?}");
    assert!(rest[0][2] < 10 && rest[1][2] > 245, "{rest:?}");
    assert_eq!((drawn.base_color, drawn.metallic, drawn.roughness), ([1.0; 4], 1.0, 1.0));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn the_default_material_stands_last() {
    let scene = File::square().scene();
    assert_eq!(scene.materials.len(), 1);
    assert_eq!(scene.meshes[0].material, 0);
    let default = Material::default();
    assert_eq!(scene.materials[0].base_color, default.base_color);
    assert_eq!(File::textured(json!({})).scene().materials.len(), 2);
}

#[test]
fn blended_and_unlit_materials_are_warned_of() {
    let scene = File::textured(json!({"alphaMode": "BLEND"})).scene();
    assert!(scene.warnings[0].contains("blended"), "{:?}", scene.warnings);

    let scene = File::textured(json!({"extensions": {"KHR_materials_unlit": {}}})).scene();
    assert!(scene.warnings[0].contains("unlit"), "{:?}", scene.warnings);
}

#[test]
fn warnings_end_somewhere() {
    let mut file = File::square();
    let blended = vec![json!({"alphaMode": "BLEND"}); 150];
    file.json["materials"] = json!(blended);
    let mut primitive = file.primitive().clone();
    let primitive = |number| {
        primitive["material"] = json!(number);
        primitive.clone()
    };
    let primitives: Vec<_> = (0..150).map(primitive).collect();
    file.json["meshes"][0]["primitives"] = json!(primitives);
    let scene = file.scene();
    assert_eq!((scene.materials.len(), scene.warnings.len()), (151, 101));
    assert!(scene.warnings[99].contains("material 99"), "{:?}", scene.warnings);
    assert!(scene.warnings[100].contains("further"), "{:?}", scene.warnings);
}

#[test]
fn an_optional_extension_is_warned_of_once() {
    let mut file = File::square();
    file.json["extensionsUsed"] =
        json!(["KHR_materials_iridescence", "KHR_materials_iridescence", "KHR_lights_punctual"]);
    let warnings = file.scene().warnings;
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("'KHR_materials_iridescence'"));
}

#[test]
fn mips_are_boxes_in_linear_light() {
    let checker = [[0, 0, 0, 0], [255; 4], [255; 4], [0, 0, 0, 0]].concat();
    let texture = &pictured(&png(2, 2, &checker)).scene().textures[0];
    assert_eq!(texture.levels.len(), 2);
    // Half the light is 188 in sRGB; alpha is linear.
    assert_eq!(texture.levels[1].texels, [[188, 188, 188, 128]]);

    // 5×3: every texel counts the same in what it becomes.
    let mut texels = [[0, 0, 0, 255]; 15];
    texels[14] = [255; 4];
    let texture = &pictured(&png(5, 3, texels.as_flattened())).scene().textures[0];
    let sizes: Vec<_> = texture.levels.iter().map(|l| (l.width, l.height)).collect();
    assert_eq!(sizes, [(5, 3), (2, 1), (1, 1)]);
    assert_eq!(texture.levels[1].texels[0], [0, 0, 0, 255]);
    // 1/15 of the light is 73.
    assert_eq!(texture.levels[2].texels[0][0].abs_diff(73), 0);
}

#[test]
fn an_image_is_one_texture_for_each_use() {
    let mut file = pictured(&png(1, 1, &[9; 4]));
    file.push("samplers", json!({"wrapS": 33071, "wrapT": 33648}));
    file.push("textures", json!({"source": 0, "sampler": 0}));
    file.push("textures", json!({"source": 0}));
    let material = &mut file.json["materials"][0];
    material["emissiveTexture"] = json!({"index": 2});
    material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = json!({"index": 0});
    material["normalTexture"] = json!({"index": 1, "scale": 0.5});
    let scene = file.scene();
    let material = &scene.materials[0];
    let number = |texture: Option<klieg::scene::TextureRef>| texture.unwrap().texture as usize;
    let base = number(material.base_color_texture);
    assert_eq!(base, number(material.emissive_texture), "same image, wrap and encoding");
    let linear = number(material.metallic_roughness_texture);
    assert!(base != linear && !scene.textures[linear].srgb);
    assert_eq!(scene.textures[linear].wrap, [Wrap::Repeat; 2]);
    let clamped = number(material.normal_texture);
    assert_eq!(scene.textures[clamped].wrap, [Wrap::Clamp, Wrap::Mirror]);
    assert_eq!(scene.textures.len(), 3);
    assert_eq!(material.normal_scale, 0.5);
}

#[test]
fn texture_transforms() {
    let mut file = pictured(&png(1, 1, &[9; 4]));
    let uv = file.accessor(&floats(&UVS), "VEC2", F32, 4);
    file.primitive()["attributes"]["TEXCOORD_1"] = json!(uv);
    let transform = json!({"KHR_texture_transform": {
        "offset": [0.25, 0.5], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2.0, 3.0],
        "texCoord": 1,
    }});
    let material = &mut file.json["materials"][0];
    material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] = transform.clone();
    material["normalTexture"] = json!({"index": 0, "extensions": transform});
    let scene = file.scene();
    for texture in [scene.materials[0].base_color_texture, scene.materials[0].normal_texture] {
        let texture = texture.unwrap();
        assert_eq!(texture.uv_set, 1);
        let expected = [[0.0, 3.0, 0.25], [-2.0, 0.0, 0.5]];
        for (value, expected) in texture.transform.iter().flatten().zip(expected.iter().flatten()) {
            assert!((value - expected).abs() < 1e-6, "{:?}", texture.transform);
        }
    }
}

#[test]
fn textures_without_their_coordinates_are_left_out() {
    for (set, attribute) in [(0, "TEXCOORD_1"), (1, "TEXCOORD_0"), (2, "TEXCOORD_0")] {
        let mut file = pictured(&png(1, 1, &[9; 4]));
        file.json["materials"][0]["normalTexture"] = json!({"index": 0, "texCoord": set});
        let uv = file.primitive()["attributes"]["TEXCOORD_0"].take();
        file.primitive()["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
        file.primitive()["attributes"][attribute] = uv;
        let scene = file.scene();
        assert!(scene.materials[0].normal_texture.is_none());
        assert!(
            scene.warnings.iter().any(|w| w.contains("normal texture") && w.contains("left out")),
            "{:?}",
            scene.warnings
        );
    }
}
