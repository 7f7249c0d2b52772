//! The file of a Chrome trace. A disk that is full ends the trace, not the program.

use super::stderr::say;
use crate::disk::DiskFile;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Takes everything, and writes it until that fails for the first time.
pub(super) struct TraceFile {
    path: PathBuf,
    file: Option<DiskFile>,
}

impl TraceFile {
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            file: Some(DiskFile::create(path)?),
        })
    }
}

impl Write for TraceFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if let Some(file) = &mut self.file
            && let Err(error) = file.write_all(bytes)
        {
            self.file = None;
            let path = self.path.display();
            say(format!(
                "{path}: the trace ends here, cannot write: {error}"
            ));
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
