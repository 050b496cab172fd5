//! The most memory that this process has held, as Linux tells it.

/// Lets the peak begin anew at what is held now. Where that cannot be done, peaks are those since
/// the process began.
pub fn reset_peak() {
    // "5" resets the peak resident set size, proc_pid_clear_refs(5); a refusal is not our fault.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// Peak resident set size, bytes; `None` where the system does not tell.
pub fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_peak_holds_what_is_held() {
        let held = vec![1u8; 64 << 20];
        assert!(peak().unwrap() >= held.len() as u64);
        reset_peak();
        assert!(peak().unwrap() >= held.len() as u64);
        assert_eq!(held[held.len() - 1], 1);
    }
}
