//! Materials and textures.

use crate::file::*;
use klieg::scene::framing::{Framing, frame};
use klieg::scene::view::View;
use klieg::scene::{Material, Wrap};
use serde_json::json;

/// The textured square with a material whose base colour texture is a picture.
fn pictured(picture: &[u8]) -> File {
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
        assert_eq!(pixels(0.498, mode), 0, "{mode}");
    }
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
        json!(["KHR_materials_clearcoat", "KHR_materials_clearcoat", "KHR_lights_punctual"]);
    let warnings = file.scene().warnings;
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("'KHR_materials_clearcoat'"));
}

#[test]
fn pictures_of_every_kind() {
    let rgba = pictured(&png(1, 1, &[1, 2, 3, 4])).scene();
    assert_eq!(rgba.textures[0].levels[0].texels, [[1, 2, 3, 4]]);
    assert!(rgba.textures[0].srgb);

    let encode = |image: image::DynamicImage, format| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        pictured(&bytes.into_inner()).scene().textures[0].levels[0].texels[0]
    };
    use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb};
    let grey = DynamicImage::ImageLuma8(ImageBuffer::from_pixel(3, 2, Luma([77])));
    assert_eq!(encode(grey, ImageFormat::Png), [77, 77, 77, 255]);
    let alpha = DynamicImage::ImageLumaA8(ImageBuffer::from_pixel(1, 1, LumaA([9, 8])));
    assert_eq!(encode(alpha, ImageFormat::Png), [9, 9, 9, 8]);
    let deep = ImageBuffer::from_pixel(1, 1, Rgb([65535u16, 257 * 100, 0]));
    assert_eq!(encode(DynamicImage::ImageRgb16(deep), ImageFormat::Png), [255, 100, 0, 255]);
    let jpeg = DynamicImage::ImageRgb8(ImageBuffer::from_pixel(8, 8, Rgb([200, 200, 200])));
    assert!(encode(jpeg, ImageFormat::Jpeg)[0].abs_diff(200) <= 2);
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

/// The textured square with a base colour texture of a picture in a format that needs an extension.
fn extended(extension: &str, picture: &[u8]) -> File {
    let mut file = pictured(picture);
    file.json["textures"][0] = json!({"extensions": {extension: {"source": 0}}});
    file.json["extensionsUsed"] = json!([extension]);
    file
}

fn encoded(format: image::ImageFormat) -> Vec<u8> {
    let pixel = |x, y| image::Rgb([(x * 3) as u8, (y * 7) as u8, (x ^ y) as u8]);
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_fn(64, 48, pixel).write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

#[test]
fn webp_is_read() {
    let file = extended("EXT_texture_webp", &encoded(image::ImageFormat::WebP));
    let scene = file.scene();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let level = &scene.textures[0].levels[0];
    assert_eq!((level.width, level.height), (64, 48));
    assert_eq!(level.texels[64 * 2 + 5], [15, 14, 7, 255]);
}

#[test]
fn a_textures_own_image_comes_first_and_no_other_is_touched() {
    let mut file = pictured(&png(1, 1, &[1, 2, 3, 4]));
    file.push("images", json!({"uri": "missing.ktx2"}));
    file.push("images", json!({"uri": "missing.avif"}));
    file.json["textures"][0]["extensions"] = json!({"KHR_texture_basisu": {"source": 1}});
    file.push("textures", json!({"extensions": {"EXT_texture_avif": {"source": 2}}}));
    let scene = file.scene();
    assert_eq!(scene.textures[0].levels[0].texels, [[1, 2, 3, 4]]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    // A picture in a format that nothing decodes is left out, as all others that cannot be used.
    file.json["materials"][0]["emissiveTexture"] = json!({"index": 1});
    let warnings = file.scene().warnings;
    assert!(warnings[0].contains("emissive texture has no image"), "{warnings:?}");
}

#[test]
fn pictures_that_cannot_be_decoded_leave_their_factors() {
    let whole = png(64, 64, &[7; 64 * 64 * 4]);
    let jpeg = encoded(image::ImageFormat::Jpeg);
    // A header that claims more pixels than there are.
    let mut bomb = png(1, 1, &[0; 4]);
    bomb[16..24].copy_from_slice(&[0, 0, 1, 0, 0, 0, 1, 0]);
    let crc = crc32(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&crc.to_be_bytes());
    for (picture, words) in [
        (&b"text"[..], "neither PNG nor JPEG"),
        (b"GIF89a..", "image/gif"),
        (b"RIFF\x04\0\0\0WEBPVP8 ", "cannot be decoded"),
        (&whole[..whole.len() / 2], "cannot be decoded"),
        (&jpeg[..jpeg.len() / 2], "truncated"),
        (&jpeg[..jpeg.len() - 2], "truncated"),
        (&bomb, "cannot be decoded"),
    ] {
        let mut file = pictured(picture);
        file.json["materials"][0]["normalTexture"] = json!({"index": 1});
        let other = file.view(&png(1, 1, &[128, 128, 255, 255]));
        file.push("images", json!({"bufferView": other}));
        file.push("textures", json!({"source": 1}));
        let scene = file.scene();
        assert!(scene.materials[0].base_color_texture.is_none());
        let normal = scene.materials[0].normal_texture.unwrap().texture as usize;
        assert_eq!(scene.textures[normal].levels[0].texels, [[128, 128, 255, 255]]);
        let [warning] = &scene.warnings[..] else { panic!("{:?}", scene.warnings) };
        assert!(warning.contains("image 0 'picture' is left out"), "{warning}");
        assert!(warning.contains(words), "{words} in {warning}");
    }
}

#[test]
fn what_a_file_requires_must_be_decoded() {
    let webp = encoded(image::ImageFormat::WebP);
    // A header of 4x4 pixels without any.
    let mut ktx2 = [&b"\xABKTX 20\xBB\r\n\x1A\n"[..], &[0; 92]].concat();
    (ktx2[20], ktx2[24], ktx2[36]) = (4, 4, 1);
    for (extension, picture) in
        [("EXT_texture_webp", &webp[..webp.len() / 2]), ("KHR_texture_basisu", &ktx2)]
    {
        let mut file = extended(extension, picture);
        let warnings = file.scene().warnings;
        assert!(warnings[0].contains("'picture' is left out"), "{warnings:?}");
        file.json["extensionsRequired"] = json!([extension]);
        let fault = file.fault();
        assert!(fault.contains("image 0 'picture'") && fault.contains(extension), "{fault}");
    }
}

#[test]
fn pictures_that_are_not_there_are_errors_that_name_them() {
    let mut file = pictured(&png(1, 1, &[9; 4]));
    file.json["images"][0] = json!({"uri": "missing%20picture.png"});
    let fault = file.fault();
    assert!(fault.contains("missing%20picture.png") && fault.contains("not found"), "{fault}");
}

/// CRC-32 of a PNG chunk.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| (c >> 1) ^ (0xEDB8_8320 & (c & 1).wrapping_neg()))
    })
}
