//! A serde deserializer over [`Node`], so that each type is compiled for one input format only.

use super::node::{Content, Node};
use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error, Expected, MapAccess, SeqAccess, Unexpected,
    VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use std::fmt::Display;
use std::ops::Range;

/// A document that could not be parsed or does not match the type: message, byte range and field path.
#[derive(Clone, Debug)]
pub struct DocumentError {
    message: String,
    span: Option<Range<usize>>,
    /// Field names, innermost first.
    path: Vec<String>,
}

impl DocumentError {
    pub(super) fn new(message: String) -> Self {
        Self { message, span: None, path: Vec::new() }
    }

    /// Sets the byte range unless a narrower one is already known.
    pub(super) fn at(mut self, span: Option<Range<usize>>) -> Self {
        self.span = self.span.or(span);
        self
    }

    fn inside(mut self, key: impl Into<String>) -> Self {
        self.path.push(key.into());
        self
    }

    /// The message without line or field.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The byte range of the offending text. `None` for a field in JSON, and for a missing top-level field.
    #[must_use]
    pub fn span(&self) -> Option<Range<usize>> {
        self.span.clone()
    }

    /// The line of `text`, counted from one, where the error is; the first line if its position is unknown.
    #[must_use]
    pub fn line(&self, text: &str) -> u64 {
        super::line_of(text, self.span.as_ref().map_or(0, |span| span.start))
    }

    /// The path of the offending field, such as `stage.2.epochs`; empty for the whole document.
    #[must_use]
    pub fn path(&self) -> String {
        self.path.iter().rev().map(String::as_str).collect::<Vec<_>>().join(".")
    }
}

impl Display for DocumentError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.path.is_empty() {
            write!(f, "`{}`: ", self.path())?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for DocumentError {}

impl Error for DocumentError {
    fn custom<T: Display>(message: T) -> Self {
        Self::new(message.to_string())
    }
}

impl From<serde_json::Error> for DocumentError {
    fn from(error: serde_json::Error) -> Self {
        Self::new(error.to_string())
    }
}

impl Node {
    /// The error of a value that is not of the expected type.
    fn unexpected(self, expected: &dyn Expected) -> DocumentError {
        let found = match &self.content {
            Content::Null => Unexpected::Unit,
            Content::Bool(b) => Unexpected::Bool(*b),
            Content::Integer(i) => Unexpected::Signed(*i),
            Content::Unsigned(u) => Unexpected::Unsigned(*u),
            Content::Float(f) => Unexpected::Float(*f),
            Content::Text(text) => Unexpected::Str(text),
            Content::Known(name) => Unexpected::Str(name),
            Content::List(_) => Unexpected::Seq,
            Content::Table(_) => Unexpected::Map,
        };
        DocumentError::invalid_type(found, expected).at(self.span)
    }
}

/// Adds the byte range of the value to an error.
fn located<T>(
    result: Result<T, DocumentError>,
    span: Option<Range<usize>>,
) -> Result<T, DocumentError> {
    match result {
        Err(e) => Err(e.at(span)),
        ok => ok,
    }
}

// `deserialize_any` instantiates nine methods of each visitor. Types that say which kind of value they expect get one.
impl<'de> Deserializer<'de> for Node {
    type Error = DocumentError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DocumentError> {
        let span = self.span;
        let result = match self.content {
            Content::Null => visitor.visit_unit(),
            Content::Bool(b) => visitor.visit_bool(b),
            Content::Integer(i) => visitor.visit_i64(i),
            Content::Unsigned(u) => visitor.visit_u64(u),
            Content::Float(f) => visitor.visit_f64(f),
            Content::Text(text) => visitor.visit_string(text),
            Content::Known(name) => visitor.visit_borrowed_str(name),
            Content::List(list) => visitor.visit_seq(Items::new(list)),
            Content::Table(entries) => visitor.visit_map(Entries::new(entries)),
        };
        located(result, span)
    }

