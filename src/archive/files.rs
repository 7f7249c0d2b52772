//! Files that are never half written.
//!
//! A whole file is written beside its place and renamed onto it. A file that grows is handed to the operating system in
//! whole lines or records, and cut back to the last whole one if that fails.

pub use crate::disk::{
    DiskFile, TemporaryFolder, create_folders, remove_temporaries, try_out, write_atomically,
};

use crate::npy;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Writes a text as it is.
pub fn write_text(path: &Path, text: &str) -> io::Result<()> {
    write_atomically(path, |file| file.write_all(text.as_bytes()))
}

/// Writes a whole table with a header line.
pub fn write_csv(path: &Path, rows: impl Iterator<Item = impl Serialize>) -> io::Result<()> {
    write_atomically(path, |file| {
        let mut table = csv::Writer::from_writer(file);
        for row in rows {
            table.serialize(row)?;
        }
        table.flush()
    })
}

/// Writes `value` as indented JSON with a final newline, or nothing if that could not be read back.
pub fn write_json<T: Serialize + DeserializeOwned>(path: &Path, value: &T) -> io::Result<()> {
    write_readable::<T>(path, serde_json::to_vec_pretty(value)?)
}

/// Writes `value` as JSON without white space, with a final newline, or nothing if that could not be read back.
pub fn write_compact_json<T: Serialize + DeserializeOwned>(
    path: &Path,
    value: &T,
) -> io::Result<()> {
    write_readable::<T>(path, serde_json::to_vec(value)?)
}

/// Writes JSON that is a `T`. JSON has no infinity and no NaN: serde writes `null`, which is no number to whoever reads it.
fn write_readable<T: DeserializeOwned>(path: &Path, mut json: Vec<u8>) -> io::Result<()> {
    serde_json::from_slice::<T>(&json).map_err(|error| {
        let what =
            format!("what came out cannot be read back, a number in it is not finite ({error})");
        io::Error::new(io::ErrorKind::InvalidData, what)
    })?;
    json.push(b'\n');
    write_atomically(path, |file| file.write_all(&json))
}

/// Reads JSON.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> io::Result<T> {
    let text = std::fs::read_to_string(path)?;
    Ok(serde_json::from_str(&text)?)
}

/// Writes `values`, row by row, as a NumPy array of little-endian `f64` of the given shape.
///
/// # Panics
/// If the number of values is not the product of `shape`.
pub fn write_npy(
    path: &Path,
    shape: &[usize],
    values: impl ExactSizeIterator<Item = f64>,
) -> io::Result<()> {
    assert_eq!(
        values.len(),
        shape.iter().product::<usize>(),
        "as many values as the shape {shape:?} has entries"
    );
    write_atomically(path, |file| {
        npy::write_header(file, npy::F64, shape)?;
        values
            .into_iter()
            .try_for_each(|value| file.write_all(&value.to_le_bytes()))
    })
}

/// Reads a NumPy array of `f64`: its shape and its values row by row.
pub fn read_npy(path: &Path) -> io::Result<(Vec<usize>, Vec<f64>)> {
    npy::read(&mut io::BufReader::new(File::open(path)?))
}

/// A file that grows by whole pieces: a piece is in it entirely or, if it cannot be written, not at all.
#[derive(Debug)]
pub struct GrowingFile {
    path: PathBuf,
    file: DiskFile,
    length: u64,
}

impl GrowingFile {
    /// Begins the file anew.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            file: DiskFile::create(path)?,
            length: 0,
        })
    }

    /// Goes on behind the first `length` bytes of a file; what is behind them is cut off.
    ///
    /// # Errors
    /// If there is no such file, if it is shorter, or if it cannot be written to.
    pub fn go_on(path: &Path, length: u64) -> io::Result<Self> {
        let mut file = DiskFile::open(path)?;
        if file.length()? < length {
            let what = format!("it has fewer than the {length} bytes that were written");
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, what));
        }
        file.set_length(length)?;
        Ok(Self {
            path: path.to_owned(),
            file,
            length,
        })
    }

    /// Waits until all of it is on the disk. Its length.
    pub fn sync(&mut self) -> io::Result<u64> {
        self.file.sync()?;
        Ok(self.length)
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether nothing has been written yet.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Writes `piece` behind what is there.
    pub fn append(&mut self, piece: &[u8]) -> io::Result<()> {
        if let Err(error) = self.file.write_all(piece) {
            self.file.set_length(self.length)?;
            return Err(error);
        }
        self.length += piece.len() as u64;
        Ok(())
    }
}

