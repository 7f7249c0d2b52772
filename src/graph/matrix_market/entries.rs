//! Lines of entries → (row, column, weight), by nalgebra-sparse, a block at a time.

use super::error::{MatrixMarketError, MatrixMarketFault as Fault, shorten};
use super::header::{Field, Header, Line};
use nalgebra_sparse::CooMatrix;
use nalgebra_sparse::io::load_coo_from_matrix_market_str as parse;
use rayon::prelude::*;
use std::fmt::Write;

/// One line of the file, with indices from 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub row: u32,
    pub column: u32,
    pub weight: f64,
}

/// Lines handed to the parser at once: its tree for a block stays in the cache, its fixed cost is spread out.
const BLOCK: usize = 4096;

/// The entries in the order of `lines`, checked one by one.
pub(super) fn read(header: &Header, lines: &[Line]) -> Result<Vec<Entry>, MatrixMarketError> {
    let blocks: Vec<Result<Vec<Entry>, MatrixMarketError>> = lines
        .par_chunks(BLOCK)
        .map(|block| read_block(header, block))
        .collect();
    let mut entries = Vec::with_capacity(lines.len());
    for block in blocks {
        entries.extend(block?);
    }
    Ok(entries)
}

fn read_block(header: &Header, lines: &[Line]) -> Result<Vec<Entry>, MatrixMarketError> {
    let Some(entries) = parse_lines(header, lines) else {
        let wrong = lines
            .iter()
            .find(|line| parse_lines(header, std::slice::from_ref(line)).is_none());
        let &(number, text) = wrong.unwrap_or(&lines[0]);
        return Err(diagnose(header, text).on_line(number));
    };
    match entries
        .iter()
        .zip(lines)
        .find(|(entry, _)| !(entry.weight.is_finite() && entry.weight >= 0.0))
    {
        Some((entry, &(number, _))) => Err(weight_fault(entry).on_line(number)),
        None => Ok(entries),
    }
}

fn weight_fault(entry: &Entry) -> Fault {
    Fault::Weight {
        row: entry.row as usize + 1,
        column: entry.column as usize + 1,
        weight: entry.weight,
    }
}

/// The entries of `lines`, one each; `None` if one of them is not an entry.
fn parse_lines(header: &Header, lines: &[Line]) -> Option<Vec<Entry>> {
    if lines.iter().any(|(_, line)| {
        line.split_whitespace()
            .take(2)
            .any(|word| word.len() > MOST_DIGITS)
    }) {
        return None;
    }
    let field = match header.field {
        Field::Pattern => "pattern",
        Field::Real => "real",
        Field::Integer => "integer",
    };
    let mut text = format!("%%MatrixMarket matrix coordinate {field} general\n");
    write!(text, "{n} {n} {}", lines.len(), n = header.nodes)
        .expect("a String takes all that is written");
    for (_, line) in lines {
        text.push('\n');
        text.push_str(line);
    }
    match header.field {
        Field::Pattern => parse::<()>(&text).ok().map(|coo| collect(&coo, |()| 1.0)),
        Field::Real => parse::<f64>(&text)
            .ok()
            .map(|coo| collect(&coo, |&weight| weight)),
        Field::Integer => parse::<i64>(&text)
            .ok()
            .map(|coo| collect(&coo, |&weight| weight as f64)),
    }
}

/// Longer indices are out of range whatever they say, and the parser would panic on them.
const MOST_DIGITS: usize = 19;

/// The triplets of `coo`, which keep the order of the lines; indices are below n < 2³².
fn collect<T: Clone>(coo: &CooMatrix<T>, weight: impl Fn(&T) -> f64) -> Vec<Entry> {
    let entry = |(row, column, value)| Entry {
        row: row as u32,
        column: column as u32,
        weight: weight(value),
    };
    coo.triplet_iter().map(entry).collect()
}

/// Why a line that the parser refuses is wrong.
fn diagnose(header: &Header, line: &str) -> Fault {
    let words: Vec<&str> = line.split_whitespace().collect();
    let expected = match header.field {
        Field::Pattern => "`row column`",
        Field::Real => "`row column weight`",
        Field::Integer => "`row column weight` with an integer weight",
    };
    let num_words = if header.field == Field::Pattern { 2 } else { 3 };
    let are_integers = words
        .iter()
        .take(2)
        .all(|word| word.bytes().all(|byte| byte.is_ascii_digit()));
    if words.len() != num_words || !are_integers {
        return Fault::Entry {
            expected,
            found: shorten(line),
        };
    }
    let index = |word: &str| {
        word.parse()
            .ok()
            .filter(|index| (1..=header.nodes).contains(index))
    };
    match (
        index(words[0]),
        index(words[1]),
        words.get(2).map(|word| word.parse::<f64>()),
    ) {
        (Some(row), Some(column), Some(Ok(weight))) if !weight.is_finite() => Fault::Weight {
            row,
            column,
            weight,
        },
        (Some(_), Some(_), _) => Fault::Entry {
            expected,
            found: shorten(line),
        },
        _ => {
            let [row, column] = [shorten(words[0]), shorten(words[1])];
            Fault::IndexOutOfRange {
                row,
                column,
                nodes: header.nodes,
            }
        }
    }
}
