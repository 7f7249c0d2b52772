//! Sparse rows with room to grow: the storage under [`Adjacency`](super::Adjacency).
//!
//! All rows share one column array and one value array. Row r owns the slots `start .. start + capacity`, of which the
//! first `len` are filled, columns increasing:
//!
//! ```text
//! columns  │ 1 3 · · │ × × × × │ 0 2 4 5 7 · · · │        · slack   × abandoned
//!            row 0     (row 1     row 1
//!                      was here)
//! ```
//!
//! A full row moves to the end with twice the capacity (the last row simply extends) and abandons its old slots.
//!
//! **Cost.** Before it moves, a row of capacity c > 4 has received at least c/2 entries since its last move, so copying
//! c entries is O(1) per entry. The arrays are compacted when abandoned slots exceed half of the owned ones; that costs
//! O(owned + abandoned) ≤ 3 · abandoned, and every abandoned slot was paid for by the move that left it. An
//! insertion is therefore amortised O(1), plus the binary search and the shift inside its row, O(len), which is nothing
//! when columns arrive in increasing order.
//! **Space.** Owned slots ≤ max(4, 2 len) per row, abandoned ≤ half of the owned.

/// Slots of a row that gets its first entry: a cell of a grid world has four neighbours and never moves.
const FIRST_CAPACITY: u32 = 4;

#[derive(Clone, Copy, Debug, Default)]
struct Row {
    start: usize,
    len: u32,
    capacity: u32,
}

impl Row {
    fn filled(self) -> std::ops::Range<usize> {
        self.start..self.start + self.len as usize
    }

    fn end(self) -> usize {
        self.start + self.capacity as usize
    }
}

/// See the module's head.
#[derive(Clone, Debug, Default)]
pub(super) struct SlackRows {
    rows: Vec<Row>,
    columns: Vec<u32>,
    values: Vec<f64>,
    /// Filled slots.
    num_entries: usize,
    /// Slots that belong to no row any more.
    abandoned: usize,
}

impl SlackRows {
    /// Takes over rows that are already sorted, without slack; row r is `columns[offsets[r]..offsets[r + 1]]`.
    pub(super) fn from_sorted(offsets: &[usize], columns: Vec<u32>, values: Vec<f64>) -> Self {
        debug_assert_eq!(offsets.last(), Some(&columns.len()));
        let rows = offsets
            .windows(2)
            .map(|ends| {
                let len = u32::try_from(ends[1] - ends[0])
                    .expect("a row has at most as many entries as nodes");
                Row {
                    start: ends[0],
                    len,
                    capacity: len,
                }
            })
            .collect();
        let num_entries = columns.len();
        Self {
            rows,
            columns,
            values,
            num_entries,
            abandoned: 0,
        }
    }

    pub(super) fn num_rows(&self) -> usize {
        self.rows.len()
    }

    pub(super) fn num_entries(&self) -> usize {
        self.num_entries
    }

    /// Adds an empty row, which owns no slots yet.
    pub(super) fn push_row(&mut self) {
        self.rows.push(Row::default());
    }

    pub(super) fn columns(&self, row: usize) -> &[u32] {
        &self.columns[self.rows[row].filled()]
    }

    pub(super) fn values(&self, row: usize) -> &[f64] {
        &self.values[self.rows[row].filled()]
    }

    /// Where `column` stands in `row` (`Ok`) or belongs (`Err`).
    pub(super) fn position(&self, row: usize, column: u32) -> Result<usize, usize> {
        let columns = self.columns(row);
        match columns.last() {
            // Columns mostly arrive in increasing order: then no search is needed.
            Some(&last) if last >= column => columns.binary_search(&column),
            _ => Err(columns.len()),
        }
    }

    /// Puts an entry at the place that [`Self::position`] returned as `Err`.
    pub(super) fn insert(&mut self, row: usize, at: usize, column: u32, value: f64) {
        if self.rows[row].len == self.rows[row].capacity {
            self.enlarge(row);
        }
        let Row { start, len, .. } = self.rows[row];
        let (from, end) = (start + at, start + len as usize);
        self.columns.copy_within(from..end, from + 1);
        self.values.copy_within(from..end, from + 1);
        self.columns[from] = column;
        self.values[from] = value;
        self.rows[row].len += 1;
        self.num_entries += 1;
    }

