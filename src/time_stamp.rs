//! The present in UTC, as records tell it.

use std::time::SystemTime;

/// `2026-03-01T12:00:00.123456789Z`, as RFC 3339 has it.
pub(crate) fn now() -> String {
    humantime::format_rfc3339(SystemTime::now()).to_string()
}

/// The second, fit for a file name: `2026-03-01T12-00-00Z`.
pub(crate) fn for_file_name() -> String {
    let second = humantime::format_rfc3339_seconds(SystemTime::now());
    second.to_string().replace(':', "-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_can_be_read_back_and_stand_in_file_names() {
        let before = SystemTime::now();
        let stamp = humantime::parse_rfc3339(&now()).unwrap();
        assert!(before <= stamp && stamp <= SystemTime::now());
        let name = for_file_name();
        let digits = name.replace(|c: char| c.is_ascii_digit(), "0");
        assert_eq!(digits, "0000-00-00T00-00-00Z");
    }
}
