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
    let pressures = |r: &RecordingEvaluation| match r.recording.command_psi {
        Some([f, e]) => [f, e].map(|p| p * KPA_PER_PSI + ATMOSPHERE_KPA),
        None => {
            let rest = r.recording.reading_at_rest();
            [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa]
        }
    };
    let masses = |r: &RecordingEvaluation| [r.masses.flexor_g, r.masses.extensor_g];
    let worst = recordings
        .iter()
        .map(|r| r.scores.r2.x)
        .filter(|v| v.is_finite())
        .fold(1.0, f64::min)
        .clamp(-1.0, 0.9);
    let largest =
        recordings.iter().map(|r| r.scores.rmse.x).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let r2 = |r: &RecordingEvaluation| r.scores.r2.x;
    let rmse = |r: &RecordingEvaluation| r.scores.rmse.x;
    let pressure_axes = ("flexor pressure (kPa abs)", "extensor pressure (kPa abs)");
    let mass_axes = ("flexor air (g)", "extensor air (g)");
    let r2_scale = ("R² of displacement", (worst, 1.0));
    let rmse_scale = ("RMSE of displacement (mm)", (0.0, largest.max(1e-6)));
    html! {
        div.grid {
            (map(recordings, trained_on, pressures, r2, pressure_axes, r2_scale))
            (map(recordings, trained_on, masses, r2, mass_axes, r2_scale))
            (map(recordings, trained_on, pressures, rmse, pressure_axes, rmse_scale))
            (map(recordings, trained_on, masses, rmse, mass_axes, rmse_scale))
        }
        @let ringed = recordings.iter().filter(|r| trained_on(r)).count();
        @if ringed > 0 {
            p.sub { "Circles: the " (ringed) " of " (recordings.len()) " conditions that the model was "
                "trained on." }
        }
    }
}

fn map(
    recordings: &[RecordingEvaluation],
    trained_on: impl Fn(&RecordingEvaluation) -> bool,
    place: impl Fn(&RecordingEvaluation) -> [f64; 2],
    value: impl Fn(&RecordingEvaluation) -> f64,
    (x_label, y_label): (&str, &str),
    (value_label, limits): (&str, (f64, f64)),
) -> Markup {
    let points = recordings
        .iter()
        .map(|r| {
            let [x, y] = place(r);
            MapPoint { x, y, value: value(r), ringed: trained_on(r) }
        })
        .collect();
    let map = ColourMap {
        plane: ValuePlane {
            title: value_label.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            value_label: value_label.into(),
            limits,
            size: (520, 400),
        },
        points,
        ring_label: "trained on".into(),
    };
    figure(map.to_svg(), "")
}
