//! Files that are never half written.
//!
//! A whole file is written beside its place and renamed onto it. A table that grows is handed to the operating
//! system in whole lines, and cut back to its last whole line if that fails.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::NamedTempFile;

/// Replaces `path` by what `fill` writes, or leaves it as it was.
pub fn write_atomically(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut NamedTempFile>) -> io::Result<()>,
) -> io::Result<()> {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut file = temporary_file(folder)?;
    let mut writer = BufWriter::new(&mut file);
    fill(&mut writer)?;
    writer.flush()?;
    drop(writer);
    file.as_file().sync_data()?;
    file.persist(path)?;
    Ok(())
}

/// A temporary file with the permissions that `File::create` gives; by default only its owner could read it.
fn temporary_file(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666)); // the umask still applies
    }
    // tempfile adds " at path" and a name that says nothing to whoever named another file.
    builder.tempfile_in(folder).map_err(|error| {
        let text = error.to_string();
        let cause = text
            .rsplit_once(" at path ")
            .map_or(&*text, |(cause, _)| cause);
        io::Error::new(error.kind(), cause)
    })
}

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

/// Writes `value` as indented JSON with a final newline.
pub fn write_json(path: &Path, value: &impl Serialize) -> io::Result<()> {
    write_atomically(path, |file| {
        serde_json::to_writer_pretty(&mut *file, value)?;
        file.write_all(b"\n")
    })
}

/// Writes `value` as JSON without white space, with a final newline.
pub fn write_compact_json(path: &Path, value: &impl Serialize) -> io::Result<()> {
    write_atomically(path, |file| {
        serde_json::to_writer(&mut *file, value)?;
        file.write_all(b"\n")
    })
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
    use npyz::WriterBuilder;
    assert_eq!(
        values.len(),
        shape.iter().product::<usize>(),
        "as many values as the shape {shape:?} has entries"
    );
    let shape: Vec<u64> = shape.iter().map(|&n| n as u64).collect();
    write_atomically(path, |file| {
        let mut array = npyz::WriteOptions::<f64>::new()
            .default_dtype()
            .shape(&shape)
            .writer(file)
            .begin_nd()?;
        array.extend(values)?;
        array.finish()
    })
}

/// Reads a NumPy array of `f64`: its shape and its values row by row.
pub fn read_npy(path: &Path) -> io::Result<(Vec<usize>, Vec<f64>)> {
    let file = npyz::NpyFile::new(io::BufReader::new(File::open(path)?))?;
    let shape = file.shape().iter().map(|&n| n as usize).collect();
    if file.order() != npyz::Order::C {
        let what = "the array is stored column by column; expected row by row";
        return Err(io::Error::new(io::ErrorKind::InvalidData, what));
    }
    Ok((shape, file.into_vec::<f64>()?))
}

/// How long rows may wait in memory.
const PATIENCE: Duration = Duration::from_secs(2);

/// A CSV file that grows row by row. Rows reach the file at least every two seconds, as long as more of them come.
#[derive(Debug)]
pub struct Table {
    path: PathBuf,
    file: File,
    /// Bytes of whole lines in the file.
    length: u64,
    rows: csv::Writer<Vec<u8>>,
    flushed: Instant,
}

impl Table {
    /// Begins the file anew. The header comes with the first row.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            file: File::create(path)?,
            length: 0,
            rows: csv::Writer::from_writer(Vec::new()),
            flushed: Instant::now(),
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
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
        let lines = self.rows.get_ref();
        if let Err(error) = self.file.write_all(lines) {
            self.file.set_len(self.length)?;
            return Err(error);
        }
        self.length += lines.len() as u64;
        self.rows = csv::WriterBuilder::new()
            .has_headers(self.length == 0)
            .from_writer(Vec::new());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.txt");
        std::fs::write(&path, "old").unwrap();
        let result = write_atomically(&path, |file| {
            file.write_all(b"new, but")?;
            Err(io::Error::other("the disk is full"))
        });
        assert!(result.is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
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
        table.flush().unwrap();
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            "episode,reward\n0,-0.0\n1,-0.5\n2,-1.0\n"
        );
    }
}