    fn deserialize_identifier<V: Visitor<'de>>(
        self,
        visitor: V,
    ) -> Result<V::Value, DocumentError> {
        match self.content {
            Content::Text(text) => located(visitor.visit_string(text), self.span),
            Content::Known(name) => visitor.visit_str(name),
            _ => Err(self.unexpected(&visitor)),
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DocumentError> {
        match self.content {
            Content::List(list) => located(visitor.visit_seq(Items::new(list)), self.span),
            _ => Err(self.unexpected(&visitor)),
        }
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        _len: usize,
        visitor: V,
    ) -> Result<V::Value, DocumentError> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DocumentError> {
        match self.content {
            Content::Table(entries) => located(visitor.visit_map(Entries::new(entries)), self.span),
            _ => Err(self.unexpected(&visitor)),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, DocumentError> {
        match self.content {
            Content::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, DocumentError> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DocumentError> {
        // `Spanned<T>` asks for three fields: start, end and the value.
        if let (true, [start, end, value]) = (serde_spanned::de::is_spanned(name), fields) {
            let span = self.span.clone().unwrap_or(0..0);
            let key = |name: &&'static str| Node::new(Content::Known(name), None);
            let number = |at: usize| Node::new(Content::Unsigned(at as u64), None);
            let entries = vec![
                (key(start), number(span.start)),
                (key(end), number(span.end)),
                (key(value), self),
            ];
            return visitor.visit_map(Entries { silent: true, ..Entries::new(entries) });
        }
        // No structure is written as a list: its visitor's method for sequences is not compiled.
        self.deserialize_map(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DocumentError> {
        let span = self.span.clone();
        let variant = match self.content {
            Content::Text(_) | Content::Known(_) => Variant { name: self, content: None },
            Content::Table(mut entries) if entries.len() == 1 => {
                let (name, content) = entries.remove(0);
                Variant { name, content: Some(content) }
            }
            _ => {
                let what = "expected a name, or a table with a single key";
                return Err(DocumentError::new(what.into()).at(span));
            }
        };
        located(visitor.visit_enum(variant), span)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        unit unit_struct tuple_struct ignored_any
    }
}

/// The items of a list.
struct Items {
    rest: std::vec::IntoIter<Node>,
    at: usize,
}

impl Items {
    fn new(list: Vec<Node>) -> Self {
        Self { rest: list.into_iter(), at: 0 }
    }

    fn error_inside<T>(&self, error: DocumentError) -> Result<T, DocumentError> {
        Err(error.inside((self.at - 1).to_string()))
    }
}

impl<'de> SeqAccess<'de> for Items {
    type Error = DocumentError;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, DocumentError> {
        let Some(item) = self.rest.next() else { return Ok(None) };
        self.at += 1;
        match seed.deserialize(item) {
            Ok(value) => Ok(Some(value)),
            Err(e) => self.error_inside(e),
        }
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// The entries of a table.
struct Entries {
    rest: std::vec::IntoIter<(Node, Node)>,
    value: Option<Node>,
    /// Name and byte range of the value that is read.
    place: (String, Option<Range<usize>>),
    /// The keys are those of `Spanned`, not of the file: errors do not mention them.
    silent: bool,
}

impl Entries {
    fn new(entries: Vec<(Node, Node)>) -> Self {
        let place = (String::new(), None);
        Self { rest: entries.into_iter(), value: None, place, silent: false }
    }

    fn next_key(&mut self) -> Option<Node> {
        let (key, value) = self.rest.next()?;
        let name = match &key.content {
            Content::Text(name) => name.clone(),
            _ => String::new(),
        };
        self.place = (name, value.span.clone());
        self.value = Some(value);
        Some(key)
    }

    fn next_value(&mut self) -> Result<Node, DocumentError> {
        self.value.take().ok_or_else(|| DocumentError::custom("a value without a key"))
    }

    fn located(&mut self, error: DocumentError) -> DocumentError {
        let (name, span) = std::mem::take(&mut self.place);
        let error = error.at(span);
        if self.silent { error } else { error.inside(name) }
    }
}

impl<'de> MapAccess<'de> for Entries {
    type Error = DocumentError;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, DocumentError> {
        let Some(key) = self.next_key() else { return Ok(None) };
        match seed.deserialize(key) {
            Ok(key) => Ok(Some(key)),
            Err(e) => Err(e),
        }
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<T::Value, DocumentError> {
        let value = self.next_value()?;
        match seed.deserialize(value) {
            Err(e) => Err(self.located(e)),
            ok => ok,
        }
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.rest.len())
    }
}

/// An enum variant: its name, and its content if it has any.
struct Variant {
    name: Node,
    content: Option<Node>,
}

impl<'de> EnumAccess<'de> for Variant {
    type Error = DocumentError;
    type Variant = VariantContent;

    fn variant_seed<T: DeserializeSeed<'de>>(
        self,
        seed: T,
    ) -> Result<(T::Value, VariantContent), DocumentError> {
        let span = self.name.span.clone();
        let variant = seed.deserialize(self.name).map_err(|e| e.at(span))?;
        Ok((variant, VariantContent(self.content)))
    }
}

/// The content of an enum variant.
struct VariantContent(Option<Node>);

impl VariantContent {
    fn content(self) -> Result<Node, DocumentError> {
        self.0
            .ok_or_else(|| DocumentError::custom("this name needs a value: write { name = value }"))
    }
}

impl<'de> VariantAccess<'de> for VariantContent {
    type Error = DocumentError;

    fn unit_variant(self) -> Result<(), DocumentError> {
        match self.0 {
            None => Ok(()),
            Some(content) => {
                Err(DocumentError::custom("this name takes no value").at(content.span))
            }
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(
        self,
        seed: T,
    ) -> Result<T::Value, DocumentError> {
        seed.deserialize(self.content()?)
    }

    fn tuple_variant<V: Visitor<'de>>(
        self,
        _len: usize,
        visitor: V,
    ) -> Result<V::Value, DocumentError> {
        self.content()?.deserialize_seq(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, DocumentError> {
        self.content()?.deserialize_map(visitor)
    }
}
