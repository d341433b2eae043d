//! The course of the parameters of effects over the epochs.

use crate::figure::{LineFigure, Role};
use crate::page::figure;
use maud::{Markup, html};

/// One figure a parameter: its name with its unit, and `(epoch, value)`.
#[must_use]
pub fn effect_curves(courses: &[(String, Vec<(f64, f64)>)]) -> Markup {
    let drawn = |name: &str, course: &[(f64, f64)]| {
        let (epochs, values): (Vec<f64>, Vec<f64>) = course.iter().copied().unzip();
        let points = crate::figure::envelope(&epochs, &values, 700);
        LineFigure::new(name, "epoch", name, 1040, 230).with("", Role::Category(0), points).to_svg()
    };
    html! {
        @for (name, course) in courses {
            (figure(drawn(name, course), ""))
        }
    }
}
