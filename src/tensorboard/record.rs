//! The framing of TFRecord files.
//!
//! ```text
//! length: u64   mask(crc(length)): u32   data: [u8; length]   mask(crc(data)): u32        all little-endian
//! ```
//!
//! crc is CRC-32C (Castagnoli). mask(c) = (c rotated right by 15) + 0xa282ead8, so that the checksum of data that
//! contains checksums is still a good one.

use crc32c::crc32c;

/// Bytes that the frame adds to a record.
pub const OVERHEAD: usize = 16;

/// Appends `data` as one record.
pub fn append(out: &mut Vec<u8>, data: &[u8]) {
    let length = (data.len() as u64).to_le_bytes();
    out.reserve(data.len() + OVERHEAD);
    out.extend_from_slice(&length);
    out.extend_from_slice(&masked(&length).to_le_bytes());
    out.extend_from_slice(data);
    out.extend_from_slice(&masked(data).to_le_bytes());
}

/// The masked checksum of `data`.
pub fn masked(data: &[u8]) -> u32 {
    crc32c(data).rotate_right(15).wrapping_add(0xa282_ead8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checksums_are_those_of_the_standard() {
        // RFC 3720, appendix B.4.
        let ascending: Vec<u8> = (0..32).collect();
        let unmask = |sum: u32| sum.wrapping_sub(0xa282_ead8).rotate_left(15);
        for (data, sum) in [
            (&[0_u8; 32][..], 0x8a91_36aa),
            (&[0xff; 32], 0x62a8_ab43),
            (&ascending, 0x46dd_794e),
            (b"123456789", 0xe306_9283),
        ] {
            assert_eq!(unmask(masked(data)), sum);
        }
    }

    #[test]
    fn a_record_is_its_data_in_a_frame() {
        let mut out = vec![7];
        append(&mut out, b"abc");
        assert_eq!(out.len(), 1 + 3 + OVERHEAD);
        assert_eq!(out[1..9], 3_u64.to_le_bytes());
        assert_eq!(&out[13..16], b"abc");
    }
}
