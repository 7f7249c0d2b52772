//! Text fit for a terminal, whatever stands in the files that it quotes.
//!
//! A terminal takes control characters as orders: to change colours and titles, to move the cursor, to answer as if it
//! had been typed. Characters that turn the direction of writing make a text read as another one. They are shown by their
//! numbers, `\u001b`, as JSON and TOML write them; line breaks and tabs stay.

use std::borrow::Cow;
use std::fmt::Write;

/// `text` without anything that a terminal would obey.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_order) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if is_order(character) {
            // A String takes all that is written.
            let _ = write!(shown, "\\u{:04x}", character as u32);
        } else {
            shown.push(character);
        }
    }
    Cow::Owned(shown)
}

/// Controls of ASCII and of Latin-1, DEL among them, line and paragraph separators, and marks of the direction of writing.
fn is_order(character: char) -> bool {
    match character {
        '\n' | '\t' => false,
        '\u{061C}' | '\u{200E}' | '\u{200F}' => true,
        '\u{2028}'..='\u{202E}' | '\u{2066}'..='\u{2069}' => true,
        other => other.is_control(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_to_the_terminal_are_shown_and_not_given() {
        let cases = [
            ("\u{1b}[31mred\u{1b}[0m", "\\u001b[31mred\\u001b[0m"),
            ("\u{1b}]0;title\u{7}", "\\u001b]0;title\\u0007"),
            ("\u{9b}31m \u{85} \u{7f}", "\\u009b31m \\u0085 \\u007f"),
            ("a\rb\u{8}c\0", "a\\u000db\\u0008c\\u0000"),
            ("\u{202e}gnp\u{2066}\u{200f}", "\\u202egnp\\u2066\\u200f"),
        ];
        for (given, shown) in cases {
            assert_eq!(printable(given), shown);
        }
    }

    #[test]
    fn everything_else_stays_as_it_is() {
        let text = "line\n\tφ ≤ 1e−3 │ 数 é e\u{301} 👩\u{200d}🔬 \u{a0}";
        assert!(matches!(printable(text), Cow::Borrowed(same) if same == text));
    }

    #[test]
    fn json_stays_the_same_value() {
        let value = serde_json::json!({ "name\u{7f}": "\u{9b}31m\u{202e} \u{1b}" });
        let text = value.to_string();
        let read: serde_json::Value = serde_json::from_str(&printable(&text)).unwrap();
        assert_eq!(read, value);
        assert_ne!(printable(&text), text);
    }
}
