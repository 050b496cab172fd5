//! Pictures: those that are read, and those that are left out.

use crate::file::*;
use crate::materials::pictured;
use serde_json::json;

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
        (&bomb, "claims 256x256 pixels"),
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
