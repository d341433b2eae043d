//! Numbers of ROS 2 messages: schemas in the language of `.msg` files, values in CDR (OMG, *DDS-XTypes*, section 7.4).

use std::collections::BTreeMap;

/// Most elements of an array that become columns.
const MOST_ELEMENTS: usize = 256;
/// Deepest nesting of messages: schemas of damaged files may contain themselves.
const DEEPEST: usize = 32;

/// The message types of a schema.
#[derive(Debug)]
pub(super) struct MessageSchema {
    root: String,
    types: BTreeMap<String, Vec<MessageField>>,
}

#[derive(Debug)]
struct MessageField {
    name: String,
    kind: String,
    count: Count,
}

#[derive(Debug, Clone, Copy)]
enum Count {
    One,
    Fixed(usize),
    Sequence,
}

impl MessageSchema {
    /// Reads the concatenated definitions of a schema named `root`.
    pub(super) fn parse(root: &str, text: &str) -> Self {
        let mut types = BTreeMap::new();
        let mut name = short(root);
        let mut fields = Vec::new();
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or("").trim();
            if line.starts_with("====") {
                continue;
            }
            if let Some(next) = line.strip_prefix("MSG:") {
                types.insert(
                    std::mem::replace(&mut name, short(next.trim())),
                    std::mem::take(&mut fields),
                );
                continue;
            }
            let mut words = line.split_whitespace();
            let (Some(kind), Some(field)) = (words.next(), words.next()) else { continue };
            // Constants are no part of the message; defaults follow the name.
            if field.contains('=') || words.next().is_some_and(|w| w.starts_with('=')) {
                continue;
            }
            let (kind, count) = match kind.split_once('[') {
                None => (kind, Count::One),
                Some((kind, size)) => match size.trim_end_matches(']').parse() {
                    Ok(size) => (kind, Count::Fixed(size)),
                    Err(_) => (kind, Count::Sequence),
                },
            };
            let kind = kind.split("<=").next().unwrap_or(kind).to_owned();
            fields.push(MessageField { name: field.to_owned(), kind, count });
        }
        types.insert(name, fields);
        Self { root: short(root), types }
    }

    /// The numbers of a message by their paths.
    pub(super) fn numbers(&self, data: &[u8]) -> Result<Vec<(String, f64)>, String> {
        let header = data.get(..4).ok_or("a message is shorter than its header")?;
        let mut reader = Cdr { data: &data[4..], at: 0, little: header[1] & 1 == 1 };
        let mut out = Vec::new();
        self.message(&self.root, "", &mut reader, &mut out, 0)?;
        Ok(out)
    }

    fn message(
        &self,
        kind: &str,
        path: &str,
        reader: &mut Cdr<'_>,
        out: &mut Vec<(String, f64)>,
        depth: usize,
    ) -> Result<(), String> {
        let fields = match self.types.get(kind) {
            Some(fields) => fields.as_slice(),
            None if matches!(kind, "builtin_interfaces/Time" | "builtin_interfaces/Duration") => {
                let [seconds, nanos] = [reader.int(4, true)?, reader.int(4, false)?];
                out.push((path.to_owned(), seconds + 1e-9 * nanos));
                return Ok(());
            }
            None => return Err(format!("the schema does not define `{kind}`")),
        };
        if depth > DEEPEST {
            return Err(format!("`{kind}` contains itself"));
        }
        let start = out.len();
        for field in fields {
            let name =
                if path.is_empty() { field.name.clone() } else { format!("{path}.{}", field.name) };
            let (count, is_array) = match field.count {
                Count::One => (1, false),
                Count::Fixed(count) => (count, true),
                Count::Sequence => (reader.int(4, false)? as usize, true),
            };
            for k in 0..count {
                let name = if is_array { format!("{name}[{k}]") } else { name.clone() };
                let before = out.len();
                self.value(&field.kind, kind, &name, reader, out, depth)?;
                if k >= MOST_ELEMENTS {
                    out.truncate(before);
                }
            }
        }
        // A time in one number beside its parts.
        if kind.starts_with("builtin_interfaces/")
            && let [(_, seconds), (_, nanos)] = out[start..]
        {
            out.push((path.to_owned(), seconds + 1e-9 * nanos));
        }
        Ok(())
    }

    fn value(
        &self,
        kind: &str,
        parent: &str,
        name: &str,
        reader: &mut Cdr<'_>,
        out: &mut Vec<(String, f64)>,
        depth: usize,
    ) -> Result<(), String> {
        let number = match kind {
            "bool" | "byte" | "char" | "uint8" => reader.int(1, false)?,
            "int8" => reader.int(1, true)?,
            "uint16" => reader.int(2, false)?,
            "int16" => reader.int(2, true)?,
            "uint32" => reader.int(4, false)?,
            "int32" => reader.int(4, true)?,
            "uint64" => reader.int(8, false)?,
            "int64" => reader.int(8, true)?,
            "float32" => f64::from(f32::from_bits(reader.bits(4)? as u32)),
            "float64" => f64::from_bits(reader.bits(8)?),
            "string" => {
                let length = reader.bits(4)? as usize;
                return reader.skip(length);
            }
            "wstring" => {
                let length = reader.bits(4)? as usize;
                return reader.skip(2 * length);
            }
            other if other.contains('/') => {
                return self.message(&short(other), name, reader, out, depth + 1);
            }
            // Types without a package are of the same one, but for the header.
            "Header" => return self.message("std_msgs/Header", name, reader, out, depth + 1),
            other => {
                let package = parent.split('/').next().unwrap_or("");
                return self.message(&format!("{package}/{other}"), name, reader, out, depth + 1);
            }
        };
        out.push((name.to_owned(), number));
        Ok(())
    }
}

/// `package/msg/Type` as `package/Type`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A reader of plain CDR: values are aligned to their size.
struct Cdr<'a> {
    data: &'a [u8],
    at: usize,
    little: bool,
}

impl Cdr<'_> {
    fn bits(&mut self, size: usize) -> Result<u64, String> {
        self.at = self.at.next_multiple_of(size);
        let bytes = self.data.get(self.at..self.at + size).ok_or("a message ends early")?;
        self.at += size;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Ok(if self.little { bytes.iter().rev().fold(0, add) } else { bytes.iter().fold(0, add) })
    }

    fn int(&mut self, size: usize, signed: bool) -> Result<f64, String> {
        let bits = self.bits(size)?;
        let shift = 64 - 8 * size as u32;
        Ok(if signed { ((bits << shift) as i64 >> shift) as f64 } else { bits as f64 })
    }

    fn skip(&mut self, length: usize) -> Result<(), String> {
        self.at = self.at.saturating_add(length);
        if self.at > self.data.len() { Err("a message ends early".into()) } else { Ok(()) }
    }
}
