//! The virtual rig.

use crate::arrays::rows;
use crate::errors::{raised, settings};
use crate::watch::{brief, watched};
use numpy::{PyArray2, PyReadonlyArray2};
use pam_core::NamedChoice;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use pam_rig::pneumatics::Opening;
use pam_rig::sensors::Part;
use pam_rig::{Command, Conditions, Frame, PressureCommand, Protocol, RigParameters, Session};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Parameters by a name, a path or TOML text, with hidden effects and ideal parts.
fn parameters(rig: &str, effects: &[String], ideal: &[String]) -> PyResult<RigParameters> {
    let mut found = if rig.contains('\n') {
        let parsed = pam_data::toml_file::parse(rig, Path::new("rig"));
        parsed.map_err(raised)?
    } else {
        RigParameters::open(rig).map_err(raised)?
    };
    for text in effects {
        let effect = text.parse().map_err(|e| raised(pam_rig::RigError::Effect(e)))?;
        found.effects.push(effect);
    }
    for name in ideal {
        found.sensors = match name.as_str() {
            "all" => found.sensors.all_ideal(),
            part => found.sensors.with_ideal(Part::from_name(part).map_err(raised)?),
        };
    }
    Ok(found)
}

/// A rig in operation, one sample at a time.
#[pyclass(frozen, module = "pam_ode._pam")]
pub(crate) struct Rig {
    rig: Mutex<pam_rig::Rig>,
}

/// Row and truth of a sample as `run` returns them: the columns are named in `python/pam_ode/rig.py`.
fn numbers(frame: &Frame, time_s: f64) -> [f64; 19] {
    let (r, t) = (&frame.row, &frame.truth);
    [
        time_s,
        r.angle_deg,
        r.current_a,
        r.reservoir_psi,
        r.measured_psi[0],
        r.measured_psi[1],
        f64::from(r.valves[0]),
        f64::from(r.valves[1]),
        t.displacement_mm,
        t.velocity_mm_s,
        t.pressures_kpa[0],
        t.pressures_kpa[1],
        t.masses_g[0],
        t.masses_g[1],
        t.temperatures_k[0],
        t.temperatures_k[1],
        t.force_n,
        t.friction_n,
        r.command,
    ]
}

fn opening(code: f64) -> PyResult<Opening> {
    match code {
        -1.0 => Ok(Opening::Exhaust),
        0.0 => Ok(Opening::Shut),
        1.0 => Ok(Opening::Inflate),
        _ => Err(settings(format!("a valve is -1 (exhaust), 0 (shut) or 1 (inflate), not {code}"))),
    }
}

#[pymethods]
impl Rig {
    #[new]
    #[pyo3(signature = (rig, effects, ideal, seed, start_s, pressures_kpa))]
    fn new(
        rig: &str,
        effects: Vec<String>,
        ideal: Vec<String>,
        seed: u64,
        start_s: f64,
        pressures_kpa: Option<[f64; 2]>,
    ) -> PyResult<Self> {
        let parameters = parameters(rig, &effects, &ideal)?;
        let mut rig = pam_rig::Rig::new(&parameters, seed, start_s).map_err(raised)?;
        if let Some(pressures) = pressures_kpa {
            if pressures.iter().any(|p| !(p.is_finite() && *p > 0.0)) {
                return Err(settings("`pressures_kpa` must be absolute and positive"));
            }
            rig.fill(pressures);
        }
        Ok(Self { rig: Mutex::new(rig) })
    }

    /// Time of the next sample, s.
    #[getter]
    fn time_s(&self) -> f64 {
        self.rig.lock().unwrap_or_else(std::sync::PoisonError::into_inner).time_s()
    }

    /// Carries out commands `[samples, 3]`, current (A) and two numbers for the air, whose meaning `air` says: `sealed`,
    /// `servo` (kPa absolute) or `valves` (-1, 0, 1). Returns one row for each.
    fn run<'py>(
        &self,
        py: Python<'py>,
        commands: PyReadonlyArray2<'py, f64>,
        air: &str,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let mut all = Vec::new();
        for [current_a, flexor, extensor] in crate::arrays::to_rows::<3>("commands", &commands)? {
            if ![current_a, flexor, extensor].iter().all(|v| v.is_finite()) {
                return Err(settings("commands must be finite"));
            }
            let psi = |kpa: f64| (kpa - ATMOSPHERE_KPA) / KPA_PER_PSI;
            let pressure = match air {
                "sealed" => PressureCommand::Sealed,
                "servo" => PressureCommand::Servo([psi(flexor), psi(extensor)]),
                "valves" => PressureCommand::Valves([opening(flexor)?, opening(extensor)?]),
                _ => return Err(settings(format!("air `{air}`: sealed, servo or valves"))),
            };
            all.push(Command { current_a, pressure });
        }
        let frames = brief(py, |_| {
            let mut rig = self.rig.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let tick = |command: &Command| {
                let time_s = rig.time_s();
                numbers(&rig.tick(command), time_s)
            };
            all.iter().map(tick).collect::<Vec<_>>()
        })?;
        Ok(rows(py, &frames))
    }
}

/// Records a protocol into a folder: paths of the logs.
#[pyfunction]
#[pyo3(signature = (folder, *, rig, protocol, conditions, effects, ideal, seed, truth, overwrite, progress))]
pub(crate) fn rig_record(
    py: Python<'_>,
    folder: PathBuf,
    rig: &str,
    protocol: &str,
    conditions: Option<&str>,
    effects: Vec<String>,
    ideal: Vec<String>,
    seed: u64,
    truth: bool,
    overwrite: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<PathBuf>> {
    let parameters = parameters(rig, &effects, &ideal)?;
    let mut protocol = if protocol.contains('\n') {
        Protocol::parse(protocol, Path::new("protocol")).map_err(raised)?
    } else {
        Protocol::open(protocol).map_err(raised)?
    };
    if let Some(text) = conditions {
        let parsed = Conditions::parse(text).map_err(|e| settings(format!("conditions: {e}")))?;
        if protocol.conditions.replace(parsed).is_none() {
            return Err(settings(format!(
                "conditions: the protocol `{}` drives the pressures itself",
                protocol.name
            )));
        }
    }
    let total = protocol.runs().map_err(raised)?.len() as f64;
    let note = pam_cli::run_record::rig_note(seed);
    let session = Session { rig: parameters, protocol, seed, truth, note };
    let done = AtomicUsize::new(0);
    let entries = watched(py, |stop| {
        session.record_into(&folder, overwrite, &|entry| {
            stop.check();
            let k = done.fetch_add(1, Ordering::Relaxed) + 1;
            stop.call(progress.as_ref(), ("recording", k as f64 / total, entry.name.clone()));
        })
    })?
    .map_err(raised)?;
    Ok(entries.into_iter().map(|e| e.log).collect())
}
