//! Commands that plan, carry out and identify.

pub mod identify;
pub mod plan;
pub mod replan;
pub mod stiffness;
pub mod track;

use crate::arguments::GlobalOptions;
use crate::error::{CliError, usage};
use crate::rig_joint::RigJoint;
use clap::Args;
use pam_control::execution::Joint;
use pam_control::synthesis::{MassBounds, SynthesisSettings};
use pam_data::SavedModel;
use pam_rig::RigParameters;

/// Within which masses a plan stays.
#[derive(Debug, Clone, Args)]
pub struct BoundsOptions {
    /// Least and most air in a muscle, g [default: what limits.pressure_kpa of the rig file, else 10 and 80 psi gauge,
    /// hold at x = 0]. What lies outside 10 and 80 psi gauge is flagged as extrapolation
    #[arg(
        long,
        value_name = "LEAST,MOST",
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true
    )]
    pub mass_bounds: Option<Vec<f64>>,
    /// Step h of the stiffness estimate, mm
    #[arg(long, value_name = "MM", default_value_t = 1.0, allow_negative_numbers = true)]
    pub stiffness_step: f64,
}

impl BoundsOptions {
    /// The settings of the synthesis.
    ///
    /// # Errors
    /// [`CliError`] naming the option.
    pub fn settings(
        &self,
        saved: &SavedModel,
        global: &GlobalOptions,
    ) -> Result<SynthesisSettings, CliError> {
        let model = &saved.model;
        let rig = global.rig()?.or_else(|| saved.info.rig.clone());
        let limits = rig.and_then(|rig| rig.limits.pressure_kpa);
        let bounds = match self.mass_bounds.as_deref() {
            None => match limits {
                Some(limits) => {
                    let of = |kpa: f64| model.gas_law_masses(0.0, [kpa, kpa]).flexor_g;
                    MassBounds::new(of(limits[0]), of(limits[1])).map_err(usage)?
                }
                None => MassBounds::trained(model),
            },
            Some([least, most]) => MassBounds::new(*least, *most).map_err(usage)?,
            Some(_) => {
                return Err(CliError::Usage("--mass-bounds takes two numbers, LEAST,MOST".into()));
            }
        };
        let settings = SynthesisSettings {
            stiffness_step_mm: self.stiffness_step,
            ..SynthesisSettings::published(bounds)
        };
        settings.validate().map_err(usage)?;
        Ok(settings)
    }
}

/// The rig of a preset or a file, checked.
fn rig(name: &str) -> Result<RigParameters, CliError> {
    let rig = RigParameters::open(name)?;
    RigJoint::new(&rig, 1, [400.0; 2])?;
    Ok(rig)
}

/// Makes joints of rigs whose parameters were checked.
fn maker(rig: &RigParameters) -> impl Fn(u64, [f64; 2]) -> Box<dyn Joint> + Sync + '_ {
    |seed, pressures| {
        Box::new(RigJoint::new(rig, seed, pressures).expect("the parameters were checked"))
    }
}
