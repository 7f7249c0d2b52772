//! The values of one moment, each under its tag: numbers, distributions, pictures, texts.
//!
//! Field numbers are those of `summary.proto` and `tensor.proto` in
//! [tensorboard/compat/proto](https://github.com/tensorflow/tensorboard/tree/master/tensorboard/compat/proto).

use super::histogram::histogram;
use super::protobuf::Message;

/// The values of one moment.
#[derive(Clone, Debug, Default)]
pub struct Summary(Message);

/// A picture, compressed already.
#[derive(Clone, Debug, PartialEq)]
pub struct Png {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// The file.
    pub bytes: Vec<u8>,
}

/// `DT_STRING` of `types.proto`.
const STRING: u64 = 7;

/// Red, green and blue, as `Image` in `summary.proto` counts.
const RGB: u64 = 3;

impl Summary {
    /// A number; TensorBoard keeps it as `f32`, so beyond the largest of these it is that one.
    pub fn scalar(&mut self, tag: &str, value: f64) {
        let mut entry = tagged(tag);
        entry.float(2, (value as f32).clamp(f32::MIN, f32::MAX));
        self.push(&entry);
    }

    /// How `values` are distributed; those that are not finite are left out, and without any nothing is written.
    pub fn histogram(&mut self, tag: &str, values: impl Iterator<Item = f64> + Clone) {
        if let Some(histogram) = histogram(values) {
            let mut entry = tagged(tag);
            entry.message(5, &histogram);
            self.push(&entry);
        }
    }

    /// A picture.
    pub fn image(&mut self, tag: &str, png: &Png) {
        let mut image = Message::default();
        image.integer(1, png.height.into());
        image.integer(2, png.width.into());
        image.integer(3, RGB);
        image.bytes(4, &png.bytes);
        let mut entry = tagged(tag);
        entry.message(4, &image);
        self.push(&entry);
    }

    /// A text in Markdown.
    pub fn text(&mut self, tag: &str, markdown: &str) {
        let (mut plugin, mut metadata) = (Message::default(), Message::default());
        plugin.bytes(1, b"text");
        metadata.message(1, &plugin);
        let (mut dimension, mut shape) = (Message::default(), Message::default());
        dimension.integer(1, 1);
        shape.message(2, &dimension);
        let mut tensor = Message::default();
        tensor.integer(1, STRING);
        tensor.message(2, &shape);
        tensor.bytes(8, markdown.as_bytes());
        let mut entry = tagged(tag);
        entry.message(8, &tensor);
        entry.message(9, &metadata);
        self.push(&entry);
    }

    /// Whether nothing has been put in.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn message(&self) -> &Message {
        &self.0
    }

    fn push(&mut self, entry: &Message) {
        self.0.message(1, entry);
    }
}

fn tagged(tag: &str) -> Message {
    let mut entry = Message::default();
    entry.bytes(1, tag.as_bytes());
    entry
}
