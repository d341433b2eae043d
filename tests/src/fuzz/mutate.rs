//! Mutations that know the structure of a format.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::io::{Cursor, Read, Write};

/// What a file is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Lines of text with numbers and names.
    Text,
    /// Arrays of NumPy one after the other.
    Arrays,
    /// A ZIP archive of such arrays.
    Archive,
    /// A JSON header with its length before it, and doubles.
    Safetensors,
    /// Words and doubles at multiples of eight bytes.
    Words,
}

/// Numbers at the limits of what can be computed with.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e300",
    "1e-308",
    "5e-324",
    "1e18",
    "1e9",
    "1e6",
    "1e-6",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551616",
    "0.5",
    "1_000",
    "0x10",
    "1e",
    "",
    "true",
    "\"\"",
    "[]",
    "{}",
    "[1, 2]",
    "\"text\"",
];

/// The same as doubles.
const DOUBLES: &[f64] = &[
    0.0,
    -0.0,
    -1.0,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    1e300,
    1e150,
    1e18,
    1e9,
    1e6,
    -1e6,
    1e-6,
    -50.0,
];

/// A seed after one to four mutations.
#[must_use]
pub fn mutated(kind: Kind, seed: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..random.random_range(1..=4) {
        bytes = match (random.random_range(0..8), kind) {
            // Of any format a part may be lost or overwritten.
            (0, _) => raw(bytes, random),
            (_, Kind::Text) => text(&bytes, random),
            (_, Kind::Arrays) => arrays(bytes, random),
            (_, Kind::Archive) => archive(&bytes, random).unwrap_or(bytes),
            (_, Kind::Safetensors) => safetensors(&bytes, random).unwrap_or(bytes),
            (_, Kind::Words) => words(bytes, random),
        };
    }
    bytes
}

fn place(len: usize, random: &mut ChaCha8Rng) -> usize {
    random.random_range(0..len.max(1))
}

fn pick<'a, T: ?Sized>(list: &[&'a T], random: &mut ChaCha8Rng) -> &'a T {
    list[place(list.len(), random)]
}

/// Bytes cut off, lost, doubled, flipped or set.
fn raw(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let len = bytes.len();
    if len == 0 {
        return vec![random.random()];
    }
    let (a, b) = (place(len, random), place(len, random));
    let (from, to) = (a.min(b), a.max(b));
    match random.random_range(0..6) {
        0 => bytes.truncate(from),
        1 => drop(bytes.drain(from..to)),
        2 => {
            let part = bytes[from..to.min(from + 4096)].to_vec();
            bytes.splice(to..to, part);
        }
        3 => bytes[a] ^= 1 << random.random_range(0..8),
        4 => bytes[a] = random.random(),
        _ => bytes[from..to.min(from + 16)].fill(0xff),
    }
    bytes
}

/// Numbers, keys and lines replaced, lost, doubled or moved.
fn text(bytes: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if lines.is_empty() {
        return b"a = 1\n".to_vec();
    }
    let (a, b) = (place(lines.len(), random), place(lines.len(), random));
    match random.random_range(0..9) {
        0 => drop(lines.remove(a)),
        1 => {
            let line = lines[a].clone();
            lines.insert(b, line);
        }
        2 => lines.swap(a, b),
        3 => {
            // A name that nothing knows.
            let at = lines[a].find(|c: char| c.is_alphabetic()).unwrap_or(0);
            lines[a].insert(at, 'x');
        }
        4 => {
            // A column lost everywhere, or a list shortened.
            let which = place(6, random);
            for line in &mut lines {
                let mut cells: Vec<&str> = line.split(',').collect();
                if which < cells.len() {
                    cells.remove(which);
                }
                *line = cells.join(",");
            }
        }
        5 => {
            // A column scaled: other units.
            let (which, by) = (place(6, random), DOUBLES[place(DOUBLES.len(), random)]);
            for line in &mut lines {
                let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
                if let Some(cell) = cells.get_mut(which)
                    && let Ok(value) = cell.parse::<f64>()
                {
                    *cell = (value * by).to_string();
                }
                *line = cells.join(",");
            }
        }
        _ => lines[a] = number_replaced(&lines[a], random),
    }
    (lines.join("\n") + "\n").into_bytes()
}

/// A line with one of its numbers or words replaced.
fn number_replaced(line: &str, random: &mut ChaCha8Rng) -> String {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "+-.".contains(c);
    let mut parts: Vec<String> = Vec::new();
    for c in line.chars() {
        let joins = parts
            .last()
            .and_then(|p| p.chars().next())
            .is_some_and(|first| is_part(first) == is_part(c) && is_part(c));
        match parts.last_mut() {
            Some(part) if joins => part.push(c),
            _ => parts.push(c.to_string()),
        }
    }
    let numbers: Vec<usize> = (0..parts.len())
        .filter(|&k| parts[k].starts_with(|c: char| c.is_ascii_digit() || c == '-'))
        .collect();
    let all: Vec<usize> = (0..parts.len()).collect();
    let among = if numbers.is_empty() { all } else { numbers };
    if let Some(&k) = among.get(place(among.len(), random)) {
        parts[k] = pick(NUMBERS, random).to_owned();
    }
    parts.concat()
}

