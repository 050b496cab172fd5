//! Small files that ask for much: each costs one message, little memory and little time.
#![cfg(target_os = "linux")]

use common::Folder;
use klieg_support::common;
use serde_json::{Value, json};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A triangle with texture coordinates, whose buffer is the file `a.bin`.
fn triangle() -> Value {
    json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 24}],
        "buffers": [{"byteLength": 60, "uri": "a.bin"}],
    })
}

/// Its buffer, as long as `length` says; what lies beyond takes no place on the disk.
fn buffer(place: &Folder, length: u64, indices: usize) {
    let values = [0.0f32, 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1.];
    let mut bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 2].repeat(indices / 3));
    std::fs::write(place.path("a.bin"), bytes).unwrap();
    let file = std::fs::File::options().write(true).open(place.path("a.bin")).unwrap();
    file.set_len(length).unwrap();
}

/// The same triangle drawn again and again by so many indices, with its buffer.
fn indexed(place: &Folder, count: usize) -> Value {
    buffer(place, 60 + count as u64, count);
    let mut scene = triangle();
    scene["buffers"][0]["byteLength"] = (60 + count).into();
    let view = json!({"buffer": 0, "byteOffset": 60, "byteLength": count});
    scene["bufferViews"].as_array_mut().unwrap().push(view);
    let indices = json!({"bufferView": 2, "componentType": 5121, "count": count, "type": "SCALAR"});
    scene["accessors"].as_array_mut().unwrap().push(indices);
    scene["meshes"][0]["primitives"][0]["indices"] = 2.into();
    scene
}

/// What became of a run.
struct Run {
    code: Option<i32>,
    said: String,
    /// Most kilobytes that it had in memory, and its seconds of computing, as seen last.
    kilobytes: u64,
    seconds: f64,
}

/// What a process has taken so far: kilobytes at most, and seconds of computing (proc_pid_status(5), proc_pid_stat(5)).
fn taken(process: u32) -> Option<(u64, f64)> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes = line.trim().trim_end_matches(" kB").parse().ok()?;
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let mut numbers = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || numbers.next()?.parse::<f64>().ok();
    Some((kilobytes, (ticks()? + ticks()?) / 100.0))
}

/// Scores a scene of the usual options within so many KiB of address space.
fn score(place: &Folder, scene: &Value, kibibytes: u32, seconds: u64) -> (Option<i32>, String) {
    let run = run(place, scene, (kibibytes, seconds), "--size 16x16");
    (run.code, run.said)
}

