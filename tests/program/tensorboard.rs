//! The event file of a run, read by a small reader that knows nothing of its writer; tests/outside has TensorBoard's.

use crate::runs::{eigentrail, event_file};
use std::collections::BTreeMap;

/// CRC-32C bit by bit, from its definition.
fn crc32c(data: &[u8]) -> u32 {
    !data.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc: u32, _| {
            (crc >> 1) ^ if crc & 1 == 1 { 0x82f6_3b78 } else { 0 }
        })
    })
}

/// The data of each record; panics if a frame or a checksum is wrong.
fn records(mut file: &[u8]) -> Vec<&[u8]> {
    let masked = |data: &[u8]| crc32c(data).rotate_right(15).wrapping_add(0xa282_ead8);
    let mut found = Vec::new();
    while !file.is_empty() {
        let (length, rest) = file.split_at(8);
        let (length_sum, rest) = rest.split_at(4);
        assert_eq!(length_sum, masked(length).to_le_bytes());
        let (data, rest) = rest.split_at(u64::from_le_bytes(length.try_into().unwrap()) as usize);
        let (data_sum, rest) = rest.split_at(4);
        assert_eq!(data_sum, masked(data).to_le_bytes());
        found.push(data);
        file = rest;
    }
    found
}

/// A field of a message: its bits if it is a number, its bytes otherwise.
#[derive(Clone, Debug, PartialEq)]
enum Field<'a> {
    Number(u64),
    Bytes(&'a [u8]),
}

impl<'a> Field<'a> {
    fn bytes(&self) -> &'a [u8] {
        match self {
            Field::Bytes(bytes) => bytes,
            Field::Number(_) => panic!("a number where bytes should be"),
        }
    }

    fn number(&self) -> u64 {
        match self {
            Field::Number(number) => *number,
            Field::Bytes(_) => panic!("bytes where a number should be"),
        }
    }
}

fn varint(message: &mut &[u8]) -> u64 {
    let mut value = 0;
    for shift in (0..).step_by(7) {
        let (&byte, rest) = message.split_first().unwrap();
        *message = rest;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            break;
        }
    }
    value
}

/// The fields of a message in order, by number.
fn fields(mut message: &[u8]) -> Vec<(u64, Field<'_>)> {
    let mut found = Vec::new();
    while !message.is_empty() {
        let key = varint(&mut message);
        let fixed = |message: &mut &[u8], size: usize| {
            let mut bytes = [0; 8];
            bytes[..size].copy_from_slice(&message[..size]);
            *message = &message[size..];
            Field::Number(u64::from_le_bytes(bytes))
        };
        let field = match key & 7 {
            0 => Field::Number(varint(&mut message)),
            1 => fixed(&mut message, 8),
            2 => {
                let length = varint(&mut message) as usize;
                let (bytes, rest) = message.split_at(length);
                message = rest;
                Field::Bytes(bytes)
            }
            5 => fixed(&mut message, 4),
            other => panic!("wire type {other}"),
        };
        found.push((key >> 3, field));
    }
    found
}

/// The one field of that number.
fn only<'a>(message: &'a [u8], number: u64) -> Field<'a> {
    let mut found = fields(message);
    found.retain(|(field, _)| *field == number);
    assert_eq!(found.len(), 1, "field {number}");
    found.swap_remove(0).1
}

/// (step, value) of each tag, in order.
fn values(file: &[u8]) -> BTreeMap<String, Vec<(u64, Vec<u8>)>> {
    let mut found: BTreeMap<String, Vec<(u64, Vec<u8>)>> = BTreeMap::new();
    for event in &records(file)[1..] {
        let step = only(event, 2).number();
        for (number, value) in fields(only(event, 5).bytes()) {
            assert_eq!(number, 1);
            let tag = String::from_utf8(only(value.bytes(), 1).bytes().to_vec()).unwrap();
            let entry = found.entry(tag).or_default();
            entry.push((step, value.bytes().to_vec()));
        }
    }
    found
}

fn scalars(values: &[(u64, Vec<u8>)]) -> Vec<(u64, f32)> {
    let value = |entry: &[u8]| f32::from_bits(only(entry, 2).number() as u32);
    values.iter().map(|(s, entry)| (*s, value(entry))).collect()
}

#[test]
fn the_checksum_of_this_test_is_the_standard_one() {
    assert_eq!(crc32c(b"123456789"), 0xe306_9283);
    assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
}

