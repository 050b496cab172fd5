//! MTL, the materials of OBJ files (Wavefront), with metallic, roughness and normal maps as Blender writes them.
//! Colours are taken as linear, as Blender has them.

use super::push;
use crate::scene::load::resources::Resources;
use crate::scene::load::{FileAccess, quoted};
use percent_encoding::{AsciiSet, CONTROLS, utf8_percent_encode};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tobj::{LoadError, MTLLoadResult, Material};

/// What stands for itself in paths, but not in URIs.
const IN_PATHS: &AsciiSet = &CONTROLS.add(b'%').add(b'#').add(b'?').add(b' ');

/// Formats of pictures that klieg reads, by the ends of their names.
const PICTURES: [&str; 4] = ["png", "jpg", "jpeg", "webp"];

/// The material libraries that an OBJ file names.
pub struct Libraries<'a> {
    resources: Resources<'a>,
    /// What was left out.
    pub warnings: Vec<String>,
}

impl<'a> Libraries<'a> {
    /// Those of the file at `path`.
    pub fn new(path: &'a Path, access: FileAccess) -> Self {
        Self { resources: Resources::new(path, access, 0), warnings: Vec::new() }
    }

    /// The library's files that were read.
    pub fn files(&self) -> &[PathBuf] {
        &self.resources.files[1..]
    }

    /// Reads a library. One that is not there, or cannot be read, is left out.
    ///
    /// # Errors
    /// What is wrong with it; the warnings say it too.
    pub fn load(&mut self, named: &Path) -> MTLLoadResult {
        let (uri, name) = (as_uri(&named.to_string_lossy()), named.to_string_lossy());
        let fault = |fault: &dyn std::fmt::Display| {
            format!("materials of {} are left out: {fault}", quoted(&name))
        };
        let text = self.resources.fetch(&uri).map_err(|error| {
            self.warnings.push(fault(&error));
            LoadError::OpenFileFailed
        })?;
        let text = String::from_utf8_lossy(&text);
        let (mut materials, numbers) =
            tobj::load_mtl_buf(&mut text.as_bytes()).inspect_err(|error| {
                self.warnings.push(fault(error));
            })?;
        let folder = name.replace('\\', "/");
        let folder = folder.rfind('/').map_or("", |end| &folder[..=end]);
        let within = |map: &mut Option<String>| {
            *map =
                map.as_deref().and_then(picture_of).map(|file| as_uri(&format!("{folder}{file}")));
        };
        for material in &mut materials {
            within(&mut material.diffuse_texture);
            within(&mut material.dissolve_texture);
            within(&mut material.normal_texture);
            for map in ["norm", "map_Ke"] {
                let mut named = material.unknown_param.remove(map);
                within(&mut named);
                material.unknown_param.extend(named.map(|uri| (map.to_owned(), uri)));
            }
        }
        Ok((materials, numbers))
    }

