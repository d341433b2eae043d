//! Values as colours, and the bar that explains them.

use super::frame::Plot;
use super::scale::Scale;
use super::style::{INK, coloured, px, tick_label};
use maud::{Markup, html};

/// Room that a bar takes right of a plane, px.
pub(super) const BAR_WIDTH: f64 = 104.0;
/// Left and right edge of the coloured bar in its room, px.
const BAR: (f64, f64) = (66.0, 90.0);
/// Steps of the bar.
const STEPS: u32 = 64;

/// The colour of a value between the ends of a scale, as `#rrggbb`; values outside take the end's colour.
pub(super) fn colour(value: f64, (low, high): (f64, f64)) -> String {
    let share = (value.clamp(low, high) - low) / (high - low);
    let c = colorous::VIRIDIS.eval_continuous(share.clamp(0.0, 1.0));
    format!("#{c:x}")
}

/// The scale with its label, beside a plane.
pub(super) fn bar(plot: Plot, label: &str, (low, high): (f64, f64)) -> Markup {
    let axis = Scale::Linear.between(low, high, 6);
    let height = |share: f64| plot.y + plot.height * (1.0 - share);
    let step = plot.height / f64::from(STEPS);
    html! {
        @for k in 0..STEPS {
            @let share = (f64::from(k) + 0.5) / f64::from(STEPS);
            // Steps overlap, so that no seam shows between them.
            rect x=(px(BAR.0)) y=(px(height(share) - 0.5 * step - 0.3)) width=(px(BAR.1 - BAR.0)) height=(px(step + 0.6))
                fill=(colour(low + share * (high - low), (low, high))) {}
        }
        (coloured(INK, &html! {
            @for &mark in axis.marks() {
                @let at = height((mark - low) / (high - low));
                path d=(format!("M{} {}h-4", px(BAR.0), px(at))) fill="none" stroke="currentColor" {}
                text x=(px(BAR.0 - 7.0)) y=(px(at + 4.5)) text-anchor="end" fill="currentColor" { (tick_label(mark, high - low)) }
            }
            text transform=(format!("translate(16 {}) rotate(-90)", px(plot.y + 0.5 * plot.height))) text-anchor="middle"
                fill="currentColor" { (label) }
        }))
    }
}
