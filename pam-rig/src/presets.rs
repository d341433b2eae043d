//! Parameter sets that come with the rig.

use crate::error::RigError;
use crate::plant::{DryFriction, PlantParameters};
use crate::rig::RigParameters;
use std::path::Path;

/// Name and parameters of a set that comes with the rig.
type Preset = (&'static str, fn() -> RigParameters);

const PRESETS: [Preset; 2] =
    [("default", RigParameters::default), ("measured", RigParameters::measured)];

impl RigParameters {
    /// Names of the parameter sets that come with the rig.
    pub const BUILT_IN: [&'static str; 2] = [PRESETS[0].0, PRESETS[1].0];

    /// A joint as rough as the published measured run (`data.mat`: 28 s at 366 kPa in both muscles, ±145 N at 0.1 Hz).
    ///
    /// The default joint is calibrated to the published *model*, which is smooth; the measured one sticks and slips. Five
    /// numbers differ, calibrated to the run's loop of force over displacement, its amplitude, its rest positions and the
    /// share of it that the published weights predict (the table of `docs/rig.md`):
    ///
    /// | parameter | default | measured | calibrated to |
    /// |---|---|---|---|
    /// | gearbox friction, sliding | 18 N | 33 N | area of the loop |
    /// | at rest | 21 N | 48 N | lengths of the steps |
    /// | Stribeck's velocity | 1 mm/s | 0.15 mm/s | steps against creep between them |
    /// | dry friction of a muscle without pressure | 2 N | 4 N | width of the loop at F = 0 |
    /// | stiffness of the wall | 30 N/mm | 43 N/mm | slope of the loop's branches |
    /// | preload of the extensor's strands | 0.85 mm | 0.30 mm | middle of the loop at F = 0 |
    ///
    /// The friction is that of the rig's parts; a model that misses friction altogether finds 29 N sliding and 51 N at rest
    /// on the measured run, since its own damping stands for some of it.
    #[must_use]
    pub fn measured() -> Self {
        let mut plant = PlantParameters {
            friction: DryFriction { coulomb_n: 33.0, static_n: 48.0, velocity_mm_s: 0.15 },
            ..PlantParameters::default()
        };
        for muscle in [&mut plant.flexor, &mut plant.extensor] {
            muscle.losses.dry_n = 4.0;
            muscle.wall.stiffness_n_mm = 43.0;
        }
        plant.extensor.wall.preload_mm = 0.30;
        Self { plant, ..Self::default() }
    }

    /// Parameters by the name of a built-in set or the path of a TOML file.
    ///
    /// # Errors
    /// [`RigError`] naming file and line, or the sets that there are.
    pub fn open(name: &str) -> Result<Self, RigError> {
        if let Some((_, make)) = PRESETS.iter().find(|(n, _)| *n == name) {
            return Ok(make());
        }
        let path = Path::new(name);
        if !path.exists() && !name.ends_with(".toml") {
            return Err(RigError::Preset {
                name: name.to_owned(),
                known: Self::BUILT_IN.join(", "),
            });
        }
        Self::read(path)
    }
}
