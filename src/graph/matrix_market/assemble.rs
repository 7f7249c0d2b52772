//! Checked entries → sorted rows → adjacency.

use super::entries::Entry;
use super::error::{MatrixMarketError, MatrixMarketFault as Fault};
use super::header::{Header, Line};
use crate::graph::slack_rows::SlackRows;
use crate::graph::{Adjacency, GraphError};

/// A place in a row, and the line that fills it.
struct Slot {
    column: u32,
    line: u32,
    weight: f64,
}

/// The graph that `entries` describe; `lines` are where they stand.
pub(super) fn adjacency(
    header: &Header,
    lines: &[Line],
    entries: &[Entry],
) -> Result<Adjacency, MatrixMarketError> {
    let (offsets, mut slots) = scatter(header, entries);
    let rows = || offsets.windows(2).map(|ends| ends[0]..ends[1]);
    rows().for_each(|row| slots[row].sort_unstable_by_key(|slot| (slot.column, slot.line)));
    // Of all repetitions, the one that stands first in the file.
    let repeated = rows()
        .flat_map(|row| slots[row].windows(2))
        .filter(|pair| pair[0].column == pair[1].column)
        .min_by_key(|pair| pair[1].line);
    if let Some([first, second]) = repeated {
        return Err(repetition(
            &lines[first.line as usize],
            &lines[second.line as usize],
            entries[second.line as usize],
        ));
    }
    let mut kept = Vec::with_capacity(offsets.len());
    kept.push(0);
    let (mut columns, mut weights) = (
        Vec::with_capacity(slots.len()),
        Vec::with_capacity(slots.len()),
    );
    for row in rows() {
        for slot in slots[row].iter().filter(|slot| slot.weight != 0.0) {
            columns.push(slot.column);
            weights.push(slot.weight);
        }
        kept.push(columns.len());
    }
    Adjacency::from_rows(SlackRows::from_sorted(&kept, columns, weights))
        .map_err(|error| translate(error, lines, entries))
}

/// Counting sort by rows. In a symmetric matrix an entry off the diagonal goes to both of its rows.
fn scatter(header: &Header, entries: &[Entry]) -> (Vec<usize>, Vec<Slot>) {
    let halves = |entry: &Entry| {
        let mirrored = header.symmetric && entry.row != entry.column;
        [
            Some((entry.row, entry.column)),
            mirrored.then_some((entry.column, entry.row)),
        ]
        .into_iter()
        .flatten()
    };
    let mut offsets = vec![0; header.nodes + 1];
    entries
        .iter()
        .flat_map(halves)
        .for_each(|(row, _)| offsets[row as usize + 1] += 1);
    (0..header.nodes).for_each(|row| offsets[row + 1] += offsets[row]);
    let mut next = offsets.clone();
    let mut slots: Vec<Slot> = Vec::new();
    slots.resize_with(offsets[header.nodes], || Slot {
        column: 0,
        line: 0,
        weight: 0.0,
    });
    for (line, entry) in entries.iter().enumerate() {
        for (row, column) in halves(entry) {
            slots[next[row as usize]] = Slot {
                column,
                line: line as u32,
                weight: entry.weight,
            };
            next[row as usize] += 1;
        }
    }
    (offsets, slots)
}

fn repetition(first: &Line, second: &Line, entry: Entry) -> MatrixMarketError {
    let (row, column) = (entry.row as usize + 1, entry.column as usize + 1);
    Fault::Repeated {
        row,
        column,
        first_line: first.0,
    }
    .on_line(second.0)
}

/// What the adjacency finds wrong, in the terms of the file.
fn translate(error: GraphError, lines: &[Line], entries: &[Entry]) -> MatrixMarketError {
    match error {
        GraphError::Asymmetric {
            row,
            column,
            weight,
            mirrored,
        } => {
            let at = entries
                .iter()
                .position(|entry| (entry.row, entry.column) == (row, column));
            let (line, _) = lines[at.expect("an entry that is there came from a line")];
            Fault::Asymmetric {
                row: row as usize + 1,
                column: column as usize + 1,
                weight,
                mirrored,
            }
            .on_line(line)
        }
        GraphError::DegreeOverflow { node } => Fault::DegreeOverflow {
            row: node as usize + 1,
        }
        .nowhere(),
        other => unreachable!("entries are in range, positive and sorted, yet {other}"),
    }
}
