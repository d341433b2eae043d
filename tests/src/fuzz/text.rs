//! Mutations of text: numbers, words, lines, columns, encodings.

use super::mutate::{DOUBLES, pick, place};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

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
    "1e400",
    "-1e400",
    "1e-400",
    "1e999999999999",
    "+infinity",
    "1,5",
    "--1",
    "0b11",
    "\u{0663}",
    "1979-05-27T07:32:00Z",
    "'text'",
    "\"\"\"",
    "null",
];

/// Numbers, keys and lines replaced, lost, doubled or moved.
pub(super) fn mutated(bytes: &[u8], random: &mut ChaCha8Rng) -> Vec<u8> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if lines.is_empty() {
        return b"a = 1\n".to_vec();
    }
    let (a, b) = (place(lines.len(), random), place(lines.len(), random));
    match random.random_range(0..20) {
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
        6 => return encoded(&text, random),
        7 => lines.insert(a, nested(random)),
        8 => {
            // A part of the file, again and again.
            let part = lines[a.min(b)..=a.max(b)].to_vec();
            for _ in 0..random.random_range(1..200_usize).min(20_000 / part.len()) {
                lines.extend_from_slice(&part);
            }
        }
        9 => {
            let length = lines[a].chars().count() << random.random_range(4..14);
            lines[a] = lines[a].chars().cycle().take(length.min(1 << 20)).collect();
        }
        10 => {
            // Times or keys backwards.
            lines[a.min(b)..=a.max(b)].reverse();
        }
        11 => {
            let other = pick(&[";", "\t", " ", ",,", "|"], random);
            return text.replace(',', other).into_bytes();
        }
        12 => {
            // Two columns in each other's place.
            let (from, to) = (place(6, random), place(6, random));
            for line in &mut lines {
                let mut cells: Vec<&str> = line.split(',').collect();
                if from.max(to) < cells.len() {
                    cells.swap(from, to);
                }
                *line = cells.join(",");
            }
        }
        _ => lines[a] = number_replaced(&lines[a], random),
    }
    (lines.join("\n") + "\n").into_bytes()
}

/// The same text in another encoding or with other ends of lines, or with bytes that are no text.
fn encoded(text: &str, random: &mut ChaCha8Rng) -> Vec<u8> {
    const MARK: &str = "\u{feff}";
    let wide = |units: Vec<[u8; 2]>| units.concat();
    match random.random_range(0..8) {
        0 => format!("{MARK}{text}").into_bytes(),
        1 => text.replace('\n', "\r\n").into_bytes(),
        2 => text.replace('\n', "\r").into_bytes(),
        3 => wide(format!("{MARK}{text}").encode_utf16().map(u16::to_le_bytes).collect()),
        4 => wide(format!("{MARK}{text}").encode_utf16().map(u16::to_be_bytes).collect()),
        5 => wide(text.encode_utf16().map(u16::to_le_bytes).collect()),
        6 => text.replace(' ', "\u{a0}").into_bytes(),
        _ => {
            let mut bytes = text.as_bytes().to_vec();
            let at = place(bytes.len(), random);
            let part = [&b"\0"[..], b"\xff\xfe", b"\xc3", b"\x1b[31m", b"\x1a"][place(5, random)];
            bytes.splice(at..at, part.iter().copied());
            bytes
        }
    }
}

/// A line of brackets or tables in each other.
fn nested(random: &mut ChaCha8Rng) -> String {
    let depth = 1 << random.random_range(2..18);
    let around =
        |open: &str, close: &str| format!("deep = {}1{}", open.repeat(depth), close.repeat(depth));
    match random.random_range(0..5) {
        0 => around("[", "]"),
        1 => around("{ a = ", " }"),
        2 => around("(", ")"),
        3 => format!("[{}a]", "a.".repeat(depth)),
        _ => format!("{}a = 1", "a.".repeat(depth)),
    }
}

/// A line with one of its numbers or words replaced.
pub(super) fn number_replaced(line: &str, random: &mut ChaCha8Rng) -> String {
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
