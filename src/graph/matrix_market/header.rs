//! The first two lines that count: what kind of matrix, and how large.

use super::error::{MatrixMarketError, MatrixMarketFault as Fault, shorten};
use crate::memory;

/// What the weights are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Field {
    Pattern,
    Real,
    Integer,
}

/// What is said before the entries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    pub field: Field,
    /// Whether one entry stands for itself and its mirror image.
    pub symmetric: bool,
    /// Number of nodes n, 1 ‥ 2³² − 1.
    pub nodes: usize,
}

/// A line that counts: its number from 1, and its text without blanks around it.
pub(super) type Line<'a> = (usize, &'a str);

/// Splits `text` into header and lines of entries, as many as promised.
pub(super) fn read(text: &str) -> Result<(Header, Vec<Line<'_>>), MatrixMarketError> {
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line.trim()));
    let (_, first) = lines.next().unwrap_or((1, ""));
    let (field, symmetric) = kind(first).map_err(|fault| fault.on_line(1))?;
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('%'));
    let Some((size_line, size_text)) = lines.next() else {
        return Err(Fault::Size {
            found: "end of file".into(),
        }
        .nowhere());
    };
    let (nodes, promised) = size(size_text).map_err(|fault| fault.on_line(size_line))?;
    let entries: Vec<Line> = lines.collect();
    let found = entries.len() as u64;
    if found == promised {
        return Ok((
            Header {
                field,
                symmetric,
                nodes,
            },
            entries,
        ));
    }
    let surplus = usize::try_from(promised)
        .ok()
        .and_then(|promised| entries.get(promised));
    Err(Fault::EntryCount {
        size_line,
        promised,
        found,
    }
    .on_line(surplus.map_or(size_line, |&(line, _)| line)))
}

fn kind(line: &str) -> Result<(Field, bool), Fault> {
    let lower = line.trim_start_matches('\u{FEFF}').to_ascii_lowercase();
    let words: Vec<&str> = lower.split_whitespace().collect();
    let ["%%matrixmarket", "matrix", format, field, symmetry] = words[..] else {
        return Err(Fault::Header {
            found: shorten(line),
        });
    };
    let unsupported = |found: &str, supported| {
        Err(Fault::Unsupported {
            found: shorten(found),
            supported,
        })
    };
    if format != "coordinate" {
        return unsupported(format, "coordinate");
    }
    let field = match field {
        "pattern" => Field::Pattern,
        "real" | "double" => Field::Real,
        "integer" => Field::Integer,
        _ => return unsupported(field, "pattern, real or integer"),
    };
    match symmetry {
        "symmetric" => Ok((field, true)),
        "general" => Ok((field, false)),
        _ => unsupported(symmetry, "symmetric or general"),
    }
}

/// The number of nodes and of entries.
fn size(line: &str) -> Result<(usize, u64), Fault> {
    let numbers: Option<Vec<u64>> = line
        .split_whitespace()
        .map(|word| word.parse().ok())
        .collect();
    match numbers.as_deref() {
        Some(&[rows, columns, _]) if rows != columns => Err(Fault::NotSquare { rows, columns }),
        Some(&[0, _, _]) => Err(Fault::NoNodes),
        Some(&[_, _, promised]) if promised > u64::from(u32::MAX) => {
            Err(Fault::TooManyEntries { promised })
        }
        Some(&[nodes, _, promised]) => match usize::try_from(nodes) {
            Ok(nodes) if nodes < u32::MAX as usize && fits_in_memory(nodes) => {
                Ok((nodes, promised))
            }
            _ => Err(Fault::TooLarge { nodes }),
        },
        _ => Err(Fault::Size {
            found: shorten(line),
        }),
    }
}

/// Whether the arrays of `nodes` isolated nodes fit into half of the memory: three bytes of file may ask for gigabytes,
/// which many systems promise to whoever asks, and end the program when it uses them.
fn fits_in_memory(nodes: usize) -> bool {
    const BYTES_PER_NODE: u64 = 64;
    nodes as u64 * BYTES_PER_NODE <= memory::total() / 2
}
