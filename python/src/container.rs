//! The form in which objects are written down: the same for all kinds of them.
//!
//! ```text
//! "EIGTRAIL"  8 bytes    kind  4 bytes    version  u32    CRC-32C of the payload  u32    length  u64    payload
//! ```
//!
//! Numbers are little-endian; the payload is MessagePack.

use pyo3::PyErr;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use serde::Serialize;
use serde::de::DeserializeOwned;

const MAGIC: &[u8; 8] = b"EIGTRAIL";
const VERSION: u32 = 1;
const HEADER: usize = 28;

/// Kind of object in a container, by its four letters.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Kind(pub &'static [u8; 4]);

/// The object in its container.
pub fn packed(kind: Kind, object: &impl Serialize) -> Result<Vec<u8>, PyErr> {
    let payload = rmp_serde::to_vec(object)
        .map_err(|error| PyRuntimeError::new_err(format!("cannot be written down: {error}")))?;
    let mut bytes = Vec::with_capacity(HEADER + payload.len());
    bytes.extend_from_slice(MAGIC);
    bytes.extend_from_slice(kind.0);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&crc32c::crc32c(&payload).to_le_bytes());
    bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&payload);
    Ok(bytes)
}

/// The object that was packed as `kind`.
///
/// # Errors
/// `ValueError` that says what is wrong with the bytes.
pub fn unpacked<T: DeserializeOwned>(kind: Kind, bytes: &[u8]) -> Result<T, PyErr> {
    payload(kind, bytes)
        .and_then(|payload| {
            rmp_serde::from_slice(payload)
                .map_err(|error| format!("the payload is damaged: {error}"))
        })
        .map_err(PyValueError::new_err)
}

fn payload(kind: Kind, bytes: &[u8]) -> Result<&[u8], String> {
    let Some((header, payload)) = bytes.split_at_checked(HEADER) else {
        return Err("not a file of eigentrail: too short for its header".into());
    };
    if &header[..8] != MAGIC {
        return Err("not a file of eigentrail: it does not begin with EIGTRAIL".into());
    }
    let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| header[at + i]));
    let version = word(12);
    if version != VERSION {
        return Err(format!(
            "written in version {version} of the format; this eigentrail reads version {VERSION}"
        ));
    }
    if &header[8..12] != kind.0 {
        let (found, wanted) = (&header[8..12], kind.0.as_slice());
        let [found, wanted] = [found, wanted].map(String::from_utf8_lossy);
        return Err(format!("holds an object of kind {found}, not {wanted}"));
    }
    let length = u64::from(word(20)) | u64::from(word(24)) << 32;
    if length != payload.len() as u64 {
        let there = payload.len();
        return Err(format!(
            "cut off or added to: {there} bytes of payload instead of {length}"
        ));
    }
    if crc32c::crc32c(payload) != word(16) {
        return Err("damaged: the checksum of the payload does not match".into());
    }
    Ok(payload)
}
