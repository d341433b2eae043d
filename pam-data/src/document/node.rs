//! The tree that TOML and JSON text is parsed into.

use super::DocumentError;
use serde_json::Value;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

/// Memory that a value of a JSON text takes while it is read.
const BYTES_OF_A_VALUE: u64 = 128;

/// A value and, if known, its byte range in the text.
#[derive(Clone, Debug)]
pub struct Node {
    pub(super) content: Content,
    pub(super) span: Option<Range<usize>>,
}

#[derive(Clone, Debug)]
pub(super) enum Content {
    Null,
    Bool(bool),
    Integer(i64),
    Unsigned(u64),
    Float(f64),
    Text(String),
    /// A field name known at compile time.
    Known(&'static str),
    List(Vec<Node>),
    /// Keys are nodes as well, so that errors can point at them.
    Table(Vec<(Node, Node)>),
}

impl Node {
    pub(super) fn new(content: Content, span: Option<Range<usize>>) -> Self {
        Self { content, span }
    }

    /// Parses TOML text. Dates become strings.
    ///
    /// # Errors
    /// [`DocumentError`] with the position if the text is not TOML.
    pub fn from_toml(text: &str) -> Result<Self, DocumentError> {
        let table = DeTable::parse(text)
            .map_err(|e| DocumentError::new(e.message().to_owned()).at(e.span()))?;
        // No span for the root: the error of a missing top-level field has no position.
        Ok(Self::new(of_table(table.into_inner())?, None))
    }

    /// Parses JSON text.
    ///
    /// # Errors
    /// [`DocumentError`] with line and column if the text is not JSON, or if its values would take more memory than a
    /// [file of the largest size](crate::read_limit::largest_bytes) may.
    pub fn from_json(text: &str) -> Result<Self, DocumentError> {
        let values = text.bytes().filter(|b| b",[{".contains(b)).count() as u64;
        let bytes = values.saturating_mul(BYTES_OF_A_VALUE);
        if bytes > crate::read_limit::largest_bytes().saturating_mul(crate::read_limit::COPIES) {
            let message =
                format!("{values} values are too many to read; raise the limit (--max-read-mib)");
            return Err(DocumentError::new(message));
        }
        let place = |e: &serde_json::Error| {
            let line = text.split_inclusive('\n').take(e.line().saturating_sub(1)).map(str::len);
            let at = line.sum::<usize>() + e.column().saturating_sub(1);
            Some(at.min(text.len())..text.len())
        };
        let value: Value = serde_json::from_str(text)
            .map_err(|e| DocumentError::new(e.to_string()).at(place(&e)))?;
        Ok(value.into())
    }
}

impl From<Value> for Node {
    fn from(value: Value) -> Self {
        let content = match value {
            Value::Null => Content::Null,
            Value::Bool(b) => Content::Bool(b),
            Value::String(text) => Content::Text(text),
            Value::Array(list) => Content::List(list.into_iter().map(Self::from).collect()),
            Value::Object(map) => {
                let key = |text| Self::new(Content::Text(text), None);
                Content::Table(map.into_iter().map(|(k, v)| (key(k), v.into())).collect())
            }
            Value::Number(number) => match (number.as_i64(), number.as_u64()) {
                (Some(integer), _) => Content::Integer(integer),
                (None, Some(unsigned)) => Content::Unsigned(unsigned),
                (None, None) => number.as_f64().map_or(Content::Null, Content::Float),
            },
        };
        Self::new(content, None)
    }
}

fn of_table(table: DeTable<'_>) -> Result<Content, DocumentError> {
    let entry = |(key, value): (Spanned<_>, Spanned<DeValue<'_>>)| {
        let span = key.span();
        let name: std::borrow::Cow<'_, str> = key.into_inner();
        Ok((Node::new(Content::Text(name.into_owned()), Some(span)), of_value(value)?))
    };
    Ok(Content::Table(table.into_iter().map(entry).collect::<Result<_, DocumentError>>()?))
}

fn of_value(value: Spanned<DeValue<'_>>) -> Result<Node, DocumentError> {
    let span = Some(value.span());
    let wrong = |what: &str| DocumentError::new(what.to_owned()).at(span.clone());
    let content = match value.into_inner() {
        DeValue::String(text) => Content::Text(text.into_owned()),
        DeValue::Boolean(b) => Content::Bool(b),
        DeValue::Integer(i) => {
            integer(&i).ok_or_else(|| wrong("the integer has too many digits"))?
        }
        DeValue::Float(f) => {
            Content::Float(f.as_str().parse().map_err(|_| wrong("this is not a number"))?)
        }
        DeValue::Datetime(date) => Content::Text(date.to_string()),
        DeValue::Array(list) => {
            Content::List(list.into_iter().map(of_value).collect::<Result<_, _>>()?)
        }
        DeValue::Table(table) => of_table(table)?,
    };
    Ok(Node::new(content, span))
}

fn integer(integer: &DeInteger<'_>) -> Option<Content> {
    let (text, radix) = (integer.as_str(), integer.radix());
    let signed = i64::from_str_radix(text, radix).ok().map(Content::Integer);
    signed.or_else(|| u64::from_str_radix(text, radix).ok().map(Content::Unsigned))
}
