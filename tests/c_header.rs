//! `include/klieg.h` against the sources of the C interface, of which it is made.

use cbindgen::{Builder, Config, DocumentationStyle, Language, SortKey};
use std::fmt::Write;
use std::path::Path;

/// The parts of the header, each of the files that belong together.
const PARTS: [&[&str]; 11] = [
    &["error"],
    &["requirements"],
    &["context", "device"],
    &["light"],
    &["scene"],
    &["camera"],
    &["evaluator", "settings", "shadows"],
    &["surface"],
    &["pictures"],
    &["design", "designer", "intent"],
    &["lit"],
];

/// Types of Vulkan, by their names in ash.
const VULKAN: [&str; 16] = [
    "Bool32",
    "Buffer",
    "CommandBuffer",
    "Device",
    "DeviceCreateInfo",
    "DeviceMemory",
    "DeviceSize",
    "Format",
    "FormatFeatureFlags",
    "ImageLayout",
    "ImageView",
    "Instance",
    "MemoryRequirements",
    "PhysicalDevice",
    "Queue",
    "QueueFlags",
];

fn config() -> Config {
    let mut config = Config {
        language: Language::C,
        documentation_style: DocumentationStyle::C99,
        line_length: 100,
        tab_width: 4,
        usize_is_size_t: true,
        no_includes: true,
        ..Config::default()
    };
    config.constant.sort_by = Some(SortKey::None);
    config.function.sort_by = Some(SortKey::None);
    config.export.rename = VULKAN.map(|name| (name.into(), format!("Vk{name}"))).into();
    let loader = ("GetInstanceProcAddr".into(), "PFN_vkGetInstanceProcAddr".into());
    config.export.rename.extend([loader]);
    config
}

/// The declarations of some files of `src/c`.
fn part(room: &Path, files: &[&str]) -> String {
    let sources = files.iter().map(|file| room.join(format!("{file}.rs")));
    let builder = sources.fold(Builder::new(), |builder, file| builder.with_src(file));
    let mut text = Vec::new();
    builder.with_config(config()).generate().expect("declarations").write(&mut text);
    String::from_utf8(text).expect("UTF-8")
}

/// The whole header: the manual, and each part under the first line of its first file.
fn generated() -> String {
    let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/c");
    let read = |name: &str| std::fs::read_to_string(room.join(name)).expect("a source");
    let mut header = read("package/klieg.h.in");
    for files in PARTS {
        let source = read(&format!("{}.rs", files[0]));
        let title = source.lines().next().and_then(|line| line.strip_prefix("//! "));
        let title = title.expect("a title").trim_end_matches('.');
        write!(header, "\n/* {title} */\n\n{}\n", part(&room, files).trim()).expect("text");
    }
    header + "\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n"
}

#[test]
fn the_header_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("include/klieg.h");
    let text = generated();
    if std::env::var_os("KLIEG_WRITE_HEADER").is_some() {
        std::fs::write(&path, &text).unwrap();
    }
    let stored = std::fs::read_to_string(&path).unwrap_or_default();
    let difference = text.lines().zip(stored.lines()).find(|(new, old)| new != old);
    assert!(
        text == stored,
        "include/klieg.h is not what src/c gives: {difference:?}; \
         KLIEG_WRITE_HEADER=1 cargo test --test c_header writes it anew"
    );
}
