//! How much memory the machine has for a scene.

use std::fs::read_to_string;

/// Bytes that are free on the machine, or within the limits of this process's control group, as far as the
/// system tells; `u64::MAX` where it does not.
pub fn available() -> u64 {
    [machine(), group()].into_iter().flatten().min().unwrap_or(u64::MAX)
}

/// `MemAvailable` of proc_meminfo(5).
fn machine() -> Option<u64> {
    let text = read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}

/// What the memory controller of the control group leaves, version 2 as containers see their own.
fn group() -> Option<u64> {
    let number = |name| {
        let text = read_to_string(format!("/sys/fs/cgroup/memory.{name}")).ok()?;
        text.trim().parse::<u64>().ok()
    };
    Some(number("max")?.saturating_sub(number("current")?))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #[test]
    fn linux_tells_what_is_free() {
        assert!((1 << 20..u64::MAX).contains(&super::available()));
    }
}
