//! The quotes of a CSV file, judged before its fields are read.
//!
//! RFC 4180 lets a quoted field run over line breaks, so that a reader takes everything from a quote left open to the next
//! one, or to the end of the file, for one name. Names hold no line breaks: here a quote opens its field, closes it on
//! the same line, and is written twice inside it.

use crate::env::EdgeListProblem;

const OPEN: &str = "a quote is not closed on its line: close it there, a name holds no line breaks";
const TEXT_AFTER: &str =
    "text after a closing quote: end the field there, or write \"\" for a quote that is part of it";
const STRAY: &str = "a quote inside a field: put the whole field in quotes, from its first character on, and write \"\" \
     for a quote that is part of it";

/// Where in a line one stands.
#[derive(Clone, Copy)]
enum At {
    FieldStart,
    Unquoted,
    /// Inside quotes that opened in this column.
    Quoted(usize),
    /// After a quote that closes what the one in this column opened, unless another one follows.
    Closed(usize),
    /// After the blanks behind it.
    Blank,
}

/// Checks every line of `text`; of a broken rule also the line, from 1.
pub(super) fn check_quotes(text: &[u8]) -> Result<(), (u64, EdgeListProblem)> {
    for (number, line) in (1..).zip(lines(text)) {
        check_line(line)
            .map_err(|(column, rule)| (number, EdgeListProblem::Quote { column, rule }))?;
    }
    Ok(())
}

/// Lines, ended as the CSV reader ends records: by `\n`, `\r\n` or `\r`.
fn lines(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let text = rest?;
        let end = text.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let Some(end) = end else {
            rest = None;
            return Some(text);
        };
        let width = if text[end..].starts_with(b"\r\n") {
            2
        } else {
            1
        };
        rest = Some(&text[end + width..]);
        Some(&text[..end])
    })
}

/// The column, from 1 and in characters, of the first quote that breaks a rule, and the rule.
fn check_line(line: &[u8]) -> Result<(), (usize, &'static str)> {
    let (mut at, mut column) = (At::FieldStart, 0);
    for &byte in line {
        let continues_character = byte & 0xC0 == 0x80;
        column += usize::from(!continues_character);
        at = match (at, byte) {
            (At::FieldStart, b'"') => At::Quoted(column),
            (At::Quoted(opened), b'"') => At::Closed(opened),
            (At::Quoted(opened), _) => At::Quoted(opened),
            // The second of two quotes: the field goes on.
            (At::Closed(opened), b'"') => At::Quoted(opened),
            (_, b',') => At::FieldStart,
            (At::Closed(_) | At::Blank, b' ' | b'\t') => At::Blank,
            (At::Closed(_) | At::Blank, _) => return Err((column, TEXT_AFTER)),
            (At::Unquoted, b'"') => return Err((column, STRAY)),
            (At::FieldStart | At::Unquoted, _) => At::Unquoted,
        };
    }
    match at {
        At::Quoted(opened) => Err((opened, OPEN)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn broken(text: &str) -> Option<(u64, usize, &'static str)> {
        match check_quotes(text.as_bytes()) {
            Ok(()) => None,
            Err((line, EdgeListProblem::Quote { column, rule })) => Some((line, column, rule)),
            Err(other) => panic!("{other:?}"),
        }
    }

    #[test]
    fn quotes_that_open_and_close_a_field_pass() {
        for text in [
            "",
            "a,go,b\n",
            "\"a\",\"go\",\"b\"\r\n\"c, d\",go,\"the \"\"sea\"\"\"",
            "\"\",\"\"\"\",\"b\" \t,c",
        ] {
            assert_eq!(broken(text), None, "{text}");
        }
    }

    #[test]
    fn a_quote_left_open_is_found_where_it_opens() {
        assert_eq!(
            broken("from\na,go,c\na,alt,\"b\nb,go,c\n"),
            Some((3, 7, OPEN))
        );
        // The next quote would have closed it, and nothing would have been left open at the end.
        assert_eq!(broken("a,go,\"b\nb,go,\"c\n"), Some((1, 6, OPEN)));
        assert_eq!(broken("ä,\"go,b\"\"\r\n"), Some((1, 3, OPEN)));
        assert_eq!(broken("x\ry\r\"z\r"), Some((3, 1, OPEN)));
    }

    #[test]
    fn quotes_elsewhere_are_found_in_their_column() {
        assert_eq!(broken("a,\"go\"x,b"), Some((1, 7, TEXT_AFTER)));
        assert_eq!(broken("a,\"go\" \"x\",b"), Some((1, 8, TEXT_AFTER)));
        assert_eq!(broken("a,go, \"b\""), Some((1, 7, STRAY)));
        assert_eq!(broken("a,5\" disk,b"), Some((1, 4, STRAY)));
    }
}