/// How long rows may wait in memory.
const PATIENCE: Duration = Duration::from_secs(2);

/// A CSV file that grows row by row. Rows reach the file at least every two seconds, as long as more of them come.
#[derive(Debug)]
pub struct Table {
    file: GrowingFile,
    rows: csv::Writer<Vec<u8>>,
    flushed: Instant,
}

impl Table {
    /// Begins the file anew. The header comes with the first row.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self::of(GrowingFile::create(path)?))
    }

    /// Goes on behind the first `length` bytes of a table.
    ///
    /// # Errors
    /// As [`GrowingFile::go_on`].
    pub fn go_on(path: &Path, length: u64) -> io::Result<Self> {
        GrowingFile::go_on(path, length).map(Self::of)
    }

    fn of(file: GrowingFile) -> Self {
        Self {
            rows: no_rows(&file),
            file,
            flushed: Instant::now(),
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Appends a row.
    pub fn push(&mut self, row: &impl Serialize) -> io::Result<()> {
        self.rows.serialize(row)?;
        if self.flushed.elapsed() >= PATIENCE {
            self.flush()?;
        }
        Ok(())
    }

    /// Brings every row to the file, or none of those that were waiting.
    pub fn flush(&mut self) -> io::Result<()> {
        self.flushed = Instant::now();
        self.rows.flush()?;
        self.file.append(self.rows.get_ref())?;
        self.rows = no_rows(&self.file);
        Ok(())
    }

    /// Brings every row to the disk. The length of the file.
    pub fn sync(&mut self) -> io::Result<u64> {
        self.flush()?;
        self.file.sync()
    }
}

/// Where rows wait that come behind what `file` has; the first of all brings the header.
fn no_rows(file: &GrowingFile) -> csv::Writer<Vec<u8>> {
    csv::WriterBuilder::new()
        .has_headers(file.is_empty())
        .from_writer(Vec::new())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_read_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.json");
        write_json(&path, &vec![1.0, f64::MAX]).unwrap();
        for number in [f64::INFINITY, f64::NAN] {
            for write in [write_json, write_compact_json] {
                let error = write(&path, &vec![2.0, number]).unwrap_err().to_string();
                assert!(error.contains("not finite"), "{error}");
            }
        }
        assert_eq!(read_json::<Vec<f64>>(&path).unwrap(), [1.0, f64::MAX]);
        // An absence is written and read as one.
        write_json(&path, &vec![Some(1.0), None]).unwrap();
        assert_eq!(
            read_json::<Vec<Option<f64>>>(&path).unwrap(),
            [Some(1.0), None]
        );
    }

    #[test]
    fn arrays_come_back_as_they_went() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.npy");
        let values = [1.0, -0.0, f64::MIN_POSITIVE, 4.0, 5.5, f64::INFINITY];
        write_npy(&path, &[2, 3], values.into_iter()).unwrap();
        assert_eq!(read_npy(&path).unwrap(), (vec![2, 3], values.to_vec()));
        // Magic, version 1.0, then the header NumPy expects.
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"));
        assert_eq!(bytes.len() % 8, 0);
    }

    #[test]
    fn a_table_has_one_header_and_every_row() {
        #[derive(Serialize)]
        struct Row {
            episode: usize,
            reward: f64,
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.csv");
        let mut table = Table::create(&path).unwrap();
        for episode in 0..3 {
            let reward = -0.5 * episode as f64;
            table.push(&Row { episode, reward }).unwrap();
            table.flush().unwrap();
        }
        let length = table.sync().unwrap();
        let whole = "episode,reward\n0,-0.0\n1,-0.5\n2,-1.0\n";
        assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
        // What came after is cut off, and it goes on.
        let late = Row {
            episode: 3,
            reward: 7.0,
        };
        table.push(&late).unwrap();
        table.flush().unwrap();
        for _ in 0..2 {
            let mut table = Table::go_on(&path, length).unwrap();
            table.push(&late).unwrap();
            table.flush().unwrap();
            let text = std::fs::read_to_string(&path).unwrap();
            assert_eq!(text, format!("{whole}3,7.0\n"));
        }
        assert!(Table::go_on(&path, 1000).is_err());
    }
}
