//! Changes of a sound glTF file, so that faults lie behind the first checks of its form.

use arbitrary::{Result, Unstructured};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use std::sync::LazyLock;

/// A scene with most of what klieg reads: skins, morph targets, instances, textures, sparse accessors.
static BASE: LazyLock<(Value, Vec<u8>)> = LazyLock::new(|| {
    let root: Value = serde_json::from_str(include_str!("../bases/scene.gltf")).expect("JSON");
    let uri = root["buffers"][0]["uri"].as_str().expect("a URI");
    let buffer = STANDARD.decode(uri.split_once(',').expect("data").1).expect("base64");
    (root, buffer)
});

/// Most changes of a file.
const CHANGES: usize = 12;

/// Numbers at which things break.
const NUMBERS: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    3.0,
    4.0,
    7.0,
    255.0,
    256.0,
    65535.0,
    65536.0,
    4294967295.0,
    4294967296.0,
    1e12,
    9007199254740993.0,
    1.8446744073709552e19,
    1e-40,
    1e38,
    1e300,
    0.5,
    5121.0,
    5123.0,
    5125.0,
];

/// Texts that stand for kinds of things.
const TEXTS: [&str; 20] = [
    "",
    "SCALAR",
    "VEC2",
    "VEC3",
    "VEC4",
    "MAT4",
    "MASK",
    "BLEND",
    "STEP",
    "CUBICSPLINE",
    "LINEAR",
    "translation",
    "rotation",
    "scale",
    "weights",
    "image/jpeg",
    "image/webp",
    "data:,",
    "../x.bin",
    "orthographic",
];

/// A glTF or GLB file by these bytes: its name, and its own bytes.
pub fn scene(data: &[u8]) -> (&'static str, Vec<u8>) {
    let (mut root, mut buffer) = BASE.clone();
    let mut bytes = Unstructured::new(data);
    for _ in 0..CHANGES {
        if bytes.is_empty() || change(&mut root, &mut buffer, &mut bytes).is_err() {
            break;
        }
    }
    match data.first().is_some_and(|byte| byte % 2 == 1) {
        true => ("scene.glb", glb(root, &buffer)),
        false => ("scene.gltf", gltf(root, &buffer)),
    }
}

/// The sound scene with this picture.
pub fn with_picture(picture: &[u8]) -> Vec<u8> {
    let (mut root, buffer) = BASE.clone();
    let kind = match picture {
        [0x89, ..] => "image/png",
        [b'R', ..] => "image/webp",
        [0xab, ..] => "image/ktx2",
        _ => "image/jpeg",
    };
    let data = STANDARD.encode(picture);
    root["images"][0] = json!({"uri": format!("data:{kind};base64,{data}"), "mimeType": kind});
    if let Some(extension) =
        [("image/webp", "EXT_texture_webp"), ("image/ktx2", "KHR_texture_basisu")]
            .into_iter()
            .find_map(|(of, name)| (of == kind).then_some(name))
    {
        root["textures"][0] = json!({"extensions": {extension: {"source": 0}}});
        root["extensionsUsed"][0] = extension.into();
    }
    gltf(root, &buffer)
}

fn gltf(mut root: Value, buffer: &[u8]) -> Vec<u8> {
    if let Some(Value::Object(first)) = root.get_mut("buffers").and_then(|all| all.get_mut(0)) {
        let data = STANDARD.encode(buffer);
        first.insert("uri".into(), format!("data:application/octet-stream;base64,{data}").into());
    }
    root.to_string().into_bytes()
}

fn glb(mut root: Value, buffer: &[u8]) -> Vec<u8> {
    if let Some(Value::Object(first)) = root.get_mut("buffers").and_then(|all| all.get_mut(0)) {
        first.remove("uri");
    }
    let mut json = root.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut data = buffer.to_vec();
    data.resize(data.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + data.len();
    let word = |value: usize| (value as u32).to_le_bytes();
    let parts: [&[u8]; 9] = [
        b"glTF",
        &word(2),
        &word(total),
        &word(json.len()),
        b"JSON",
        &json,
        &word(data.len()),
        b"BIN\0",
        &data,
    ];
    parts.concat()
}

fn change(root: &mut Value, buffer: &mut Vec<u8>, bytes: &mut Unstructured) -> Result<()> {
    match bytes.int_in_range(0..=9)? {
        0 if !buffer.is_empty() => {
            let at = bytes.choose_index(buffer.len())?;
            buffer[at] = bytes.arbitrary()?;
        }
        1 if buffer.len() > 4 => {
            let at = bytes.choose_index(buffer.len() / 4)? * 4;
            let value =
                *bytes.choose(&[f32::NAN, f32::INFINITY, f32::MAX, -f32::MAX, 1e-40, 1e19, 0.0])?;
            buffer[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
        2 => buffer.truncate(bytes.choose_index(buffer.len() + 1)?),
        _ => {
            let other = part(root, bytes)?.clone();
            rewrite(part(root, bytes)?, other, bytes)?;
        }
    }
    Ok(())
}

/// One of all values in a value.
fn part<'a>(root: &'a mut Value, bytes: &mut Unstructured) -> Result<&'a mut Value> {
    let mut at = bytes.choose_index(count(root))?;
    nth(root, &mut at).ok_or(arbitrary::Error::IncorrectFormat)
}

/// The value of this number, itself first; what it has of its parts is taken off `at`.
fn nth<'a>(value: &'a mut Value, at: &mut usize) -> Option<&'a mut Value> {
    if *at == 0 {
        return Some(value);
    }
    *at -= 1;
    match value {
        Value::Array(all) => all.iter_mut().find_map(|part| nth(part, at)),
        Value::Object(all) => all.values_mut().find_map(|part| nth(part, at)),
        _ => None,
    }
}

/// A value and all in it.
fn count(value: &Value) -> usize {
    1 + match value {
        Value::Array(all) => all.iter().map(count).sum(),
        Value::Object(all) => all.values().map(count).sum(),
        _ => 0,
    }
}

fn rewrite(value: &mut Value, other: Value, bytes: &mut Unstructured) -> Result<()> {
    let way: u8 = bytes.int_in_range(0..=7)?;
    match (way, &mut *value) {
        (0..=3, Value::Number(_)) => {
            let number = *bytes.choose(&NUMBERS)?;
            // Whole numbers as such: an index is no float.
            let whole = number.fract() == 0.0 && (0.0..1e15).contains(&number);
            *value = if whole { json!(number as u64) } else { json!(number) };
        }
        (0..=3, Value::String(text)) => *text = (*bytes.choose(&TEXTS)?).into(),
        (0..=1, Value::Array(all)) if !all.is_empty() => {
            drop(all.remove(bytes.choose_index(all.len())?));
        }
        (2, Value::Array(all)) if !all.is_empty() => {
            let one = all[bytes.choose_index(all.len())?].clone();
            let times = *bytes.choose(&[1usize, 3, 300])?;
            all.extend(std::iter::repeat_n(one, times));
        }
        (0..=2, Value::Object(all)) if !all.is_empty() => {
            let at = bytes.choose_index(all.len())?;
            let key = all.keys().nth(at).cloned().unwrap_or_default();
            all.remove(&key);
        }
        (4, _) => *value = Value::Null,
        (5, _) => *value = json!({}),
        _ => *value = other,
    }
    Ok(())
}