#[test]
fn events_say_what_the_tables_say() {
    let folder = tempfile::tempdir().unwrap();
    let path = event_file(folder.path());
    let file = std::fs::read(&path).unwrap();
    assert_eq!(only(records(&file)[0], 3).bytes(), b"brain.Event:2");
    let values = values(&file);

    let mut rows = csv::Reader::from_path(path.with_file_name("episodes.csv")).unwrap();
    let mut column = |name: &str| {
        let header = rows.headers().unwrap();
        header.iter().position(|h| h == name).unwrap()
    };
    let [step, length, reward, shaped, regret, nodes] = [
        "step",
        "length",
        "return",
        "shaped_return",
        "regret",
        "nodes",
    ]
    .map(&mut column);
    let rows: Vec<csv::StringRecord> = rows.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 60);
    for (tag, place) in [
        ("charts/episodic_length", length),
        ("charts/episodic_return", reward),
        ("charts/shaped_return", shaped),
        ("charts/regret", regret),
        ("graph/nodes", nodes),
    ] {
        let expected: Vec<(u64, f32)> = rows
            .iter()
            .map(|row| {
                (
                    row[step].parse().unwrap(),
                    row[place].parse::<f64>().unwrap() as f32,
                )
            })
            .collect();
        assert_eq!(scalars(&values[tag]), expected, "{tag}");
    }
    let mut refreshes = csv::Reader::from_path(path.with_file_name("refreshes.csv")).unwrap();
    let header = refreshes.headers().unwrap().clone();
    for (tag, name) in [
        ("spectral/applications", "applications"),
        ("gcn/loss", "loss"),
    ] {
        let place = header.iter().position(|h| h == name).unwrap();
        refreshes.seek(csv::Position::new()).unwrap();
        let filled = refreshes.records().map(Result::unwrap);
        let filled = filled.filter(|row| row[place].parse::<f64>().is_ok());
        assert_eq!(values[tag].len(), filled.count(), "{tag}");
    }
    for tag in ["charts/SPS", "losses/td_loss"] {
        let values = scalars(&values[tag]);
        assert!(
            values.iter().all(|(_, v)| v.is_finite() && *v > 0.0),
            "{tag}"
        );
    }
}

#[test]
fn histograms_count_every_state_and_pictures_are_png() {
    let folder = tempfile::tempdir().unwrap();
    let path = event_file(folder.path());
    let file = std::fs::read(&path).unwrap();
    let values = values(&file);
    let (last_step, histogram) = values["potential/phi"].last().unwrap();
    let histogram = only(histogram, 5);
    let number = |field| f64::from_bits(only(histogram.bytes(), field).number());
    let states = csv::Reader::from_path(path.with_file_name("states.csv"));
    let states = states.unwrap().records().count() as f64;
    assert_eq!(number(3), states);
    let counts = only(histogram.bytes(), 7);
    let counts = counts.bytes().chunks(8);
    let sum: f64 = counts
        .map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()))
        .sum();
    assert_eq!(sum, states);
    assert!(number(1) < number(2) && number(2) == 0.0, "φ is 0 at goals");

    let (step, picture) = values["potential/map"].last().unwrap();
    assert_eq!(step, last_step);
    let image = only(picture, 4);
    let bytes = only(image.bytes(), 4);
    let size = &bytes.bytes()[16..24]; // width and height in the header chunk
    for (field, range) in [(2, 0..4), (1, 4..8)] {
        let written = u32::from_be_bytes(size[range].try_into().unwrap());
        assert_eq!(only(image.bytes(), field).number(), u64::from(written));
    }
    assert!(bytes.bytes().starts_with(b"\x89PNG\r\n\x1a\n"));
}

#[test]
fn equal_runs_differ_in_the_clock_only() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str| {
        let file = std::fs::read(event_file(&folder.path().join(name))).unwrap();
        let mut values = values(&file);
        values.retain(|tag, _| tag != "charts/SPS" && !tag.ends_with("/seconds"));
        values
    };
    assert_eq!(read("a"), read("b"));
}

#[test]
fn the_file_can_be_switched_off() {
    let folder = tempfile::tempdir().unwrap();
    eigentrail()
        .args(["run", "smoke", "-q", "--no-report", "--no-tensorboard"])
        .arg("--out")
        .arg(folder.path().join("run"))
        .assert()
        .success();
    let files = std::fs::read_dir(folder.path().join("run/seed-0000")).unwrap();
    assert!(
        files
            .map(|file| file.unwrap().file_name())
            .all(|name| !name.to_string_lossy().contains("tfevents"))
    );
}
