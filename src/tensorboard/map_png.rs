//! A function of the cells as a PNG: as many pixels as it takes to see something, a palette instead of colours.

use super::Png;
use crate::env::layouts::{Cell, Layout, Tile};
use crate::report::viridis_rgb;

/// Small maps get several pixels a cell, up to this many across or down.
const SMALL: usize = 320;

/// Of larger maps every second, third … cell is shown, so that no side has more pixels.
const LARGE: usize = 1024;

/// The palette: what is not a value, then viridis from low to high.
const UNSEEN: u8 = 0;
const WALL: u8 = 1;
const START: u8 = 2;
const GOAL: u8 = 3;
const LOWEST: u8 = 4;
const MARKS: [[u8; 3]; LOWEST as usize] = [[232; 3], [64; 3], [255; 3], [213, 94, 0]];

/// The map coloured by `value` from its lowest (violet) to its highest (yellow); cells without a value are light grey,
/// walls dark, the start is white and goals are vermilion.
pub fn png_of_values(layout: &Layout, value: impl Fn(Cell) -> Option<f64>) -> Png {
    let longest = layout.rows().max(layout.cols());
    let (side, skip) = (SMALL.div_ceil(longest), longest.div_ceil(LARGE));
    let side = if skip > 1 { 1 } else { side };
    let [rows, cols] = [layout.rows(), layout.cols()].map(|n| n.div_ceil(skip));
    let index = palette_index(layout, value);
    let mut pixels = Vec::with_capacity(rows * cols * side * side);
    for row in 0..rows {
        let begun = pixels.len();
        for col in 0..cols {
            let cell = layout.cell(row * skip, col * skip);
            let color = cell.map_or(UNSEEN, &index);
            pixels.extend(std::iter::repeat_n(color, side));
        }
        for _ in 1..side {
            pixels.extend_from_within(begun..begun + cols * side);
        }
    }
    let (width, height) = ((cols * side) as u32, (rows * side) as u32);
    Png {
        width,
        height,
        bytes: encoded(width, height, &pixels),
    }
}

/// Which colour each cell has.
fn palette_index(layout: &Layout, value: impl Fn(Cell) -> Option<f64>) -> impl Fn(Cell) -> u8 {
    let finite = move |cell| value(cell).filter(|v: &f64| v.is_finite());
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in layout.free_cells().filter_map(&finite) {
        (low, high) = (low.min(v), high.max(v));
    }
    let steps = f64::from(u8::MAX - LOWEST);
    move |cell| {
        if layout.tile(cell) == Tile::Wall {
            WALL
        } else if layout.is_start(cell) {
            START
        } else if layout.goals.iter().any(|goal| goal.cell == cell) {
            GOAL
        } else if let Some(v) = finite(cell) {
            let share = (v - low) / (high - low).max(f64::MIN_POSITIVE);
            LOWEST + (share * steps).round() as u8
        } else {
            UNSEEN
        }
    }
}

fn encoded(width: u32, height: u32, pixels: &[u8]) -> Vec<u8> {
    let shades = 0..=u8::MAX - LOWEST;
    let shades = shades.map(|i| viridis_rgb(f64::from(i) / f64::from(u8::MAX - LOWEST)));
    let palette: Vec<u8> = MARKS.into_iter().chain(shades).flatten().collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_compression(png::Compression::Fast);
    let written = encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(pixels));
    written.expect("memory can be written to, and the sizes agree");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// Colour of the pixel in the middle of a cell.
    fn color(png: &Png, cells: (usize, usize), row: usize, col: usize) -> [u8; 3] {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(&png.bytes));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((info.width, info.height), (png.width, png.height));
        let x = (2 * col + 1) * info.width as usize / (2 * cells.1);
        let y = (2 * row + 1) * info.height as usize / (2 * cells.0);
        let at = 3 * (y * info.width as usize + x);
        [pixels[at], pixels[at + 1], pixels[at + 2]]
    }

    #[test]
    fn cells_have_the_colours_of_what_they_are() {
        let layout = Layout::from_ascii("S.#\n..G", &BTreeMap::new()).unwrap();
        let value = |cell: Cell| match layout.position(cell) {
            (0, 1) => Some(-3.0),
            (1, 1) => Some(-1.0),
            _ => None,
        };
        let png = png_of_values(&layout, value);
        let color = |row, col| color(&png, (2, 3), row, col);
        assert_eq!(color(0, 0), MARKS[usize::from(START)]);
        assert_eq!(color(0, 1), viridis_rgb(0.0));
        assert_eq!(color(0, 2), MARKS[usize::from(WALL)]);
        assert_eq!(color(1, 0), MARKS[usize::from(UNSEEN)]);
        assert_eq!(color(1, 1), viridis_rgb(1.0));
        assert_eq!(color(1, 2), MARKS[usize::from(GOAL)]);
    }

    #[test]
    fn pictures_are_neither_tiny_nor_huge() {
        for (rows, cols) in [(1, 1), (11, 11), (3, 200), (1025, 2), (3000, 5)] {
            let layout = Layout::open(rows, cols).unwrap();
            let png = png_of_values(&layout, |_| Some(1.0));
            let longest = png.width.max(png.height) as usize;
            assert!((SMALL..=LARGE).contains(&longest), "{rows} × {cols}");
            assert_eq!(color(&png, (1, 1), 0, 0), viridis_rgb(0.0));
        }
    }
}
