//! One look for all figures.

use maud::{Markup, html};

/// Axis and label text, px.
pub(super) const TEXT: u32 = 13;
/// Title text, px.
pub(super) const TITLE: u32 = 15;

/// A colour on light and on dark ground, as `#rrggbb`. Its name is the class of what it colours, and the CSS variable by
/// which a page sets it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Colour {
    pub(crate) name: &'static str,
    pub(crate) light: &'static str,
    pub(crate) dark: &'static str,
}

const fn colour(name: &'static str, light: &'static str, dark: &'static str) -> Colour {
    Colour { name, light, dark }
}

pub(super) const GROUND: Colour = colour("ground", "#ffffff", "#16181b");
pub(super) const INK: Colour = colour("ink", "#222222", "#e4e4e4");
pub(super) const GRID: Colour = colour("grid", "#e4e4e4", "#363b41");
/// Ground of every other band; the grid is drawn over it.
pub(super) const BAND: Colour = colour("band", "#f1f4f8", "#20252b");
const MEASURED: Colour = colour("measured", "#404040", "#d0d0d0");
const PREDICTED: Colour = colour("predicted", "#d55e00", "#ff8a3d");
const RESIDUAL: Colour = colour("residual", "#0072b2", "#4aa8e8");
const NEUTRAL: Colour = colour("neutral", "#6e6e6e", "#a6a6a6");
/// Okabe and Ito's palette, its yellow last and darker, after a grey and a brown.
const CATEGORIES: [Colour; 10] = [
    colour("c0", "#0072b2", "#4aa8e8"),
    colour("c1", "#e69f00", "#f2b430"),
    colour("c2", "#009e73", "#2ec497"),
    colour("c3", "#cc79a7", "#e597c2"),
    colour("c4", "#56b4e9", "#a5dcff"),
    colour("c5", "#d55e00", "#ff8a3d"),
    colour("c6", "#000000", "#ffffff"),
    colour("c7", "#969696", "#8c8c8c"),
    colour("c8", "#924900", "#c98b4e"),
    colour("c9", "#b4a500", "#d6c83a"),
];

/// Every colour of figures but those of maps.
pub(crate) const PALETTE: [Colour; 18] = {
    let mut all = [GROUND; 18];
    (all[1], all[2], all[3]) = (INK, GRID, BAND);
    (all[4], all[5], all[6], all[7]) = (MEASURED, PREDICTED, RESIDUAL, NEUTRAL);
    let mut k = 0;
    while k < CATEGORIES.len() {
        all[8 + k] = CATEGORIES[k];
        k += 1;
    }
    all
};

/// Role of a line, which decides its colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Measured data.
    Measured,
    /// A model's prediction.
    Predicted,
    /// A difference between the two.
    Residual,
    /// One of several equals, by number.
    Category(usize),
    /// Not data: a rule, a sample in the legend.
    Neutral,
}

impl Role {
    pub(super) fn colour(self) -> Colour {
        match self {
            Self::Measured => MEASURED,
            Self::Predicted => PREDICTED,
            Self::Residual => RESIDUAL,
            Self::Category(i) => CATEGORIES[i % CATEGORIES.len()],
            Self::Neutral => NEUTRAL,
        }
    }
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stroke {
    /// Without gaps.
    #[default]
    Solid,
    /// In dashes.
    Dashed,
    /// In dots.
    Dotted,
}

impl Stroke {
    /// Lengths of a dash and of the gap after it, px; none for a solid line.
    pub(super) fn dashes(self) -> Option<&'static str> {
        match self {
            Self::Solid => None,
            Self::Dashed => Some("6 4"),
            Self::Dotted => Some("1.5 3"),
        }
    }

    /// Width of a line, px.
    pub(super) fn width(self) -> &'static str {
        if self == Self::Solid { "1.5" } else { "1.2" }
    }
}

/// Content in one colour: it draws with `currentColor`, which a page may set by the class.
pub(super) fn coloured(colour: Colour, content: &Markup) -> Markup {
    html! { g class=(colour.name) color=(colour.light) { (content) } }
}

/// A number of the drawing, to a tenth of a pixel.
pub(super) fn px(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
}

/// About how wide a text is, px: it is drawn by the reader's browser and can only be estimated.
pub(super) fn text_width(text: &str, size: u32) -> f64 {
    text.chars().count() as f64 * f64::from(size) * 0.56
}

/// A range with a margin around the finite values, never empty.
pub(super) fn padded_range(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in values.filter(|v| v.is_finite()) {
        low = low.min(v);
        high = high.max(v);
    }
    if low > high {
        return (0.0, 1.0);
    }
    let span = high - low;
    let size = high.abs().max(low.abs());
    if span <= 1e-6 * size || span == 0.0 {
        // One value: a range of a tenth of its size about it.
        let half = if size > 0.0 { 0.05 * size } else { 0.5 };
        return (low - half, high + half);
    }
    (low - margin * span, high + margin * span)
}

/// Tick labels: as many decimals as the distance of ticks asks for, with a power of ten where they were long.
pub(super) fn tick_label(value: f64, span: f64) -> String {
    let place = span.abs().max(f64::MIN_POSITIVE).log10().floor() - 1.0;
    let size = value.abs().log10().floor();
    let (mantissa, exponent) = if value != 0.0 && (size >= 5.0 || place < -4.0) {
        let digits = (size - place).clamp(0.0, 15.0) as usize;
        let text = format!("{value:.digits$e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        (mantissa.to_owned(), format!("e{exponent}"))
    } else {
        (format!("{value:.0$}", (-place).clamp(0.0, 6.0) as usize), String::new())
    };
    let mantissa = if mantissa.contains('.') {
        mantissa.trim_end_matches('0').trim_end_matches('.')
    } else {
        &mantissa
    };
    let text = format!("{mantissa}{exponent}").replace('-', "−");
    if text == "−0" { "0".into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tick_labels_are_short() {
        let labels =
            [(0.5, 2.0), (-0.25, 0.4), (1.27e6, 3e4), (1e-4, 5e-4), (0.0, 1e-6), (1e5, 3e5)];
        let labels = labels.map(|(value, span)| tick_label(value, span));
        assert_eq!(labels, ["0.5", "−0.25", "1.27e6", "1e−4", "0", "1e5"]);
    }
}
