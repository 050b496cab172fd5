//! Which buffers and images of a file anything in it uses, so that the others are left alone.

use serde_json::{Map, Value};
use std::collections::BTreeSet;

/// Extensions beside Khronos's own that name images and buffers as glTF itself does.
const LIKE_GLTF: [&str; 5] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "MSFT_texture_dds",
];

/// Indices of what is used: images by textures, buffer views by accessors, images and extensions,
/// buffers by such views. Other extensions may name anything in their own way, and so use all images
/// and views.
#[derive(Debug, Default)]
pub struct Used {
    /// Of buffers.
    pub buffers: BTreeSet<usize>,
    /// Of buffer views.
    pub views: BTreeSet<usize>,
    /// Of images.
    pub images: BTreeSet<usize>,
}

impl Used {
    /// What the file with this root object uses.
    pub fn of(root: &Map<String, Value>) -> Self {
        let list = |key| root.get(key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let (images, views) = (list("images"), list("bufferViews"));
        let mut used = Self::default();
        let is_other = |name: &str| !name.starts_with("KHR_") && !LIKE_GLTF.contains(&name);
        if list("extensionsUsed").iter().filter_map(Value::as_str).any(is_other) {
            used.images.extend(0..images.len());
            used.views.extend(0..views.len());
        }
        list("textures").iter().for_each(|texture| collect(texture, "source", &mut used.images));
        for (_, value) in root.iter().filter(|(key, _)| *key != "images") {
            collect(value, "bufferView", &mut used.views);
        }
        for image in used.images.iter().filter_map(|&index| images.get(index)) {
            collect(image, "bufferView", &mut used.views);
        }
        for view in used.views.iter().filter_map(|&index| views.get(index)) {
            collect(view, "buffer", &mut used.buffers);
        }
        used
    }
}

/// Adds the indices that stand under `key` anywhere in `value`.
fn collect(value: &Value, key: &str, indices: &mut BTreeSet<usize>) {
    match value {
        Value::Object(object) => {
            for (name, value) in object {
                match value.as_u64().and_then(|index| usize::try_from(index).ok()) {
                    Some(index) if name == key => _ = indices.insert(index),
                    _ => collect(value, key, indices),
                }
            }
        }
        Value::Array(values) => values.iter().for_each(|value| collect(value, key, indices)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn used(root: Value) -> [Vec<usize>; 3] {
        let Used { buffers, views, images } = Used::of(root.as_object().unwrap());
        [buffers, views, images].map(|indices| indices.into_iter().collect())
    }

    /// Buffer views and images of which nothing but the last image and the views 0 to 2 is used.
    fn root() -> Value {
        json!({
            "accessors": [{"bufferView": 0}, {"sparse": {"indices": {"bufferView": 1},
                "values": {"bufferView": 2}}}],
            "bufferViews": [{"buffer": 4}, {"buffer": 1}, {"buffer": 1}, {"buffer": 2},
                {"buffer": 3}, {"buffer": 0, "extensions": {"X": {"buffer": 5}}}],
            "images": [{"bufferView": 3}, {"uri": "a.png"}, {"bufferView": 5}],
            "textures": [{"sampler": 1, "extensions": {"KHR_texture_basisu": {"source": 2}}}],
            "extensionsUsed": ["KHR_texture_basisu"],
        })
    }

    #[test]
    fn what_nothing_names_is_not_used() {
        assert_eq!(used(json!({})).concat(), Vec::<usize>::new());
        assert_eq!(used(root()), [vec![0, 1, 4, 5], vec![0, 1, 2, 5], vec![2]]);
        let mut compressed = root();
        let extensions = json!({"KHR_draco_mesh_compression": {"bufferView": 4}});
        compressed["meshes"] = json!([{"primitives": [{"extensions": extensions}]}]);
        assert_eq!(used(compressed), [vec![0, 1, 3, 4, 5], vec![0, 1, 2, 4, 5], vec![2]]);
    }

    #[test]
    fn an_unknown_extension_may_use_all_images_and_views() {
        let mut unknown = root();
        unknown["extensionsUsed"] = json!(["KHR_texture_basisu", "EXAMPLE_unknown"]);
        assert_eq!(used(unknown), [(0..6).collect(), (0..6).collect(), (0..3).collect::<Vec<_>>()]);
    }
}
