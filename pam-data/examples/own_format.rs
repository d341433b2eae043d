//! A data format of another rig: lines of `key;value;…` in SI units, without a header of standard columns.
//!
//! To read such files everywhere, put the part before `main` into `pam-data/src/formats/si_log.rs` and add two
//! lines: `pub mod si_log;` in `mod.rs` and `super::si_log::SiLog,` in the list of `list.rs`.

use pam_data::formats::format::{FileFormat, Head};
use pam_data::{DataError, LoadOptions, Recording};
use std::path::Path;

/// Text files that begin with `#SI` and hold rows `t (s);x (m);v (m/s);P_f (Pa);P_e (Pa);F (N)`.
#[derive(Debug)]
pub struct SiLog;

impl FileFormat for SiLog {
    fn id(&self) -> &'static str {
        "si_log"
    }
    fn name(&self) -> &'static str {
        "a log in SI units"
    }
    fn recognises(&self, head: &Head<'_>) -> bool {
        head.bytes.starts_with(b"#SI\n")
    }
    fn read_recordings(
        &self,
        path: &Path,
        _options: &LoadOptions,
    ) -> Result<Vec<Recording>, DataError> {
        let text = std::fs::read_to_string(path).map_err(|e| DataError::io(path, e))?;
        let mut recording = Recording::empty(path);
        for (index, line) in text.lines().enumerate().skip(1) {
            let at = |why: String| DataError::line(path, index as u64 + 1, why);
            let cells: Result<Vec<f64>, _> = line.split(';').map(|c| c.trim().parse()).collect();
            let cells = cells.map_err(|e| at(format!("not a number: {e}")))?;
            let [t, x, v, pf, pe, f] = cells[..] else {
                return Err(at(format!("6 numbers are needed, here are {}", cells.len())));
            };
            recording.time_s.push(t);
            recording.displacement_mm.push(1e3 * x);
            recording.velocity_mm_s.push(1e3 * v);
            recording.pressure_flexor_kpa.push(1e-3 * pf);
            recording.pressure_extensor_kpa.push(1e-3 * pe);
            recording.force_mn.push(1e3 * f);
        }
        recording.validate()?;
        Ok(vec![recording])
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("run.log");
    std::fs::write(&path, "#SI\n0.0;0.001;0;412000;412000;5\n0.01;0.002;0.1;411000;413000;6\n")?;
    let read = SiLog.read_recordings(&path, &LoadOptions::default())?;
    assert_eq!(read[0].displacement_mm, [1.0, 2.0]);
    assert_eq!(read[0].pressure_flexor_kpa, [412.0, 411.0]);
    assert_eq!(read[0].force_mn, [5e3, 6e3]);

    std::fs::write(&path, "#SI\n0.0;0.001;0;412000;412000\n")?;
    let error = SiLog.read_recordings(&path, &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("run.log") && error.contains('2'), "{error}");
    Ok(())
}
