//! Colours that colour-blind readers can tell apart.

/// Viridis (Smith & van der Walt 2015) at nine equal steps.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// The colour of `share` in 0..=1, from dark violet to yellow, as `#rrggbb`; NaN counts as 0.
pub fn viridis(share: f64) -> String {
    let [red, green, blue] = viridis_rgb(share);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// The same as red, green and blue.
pub fn viridis_rgb(share: f64) -> [u8; 3] {
    let place = if share > 0.0 { share.min(1.0) } else { 0.0 } * (VIRIDIS.len() - 1) as f64;
    let below = (place as usize).min(VIRIDIS.len() - 2);
    let part = place - below as f64;
    [0, 1, 2].map(|channel| {
        let [low, high] = [below, below + 1].map(|i| f64::from(VIRIDIS[i][channel]));
        (low + part * (high - low)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_are_those_of_viridis() {
        assert_eq!(viridis(0.0), "#440154");
        assert_eq!(viridis(1.0), "#fde725");
        assert_eq!(viridis(f64::NAN), "#440154");
    }
}
