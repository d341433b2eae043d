//! Title and legend above the axes, where they hide nothing.

use super::series::Series;
use super::style::{INK, SCALE, TEXT, TITLE};
use plotters::element::DashedPathElement;
use plotters::prelude::*;

/// About how wide a text is, px: it is drawn by the reader's browser and can only be estimated.
pub(super) fn text_width(text: &str, size: u32) -> f64 {
    text.chars().count() as f64 * f64::from(size) * 0.56
}

/// Draws the title at the left and the legend at the right, the legend in as many rows as it needs.
/// Returns the height of it all.
pub(super) fn draw_header(
    root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    title: &str,
    series: &[Series],
    figure_width: u32,
) -> Result<u32, Box<dyn std::error::Error>> {
    let scale = SCALE as i32;
    let width = |text: &str, size: u32| text_width(text, size) as i32 * scale;
    let left = 70 * scale;
    let title_style = ("sans-serif", TITLE * SCALE).into_font().color(&INK);
    root.draw(&Text::new(title.to_owned(), (left, 8 * scale), title_style))?;
    let text = ("sans-serif", TEXT * SCALE).into_font().color(&INK);
    let gap = 42 * scale;
    let whole = (figure_width as i32 - 16) * scale;
    // The first row shares its line with the title.
    let mut room = whole - left - width(title, TITLE);
    let mut rows: Vec<Vec<&Series>> = vec![Vec::new()];
    for entry in series.iter().filter(|s| !s.label.is_empty()) {
        let needed = width(&entry.label, TEXT) + gap;
        if needed > room {
            rows.push(Vec::new());
            room = whole - left;
        }
        room -= needed;
        if let Some(row) = rows.last_mut() {
            row.push(entry);
        }
    }
    let mut baseline = 8 * scale;
    let height = (TEXT as i32 + 7) * scale;
    for row in &rows {
        let mut right = whole;
        for series in row.iter().rev() {
            right -= width(&series.label, TEXT);
            root.draw(&Text::new(series.label.clone(), (right, baseline), text.clone()))?;
            let middle = baseline + (TEXT as i32 * scale) / 2;
            let line = [(right - 28 * scale, middle), (right - 6 * scale, middle)];
            let style = series.role.colour().stroke_width(2 * SCALE);
            match series.stroke.pattern() {
                None => root.draw(&PathElement::new(line, style))?,
                Some((dash, gap)) => root.draw(&DashedPathElement::new(line, dash, gap, style))?,
            }
            right -= gap;
        }
        baseline += height;
    }
    let extra = (rows.len() as u32 - 1) * height.unsigned_abs();
    Ok((TITLE + 14) * SCALE + extra)
}