fn run(place: &Folder, scene: &Value, (kibibytes, seconds): (u32, u64), options: &str) -> Run {
    std::fs::write(place.path("a.gltf"), scene.to_string()).unwrap();
    let line = format!(
        "ulimit -v {kibibytes}; RAYON_NUM_THREADS=2 MALLOC_ARENA_MAX=2 RUST_BACKTRACE=0 exec {} \
         score a.gltf --preset headlight {options} --device cpu",
        assert_cmd::cargo::cargo_bin("klieg").display()
    );
    let mut shell = Command::new("sh");
    shell.current_dir(place.path("")).args(["-c", &line]).stdout(Stdio::null());
    let mut child = shell.stderr(Stdio::piped()).spawn().unwrap();
    let (begin, mut last) = (Instant::now(), (0, 0.0));
    while child.try_wait().unwrap().is_none() {
        last = taken(child.id()).unwrap_or(last);
        if begin.elapsed() > Duration::from_secs(seconds) {
            child.kill().unwrap();
            panic!("it takes more than {seconds} s");
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    Run { code: output.status.code(), said, kilobytes: last.0, seconds: last.1 }
}

/// Panics unless a scene is refused with these words, in 300 MB of address space, most of it the program's own, and
/// 64 MB of memory. It takes 0.2 s; a build for tests has five times that.
fn refused(place: &Folder, scene: &Value, words: &[&str]) {
    let Run { code, said, kilobytes, seconds } = run(place, scene, (300_000, 20), "--size 16x16");
    assert_eq!(code, Some(2), "{said}");
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
    println!("{kilobytes} kB, {seconds} s: {}", said.trim());
    assert!(kilobytes < 64_000 && seconds < 1.0, "{kilobytes} kB, {seconds} s: {said}");
}

#[test]
fn a_picture_that_claims_more_than_it_holds_is_not_decoded() {
    let place = Folder::new();
    buffer(&place, 60, 0);
    let mut picture = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(8, 8).write_to(&mut picture, image::ImageFormat::Jpeg).unwrap();
    let mut jpeg = picture.into_inner();
    // Behind the marker SOF0 and its length stand the precision, the height and the width.
    let frame = jpeg.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
    jpeg[frame + 5..frame + 9].copy_from_slice(&[0x40, 0, 0x40, 0]);
    std::fs::write(place.path("a.jpg"), jpeg).unwrap();
    let mut scene = triangle();
    scene["images"] = json!([{"uri": "a.jpg"}]);
    scene["textures"] = json!([{"source": 0}]);
    scene["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    scene["meshes"][0]["primitives"][0]["material"] = 0.into();
    let (code, said) = score(&place, &scene, 600_000, 20);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("a.jpg") && said.contains("claims 16384x16384 pixels"), "{said}");
}

#[test]
fn indices_without_data_draw_nothing_and_take_no_memory() {
    let place = Folder::new();
    buffer(&place, 64 << 20, 0);
    let mut scene = triangle();
    scene["buffers"][0]["byteLength"] = (64 << 20).into();
    let indices = json!({"componentType": 5125, "count": 500_000_000, "type": "SCALAR"});
    scene["accessors"].as_array_mut().unwrap().push(indices);
    scene["meshes"][0]["primitives"][0]["indices"] = 2.into();
    refused(&place, &scene, &["no triangles"]);
}

#[test]
fn few_bytes_do_not_draw_many_meshes_or_triangles() {
    let place = Folder::new();
    buffer(&place, 60, 0);
    let mut scene = triangle();
    let primitive = scene["meshes"][0]["primitives"][0].clone();
    scene["meshes"][0]["primitives"] = vec![primitive; 2000].into();
    scene["nodes"] = vec![json!({"mesh": 0, "name": "n".repeat(200)}); 2000].into();
    scene["scenes"][0]["nodes"] = (0..2000).collect::<Vec<_>>().into();
    refused(&place, &scene, &["meshes", "--allow-large"]);
    let mut scene = indexed(&place, 300_000);
    scene["nodes"] = vec![json!({"mesh": 0}); 4000].into();
    scene["scenes"][0]["nodes"] = (0..4000).collect::<Vec<_>>().into();
    refused(&place, &scene, &["triangles", "--allow-large"]);
}

/// Each of them fills half of the picture: what is behind the limit would take a minute and more.
#[test]
fn triangles_that_cover_each_other_without_end_are_refused() {
    let place = Folder::new();
    let scene = indexed(&place, 60_000);
    let options = "--size 2048x2048 --azimuth 0 --elevation 0";
    let Run { code, said, .. } = run(&place, &scene, (4_000_000, 30), options);
    assert!(code == Some(2) && said.contains("cover each other"), "{said}");
}

/// The file system stores nothing of it, and the machine has no memory for it.
#[test]
fn a_sparse_file_is_refused_before_its_memory_is_taken() {
    let place = Folder::new();
    buffer(&place, 7 << 30, 0);
    let mut scene = triangle();
    scene["buffers"][0]["byteLength"] = (7u64 << 30).into();
    scene["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
    scene["bufferViews"][0]["byteLength"] = 6_600_000_000u64.into();
    scene["accessors"][0]["count"] = 530_000_000.into();
    let (code, said) = score(&place, &scene, 20_000_000, 60);
    // Of 38 GB of vertices; on a machine that has as much, the limit of the address space.
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("more memory"), "{said}");
}

#[test]
fn many_materials_and_deep_hierarchies_take_time_in_proportion() {
    let place = Folder::new();
    buffer(&place, 60, 0);
    let count = 300_000;
    let mut scene = triangle();
    scene["materials"] = (0..count).map(|i| json!({"name": format!("m{i}")})).collect();
    let attributes = &scene["meshes"][0]["primitives"][0]["attributes"].clone();
    scene["meshes"][0]["primitives"] =
        (0..count).map(|i| json!({"attributes": attributes, "material": i})).collect();
    let (code, said) = score(&place, &scene, 2_000_000, 120);
    assert_eq!(code, Some(0), "{said}");
    let mut scene = triangle();
    let nodes = 300_000;
    scene["nodes"] =
        (1..nodes).map(|i| json!({"children": [i]})).chain([json!({"mesh": 0})]).collect();
    let (code, said) = score(&place, &scene, 1_000_000, 60);
    assert_eq!(code, Some(0), "{said}");
}
