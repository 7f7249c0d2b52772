//! As much of the [protocol buffer encoding](https://protobuf.dev/programming-guides/encoding) as events need.
//!
//! A message is a sequence of fields, each a key (number · 8 + wire type) and a value: a varint (type 0), eight bytes
//! (1), a length and so many bytes (2), or four bytes (5).

/// A message under construction.
#[derive(Clone, Debug, Default)]
pub(super) struct Message(Vec<u8>);

impl Message {
    pub(super) fn as_bytes(&self) -> &[u8] {
        &self.0
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// An int32, int64 or enum, none of which is negative here.
    pub(super) fn integer(&mut self, field: u32, value: u64) {
        self.key(field, 0);
        self.varint(value);
    }

    pub(super) fn double(&mut self, field: u32, value: f64) {
        self.key(field, 1);
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    pub(super) fn float(&mut self, field: u32, value: f32) {
        self.key(field, 5);
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    pub(super) fn bytes(&mut self, field: u32, value: &[u8]) {
        self.key(field, 2);
        self.varint(value.len() as u64);
        self.0.extend_from_slice(value);
    }

    pub(super) fn message(&mut self, field: u32, value: &Message) {
        self.bytes(field, &value.0);
    }

    /// Repeated doubles, packed.
    pub(super) fn doubles(&mut self, field: u32, values: &[f64]) {
        self.key(field, 2);
        self.varint(8 * values.len() as u64);
        for value in values {
            self.0.extend_from_slice(&value.to_le_bytes());
        }
    }

    fn key(&mut self, field: u32, wire_type: u32) {
        self.varint(u64::from(field << 3 | wire_type));
    }

    /// Seven bits a byte, the lowest first; the top bit says that more follow.
    fn varint(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.0.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.0.push(value as u8);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_those_of_the_documentation() {
        let mut first = Message::default();
        first.integer(1, 150);
        assert_eq!(first.as_bytes(), [0x08, 0x96, 0x01]);
        let mut second = Message::default();
        second.bytes(2, b"testing");
        assert_eq!(second.as_bytes(), b"\x12\x07testing");
        let mut third = Message::default();
        third.message(3, &first);
        assert_eq!(third.as_bytes(), [0x1a, 0x03, 0x08, 0x96, 0x01]);
    }

    #[test]
    fn numbers_keep_their_bits() {
        let mut message = Message::default();
        message.double(1, -0.1);
        message.float(2, 0.1);
        message.doubles(6, &[1.0, f64::MAX]);
        let bytes = message.as_bytes();
        assert_eq!(bytes[0], 0x09);
        assert_eq!(bytes[1..9], (-0.1_f64).to_le_bytes());
        assert_eq!(bytes[9], 0x15);
        assert_eq!(bytes[10..14], 0.1_f32.to_le_bytes());
        assert_eq!(bytes[14..16], [0x32, 16]);
        let mut largest = Message::default();
        largest.integer(1, u64::MAX);
        assert_eq!(largest.as_bytes().len(), 11);
    }
}
