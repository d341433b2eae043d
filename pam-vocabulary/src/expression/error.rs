//! Errors of expressions.

use std::fmt;

/// An expression that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExpressionError {
    /// Line in the text, from 1.
    pub line: usize,
    /// Column in the line, in characters, from 1.
    pub column: usize,
    /// The fault and its remedy.
    pub message: String,
}

impl ExpressionError {
    /// An error at a byte of a text.
    #[must_use]
    pub fn at(text: &str, byte: usize, message: String) -> Self {
        let before = &text[..text.floor_char_boundary(byte.min(text.len()))];
        let line = before.matches('\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |k| k + 1);
        Self { line, column: before[start..].chars().count() + 1, message }
    }
}

impl fmt::Display for ExpressionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}: {}", self.line, self.column, self.message)
    }
}

impl std::error::Error for ExpressionError {}

/// The known word that is nearest to an unknown one by insertions, deletions and replacements; `None` where none is near.
pub(crate) fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Every word of one letter is near to every other.
    let most = match word.chars().count() {
        1 => 0,
        letters => letters.div_ceil(3),
    };
    let near = known.into_iter().map(|k| (distance(word, k), k)).min_by_key(|(d, _)| *d);
    near.filter(|(d, _)| *d <= most).map(|(_, k)| k)
}

/// Levenshtein's distance.
fn distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.chars().enumerate() {
            let replaced = diagonal + usize::from(!x.eq_ignore_ascii_case(&y));
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.chars().count()]
}
