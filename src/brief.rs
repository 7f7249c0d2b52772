//! Numbers in messages: all their digits, unless these are a row of zeros.

/// `0.25`, `1500`, `1e308`.
pub(crate) fn brief(value: f64) -> String {
    match value.abs() {
        0.0 | 1e-6..1e16 => value.to_string(),
        _ => format!("{value:e}"), // NaN and inf are written alike by both
    }
}

#[cfg(test)]
mod tests {
    use super::brief;

    #[test]
    fn zeros_are_not_counted_out() {
        let numbers = [0.0, -0.25, 1500.0, 1e308, -2.5e-9, f64::NAN, f64::INFINITY];
        let texts = ["0", "-0.25", "1500", "1e308", "-2.5e-9", "NaN", "inf"];
        assert_eq!(numbers.map(brief), texts);
    }
}
