use pam_train::{EVENT_FILE_NAME, EventFile, ScalarEvent};
use std::path::Path;

/// CRC-32C bit by bit, and the mask as the format describes it.
fn slow_masked_crc(data: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for byte in data {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ (0x82f6_3b78 * (crc & 1));
        }
    }
    // Seventeen bits to the left; those that leave come back at the right.
    let wide = u64::from(!crc) << 17;
    (wide as u32 | (wide >> 32) as u32).wrapping_add(0xa282_ead8)
}

/// The data of every whole record; an error at a wrong checksum or a cut.
fn read_records(mut bytes: &[u8]) -> Result<Vec<Vec<u8>>, &'static str> {
    let word = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap());
    let mut records = Vec::new();
    while !bytes.is_empty() {
        let (head, rest) = bytes.split_at_checked(12).ok_or("cut head")?;
        if word(&head[8..]) != slow_masked_crc(&head[..8]) {
            return Err("length");
        }
        let length = u64::from_le_bytes(head[..8].try_into().unwrap()) as usize;
        let (data, rest) = rest.split_at_checked(length).ok_or("cut data")?;
        let (foot, rest) = rest.split_at_checked(4).ok_or("cut foot")?;
        if word(foot) != slow_masked_crc(data) {
            return Err("data");
        }
        records.push(data.to_vec());
        bytes = rest;
    }
    Ok(records)
}

#[derive(Debug, PartialEq)]
enum Field {
    Number(u64),
    Double(f64),
    Bytes(Vec<u8>),
    Float(f32),
}

/// The fields of a protobuf message with their numbers.
fn fields(mut bytes: &[u8]) -> Vec<(u64, Field)> {
    fn varint(bytes: &mut &[u8]) -> u64 {
        let end = bytes.iter().position(|b| b & 0x80 == 0).unwrap();
        let (own, rest) = bytes.split_at(end + 1);
        *bytes = rest;
        own.iter().rev().fold(0, |value, b| value << 7 | u64::from(b & 0x7f))
    }
    fn take<'a>(bytes: &mut &'a [u8], length: usize) -> &'a [u8] {
        let (own, rest) = bytes.split_at(length);
        *bytes = rest;
        own
    }
    let mut out = Vec::new();
    while !bytes.is_empty() {
        let key = varint(&mut bytes);
        let field = match key & 7 {
            0 => Field::Number(varint(&mut bytes)),
            1 => Field::Double(f64::from_le_bytes(take(&mut bytes, 8).try_into().unwrap())),
            2 => {
                let length = varint(&mut bytes) as usize;
                Field::Bytes(take(&mut bytes, length).to_vec())
            }
            5 => Field::Float(f32::from_le_bytes(take(&mut bytes, 4).try_into().unwrap())),
            wire => panic!("wire type {wire}"),
        };
        out.push((key >> 3, field));
    }
    out
}

/// Version, then `(tag, step, time, value)` of every scalar of a file.
fn read_file(path: &Path) -> (String, Vec<ScalarEvent>) {
    let records = read_records(&std::fs::read(path).unwrap()).unwrap();
    let [(1, Field::Double(_)), (3, Field::Bytes(version))] = &fields(&records[0])[..] else {
        panic!("version");
    };
    let scalar = |data: &Vec<u8>| {
        let event = fields(data);
        let [(1, Field::Double(time)), (2, Field::Number(step)), (5, Field::Bytes(summary))] =
            &event[..]
        else {
            panic!("event {event:?}");
        };
        let [(1, Field::Bytes(value))] = &fields(summary)[..] else { panic!("summary") };
        let [(1, Field::Bytes(tag)), (2, Field::Float(number))] = &fields(value)[..] else {
            panic!("value");
        };
        (String::from_utf8(tag.clone()).unwrap(), *step as i64, *time, *number)
    };
    let version = String::from_utf8(version.clone()).unwrap();
    (version, records[1..].iter().map(scalar).collect())
}

#[test]
fn an_independent_reader_reads_what_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new").join(EVENT_FILE_NAME);
    let mut file = EventFile::create(&path).unwrap();
    file.scalar("loss/train", 0, 1.75e9, 12.5).unwrap();
    file.scalar("R²", 300, 1.75e9 + 0.25, -0.5).unwrap();
    file.scalar("loss", -1, 1.75e9, 1.0).unwrap();
    file.scalar("loss/train", i64::from(u32::MAX), 1.75e9 + 1.0, 1e-3).unwrap();
    file.flush().unwrap();
    let (version, scalars) = read_file(&path);
    assert_eq!(version, "brain.Event:2");
    assert_eq!(
        scalars,
        [
            ("loss/train".to_owned(), 0, 1.75e9, 12.5),
            ("R²".to_owned(), 300, 1.75e9 + 0.25, -0.5),
            ("loss".to_owned(), -1, 1.75e9, 1.0),
            ("loss/train".to_owned(), i64::from(u32::MAX), 1.75e9 + 1.0, 1e-3),
        ]
    );
}

#[test]
fn a_rewritten_file_drops_half_records_and_grows_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(EVENT_FILE_NAME);
    let mut file = EventFile::create(&path).unwrap();
    for step in 0..5 {
        file.scalar("loss", step, step as f64, 1.0).unwrap();
    }
    drop(file);
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() - 7]).unwrap();
    assert!(read_records(&std::fs::read(&path).unwrap()).is_err());

    let kept = |step: i64| ("loss".to_owned(), step, step as f64, 1.0 / (1.0 + step as f32));
    let mut file = EventFile::rewrite(&path, &[kept(0), kept(1)]).unwrap();
    file.scalar("loss", 2, 2.0, 0.25).unwrap();
    file.flush().unwrap();
    let values: Vec<_> = read_file(&path).1.into_iter().map(|s| (s.1, s.3)).collect();
    assert_eq!(values, [(0, 1.0), (1, 0.5), (2, 0.25)]);
}

#[test]
fn damage_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(EVENT_FILE_NAME);
    EventFile::create(&path).unwrap().flush().unwrap();
    let good = std::fs::read(&path).unwrap();
    assert_eq!(read_records(&good).unwrap().len(), 1);
    for k in 0..good.len() {
        let mut bad = good.clone();
        bad[k] ^= 1;
        assert!(read_records(&bad).is_err(), "byte {k}");
    }
}
