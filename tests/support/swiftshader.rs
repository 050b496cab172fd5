//! SwiftShader, a Vulkan driver that comes with Chromium.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What tells Vulkan's loader which drivers there are.
const DRIVERS: [&str; 2] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"];

/// SwiftShader's description, beside the browser's program.
fn driver() -> PathBuf {
    let usual = [
        "/usr/lib/chromium",
        "/usr/lib64/chromium",
        "/usr/lib64/chromium-browser",
        "/opt/google/chrome",
    ];
    let named = std::env::var_os("CHROMIUM").and_then(|program| {
        PathBuf::from(program).canonicalize().ok()?.parent().map(Path::to_owned)
    });
    let folders: Vec<_> = named.into_iter().chain(usual.map(PathBuf::from)).collect();
    let mut found = folders.iter().map(|folder| folder.join("vk_swiftshader_icd.json"));
    let message = format!("no SwiftShader in {folders:?}: install Chromium, or set CHROMIUM");
    found.find(|path| path.is_file()).expect(&message)
}

/// Runs the test of that name again, with SwiftShader as the only driver; whether this is that run.
///
/// # Panics
/// Where there is no SwiftShader, and where the test fails on it.
pub fn on_swiftshader(test: &str) -> bool {
    let driver = driver();
    if std::env::var_os(DRIVERS[0]).is_some_and(|set| set == driver.as_os_str()) {
        return true;
    }
    let mut command = Command::new(std::env::current_exe().expect("a running program"));
    command.args(["--exact", test, "--nocapture"]).envs(DRIVERS.map(|name| (name, &driver)));
    let status = command.status().expect("the program starts again");
    assert!(status.success(), "{test} fails on SwiftShader: {status}");
    false
}
