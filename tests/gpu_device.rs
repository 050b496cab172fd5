//! Choosing a device, and what is said when there is none.

use klieg::Error;
use klieg::gpu::{Context, ContextOptions, DeviceChoice, devices};
use klieg_support::gpu as support;

fn with(device: DeviceChoice) -> klieg::Result<std::sync::Arc<Context>> {
    support::watched(ContextOptions { device, ..Default::default() })
}

#[test]
fn devices_are_reported_and_chosen_by_index_and_name() {
    support::alone();
    let all = devices().expect("a Vulkan loader");
    assert!(!all.is_empty(), "no Vulkan device");
    for (index, report) in all.iter().enumerate() {
        assert_eq!(report.index, index);
        assert!(!report.info.name.is_empty() && !report.info.driver.is_empty());
        if report.lacks.is_empty() {
            let name = report.info.name.to_uppercase();
            let by_index = with(DeviceChoice::Index(index)).expect("the device");
            let by_name = with(DeviceChoice::Name(name)).expect("the device");
            assert_eq!(by_index.report().info, report.info);
            assert_eq!(by_name.report().info, report.info);
            support::assert_valid(&by_index);
            support::assert_valid(&by_name);
        }
    }
    assert!(with(DeviceChoice::Best).is_ok_and(|best| best.report().lacks.is_empty()));
}

#[test]
fn a_device_that_is_not_there_is_the_callers_fault() {
    for choice in [DeviceChoice::Index(99), DeviceChoice::Name("no such device".into())] {
        let error = with(choice).err().expect("no such device");
        assert!(matches!(error, Error::Argument(_)), "{error}");
        assert!(error.to_string().contains("there are 0: "), "{error}");
    }
}

/// The libraries of this process, without validation layers.
#[cfg(target_os = "linux")]
fn libraries() -> std::collections::BTreeSet<String> {
    let maps = std::fs::read_to_string("/proc/self/maps").expect("Linux");
    let paths = maps.lines().filter_map(|line| line.split_whitespace().nth(5));
    paths.filter(|path| path.contains(".so") && !path.contains("VkLayer")).map(Into::into).collect()
}

/// NVIDIA's driver can be loaded 30 times in a process and no more.
#[cfg(target_os = "linux")]
#[test]
fn drivers_stay_loaded_when_a_context_goes() {
    let context = with(DeviceChoice::Best).expect("a device");
    let held = libraries();
    drop(context);
    let gone = &held - &libraries();
    assert!(gone.is_empty(), "{gone:?}");
}

/// Set in the test's own copies of itself, whose environment lacks something.
const COPY: &str = "KLIEG_TEST_COPY";

#[test]
fn a_machine_without_vulkan_gets_a_reason() {
    if std::env::var_os(COPY).is_some() {
        let error = with(DeviceChoice::Best).err();
        println!("{}", error.map_or("no error".into(), |error| error.to_string()));
        return;
    }
    let empty = tempfile::tempdir().expect("a folder");
    let folder = empty.path().to_str().expect("a plain path").to_owned();
    std::fs::write(empty.path().join("libvulkan.so.1"), "").expect("a file");
    for (variable, value, expected) in [
        ("VK_ICD_FILENAMES", "/nonexistent.json", "Vulkan is not usable here"),
        ("VK_LAYER_PATH", folder.as_str(), "VK_LAYER_KHRONOS_validation is missing"),
        ("LD_LIBRARY_PATH", folder.as_str(), "no Vulkan loader"),
        ("KLIEG_UNUSED", "", "no error"),
    ] {
        let output = std::process::Command::new(std::env::current_exe().expect("this test"))
            .args(["--exact", "a_machine_without_vulkan_gets_a_reason", "--nocapture"])
            .env(COPY, "1")
            // It would take the place of VK_ICD_FILENAMES.
            .env_remove("VK_DRIVER_FILES")
            .env(variable, value)
            .output()
            .expect("the test's own program");
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(said.contains(expected), "{variable}: {said}");
    }
}
