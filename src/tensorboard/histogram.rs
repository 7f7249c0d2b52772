//! Histograms of values: counts in buckets of equal width between the smallest and the largest.

use super::protobuf::Message;

/// As many as TensorBoard draws.
const BUCKETS: usize = 30;

/// The histogram of the finite ones among `values` as a `HistogramProto`; nothing if there are none. O(values).
pub(super) fn histogram(values: impl Iterator<Item = f64> + Clone) -> Option<Message> {
    let values = values.filter(|value| value.is_finite());
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut count, mut sum, mut squares) = (0_u64, 0.0, 0.0);
    for value in values.clone() {
        (low, high) = (low.min(value), high.max(value));
        count += 1;
        sum += value;
        squares += value * value;
    }
    if count == 0 {
        return None;
    }
    let (limits, counts) = buckets(values, low, high);
    let mut message = Message::default();
    message.double(1, low);
    message.double(2, high);
    message.double(3, count as f64);
    message.double(4, sum);
    message.double(5, squares);
    message.doubles(6, &limits);
    message.doubles(7, &counts);
    Some(message)
}

/// Right edges and counts. One bucket is enough where all values are equal.
fn buckets(values: impl Iterator<Item = f64>, low: f64, high: f64) -> (Vec<f64>, Vec<f64>) {
    let width = (high - low) / BUCKETS as f64;
    if !(width > 0.0 && width.is_finite()) {
        return (vec![high], vec![values.count() as f64]);
    }
    let mut limits: Vec<f64> = (1..=BUCKETS).map(|i| low + i as f64 * width).collect();
    limits[BUCKETS - 1] = high;
    let mut counts = vec![0.0; BUCKETS];
    for value in values {
        let place = ((value - low) / width) as usize;
        counts[place.min(BUCKETS - 1)] += 1.0;
    }
    (limits, counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_its_bucket() {
        let values = [0.0, 0.0, 0.05, 1.5, 3.0, 3.0];
        let (limits, counts) = buckets(values.into_iter(), 0.0, 3.0);
        assert_eq!(counts.iter().sum::<f64>(), 6.0);
        assert_eq!((counts[0], counts[15], counts[29]), (3.0, 1.0, 2.0));
        assert_eq!(limits.len(), BUCKETS);
        assert_eq!(limits[29], 3.0);
        assert!(limits.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn equal_values_share_one_bucket_and_no_value_has_none() {
        assert_eq!(
            buckets([2.0; 4].into_iter(), 2.0, 2.0),
            (vec![2.0], vec![4.0])
        );
        assert!(histogram([f64::NAN, f64::INFINITY].into_iter()).is_none());
    }
}
