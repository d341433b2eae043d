use super::colour_bar::{BAR_WIDTH, bar};
use super::frame::{Entry, Frame, FrameAxis, Plot};
use super::scale::{Axis, Scale};
use maud::Markup;

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

/// Where places of a plane lie in a drawing.
pub(super) struct PlaneGeometry<'a> {
    pub(super) plot: Plot,
    pub(super) x: &'a Axis,
    pub(super) y: &'a Axis,
}

impl PlaneGeometry<'_> {
    /// A place in units of the content.
    pub(super) fn unit(&self, x: f64, y: f64) -> (i64, i64) {
        (self.x.unit(x), self.y.unit_down(y))
    }
}

impl ValuePlane {
    /// The frame with its content as SVG text; `window` is the least and largest value shown of each axis. Content outside is
    /// cut off.
    pub(super) fn to_svg(
        &self,
        window: [[f64; 2]; 2],
        entries: Vec<Entry<'_>>,
        content: impl FnOnce(&PlaneGeometry<'_>) -> Markup,
    ) -> String {
        let axis = |[low, high]: [f64; 2]| Scale::Linear.between(low, high, 8);
        let [x, y] = window.map(axis);
        let frame = Frame {
            title: &self.title,
            size: self.size,
            x: FrameAxis { label: &self.x_label, axis: &x, scale: Scale::Linear },
            y: FrameAxis { label: &self.y_label, axis: &y, scale: Scale::Linear },
            entries,
            bands: Vec::new(),
            right: BAR_WIDTH,
            cut: true,
        };
        let plot = frame.plot();
        let content = content(&PlaneGeometry { plot, x: &x, y: &y });
        frame.to_svg(&content, &bar(plot, &self.value_label, self.scale()))
    }

    /// The ends of the colour scale, apart also where all values are the same.
    pub(super) fn scale(&self) -> (f64, f64) {
        wide(self.limits)
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
