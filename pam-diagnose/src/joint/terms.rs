//! The joint as a system to which terms can be added.

use super::baseline::BaselineDiscrepancy;
use super::system::JointSystem;
use crate::data::OpenPart;
use crate::error::DiagnoseError;
use crate::fit::Hypothesis;
use crate::search::{Candidates, Work};
use crate::settings::DiagnosisSettings;
use crate::terms::{
    Definition, Factor, Function, Place, Term, TermSpace, Unit, Variable, VariableKind,
};
use pam_core::units::MN_PER_N;
use pam_effects::effects::{AnyEffect, DataScales};
use pam_effects::expression;
use pam_effects::model::ActiveEffect;
use pam_effects::simulation::{Base, Trial};
use std::sync::Arc;

/// Recordings of a joint, its model, candidates from a list, and whatever terms are asked for.
pub(super) struct JointTerms<'a> {
    pub(super) trials: Vec<&'a Trial>,
    pub(super) open: Vec<OpenPart>,
    pub(super) base: Base<f64>,
    /// Effects that are part of the model.
    pub(super) fixed: &'a [ActiveEffect],
    /// What baseline recordings have shown.
    pub(super) baseline: Option<BaselineDiscrepancy>,
    /// Whether the trials are pieces of longer recordings.
    in_parts: bool,
    /// Candidates from a list.
    pub(super) listed: Vec<&'static dyn AnyEffect>,
    pub(super) settings: &'a DiagnosisSettings,
    variables: Vec<Variable>,
    places: Vec<Place>,
    work: Arc<Work>,
}

/// Indices of the variables.
const X: usize = 0;
const V: usize = 1;
const FORCE: usize = 2;
const SUM: usize = 3;
const DIFFERENCE: usize = 4;
const FLEXOR: usize = 5;
const EXTENSOR: usize = 6;
const TIME: usize = 7;

/// Name of the sum of the gauge pressures.
const SUM_NAME: &str = "sum of the gauge pressures";

/// Index of the place for the level of dry friction.
const DRY: usize = 1;

/// Part of the air that a flow worth looking for moves in a second.
const FLOW_PER_S: f64 = 0.01;

impl<'a> JointTerms<'a> {
    pub(super) fn new(
        trials: Vec<&'a Trial>,
        open: Vec<OpenPart>,
        base: Base<f64>,
        fixed: &'a [ActiveEffect],
        baseline: Option<BaselineDiscrepancy>,
        listed: Vec<&'static dyn AnyEffect>,
        settings: &'a DiagnosisSettings,
    ) -> Self {
        let mut space = Self {
            trials,
            open,
            in_parts: false,
            base,
            fixed,
            baseline,
            listed,
            settings,
            variables: Vec::new(),
            places: Vec::new(),
            work: Arc::default(),
        };
        let scales = space.system().scales().clone();
        let longest_s = space.trials.iter().map(|t| t.record.duration_s()).fold(0.0, f64::max);
        let air_g =
            space.trials.iter().map(|t| t.record.masses.flexor_g + t.record.masses.extensor_g);
        let air_g = 0.5 * air_g.sum::<f64>() / space.trials.len().max(1) as f64;
        space.variables = variables(&scales, longest_s);
        space.places = places(&scales, air_g);
        space
    }

    /// The same with a count of its simulations.
    pub(super) fn counted_by(self, work: &Arc<Work>) -> Self {
        Self { work: Arc::clone(work), ..self }
    }

    /// The same for parts of the recordings, with the variables and places of the whole.
    pub(super) fn of_parts(&self, parts: Vec<&'a Trial>) -> Self {
        Self {
            open: OpenPart::whole(parts.len()),
            trials: parts,
            in_parts: true,
            base: self.base,
            fixed: self.fixed,
            baseline: self.baseline.clone(),
            listed: self.listed.clone(),
            settings: self.settings,
            variables: self.variables.clone(),
            places: self.places.clone(),
            work: Arc::clone(&self.work),
        }
    }

    /// The effects from the baseline recordings as far as the data have them.
    pub(super) fn learned_in_part(&self, h: &Hypothesis) -> Vec<ActiveEffect> {
        self.system().learned_in_part(h)
    }

    fn system(&self) -> JointSystem<'_> {
        let effects = self.listed.clone();
        let trials = self.trials.clone();
        let mut system =
            JointSystem::new(trials, &self.open, self.base, self.fixed, effects, self.settings);
        if let Some(baseline) = &self.baseline {
            system.learn(baseline);
        }
        if self.in_parts {
            system.widen_offsets(self.settings.remainder.piece_offset_kpa);
        }
        system
    }
}

