//! The line by which the program knows its own pages and figures again.

/// A comment, which HTML and SVG write alike.
pub(super) const MARKER: &str = concat!(
    "<!-- made by eigentrail ",
    env!("CARGO_PKG_VERSION"),
    " -->"
);

/// Whether a file that begins so is a page or a figure of this program, of whatever version.
pub fn is_ours(text: &[u8]) -> bool {
    let begin = b"<!-- made by eigentrail ";
    text.windows(begin.len()).any(|window| window == begin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_we_make_is_known_again() {
        assert!(is_ours(format!("<!doctype html>\n{MARKER}\n").as_bytes()));
        let older = MARKER.replace(env!("CARGO_PKG_VERSION"), "0.0.1");
        assert!(is_ours(format!("<svg>\n{older}\n").as_bytes()));
        assert!(!is_ours(b"# notes on eigentrail"));
        assert!(!is_ours(b""));
    }
}
