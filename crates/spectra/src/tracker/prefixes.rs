//! Sizes of a graph that grows by a fixed share.

/// Numbers of nodes at each update: from min(`start`, n), each time a share of `growth` more, at least one node.
pub(crate) fn prefix_sizes(n: usize, start: usize, growth: f64) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(start.min(n)), move |&m| {
        let grown = ((m as f64 * (1.0 + growth)).round() as usize).max(m + 1);
        (m < n).then(|| grown.min(n))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prefixes_grow_by_the_share_asked_for_up_to_the_whole() {
        let sizes = |n, start, growth| prefix_sizes(n, start, growth).collect::<Vec<_>>();
        assert_eq!(sizes(200, 64, 0.5), [64, 96, 144, 200]);
        assert_eq!(sizes(30, 64, 0.5), [30]);
        assert_eq!(sizes(4, 1, 1e-9), [1, 2, 3, 4]);
    }
}