impl TermSpace for JointTerms<'_> {
    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn places(&self) -> &[Place] {
        &self.places
    }

    fn work(&self) -> Arc<Work> {
        Arc::clone(&self.work)
    }

    fn call_with(
        &self,
        definitions: &[Definition],
        then: &mut dyn FnMut(&dyn Candidates) -> Result<(), DiagnoseError>,
    ) -> Result<(), DiagnoseError> {
        let mut built: Vec<Box<dyn AnyEffect>> = Vec::with_capacity(definitions.len());
        for definition in definitions {
            built.extend(expression::build(&definition.to_toml())?);
        }
        let deviations = |d: &Definition| d.parameters.iter().map(|p| p.deviation).collect();
        let mut system = self.system();
        system.terms =
            built.iter().map(AsRef::as_ref).zip(definitions.iter().map(deviations)).collect();
        then(&system)
    }

    fn series(&self, experiment: usize) -> Vec<Vec<f64>> {
        let record = &self.trials[experiment].record;
        let [x, v, flexor, extensor] = &record.measured;
        let rows = 0..record.points();
        let gauge = |p: &[f64]| -> Vec<f64> {
            p.iter().map(|p| p - pam_core::units::ATMOSPHERE_KPA).collect()
        };
        let both = |f: fn(f64, f64) -> f64| -> Vec<f64> {
            gauge(flexor).iter().zip(gauge(extensor)).map(|(a, b)| f(*a, b)).collect()
        };
        vec![
            x.clone(),
            v.clone(),
            rows.clone().map(|k| record.force_mn(k) / MN_PER_N).collect(),
            both(|a, b| a + b),
            both(|a, b| a - b),
            gauge(flexor),
            gauge(extensor),
            rows.map(|k| record.since_start_s + k as f64 * record.step_s).collect(),
        ]
    }

    fn step_s(&self, experiment: usize) -> f64 {
        self.trials[experiment].record.step_s
    }

    fn listed(&self, term: &Term) -> Option<&'static str> {
        let linear =
            |f: &Factor| (f.lag.is_none() && f.function == Function::Linear).then_some(f.variable);
        let of: Option<usize> = match term.factors.as_slice() {
            [] => None,
            [one] => Some(linear(one)?),
            _ => return None,
        };
        match (self.places[term.place].id.as_str(), of) {
            ("force", None) => Some("constant_load"),
            ("force", Some(V)) => Some("viscous_damping"),
            ("force", Some(FORCE)) => Some("force_gain"),
            ("dry_friction", None) => Some("coulomb_friction"),
            ("position_reading", None) => Some("position_offset"),
            ("position_reading", Some(X)) => Some("position_gain"),
            ("flexor_reading" | "extensor_reading", None) => Some("pressure_bias"),
            ("flexor_reading", Some(FLEXOR)) | ("extensor_reading", Some(EXTENSOR)) => {
                Some("pressure_gain")
            }
            _ => None,
        }
    }

    fn file(&self, definitions: &[Definition]) -> String {
        definitions.iter().map(Definition::to_toml).collect::<Vec<_>>().join("\n")
    }
}

