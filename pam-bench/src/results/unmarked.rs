//! Numbers of a page that no marker covers.

/// Units after which a whole number counts as well: the units of measurements.
const UNITS: [&str; 22] = [
    "ms", "µs", "s", "%", "mm", "µm", "N", "mN", "N/mm", "kg", "kg/s", "kPa", "g", "GB", "MB",
    "GFLOP/s", "times", "min", "mJ", "Hz", "kHz", "mm/s",
];

/// The numbers of a Markdown page that have decimals, an exponent or the unit of a measurement and stand outside of markers,
/// code, links, headings and parts that other programs write (`<!-- … -->` to `<!-- end … -->`), each with its line and its
/// unit: `(12, "0.5 mm")`. A page that a program writes as a whole (`<!-- Generated …`) has none.
#[must_use]
pub fn unmarked(page: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    if page.starts_with("<!-- Generated") {
        return found;
    }
    let prose = prose(page);
    for (line, text) in prose.lines().enumerate() {
        if text.starts_with('#') {
            continue;
        }
        let mut rest = text;
        let mut before = ' ';
        while let Some(first) = rest.chars().next() {
            let starts = first.is_ascii_digit()
                || (matches!(first, '−' | '-')
                    && rest.chars().nth(1).is_some_and(|c| c.is_ascii_digit()));
            let separated = !before.is_alphanumeric() && !"._/^,⁻".contains(before);
            let length = if starts && separated { number_length(rest) } else { 0 };
            if length == 0 {
                // A word with digits is no number, and its end no start of one.
                before = first;
                rest = &rest[first.len_utf8()..];
                continue;
            }
            let (number, after) = rest.split_at(length);
            let unit = unit(after);
            let is_word = after.starts_with(|c: char| c.is_alphabetic()) && unit.is_none();
            if !is_word && (unit.is_some() || number.contains(['.', 'e'])) {
                let text = unit.map_or(number.to_owned(), |unit| format!("{number} {unit}"));
                found.push((line + 1, text));
            }
            before = number.chars().next_back().unwrap_or(' ');
            rest = after;
        }
    }
    found
}

/// Length of the number at the start of a text.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| text[from..].bytes().take_while(u8::is_ascii_digit).count();
    let sign = text.chars().next().filter(|c| matches!(c, '−' | '-')).map_or(0, char::len_utf8);
    let mut end = sign + digits(sign);
    if text[end..].starts_with('.') && digits(end + 1) > 0 {
        end += 1 + digits(end + 1);
    }
    for exponent in ["e-", "e−", "e"] {
        let from = end + exponent.len();
        if text[end..].starts_with(exponent) && digits(from) > 0 {
            return from + digits(from);
        }
    }
    end
}

/// The unit of a measurement at the start of a text.
fn unit(text: &str) -> Option<&'static str> {
    let text = text.strip_prefix(' ').unwrap_or(text);
    UNITS.into_iter().find(|unit| {
        text.strip_prefix(unit)
            .is_some_and(|after| !after.starts_with(|c: char| c.is_alphanumeric() || c == '/'))
    })
}

/// The page with blanks, and its line breaks, in place of what is no prose.
fn prose(page: &str) -> String {
    let spans =
        [("```", "```"), ("<!--= ", "<!--/-->"), ("<!--# ", "<!--/-->"), ("`", "`"), ("](", ")")];
    let mut out = String::with_capacity(page.len());
    let mut rest = page;
    while let Some(first) = rest.chars().next() {
        let generated = rest.starts_with("<!-- ") && rest.contains("<!-- end");
        let end = if generated {
            let end = rest.find("<!-- end").unwrap_or(0);
            Some(end + rest[end..].find("-->").map_or(0, |k| k + 3))
        } else {
            spans.iter().find(|(open, _)| rest.starts_with(open)).and_then(|(open, close)| {
                rest[open.len()..].find(close).map(|k| open.len() + k + close.len())
            })
        };
        let length = end.unwrap_or(first.len_utf8());
        match end {
            Some(end) => {
                out.push('§');
                out.extend(rest[..end].chars().filter(|c| *c == '\n'));
            }
            None => out.push(first),
        }
        rest = &rest[length..];
    }
    out
}
