//! The form in which objects are written down: the same for all kinds of them.
//!
//! ```text
//! "EIGTRAIL"  8 bytes    kind  4 bytes    version  u32    CRC-32C of the payload  u32    length  u64    payload
//! ```
//!
//! Numbers are little-endian; the payload is MessagePack. The version is that of the payload's layout, by kind.

use serde::Serialize;
use serde::de::DeserializeOwned;

const MAGIC: &[u8; 8] = b"EIGTRAIL";
const HEADER: usize = 28;

/// Kind of object in a container, by its four letters, and the version of its layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kind {
    /// The letters.
    pub letters: &'static [u8; 4],
    /// The only version that is read, and the one that is written.
    pub version: u32,
}

/// The object in its container.
///
/// # Errors
/// If it cannot be written down.
pub fn pack(kind: Kind, object: &impl Serialize) -> Result<Vec<u8>, String> {
    let mut bytes = vec![0; HEADER];
    let written = rmp_serde::encode::write(&mut bytes, object);
    written.map_err(|error| format!("cannot be written down: {error}"))?;
    write_header(kind, &mut bytes);
    Ok(bytes)
}

/// A payload in its container.
#[cfg(any(test, fuzzing))]
pub(super) fn framed(kind: Kind, payload: &[u8]) -> Vec<u8> {
    let mut bytes = [&[0; HEADER], payload].concat();
    write_header(kind, &mut bytes);
    bytes
}

fn write_header(kind: Kind, bytes: &mut [u8]) {
    let (header, payload) = bytes.split_at_mut(HEADER);
    header[..8].copy_from_slice(MAGIC);
    header[8..12].copy_from_slice(kind.letters);
    header[12..16].copy_from_slice(&kind.version.to_le_bytes());
    header[16..20].copy_from_slice(&crc32c::crc32c(payload).to_le_bytes());
    header[20..28].copy_from_slice(&(payload.len() as u64).to_le_bytes());
}

/// The object that was packed as `kind`.
///
/// # Errors
/// What is wrong with the bytes.
pub fn unpack<T: DeserializeOwned>(kind: Kind, bytes: &[u8]) -> Result<T, String> {
    let object = rmp_serde::from_slice(payload(kind, bytes)?);
    object.map_err(|error| format!("the payload is damaged: {error}"))
}

fn payload(kind: Kind, bytes: &[u8]) -> Result<&[u8], String> {
    let Some((header, payload)) = bytes.split_at_checked(HEADER) else {
        return Err("not a file of eigentrail: too short for its header".to_owned());
    };
    if &header[..8] != MAGIC {
        return Err("not a file of eigentrail: it does not begin with EIGTRAIL".to_owned());
    }
    if &header[8..12] != kind.letters {
        let (found, wanted) = (&header[8..12], kind.letters.as_slice());
        let [found, wanted] = [found, wanted].map(String::from_utf8_lossy);
        return Err(format!("holds an object of kind {found}, not {wanted}"));
    }
    let number = |at: usize| u32::from_le_bytes(header[at..at + 4].try_into().expect("4 bytes"));
    let length = u64::from_le_bytes(header[20..].try_into().expect("8 bytes"));
    let (version, checksum) = (number(12), number(16));
    if version != kind.version {
        return Err(format!(
            "written in version {version} of the format; this eigentrail reads version {}",
            kind.version
        ));
    }
    if payload.len() as u64 != length {
        let there = payload.len();
        return Err(format!(
            "cut off or added to: {there} bytes of payload instead of {length}"
        ));
    }
    match crc32c::crc32c(payload) == checksum {
        true => Ok(payload),
        false => Err("damaged: the checksum of the payload does not match".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const KIND: Kind = Kind {
        letters: b"TEST",
        version: 3,
    };

    #[test]
    fn what_it_is_not_is_said() {
        let bytes = pack(KIND, &vec![1.5, -0.0]).unwrap();
        let read = |kind| unpack::<Vec<f64>>(kind, &bytes);
        assert_eq!(read(KIND).unwrap(), [1.5, -0.0]);
        let other = Kind {
            letters: b"ELSE",
            version: 3,
        };
        assert!(read(other).unwrap_err().contains("of kind TEST, not ELSE"));
        let newer = Kind { version: 4, ..KIND };
        let said = "version 3 of the format; this eigentrail reads version 4";
        assert!(read(newer).unwrap_err().contains(said));
        assert!(
            unpack::<String>(KIND, &bytes)
                .unwrap_err()
                .contains("damaged")
        );
        assert!(
            unpack::<Vec<f64>>(KIND, b"EIGTRAIL")
                .unwrap_err()
                .contains("too short")
        );
    }

    proptest! {
        #[test]
        fn a_flipped_bit_a_cut_and_a_tail_are_noticed(numbers in prop::collection::vec(any::<u64>(), 0..20), bit in any::<prop::sample::Index>(), cut in any::<prop::sample::Index>()) {
            let bytes = pack(KIND, &numbers).unwrap();
            prop_assert_eq!(unpack::<Vec<u64>>(KIND, &bytes), Ok(numbers));
            let mut flipped = bytes.clone();
            let bit = bit.index(8 * bytes.len());
            flipped[bit / 8] ^= 1 << (bit % 8);
            prop_assert!(unpack::<Vec<u64>>(KIND, &flipped).is_err());
            let cut = cut.index(bytes.len());
            prop_assert!(unpack::<Vec<u64>>(KIND, &bytes[..cut]).is_err());
            let longer = [&bytes[..], &[0]].concat();
            prop_assert!(unpack::<Vec<u64>>(KIND, &longer).is_err());
        }
    }
}
