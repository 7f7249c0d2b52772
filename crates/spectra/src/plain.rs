//! Arrays as plain values that serde can write and read: numbers by their bits, for `#[serde(with = "…")]`.
//!
//! An integer comes back as it was in every format. A decimal fraction may not, and an infinite one, which a search
//! that has failed can leave, cannot be written in JSON at all.

use crate::Convergence;
use crate::block::{LANES, RowBlock};
use faer::Mat;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// `Vec<f64>`.
pub mod numbers {
    use super::*;

    /// Writes the bits of each number.
    pub fn serialize<S: Serializer>(numbers: &[f64], to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(numbers.iter().map(|v| v.to_bits()))
    }

    /// Reads what [`serialize`] wrote.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<f64>, D::Error> {
        let bits = Vec::<u64>::deserialize(from)?;
        Ok(bits.into_iter().map(f64::from_bits).collect())
    }
}

/// `f64`.
mod number {
    use super::*;

    pub(super) fn serialize<S: Serializer>(number: &f64, to: S) -> Result<S::Ok, S::Error> {
        number.to_bits().serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
        u64::deserialize(from).map(f64::from_bits)
    }
}

/// `Option<f64>`.
mod maybe {
    use super::*;

    pub(super) fn serialize<S: Serializer>(number: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
        number.map(f64::to_bits).serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
        Ok(Option::<u64>::deserialize(from)?.map(f64::from_bits))
    }
}

/// A table by rows.
#[derive(Serialize, Deserialize)]
struct Table {
    rows: usize,
    columns: usize,
    #[serde(with = "numbers")]
    numbers: Vec<f64>,
}

impl Table {
    fn of(matrix: &Mat<f64>) -> Self {
        let (rows, columns) = matrix.shape();
        let row = |i: usize| (0..columns).map(move |j| matrix[(i, j)]);
        Self {
            rows,
            columns,
            numbers: (0..rows).flat_map(row).collect(),
        }
    }

    fn matrix(&self) -> Mat<f64> {
        let number = |i: usize, j: usize| self.numbers[i * self.columns + j];
        Mat::from_fn(self.rows, self.columns, number)
    }

    fn checked<E: Error>(self) -> Result<Self, E> {
        if self.rows.checked_mul(self.columns) == Some(self.numbers.len()) {
            return Ok(self);
        }
        let (rows, columns, found) = (self.rows, self.columns, self.numbers.len());
        Err(E::custom(format!("{found} numbers for {rows} × {columns}")))
    }
}

/// `Mat<f64>`, by rows.
pub mod matrix {
    use super::*;

    /// Writes the shape and the bits of each entry.
    pub fn serialize<S: Serializer>(matrix: &Mat<f64>, to: S) -> Result<S::Ok, S::Error> {
        Table::of(matrix).serialize(to)
    }

    /// Reads what [`serialize`] wrote; entries that do not fill the shape are an error.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Mat<f64>, D::Error> {
        Ok(Table::deserialize(from)?.checked()?.matrix())
    }
}

/// `Option<Mat<f64>>`, by rows.
pub mod maybe_matrix {
    use super::*;

    /// Writes the shape and the bits of each entry, if there is a matrix.
    pub fn serialize<S: Serializer>(matrix: &Option<Mat<f64>>, to: S) -> Result<S::Ok, S::Error> {
        matrix.as_ref().map(Table::of).serialize(to)
    }

    /// Reads what [`serialize`] wrote; entries that do not fill the shape are an error.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Mat<f64>>, D::Error> {
        let table = Option::<Table>::deserialize(from)?;
        table.map(|table| Ok(table.checked()?.matrix())).transpose()
    }
}

impl Serialize for RowBlock {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let table = Table {
            rows: self.rows(),
            columns: self.width(),
            numbers: self.as_slice().to_vec(),
        };
        table.serialize(to)
    }
}

impl<'de> Deserialize<'de> for RowBlock {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let table = Table::deserialize(from)?.checked()?;
        if table.columns % LANES != 0 {
            return Err(D::Error::custom(format!(
                "a block of {} columns",
                table.columns
            )));
        }
        let mut block = RowBlock::zeros(table.rows, table.columns);
        block.as_mut_slice().copy_from_slice(&table.numbers);
        Ok(block)
    }
}

/// The fields of [`Convergence`].
#[derive(Serialize, Deserialize)]
#[serde(remote = "Convergence")]
pub(crate) struct PlainConvergence {
    converged: usize,
    #[serde(with = "numbers")]
    residual_norms: Vec<f64>,
    #[serde(with = "number")]
    max_relative_residual: f64,
    restarts: usize,
    applications: usize,
    solves: usize,
    cluster_cut: bool,
    certified: Option<bool>,
    #[serde(with = "maybe")]
    tolerance_floor: Option<f64>,
    repaired: usize,
}
