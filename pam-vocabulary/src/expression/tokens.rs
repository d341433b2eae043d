//! Words, numbers and signs of an expression.

use super::ExpressionError;

/// A word, a number or a sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Token<'a> {
    Word(&'a str),
    Number(f64),
    Sign(&'static str),
    End,
}

const SIGNS: [&str; 15] =
    ["<=", ">=", "==", "!=", "<", ">", "+", "-", "*", "/", "^", "(", ")", ",", "−"];

/// The tokens of a text, each with its byte; the last one is [`Token::End`].
pub(super) fn tokens(text: &str) -> Result<Vec<(Token<'_>, usize)>, ExpressionError> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(next) = text[at..].chars().next() {
        let rest = &text[at..];
        if next.is_whitespace() {
            at += next.len_utf8();
        } else if next.is_ascii_alphabetic() || next == '_' {
            let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
            found.push((Token::Word(&rest[..end]), at));
            at += end;
        } else if next.is_ascii_digit() || next == '.' {
            let end = number_end(rest);
            let number: f64 = rest[..end].parse().map_err(|_| {
                ExpressionError::at(text, at, format!("`{}` is no number", &rest[..end]))
            })?;
            if !number.is_finite() {
                let message = format!("`{}` is too large for a number", &rest[..end]);
                return Err(ExpressionError::at(text, at, message));
            }
            found.push((Token::Number(number), at));
            at += end;
        } else if let Some(sign) = SIGNS.iter().find(|sign| rest.starts_with(**sign)) {
            found.push((Token::Sign(if *sign == "−" { "-" } else { sign }), at));
            at += sign.len();
        } else {
            let message = match next {
                '=' => "`=` assigns nothing here; compare with `==`".to_owned(),
                '&' | '|' => {
                    "there is no `and` and `or`; multiply conditions, or take their max".into()
                }
                other => format!("`{other}` has no meaning in an expression"),
            };
            return Err(ExpressionError::at(text, at, message));
        }
    }
    found.push((Token::End, text.len()));
    Ok(found)
}

/// Where a number like `1.5e-3` at the start of a text ends.
fn number_end(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |mut k: usize| {
        while bytes.get(k).is_some_and(|b| b.is_ascii_digit() || *b == b'.') {
            k += 1;
        }
        k
    };
    let end = digits(0);
    if !matches!(bytes.get(end), Some(b'e' | b'E')) {
        return end;
    }
    let signed = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
    if bytes.get(signed).is_some_and(u8::is_ascii_digit) { digits(signed) } else { end }
}
