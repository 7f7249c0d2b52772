//! A curve in one line of text.

const BLOCKS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

/// Draws `values` as at most `width` blocks, each the mean of its share of the values. Heights are logarithmic:
/// the first episodes of a run may be a hundred times as long as its last. Empty for no values.
///
/// # Panics
/// If `width` is 0.
pub fn sparkline(values: &[u32], width: usize) -> String {
    assert!(width > 0, "a sparkline needs room");
    let groups = values.len().min(width);
    let means: Vec<f64> = (0..groups)
        .map(|g| {
            let group = &values[g * values.len() / groups..(g + 1) * values.len() / groups];
            let sum: u64 = group.iter().map(|&v| u64::from(v)).sum();
            libm::log(1.0 + sum as f64 / group.len() as f64)
        })
        .collect();
    let low = means.iter().copied().fold(f64::INFINITY, f64::min);
    let high = means.iter().copied().fold(0.0, f64::max);
    let range = (high - low).max(f64::MIN_POSITIVE);
    means
        .iter()
        .map(|m| BLOCKS[(((m - low) / range) * 7.0).round() as usize])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn falls_with_its_values() {
        assert_eq!(sparkline(&[1000, 100, 10, 1], 40), "█▅▃▁");
        assert_eq!(sparkline(&[5; 100], 3), "▁▁▁");
        assert_eq!(sparkline(&[], 3), "");
        assert_eq!(sparkline(&[0], 3), "▁");
    }

    #[test]
    fn every_value_is_in_one_group() {
        let mut values = vec![1; 103];
        values[102] = 9;
        assert!(sparkline(&values, 10).ends_with('█'));
    }
}
