//! Lines as path data.

use std::fmt::Write as _;

/// Units of the content along either axis: fine enough to be magnified, and whole, which keeps paths short.
pub(super) const UNITS: i64 = 20_000;

/// Path data through places in [`UNITS`]: a start and steps. Empty for no place.
pub(super) fn path_through(places: impl IntoIterator<Item = (i64, i64)>) -> String {
    let mut places = places.into_iter();
    let Some(start) = places.next() else { return String::new() };
    let mut text = format!("M{} {}l", start.0, start.1);
    let mut at = start;
    let mut moved = false;
    for place in places {
        let (dx, dy) = (place.0 - at.0, place.1 - at.1);
        if (dx, dy) == (0, 0) {
            continue;
        }
        // A sign separates numbers as well as a blank does.
        let blank = |v: i64| if v < 0 { "" } else { " " };
        let first = if moved { blank(dx) } else { "" };
        write!(text, "{first}{dx}{}{dy}", blank(dy)).expect("writing to a string cannot fail");
        (at, moved) = (place, true);
    }
    if !moved {
        text.push_str("0 0");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_a_start_and_steps() {
        assert_eq!(path_through([]), "");
        assert_eq!(path_through([(5, 6), (5, 6)]), "M5 6l0 0");
        assert_eq!(path_through([(5, 6), (7, 5), (7, 5), (6, 5), (9, 9)]), "M5 6l2-1-1 0 3 4");
    }
}
