//! Mutations that know the structure of a format.

use super::text::{self, number_replaced};
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

/// Doubles at the limits of what can be computed with.
pub(super) const DOUBLES: &[f64] = &[
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

/// Most bytes of an input that is mutated again.
const LARGEST: usize = 4 << 20;

/// A seed after one to four mutations.
#[must_use]
pub fn mutated(kind: Kind, seed: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..random.random_range(1..=4) {
        // What has become large is cut, so that the next mutation does not exceed the memory itself.
        bytes.truncate(LARGEST);
        bytes = match (random.random_range(0..8), kind) {
            // Of any format a part may be lost or overwritten.
            (0, _) => raw(bytes, random),
            (_, Kind::Text) => text::mutated(&bytes, random),
            (_, Kind::Arrays) => arrays(bytes, random),
            (_, Kind::Archive) => archive(&bytes, random).unwrap_or(bytes),
            (_, Kind::Safetensors) => safetensors(&bytes, random).unwrap_or(bytes),
            (_, Kind::Words) => words(bytes, random),
        };
    }
    bytes
}

pub(super) fn place(len: usize, random: &mut ChaCha8Rng) -> usize {
    random.random_range(0..len.max(1))
}

pub(super) fn pick<'a, T: ?Sized>(list: &[&'a T], random: &mut ChaCha8Rng) -> &'a T {
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
    let changed = match random.random_range(0..4) {
        // Nested as deep as the header is long.
        3 => "(".repeat(text.len()),
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
    let mut method = zip::CompressionMethod::Stored;
    match random.random_range(0..40) {
        0 => {
            // Much that packs into little.
            members[which].1.resize(8 << 20, 0);
            method = zip::CompressionMethod::Deflated;
        }
        1 => members[which].0 = format!("../{}", members[which].0),
        2..6 => drop(members.remove(which)),
        6..12 => members[which].0.insert(0, 'x'),
        12..18 => {
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
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (name, content) in members {
        to.start_file(name, options).ok()?;
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
    if random.random_range(0..12) == 0 {
        // A header that is longer than the file, or than any.
        let claimed = [u64::MAX, 1 << 40, bytes.len() as u64, 0][place(4, random)];
        return Some([&claimed.to_le_bytes()[..], header, body].concat());
    }
    let changed = match random.random_range(0..5) {
        0 => number_replaced(&text, random),
        1 => text.replacen("weight", "wait", 1),
        2 => {
            let depth = 1 << random.random_range(2..18);
            let deep = pick(&["[", "{\"a\":"], random).repeat(depth);
            format!("{{\"__metadata__\":{deep}")
        }
        // Every tensor twice.
        3 => format!("{},{}", text.trim_end().strip_suffix('}')?, text.strip_prefix('{')?),
        _ => {
            let at = place(text.len(), random);
            let (a, b) = text.split_at_checked(at)?;
            format!("{a}{}{b}", pick(&["\"", "}", "\\u0000", "0", ",", "é"], random))
        }
    };
    Some([&(changed.len() as u64).to_le_bytes()[..], changed.as_bytes(), body].concat())
}
