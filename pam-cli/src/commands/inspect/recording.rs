//! Summary of a recording.

use super::ranges::{range_json, range_row, range_titles};
use crate::console::table;
use crate::error::CliError;
use pam_core::units::{ATMOSPHERE_KPA, MN_PER_N, significant};
use pam_data::plausibility::Severity;
use pam_data::quality::{Quality, QualitySettings};
use pam_data::recording::median_step_s;
use pam_data::{Channel, MassOptions, MassOrigin, Recording, SavedModel, resolve_masses};
use serde_json::{Value, json};

/// Ranges, reading at rest and masses of a recording, as text and as JSON.
pub(super) fn recording(
    r: &Recording,
    saved: &SavedModel,
    masses: &MassOptions,
) -> Result<(String, Value), CliError> {
    let (masses, origin) = resolve_masses(
        r,
        &saved.model,
        saved.info.trained,
        masses.choice,
        masses.surfaces.as_ref(),
    )?;
    let (t0, t1) = r.span_s();
    let rate = 1.0 / median_step_s(&r.time_s);
    let force_n: Vec<f64> = r.force_mn.iter().map(|f| f / MN_PER_N).collect();
    let mut rows = vec![range_titles("channel")];
    let mut ranges = serde_json::Map::new();
    for c in Channel::ALL {
        rows.push(range_row(c.label(), r.channel(c)));
        ranges.insert(c.key().to_owned(), range_json(r.channel(c)));
    }
    rows.push(range_row("external force (N)", &force_n));
    ranges.insert("force_n".to_owned(), range_json(&force_n));
    let rest = r.reading_at_rest();
    let atmosphere = r.rig.as_ref().map_or(ATMOSPHERE_KPA, |rig| rig.air.atmosphere_kpa);
    let at_rest = if r.sealed.is_some() { "sealed" } else { "first sample" };
    let mut text = format!(
        "  recording {}: {} samples, {t0:.3} to {t1:.3} s at {rate:.1} Hz; {}\n{}\n",
        r.name,
        r.len(),
        r.preprocessing,
        table(&rows)
    );
    text += &format!(
        "  {at_rest}: {:.2} and {:.2} kPa abs ({:.2} and {:.2} gauge) at x = {:.4} mm\n",
        rest.pressure_flexor_kpa,
        rest.pressure_extensor_kpa,
        rest.pressure_flexor_kpa - atmosphere,
        rest.pressure_extensor_kpa - atmosphere,
        rest.displacement_mm
    );
    text += &format!(
        "  masses: {:.6} g flexor, {:.6} g extensor ({}{})",
        masses.flexor_g,
        masses.extensor_g,
        origin.label(),
        if origin == MassOrigin::GasLaw {
            format!(" with ν = {:.3}", saved.model.physical().deformation)
        } else {
            String::new()
        }
    );
    for note in &r.notes {
        text += &format!("\n  note: {note}");
    }
    let value = json!({
        "name": r.name,
        "samples": r.len(),
        "from_s": t0,
        "to_s": t1,
        "rate_hz": rate,
        "ranges": ranges,
        "at_rest": {
            "source": at_rest,
            "displacement_mm": rest.displacement_mm,
            "pressure_flexor_kpa": rest.pressure_flexor_kpa,
            "pressure_extensor_kpa": rest.pressure_extensor_kpa,
        },
        "mass_flexor_g": masses.flexor_g,
        "mass_extensor_g": masses.extensor_g,
        "mass_origin": origin,
        "commanded_psi": r.command_psi,
        "preprocessing": r.preprocessing,
        "notes": r.notes,
    });
    Ok((text, value))
}

/// The quality of a recording in sentences.
pub(super) fn quality_text(quality: &Quality) -> String {
    let mut rows = vec![["channel", "noise", "resolution", "drift"].map(str::to_owned).to_vec()];
    for c in &quality.channels {
        let resolution = c.resolution.map_or("-".into(), |r| significant(r, 3));
        rows.push(vec![
            format!("{} ({})", c.column, c.unit),
            significant(c.noise, 3),
            resolution,
            format!("{:.4}", c.drift),
        ]);
    }
    let mut text = format!("\n{}", table(&rows));
    for f in &quality.findings {
        let word = if f.severity == Severity::Error { "error" } else { "warning" };
        text += &format!("\n  {word}: {}", f.message);
    }
    for sentence in quality.excitation.sentences(&QualitySettings::default()) {
        text += &format!("\n  {sentence}");
    }
    text
}

/// One line on all recordings together, if there are several.
pub(super) fn data_set_line(files: &[Value]) -> Option<String> {
    let recordings: Vec<&Value> =
        files.iter().filter_map(|f| f["recordings"].as_array()).flatten().collect();
    if recordings.len() < 2 {
        return None;
    }
    let number = |r: &Value, key: &str| r[key].as_f64().unwrap_or(0.0);
    let duration: f64 = recordings.iter().map(|r| number(r, "to_s") - number(r, "from_s")).sum();
    let range = |key: &str| {
        let values = recordings.iter().map(|r| number(r, key));
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        format!("{low:.4} to {high:.4} g")
    };
    Some(format!(
        "{} recordings, {duration:.1} s; air in the flexor {}, in the extensor {}",
        recordings.len(),
        range("mass_flexor_g"),
        range("mass_extensor_g")
    ))
}
