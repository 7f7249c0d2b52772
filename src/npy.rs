//! NumPy's files of one array: a line about kind and shape, then the entries, row by row, as they stand in memory.
//!
//! Libraries come first elsewhere. The one for these files reads that line by a grammar of Python's literals with whole
//! numbers of any length: six crates and 12 CPU seconds of a first build, for a line of which four forms are ever written
//! here and one is read. The tests let it judge what is written.

use std::io::{self, Read, Write};

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// Entries begin at a multiple of this many bytes.
const ALIGNMENT: usize = 64;
/// Bytes before the line in version 1.0: magic, version, length of the line.
const PREFIX: usize = 10;

/// `f64`, little-endian, as NumPy names it.
pub(crate) const F64: &str = "<f8";

/// Writes what stands before the entries of an array of `kind` (NumPy's name, such as [`F64`]) and `shape`.
///
/// # Errors
/// Those of `out`.
pub(crate) fn write_header(out: &mut impl Write, kind: &str, shape: &[usize]) -> io::Result<()> {
    let lengths: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let line = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({lengths}), }}");
    let length = (PREFIX + line.len() + 1).next_multiple_of(ALIGNMENT) - PREFIX;
    let told = u16::try_from(length).map_err(|_| invalid("an array of too many dimensions"))?;
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&told.to_le_bytes())?;
    writeln!(out, "{line:<width$}", width = length - 1)
}

/// Reads an array of [`F64`] that is stored row by row: its shape and its entries.
///
/// # Errors
/// Those of `input`; if it is not such an array, or not the whole of it.
pub(crate) fn read(input: &mut impl Read) -> io::Result<(Vec<usize>, Vec<f64>)> {
    let shape = read_header(input)?;
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes)?;
    let (entries, rest) = bytes.as_chunks::<8>();
    let expected = shape
        .iter()
        .try_fold(1_usize, |n, &length| n.checked_mul(length));
    if Some(entries.len()) != expected || !rest.is_empty() {
        let found = bytes.len();
        return Err(invalid(format!(
            "{found} bytes of entries do not fill the shape {shape:?}"
        )));
    }
    Ok((
        shape,
        entries
            .iter()
            .map(|&entry| f64::from_le_bytes(entry))
            .collect(),
    ))
}

/// The shape.
fn read_header(input: &mut impl Read) -> io::Result<Vec<usize>> {
    let mut start = [0; MAGIC.len() + 2];
    input.read_exact(&mut start)?;
    if !start.starts_with(MAGIC) {
        return Err(invalid("not an array of NumPy"));
    }
    let mut length = [0; 4];
    // Since version 2 the length of the line has four bytes.
    let width = if start[MAGIC.len()] == 1 { 2 } else { 4 };
    input.read_exact(&mut length[..width])?;
    let mut line = String::new();
    input
        .take(u32::from_le_bytes(length).into())
        .read_to_string(&mut line)?;
    line.retain(|character| !character.is_whitespace());
    if !line.contains(&format!("'descr':'{F64}'")) {
        return Err(invalid(format!("the entries are not of the kind {F64}")));
    }
    if !line.contains("'fortran_order':False") {
        return Err(invalid(
            "the array is stored column by column; expected row by row",
        ));
    }
    let shape = line
        .split_once("'shape':(")
        .and_then(|(_, rest)| rest.split_once(')'));
    let lengths = shape.map(|(lengths, _)| lengths.split_terminator(','));
    let lengths = lengths.and_then(|lengths| lengths.map(|length| length.parse().ok()).collect());
    lengths.ok_or_else(|| invalid("no shape is told"))
}

fn invalid(what: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what)
}

#[cfg(test)]
mod tests {
    use super::*;
    use npyz::{NpyFile, WriterBuilder};

    const SHAPES: [&[usize]; 6] = [&[], &[0], &[5], &[2, 3], &[3, 0], &[1, 2, 100_000_000, 0]];

    fn entries(shape: &[usize]) -> Vec<f64> {
        let special = [-0.0, f64::MIN_POSITIVE, f64::INFINITY];
        (0..shape.iter().product::<usize>())
            .map(|i| special.get(i).copied().unwrap_or(0.1 * i as f64))
            .collect()
    }

    fn written(shape: &[usize]) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_header(&mut bytes, F64, shape).unwrap();
        bytes.extend(entries(shape).iter().flat_map(|entry| entry.to_le_bytes()));
        bytes
    }

    #[test]
    fn the_bytes_are_those_of_npyz_and_come_back() {
        for shape in SHAPES {
            let mut theirs = Vec::new();
            let lengths: Vec<u64> = shape.iter().map(|&length| length as u64).collect();
            let options = npyz::WriteOptions::new().default_dtype().shape(&lengths);
            let mut array = options.writer(&mut theirs).begin_nd().unwrap();
            array.extend(entries(shape)).unwrap();
            array.finish().unwrap();
            assert_eq!(written(shape), theirs, "{shape:?}");
            let (found, back) = read(&mut theirs.as_slice()).unwrap();
            assert_eq!(found, shape);
            assert!(
                back.iter()
                    .map(|x| x.to_bits())
                    .eq(entries(shape).iter().map(|x| x.to_bits()))
            );
        }
    }

    #[test]
    fn other_kinds_are_read_by_npyz() {
        let mut bytes = Vec::new();
        write_header(&mut bytes, "<U2", &[2]).unwrap();
        bytes.extend(
            ['a', 'φ', 'b', '\0']
                .map(u32::from)
                .iter()
                .flat_map(|c| c.to_le_bytes()),
        );
        let texts = NpyFile::new(bytes.as_slice())
            .unwrap()
            .into_vec::<String>()
            .unwrap();
        assert_eq!(texts, ["aφ", "b"]);
    }

    #[test]
    fn what_is_no_such_array_is_refused() {
        let whole = written(&[2, 3]);
        for length in 0..whole.len() {
            assert!(read(&mut &whole[..length]).is_err(), "{length} bytes");
        }
        assert!(read(&mut [&whole[..], &[0]].concat().as_slice()).is_err());
        let text = String::from_utf8_lossy(&whole[..128]).into_owned();
        assert!(text.contains("(2, 3, )"));
        let changes: [(&[u8], &[u8], &str); 5] = [
            (b"<f8", b">f8", "kind"),
            (b"False", b"True ", "column by column"),
            (b"(2, 3, )", b"(2, 4, )", "fill"),
            (b"(2, 3, )", b"(2, -3,)", "shape"),
            (b"NUMPY", b"numpy", "NumPy"),
        ];
        for (old, new, message) in changes {
            let mut changed = whole.clone();
            let at = whole
                .windows(old.len())
                .position(|part| part == old)
                .unwrap();
            changed[at..at + new.len()].copy_from_slice(new);
            let error = read(&mut changed.as_slice()).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
    }
}
