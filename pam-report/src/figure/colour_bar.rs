//! Values as colours, and the bar that explains them.

use super::style::{INK, SCALE, TEXT, tick_label};
use plotters::coord::Shift;
use plotters::prelude::*;

/// The colour of a value between the ends of a scale; values outside take the end's colour.
pub(super) fn colour(value: f64, (low, high): (f64, f64)) -> RGBColor {
    ViridisRGB::get_color_normalized(value.clamp(low, high), low, high)
}

/// Draws the scale with its label.
pub(super) fn draw_bar(
    bar: &DrawingArea<SVGBackend<'_>, Shift>,
    label: &str,
    (low, high): (f64, f64),
) -> Result<(), Box<dyn std::error::Error>> {
    let text = ("sans-serif", TEXT * SCALE).into_font().color(&INK);
    let mut chart = ChartBuilder::on(bar)
        .margin(8 * SCALE)
        .margin_top(36 * SCALE)
        .margin_bottom(46 * SCALE)
        .margin_right(14 * SCALE)
        .y_label_area_size(58 * SCALE)
        .build_cartesian_2d(0.0..1.0, low..high)?;
    let steps = 64;
    let edge = |k: i32| low + (high - low) * f64::from(k) / f64::from(steps);
    chart.draw_series((0..steps).map(|k| {
        let colour = colour(0.5 * (edge(k) + edge(k + 1)), (low, high));
        Rectangle::new([(0.0, edge(k)), (1.0, edge(k + 1))], colour.filled())
    }))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .y_desc(label)
        .y_labels(6)
        .label_style(text.clone())
        .axis_desc_style(text)
        .y_label_formatter(&|v| tick_label(*v, high - low))
        .draw()?;
    Ok(())
}
