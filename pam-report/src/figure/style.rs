//! One look for all figures.

use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;

/// Figures are drawn at this multiple of their size and scaled down by the page, because the drawing
/// library rounds to whole pixels.
pub(super) const SCALE: u32 = 2;

/// Axis and label text, before scaling, px.
pub(super) const TEXT: u32 = 13;
/// Title text, before scaling, px.
pub(super) const TITLE: u32 = 15;

pub(super) const INK: RGBColor = RGBColor(34, 34, 34);
pub(super) const GRID: RGBColor = RGBColor(228, 228, 228);
/// Ground of every other band; the grid is drawn over it.
pub(super) const BAND: RGBColor = RGBColor(241, 244, 248);

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
    /// Lengths of a dash and of the gap after it, px of the drawing; none for a solid line.
    pub(super) fn pattern(self) -> Option<(u32, u32)> {
        match self {
            Self::Solid => None,
            Self::Dashed => Some((6 * SCALE, 4 * SCALE)),
            Self::Dotted => Some((SCALE + 1, 3 * SCALE)),
        }
    }
}

impl Role {
    /// The colour (Okabe and Ito's palette, its yellow last and darker, after a grey and a brown).
    #[must_use]
    pub fn colour(self) -> RGBColor {
        const PALETTE: [RGBColor; 10] = [
            RGBColor(0, 114, 178),
            RGBColor(230, 159, 0),
            RGBColor(0, 158, 115),
            RGBColor(204, 121, 167),
            RGBColor(86, 180, 233),
            RGBColor(213, 94, 0),
            RGBColor(0, 0, 0),
            RGBColor(150, 150, 150),
            RGBColor(146, 73, 0),
            RGBColor(180, 165, 0),
        ];
        match self {
            Self::Measured => RGBColor(64, 64, 64),
            Self::Predicted => RGBColor(213, 94, 0),
            Self::Residual => RGBColor(0, 114, 178),
            Self::Category(i) => PALETTE[i % PALETTE.len()],
            Self::Neutral => RGBColor(110, 110, 110),
        }
    }
}

/// SVG text that was drawn at [`SCALE`] times its size, shown at its size.
pub(super) fn at_nominal_size(svg: &str, width: u32, height: u32) -> String {
    let drawn = format!("width=\"{}\" height=\"{}\"", width * SCALE, height * SCALE);
    svg.replacen(&drawn, &format!("width=\"{width}\" height=\"{height}\""), 1)
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

/// How one axis is labelled.
pub(super) struct AxisLabels<'a> {
    pub(super) label: &'a str,
    /// About how many tick marks it has.
    pub(super) ticks: usize,
    /// Text of a tick mark.
    pub(super) format: &'a dyn Fn(f64) -> String,
}

/// Draws axes, grid and labels of a figure.
pub(super) fn draw_axes<X, Y>(
    chart: &mut ChartContext<'_, SVGBackend<'_>, Cartesian2d<X, Y>>,
    x: AxisLabels<'_>,
    y: AxisLabels<'_>,
) -> Result<(), Box<dyn std::error::Error>>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let text = ("sans-serif", TEXT * SCALE).into_font().color(&INK);
    chart
        .configure_mesh()
        .x_desc(x.label)
        .y_desc(y.label)
        .label_style(text.clone())
        .axis_desc_style(text)
        .axis_style(INK.stroke_width(SCALE))
        .bold_line_style(GRID.stroke_width(SCALE))
        .max_light_lines(0)
        .x_labels(x.ticks)
        .y_labels(y.ticks)
        .x_label_formatter(&|v| (x.format)(*v))
        .y_label_formatter(&|v| (y.format)(*v))
        .draw()?;
    Ok(())
}

/// Tick labels: as many decimals as the distance of ticks asks for.
pub(super) fn tick_label(value: f64, span: f64) -> String {
    let decimals = (1.0 - span.abs().max(1e-12).log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    };
    if text == "-0" { "0".into() } else { text }
}