    /// A material as glTF has it; its pictures go into the root object.
    pub fn convert(&mut self, root: &mut Value, material: &Material) -> Value {
        let other = |name: &str| material.unknown_param.get(name).map(String::as_str);
        let number = |name: &str| other(name).and_then(|text| text.parse::<f32>().ok());
        let unit = |value: f32| if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 };
        let color = self.texture(root, material.diffuse_texture.as_deref());
        // Of a textured surface exporters leave the colour black or grey.
        let base = material.diffuse.filter(|_| color.is_none()).unwrap_or([1.0; 3]).map(unit);
        // Some programs write 1 for opaque surfaces, others for invisible ones.
        let clear = number("Tr").filter(|clear| *clear < 1.0);
        let alpha = material.dissolve.or(clear.map(|clear| 1.0 - clear)).map_or(1.0, unit);
        let roughness = number("Pr").map_or(roughness(material.shininess), unit);
        let mut made = json!({
            "name": material.name, "doubleSided": true,
            "pbrMetallicRoughness": {
                "baseColorFactor": [base[0], base[1], base[2], alpha],
                "metallicFactor": number("Pm").map_or(0.0, unit), "roughnessFactor": roughness,
            },
        });
        let cut_out = material.dissolve_texture.is_some();
        if cut_out && material.dissolve_texture == material.diffuse_texture {
            made["alphaMode"] = json!("MASK");
        } else if alpha < 1.0 {
            made["alphaMode"] = json!("BLEND");
        }
        if let Some(texture) = color {
            made["pbrMetallicRoughness"]["baseColorTexture"] = texture;
        }
        if let Some(texture) =
            self.texture(root, other("norm").or(material.normal_texture.as_deref()))
        {
            made["normalTexture"] = texture;
        }
        let glow = self.texture(root, other("map_Ke"));
        let emissive = material.emissive.filter(|_| glow.is_none()).map(|color| color.map(unit));
        made["emissiveFactor"] =
            json!(emissive.unwrap_or([f32::from(u8::from(glow.is_some())); 3]));
        if let Some(texture) = glow {
            made["emissiveTexture"] = texture;
        }
        let unread = ["map_Pr", "map_Pm"].into_iter().filter(|map| other(map).is_some());
        let alone = (cut_out && made["alphaMode"] != "MASK").then_some("map_d");
        for map in unread.chain(alone) {
            let name = quoted(&material.name);
            self.warnings.push(format!("material {name}: its {map} is not read"));
        }
        made
    }

    /// The texture of a picture, which is left out where it is not there or in another format.
    fn texture(&mut self, root: &mut Value, uri: Option<&str>) -> Option<Value> {
        let uri = uri?;
        let end = uri.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
        let fault = if !PICTURES.contains(&end.as_str()) {
            "klieg reads PNG, JPEG and WebP"
        } else if self.resources.is_missing(uri) {
            "there is no such file"
        } else {
            let there = |image: &Value| image["uri"] == uri;
            let known = root["images"].as_array().and_then(|images| images.iter().position(there));
            let index = known.map_or_else(
                || {
                    let image = push(root, "images", json!({"uri": uri}));
                    push(root, "textures", json!({"source": image}))
                },
                Value::from,
            );
            return Some(json!({"index": index}));
        };
        let warning = format!("texture {} is left out: {fault}", quoted(uri));
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
        None
    }
}

/// Perceptual roughness of a specular exponent, as Blender reads it: 1 at 0 and 0 from 900 on.
fn roughness(exponent: Option<f32>) -> f32 {
    exponent.filter(|ns| ns.is_finite()).map_or(0.6, |ns| 1.0 - ns.clamp(0.0, 900.0).sqrt() / 30.0)
}

fn as_uri(path: &str) -> String {
    utf8_percent_encode(path, IN_PATHS).to_string()
}

/// The file that a map names, behind its options.
fn picture_of(map: &str) -> Option<String> {
    let mut rest = map.trim();
    while let Some((option, behind)) = rest.split_once(char::is_whitespace) {
        let most = match option {
            "-s" | "-o" | "-t" => 3,
            "-mm" => 2,
            "-bm" | "-blendu" | "-blendv" | "-boost" | "-cc" | "-clamp" | "-imfchan"
            | "-texres" | "-type" => 1,
            _ => break,
        };
        rest = behind.trim_start();
        // Of three numbers the second and third may be left out.
        for number in 0..most {
            let Some((value, behind)) = rest.split_once(char::is_whitespace) else { break };
            if number > 0 && value.parse::<f32>().is_err() {
                break;
            }
            rest = behind.trim_start();
        }
    }
    (!rest.is_empty()).then(|| rest.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_options_of_maps_are_no_part_of_their_names() {
        for (map, file) in [
            ("wood.png", Some("wood.png")),
            ("-s 2 2 2 -o 0.5 wood grain.png", Some("wood grain.png")),
            ("-bm 0.3 -clamp on a.png", Some("a.png")),
            ("-mm 0 1 a.png", Some("a.png")),
            ("-1.png", Some("-1.png")),
            ("  ", None),
        ] {
            assert_eq!(picture_of(map).as_deref(), file, "{map}");
        }
    }

    #[test]
    fn exponents_are_roughnesses_as_blender_has_them() {
        let all = [None, Some(0.0), Some(225.0), Some(900.0), Some(1e4), Some(f32::NAN)];
        assert_eq!(all.map(roughness), [0.6, 1.0, 0.5, 0.0, 0.0, 0.6]);
    }
}
