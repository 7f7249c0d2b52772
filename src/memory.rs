//! Memory of the machine, so that what cannot fit is refused before the work and not ended by the system in it.

use std::fs;

/// Taken where the system does not say: more than any machine that these programs run on.
const UNKNOWN: u64 = 1 << 40;

/// Bytes of memory of this machine.
pub(crate) fn total() -> u64 {
    let told = fs::read_to_string("/proc/meminfo").ok();
    told.as_deref().and_then(parse).unwrap_or(UNKNOWN)
}

/// The line `MemTotal:  16384 kB`.
fn parse(text: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"));
    let kilobytes: u64 = line?.trim().strip_suffix("kB")?.trim_end().parse().ok()?;
    kilobytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_the_whole_is_found() {
        let text = "MemFree:  1 kB\nMemTotal:       16384 kB\nSwapTotal: 2 kB\n";
        assert_eq!(parse(text), Some(16_384 * 1024));
        assert_eq!(parse("MemTotal: much\n"), None);
        assert_eq!(parse("MemTotal: 18446744073709551615 kB\n"), None);
        assert!(total() > 0);
    }
}