/// Doubles at multiples of eight bytes replaced, or words of four bytes.
fn words(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let Some(last) = bytes.len().checked_sub(8) else { return raw(bytes, random) };
    let at = place(last / 8 + 1, random) * 8;
    if random.random() {
        let value = DOUBLES[place(DOUBLES.len(), random)];
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
    } else {
        let at = at + 4 * random.random_range(0..2);
        let word: u32 = [0, 1, 7, 9, 14, 15, 0x7fff_ffff, 0xffff_ffff][place(8, random)];
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// The header of one array changed, or its numbers.
fn arrays(mut bytes: Vec<u8>, random: &mut ChaCha8Rng) -> Vec<u8> {
    let starts: Vec<usize> =
        (0..bytes.len()).filter(|&k| bytes[k..].starts_with(b"\x93NUMPY")).collect();
    if starts.is_empty() || random.random_range(0..3) > 0 {
        return words(bytes, random);
    }
    // A header may be cut off before its text.
    let header = (starts[place(starts.len(), random)] + 10).min(bytes.len());
    let end = bytes[header..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |n| header + n);
    let text = String::from_utf8_lossy(&bytes[header..end]).into_owned();
    let shape = [
        "(0,)",
        "(1, 1)",
        "(18446744073709551615, 2)",
        "(4294967296,)",
        "(3, -1)",
        "()",
        "(1000000,)",
    ];
    let changed = match random.random_range(0..3) {
        0 => match (text.find('('), text.find(')')) {
            (Some(a), Some(b)) if a < b => text.replace(&text[a..=b], pick(&shape, random)),
            _ => text,
        },
        1 => text.replace(
            "<f8",
            pick(&["<f4", ">f8", "<i8", "|b1", "<U9", "|O", "<c16", "<f0"], random),
        ),
        _ => text.replace("False", "True"),
    };
    // The length of the header stays: the array begins where it began.
    let mut changed = changed.into_bytes();
    changed.resize(end - header, b' ');
    bytes[header..end].copy_from_slice(&changed);
    bytes
}

/// A member changed, renamed, lost or doubled; the archive around it is sound.
fn archive(bytes: &[u8], random: &mut ChaCha8Rng) -> Option<Vec<u8>> {
    let mut from = zip::ZipArchive::new(Cursor::new(bytes)).ok()?;
    let mut members = Vec::new();
    for k in 0..from.len() {
        let mut file = from.by_index(k).ok()?;
        let mut content = Vec::new();
        // Damaged members stay as they are.
        file.by_ref().take(1 << 20).read_to_end(&mut content).ok()?;
        members.push((file.name().ok()?.to_string(), content));
    }
    if members.is_empty() {
        return None;
    }
    let which = place(members.len(), random);
    match random.random_range(0..6) {
        0 => drop(members.remove(which)),
        1 => members[which].0.insert(0, 'x'),
        2 => {
            let other = place(members.len(), random);
            let content = members[other].1.clone();
            members[which].1 = content;
        }
        _ => {
            let content = std::mem::take(&mut members[which].1);
            members[which].1 = arrays(content, random);
        }
    }
    let mut to = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in members {
        to.start_file(name, zip::write::SimpleFileOptions::default()).ok()?;
        to.write_all(&content).ok()?;
    }
    Some(to.finish().ok()?.into_inner())
}

/// The header's text changed with its length, or the numbers.
fn safetensors(bytes: &[u8], random: &mut ChaCha8Rng) -> Option<Vec<u8>> {
    let length = usize::try_from(u64::from_le_bytes(bytes.get(..8)?.try_into().ok()?)).ok()?;
    let header = bytes.get(8..8usize.checked_add(length)?)?;
    let body = &bytes[8 + length..];
    if random.random_range(0..3) > 0 {
        return Some([&bytes[..8 + length], &words(body.to_vec(), random)].concat());
    }
    let text = String::from_utf8_lossy(header).into_owned();
    let changed = match random.random_range(0..3) {
        0 => number_replaced(&text, random),
        1 => text.replacen("weight", "wait", 1),
        _ => {
            let at = place(text.len(), random);
            let (a, b) = text.split_at_checked(at)?;
            format!("{a}{}{b}", pick(&["\"", "}", "\\u0000", "0", ",", "é"], random))
        }
    };
    Some([&(changed.len() as u64).to_le_bytes()[..], changed.as_bytes(), body].concat())
}