fn variables(scales: &DataScales, longest_s: f64) -> Vec<Variable> {
    use VariableKind::{Combined, Moving, Slow, Turning};
    let variable = |name: &str,
                    text: &str,
                    names: &[&str],
                    unit: Unit,
                    size: f64,
                    start: Option<&str>,
                    kind: VariableKind,
                    length: f64| {
        Variable {
            name: name.to_owned(),
            text: text.to_owned(),
            group: if names.iter().any(|n| n.starts_with('p')) { "pressures" } else { name }
                .to_owned(),
            names: names.iter().map(|n| (*n).to_owned()).collect(),
            unit,
            unit_text: unit.text(),
            size: size.max(f64::MIN_POSITIVE),
            kind,
            signed: !matches!(kind, Combined) && !matches!(name, SUM_NAME | "time"),
            at_start: start.map(str::to_owned),
            change: (name == "displacement").then(|| "dx".to_owned()),
            description_length: length,
        }
    };
    let gauge = scales.gauge_kpa;
    let rate = Unit::MM.times(Unit::S, -1);
    vec![
        variable("displacement", "x", &["x"], Unit::MM, scales.travel_mm, Some("x"), Moving, 1.8),
        variable("velocity", "v", &["v"], rate, scales.speed_mm_s, Some("0"), Turning, 1.8),
        variable(
            "force of the drive",
            "force",
            &["force"],
            Unit::N,
            scales.force_n,
            Some("0"),
            Moving,
            2.2,
        ),
        variable(
            SUM_NAME,
            "(pf + pe - 2 * p_atm)",
            &["pf", "pe"],
            Unit::KPA,
            2.0 * gauge,
            Some("pf + pe - 2 * p_atm"),
            Slow,
            2.2,
        ),
        variable(
            "difference of the pressures",
            "(pf - pe)",
            &["pf", "pe"],
            Unit::KPA,
            gauge,
            Some("pf - pe"),
            Slow,
            2.5,
        ),
        variable(
            "gauge pressure of the flexor",
            "(pf - p_atm)",
            &["pf"],
            Unit::KPA,
            gauge,
            Some("pf - p_atm"),
            Combined,
            2.5,
        ),
        variable(
            "gauge pressure of the extensor",
            "(pe - p_atm)",
            &["pe"],
            Unit::KPA,
            gauge,
            Some("pe - p_atm"),
            Combined,
            2.5,
        ),
        variable("time", "t", &["t"], Unit::S, longest_s, None, Slow, 3.0),
    ]
}

fn places(scales: &DataScales, air_g: f64) -> Vec<Place> {
    let motion = vec![X, V, FORCE, SUM, DIFFERENCE, FLEXOR, EXTENSOR, TIME];
    let sensed = vec![X, V, FORCE, SUM, DIFFERENCE, FLEXOR, EXTENSOR, TIME];
    let place = |id: &str,
                 name: &str,
                 unit: Unit,
                 size: f64,
                 targets: &[(&str, &str, f64)],
                 length: f64| Place {
        id: id.to_owned(),
        name: name.to_owned(),
        unit,
        unit_text: unit.text(),
        size,
        targets: targets.iter().map(|(t, b, f)| ((*t).to_owned(), (*b).to_owned(), *f)).collect(),
        variables: motion.clone(),
        remembers: false,
        rich: false,
        dry: None,
        family: 0,
        description_length: length,
    };
    let sensor =
        |id: &str, name: &str, unit: Unit, size: f64, target: (&str, &str, f64), family: usize| {
            Place {
                variables: sensed.clone(),
                family,
                remembers: true,
                ..place(id, name, unit, size, &[target], 2.0)
            }
        };
    let flow = Unit::G.times(Unit::S, -1);
    let air = |id: &str, name: &str, targets: &[(&str, &str, f64)]| Place {
        variables: motion.clone(),
        family: 1,
        ..place(id, name, flow, FLOW_PER_S * air_g, targets, 2.0)
    };
    let (flexor, extensor) = ("air_flexor_g_s", "air_extensor_g_s");
    let (travel, gauge) = (scales.travel_mm, scales.gauge_kpa);
    vec![
        Place {
            remembers: true,
            rich: true,
            dry: Some((DRY, V)),
            ..place(
                "force",
                "force on the joint",
                Unit::N,
                scales.force_n,
                &[("force_n", "", 1.0)],
                0.5,
            )
        },
        place(
            "dry_friction",
            "dry friction",
            Unit::N,
            scales.force_n,
            &[("dry_friction_n", "", 1.0)],
            1.5,
        ),
        air(
            "exchange",
            "air from the extensor to the flexor",
            &[(flexor, "", 1.0), (extensor, "", -1.0)],
        ),
        air("inflow_flexor", "air into the flexor", &[(flexor, "", 1.0)]),
        air("inflow_extensor", "air into the extensor", &[(extensor, "", 1.0)]),
        sensor(
            "position_reading",
            "reading of the displacement",
            Unit::MM,
            0.1 * travel,
            ("position_mm", "x", 1.0),
            2,
        ),
        sensor(
            "flexor_reading",
            "reading of the flexor's pressure",
            Unit::KPA,
            0.1 * gauge,
            ("pressure_flexor_kpa", "pf", 1.0),
            3,
        ),
        sensor(
            "extensor_reading",
            "reading of the extensor's pressure",
            Unit::KPA,
            0.1 * gauge,
            ("pressure_extensor_kpa", "pe", 1.0),
            3,
        ),
    ]
}
