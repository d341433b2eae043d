//! Errors over the pressure and mass planes.

use crate::figure::{ColourMap, MapPoint, ValuePlane};
use crate::page::figure;
use maud::{Markup, html};
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use pam_train::RecordingEvaluation;

/// R² and RMSE of the displacement over both planes; recordings for which `trained_on` holds are ringed.
pub(super) fn maps(
    recordings: &[RecordingEvaluation],
    trained_on: impl Fn(&RecordingEvaluation) -> bool + Copy,
) -> Markup {
    let pressures: Value<'_, [f64; 2]> = &|r| match r.recording.command_psi {
        Some([f, e]) => [f, e].map(|p| p * KPA_PER_PSI + ATMOSPHERE_KPA),
        None => {
            let rest = r.recording.reading_at_rest();
            [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa]
        }
    };
    let masses: Value<'_, [f64; 2]> = &|r| [r.masses.flexor_g, r.masses.extensor_g];
    let worst = recordings
        .iter()
        .map(|r| r.scores.r2.x)
        .filter(|v| v.is_finite())
        .fold(1.0, f64::min)
        .clamp(-1.0, 0.9);
    let largest =
        recordings.iter().map(|r| r.scores.rmse.x).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let planes = [
        Plane {
            labels: ["flexor pressure (kPa abs)", "extensor pressure (kPa abs)"],
            place: pressures,
        },
        Plane { labels: ["flexor air (g)", "extensor air (g)"], place: masses },
    ];
    let quantities = [
        Quantity { label: "R² of displacement", limits: (worst, 1.0), value: &|r| r.scores.r2.x },
        Quantity {
            label: "RMSE of displacement (mm)",
            limits: (0.0, largest.max(1e-6)),
            value: &|r| r.scores.rmse.x,
        },
    ];
    html! {
        div.grid {
            @for quantity in &quantities {
                @for plane in &planes {
                    (map(recordings, trained_on, plane, quantity))
                }
            }
        }
        @let ringed = recordings.iter().filter(|r| trained_on(r)).count();
        @if ringed > 0 {
            p.sub { "Circles: the " (ringed) " of " (recordings.len()) " conditions that the model was "
                "trained on." }
        }
    }
}

type Value<'a, T> = &'a dyn Fn(&RecordingEvaluation) -> T;

/// Axes of a map, and the place of a recording in it.
struct Plane<'a> {
    labels: [&'static str; 2],
    place: Value<'a, [f64; 2]>,
}

/// Quantity that a map shows as colour.
struct Quantity<'a> {
    label: &'static str,
    limits: (f64, f64),
    value: Value<'a, f64>,
}

fn map(
    recordings: &[RecordingEvaluation],
    trained_on: impl Fn(&RecordingEvaluation) -> bool,
    plane: &Plane<'_>,
    quantity: &Quantity<'_>,
) -> Markup {
    let points = recordings
        .iter()
        .map(|r| {
            let [x, y] = (plane.place)(r);
            MapPoint { x, y, value: (quantity.value)(r), ringed: trained_on(r) }
        })
        .collect();
    let map = ColourMap {
        plane: ValuePlane {
            title: quantity.label.into(),
            x_label: plane.labels[0].into(),
            y_label: plane.labels[1].into(),
            value_label: quantity.label.into(),
            limits: quantity.limits,
            size: (520, 400),
        },
        points,
        ring_label: "trained on".into(),
    };
    figure(map.to_svg(), "")
}
