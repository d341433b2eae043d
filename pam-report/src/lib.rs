//! Figures and self-contained HTML reports.
//!
//! [`figure`] and [`page`] are always there; all else is behind the feature `joint`, which is on by default.
//!
//! - [`figure`]: line figures and coloured maps as SVG text, in one style: units on the axes,
//!   colours that colour-blind readers can distinguish (Okabe and Ito 2008; viridis);
//! - [`page`]: the frame of a report, one HTML file that needs nothing else;
//! - [`evaluation`]: the report of an evaluation;
//! - [`mod@force_curves`]: the restoring force over the displacement; [`parameters`]: the joint's own
//!   parameters and their known values;
//! - [`training`]: the report of a training run;
//! - [`gradient`]: the report of a loss and its gradient;
//! - [`inspection`]: the report of recordings that are checked before a fit;
//! - [`recordings`]: the report of recordings before any model;
//! - [`simulation`]: the report of a simulated trajectory.

#[cfg(feature = "joint")]
pub mod evaluation;
pub mod figure;
#[cfg(feature = "joint")]
pub mod force_curves;
#[cfg(feature = "joint")]
pub mod gradient;
#[cfg(feature = "joint")]
pub mod inspection;
pub mod page;
#[cfg(feature = "joint")]
pub mod parameters;
#[cfg(feature = "joint")]
pub mod recordings;
#[cfg(feature = "joint")]
pub mod simulation;
#[cfg(feature = "joint")]
pub mod training;

#[cfg(feature = "joint")]
pub use evaluation::{EvaluationContext, evaluation_report};
pub use figure::{Band, ColourMap, LineFigure, Role, Scale, Series, Stroke, ValuePlane};
#[cfg(feature = "joint")]
pub use force_curves::force_curves;
#[cfg(feature = "joint")]
pub use gradient::{GradientBlock, GradientReport, gradient_report};
#[cfg(feature = "joint")]
pub use inspection::{InspectedRun, inspection_report};
#[cfg(feature = "joint")]
pub use parameters::parameter_table;
#[cfg(feature = "joint")]
pub use recordings::{RecordedRun, recordings_report};
#[cfg(feature = "joint")]
pub use simulation::simulation_report;
#[cfg(feature = "joint")]
pub use training::{
    EpochRow, ParameterRow, StageRow, TrainingReport, effect_curves, training_report,
};
