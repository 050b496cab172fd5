//! What loading takes of memory, alone in its program: every allocation counts.

use klieg::scene::load::load;
use std::alloc::{GlobalAlloc, Layout, System};
use std::io::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The system's allocator, counting bytes.
struct Counting;

static NOW: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

fn grown(size: usize) {
    let now = NOW.fetch_add(size, Ordering::Relaxed) + size;
    PEAK.fetch_max(now, Ordering::Relaxed);
}

// SAFETY: everything is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grown(layout.size());
        // SAFETY: the caller keeps the contract of `GlobalAlloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        grown(layout.size());
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        NOW.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // In the worst case both are there for a while.
        grown(size);
        NOW.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: as above.
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Vertices of a side of the grid.
const SIDE: u32 = 400;

/// Writes a grid with normals, its attributes apart or side by side, drawn by `instances` nodes.
/// Returns the bytes of its geometry.
fn write_grid(path: &std::path::Path, interleaved: bool, instances: usize) -> usize {
    let (vertices, cells) = (SIDE * SIDE, (SIDE - 1) * (SIDE - 1));
    let number = |x: u32| (x as f32 / SIDE as f32).to_le_bytes();
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    let mut both = Vec::new();
    for at in 0..vertices {
        let position = [number(at % SIDE), number(at / SIDE), number(0)].concat();
        let normal = [0.0f32, 0.0, 1.0].map(f32::to_le_bytes).concat();
        both.extend([&position[..], &normal].concat());
        positions.extend(position);
        normals.extend(normal);
    }
    let corners = (0..cells).flat_map(|cell| {
        let a = cell / (SIDE - 1) * SIDE + cell % (SIDE - 1);
        [a, a + 1, a + SIDE + 1, a, a + SIDE + 1, a + SIDE]
    });
    let indices: Vec<u8> = corners.flat_map(u32::to_le_bytes).collect();
    let bin = if interleaved { both } else { [positions, normals].concat() };
    let (attributes, count) = (bin.len(), indices.len() / 4);
    let stride = if interleaved { 24 } else { 12 };
    let second = if interleaved { 12 } else { attributes / 2 };
    let bin = [bin, indices].concat();
    let nodes = vec![r#"{"mesh":0}"#; instances].join(",");
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1}},"indices":2}}]}}],
        "accessors":[
        {{"bufferView":0,"componentType":5126,"count":{vertices},"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
        {{"bufferView":0,"byteOffset":{second},"componentType":5126,"count":{vertices},"type":"VEC3"}},
        {{"bufferView":1,"componentType":5125,"count":{count},"type":"SCALAR"}}],
        "bufferViews":[
        {{"buffer":0,"byteLength":{attributes},"byteStride":{stride}}},
        {{"buffer":0,"byteOffset":{attributes},"byteLength":{}}}],
        "buffers":[{{"byteLength":{}}}]}}"#,
        bin.len() - attributes,
        bin.len()
    );
    let json = format!("{json:width$}", width = json.len().next_multiple_of(4));
    let length = 12 + 8 + json.len() + 8 + bin.len();
    let mut file = std::fs::File::create(path).expect("a file in the temporary folder");
    let chunk =
        |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes(), kind, data].concat();
    let head = [&b"glTF"[..], &2u32.to_le_bytes(), &(length as u32).to_le_bytes()].concat();
    for part in [head, chunk(b"JSON", json.as_bytes()), chunk(b"BIN\0", &bin)] {
        file.write_all(&part).expect("room for the file");
    }
    bin.len()
}

/// Most bytes that were taken at once while `work` ran, beyond what was taken before.
fn peak<T>(work: impl FnOnce() -> T) -> (usize, T) {
    let before = NOW.load(Ordering::Relaxed);
    PEAK.store(before, Ordering::Relaxed);
    let result = work();
    (PEAK.load(Ordering::Relaxed) - before, result)
}

#[test]
fn loading_takes_at_most_two_and_a_half_times_the_files_geometry() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // The first load sets up the threads and their queues.
    let path = folder.path().join("grid.glb");
    write_grid(&path, false, 1);
    load(&path).expect("a scene");
    for (interleaved, instances) in [(false, 1), (true, 1), (false, 50)] {
        let bytes = write_grid(&path, interleaved, instances);
        let (peak, scene) = peak(|| load(&path).expect("a scene"));
        let share = peak as f64 / bytes as f64;
        assert_eq!(scene.polygons() as usize, instances * 2 * (SIDE as usize - 1).pow(2));
        assert_eq!((scene.meshes.len(), scene.instances.len()), (1, instances));
        // The allocator must have seen the vertices and the indices.
        assert!(share > 1.5 && share <= 2.5, "{share} times, interleaved: {interleaved}");
        let vertex = scene.meshes[0].vertices[SIDE as usize + 3];
        assert_eq!(vertex.position, [3.0 / SIDE as f32, 1.0 / SIDE as f32, 0.0]);
        assert_eq!(vertex.normal, [0.0, 0.0, 1.0]);
    }
}
