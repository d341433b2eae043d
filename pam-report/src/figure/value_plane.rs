use super::colour_bar::draw_bar;
use super::style::{AxisLabels, INK, SCALE, TITLE, at_nominal_size, draw_axes, tick_label};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// The whole drawing.
pub(super) type Root<'s> = DrawingArea<SVGBackend<'s>, Shift>;
/// The plane between the axes.
pub(super) type Plane<'p, 's> =
    ChartContext<'p, SVGBackend<'s>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
/// Why something could not be drawn.
pub(super) type DrawError = Box<dyn std::error::Error>;

/// Title, axes and colour bar of a plane whose colours are values.
#[derive(Debug, Clone, PartialEq)]
pub struct ValuePlane {
    /// Title above the axes.
    pub title: String,
    /// Label and unit of the horizontal axis.
    pub x_label: String,
    /// Label and unit of the vertical axis.
    pub y_label: String,
    /// Name and unit of the value.
    pub value_label: String,
    /// Values at the ends of the colour scale; values outside take the end's colour.
    pub limits: (f64, f64),
    /// Width and height, px.
    pub size: (u32, u32),
}

impl ValuePlane {
    /// The frame with its content as SVG text; `window` is the least and largest value shown of each axis.
    pub(super) fn to_svg(
        &self,
        window: [[f64; 2]; 2],
        content: impl FnOnce(&Root<'_>, &mut Plane<'_, '_>) -> Result<(), DrawError>,
    ) -> String {
        let mut svg = String::new();
        self.draw(&mut svg, window, content).expect("drawing into memory cannot fail");
        at_nominal_size(&svg, self.size.0, self.size.1)
    }

    /// The ends of the colour scale, apart also where all values are the same.
    pub(super) fn scale(&self) -> (f64, f64) {
        wide(self.limits)
    }

    fn draw(
        &self,
        svg: &mut String,
        [[x0, x1], [y0, y1]]: [[f64; 2]; 2],
        content: impl FnOnce(&Root<'_>, &mut Plane<'_, '_>) -> Result<(), DrawError>,
    ) -> Result<(), DrawError> {
        let (width, height) = (self.size.0 * SCALE, self.size.1 * SCALE);
        let root = SVGBackend::with_string(svg, (width, height)).into_drawing_area();
        root.fill(&WHITE)?;
        let (plane, bar) = root.split_horizontally(width - 104 * SCALE);
        let title = ("sans-serif", TITLE * SCALE).into_font().color(&INK);
        let mut chart = ChartBuilder::on(&plane)
            .margin(8 * SCALE)
            .caption(&self.title, title)
            .x_label_area_size(40 * SCALE)
            .y_label_area_size(62 * SCALE)
            .build_cartesian_2d(x0..x1, y0..y1)?;
        draw_axes(
            &mut chart,
            AxisLabels { label: &self.x_label, ticks: 8, format: &|v| tick_label(v, x1 - x0) },
            AxisLabels { label: &self.y_label, ticks: 8, format: &|v| tick_label(v, y1 - y0) },
        )?;
        content(&root, &mut chart)?;
        draw_bar(&bar, &self.value_label, self.scale())?;
        root.present()?;
        Ok(())
    }
}

/// A range that is not empty: some values of a plane are all the same, or so large that no two doubles lie between them.
fn wide((low, high): (f64, f64)) -> (f64, f64) {
    let largest = 0.1 * f64::MAX;
    let (low, high) = if low.is_finite() && high.is_finite() { (low, high) } else { (0.0, 1.0) };
    let (low, high) = (low.clamp(-largest, largest), high.clamp(-largest, largest));
    let least = 1e-9 * low.abs().max(high.abs());
    if high - low > least {
        return (low, high);
    }
    let half = if least > 0.0 { 1e3 * least } else { 0.5 };
    (low - half, high + half)
}