    /// Doubles the capacity of `row`, moving it to the end unless it is there already.
    fn enlarge(&mut self, row: usize) {
        let old = self.rows[row];
        let capacity = old.capacity.saturating_mul(2).max(FIRST_CAPACITY);
        let is_last = old.capacity > 0 && old.end() == self.columns.len();
        let start = if is_last {
            old.start
        } else {
            self.columns.len()
        };
        self.columns.resize(start + capacity as usize, 0);
        self.values.resize(start + capacity as usize, 0.0);
        self.rows[row] = Row {
            start,
            capacity,
            ..old
        };
        if !is_last {
            self.columns.copy_within(old.filled(), start);
            self.values.copy_within(old.filled(), start);
            self.abandoned += old.capacity as usize;
            if self.abandoned > (self.columns.len() - self.abandoned) / 2 {
                self.compact();
            }
        }
    }

    /// Lays the rows out in order of their numbers, each with its slack, and drops what was abandoned.
    fn compact(&mut self) {
        let owned = self.columns.len() - self.abandoned;
        let mut columns = Vec::with_capacity(owned);
        let mut values = Vec::with_capacity(owned);
        for row in &mut self.rows {
            let start = columns.len();
            columns.extend_from_slice(&self.columns[row.start..row.end()]);
            values.extend_from_slice(&self.values[row.start..row.end()]);
            row.start = start;
        }
        self.columns = columns;
        self.values = values;
        self.abandoned = 0;
    }

    /// Checks everything that the module's head promises.
    pub(super) fn assert_consistent(&self) {
        assert_eq!(self.columns.len(), self.values.len());
        let mut slots: Vec<Row> = self
            .rows
            .iter()
            .copied()
            .filter(|row| row.capacity > 0)
            .collect();
        slots.sort_by_key(|row| row.start);
        assert!(
            slots.windows(2).all(|pair| pair[0].end() <= pair[1].start),
            "rows overlap"
        );
        assert!(
            slots
                .last()
                .is_none_or(|row| row.end() <= self.columns.len()),
            "a row leaves the array"
        );
        let owned: usize = slots.iter().map(|row| row.capacity as usize).sum();
        assert_eq!(owned + self.abandoned, self.columns.len(), "slots are lost");
        assert!(
            self.abandoned <= owned.div_ceil(2),
            "{} of {} slots abandoned",
            self.abandoned,
            self.columns.len()
        );
        let filled: usize = self.rows.iter().map(|row| row.len as usize).sum();
        assert_eq!(filled, self.num_entries);
        for (number, row) in self.rows.iter().enumerate() {
            assert!(row.len <= row.capacity);
            assert!(
                row.capacity <= FIRST_CAPACITY.max(row.len.saturating_mul(2)),
                "row {number} hoards slots"
            );
            assert!(
                self.columns(number).is_sorted_by(|a, b| a < b),
                "row {number} is not sorted"
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn insert(rows: &mut SlackRows, row: usize, column: u32) {
        if let Err(at) = rows.position(row, column) {
            rows.insert(row, at, column, f64::from(column));
        }
    }

    #[test]
    fn interleaved_rows_move_compact_and_stay_sorted() {
        let mut rows = SlackRows::default();
        (0..3).for_each(|_| rows.push_row());
        // 7 is a generator of the multiplicative group modulo 71: each column exactly once, in no order.
        let mut column = 1;
        for _ in 0..70 {
            (0..3).for_each(|row| insert(&mut rows, row, column));
            rows.assert_consistent();
            column = column * 7 % 71;
        }
        let all: Vec<u32> = (1..71).collect();
        for row in 0..3 {
            assert_eq!(rows.columns(row), all);
            assert!(
                rows.values(row)
                    .iter()
                    .zip(&all)
                    .all(|(&value, &column)| value == f64::from(column))
            );
        }
    }

    #[test]
    fn the_last_row_extends_where_it_stands() {
        let mut rows = SlackRows::default();
        rows.push_row();
        (0..100).for_each(|column| insert(&mut rows, 0, column));
        rows.assert_consistent();
        assert_eq!((rows.abandoned, rows.columns.len()), (0, 128));
    }

    #[test]
    fn abandoned_slots_are_reclaimed() {
        let mut rows = SlackRows::default();
        (0..64).for_each(|_| rows.push_row());
        let mut compactions = 0;
        for column in 0..64 {
            for row in 0..64 {
                let before = rows.abandoned;
                insert(&mut rows, row, column);
                compactions += usize::from(rows.abandoned < before);
            }
        }
        rows.assert_consistent();
        assert!(compactions > 0);
    }
}
