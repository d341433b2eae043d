//! Single cases on which the diagnosis once said what is not so, each with what must hold of its outcome.
//!
//! Several cases can belong to a row; their ids are `rows-LETTER` or `rows-LETTER-NUMBER`.

use super::case::{Case, Factors, Fault, Kind, ModelError, Shape, Source};
use super::outcome::{Named, Outcome, REFUSED};
use crate::plant::{Colour, Hidden, Noise};

/// What must hold of the outcome of a row; the error says what does not.
pub type Check = fn(&Outcome) -> Result<(), String>;

/// A row: a case with what must hold.
#[derive(Debug, Clone)]
pub struct Row {
    /// The case.
    pub case: Case,
    /// What must hold, in words.
    pub asked: &'static str,
    /// The same as a function.
    pub check: Check,
}

fn said(o: &Outcome) -> String {
    format!("`{}` {}", o.verdict, o.headline_text())
}

fn hold(o: &Outcome, holds: bool) -> Result<(), String> {
    if holds { Ok(()) } else { Err(said(o)) }
}

fn nothing(o: &Outcome) -> Result<(), String> {
    hold(o, o.verdict == "nothing_found" && o.causes.is_empty())
}

/// Every hidden effect is named, or the verdict admits that more is left.
fn all_or_admitted(o: &Outcome) -> Result<(), String> {
    let all = o.truth.iter().all(|t| o.names(&t.hidden.id));
    hold(o, all || (o.verdict == "partly_explained" && o.first_is_right()))
}

fn all_named(o: &Outcome) -> Result<(), String> {
    hold(o, o.truth.iter().all(|t| o.names(&t.hidden.id)))
}

fn only_the_hidden(o: &Outcome) -> Result<(), String> {
    all_named(o)?;
    hold(o, o.superfluous() == 0)
}

/// Limits that the rows give.
const SMALL_X_MM: f64 = 0.03;
const TRUE_FRICTION_N: f64 = 15.0;
/// Time at which the friction of row d begins, and how far a fitted onset may be from it, s.
const HALF_S: f64 = 20.0;
const ONSET_S: f64 = 0.5;

fn inertia_and_gain_shown(o: &Outcome) -> Result<(), String> {
    hold(o, o.names("added_inertia"))
}

fn friction_within_its_interval(o: &Outcome) -> Result<(), String> {
    let friction = o.causes.iter().find(|c| c.effect == "coulomb_friction");
    let interval = friction.and_then(|c| c.parameters.get("force_n"));
    let holds = interval.is_none_or(|i| i[1] <= TRUE_FRICTION_N && TRUE_FRICTION_N <= i[2]);
    hold(o, holds && o.names("coulomb_friction"))
        .map_err(|said| format!("{said}, force {interval:?}"))
}

/// No delay is named, and nothing is explained but by friction that begins when it does.
fn no_delay(o: &Outcome) -> Result<(), String> {
    let begins = |c: &Named| {
        let onset_s = c.parameters.get("onset_s");
        c.covers("coulomb_friction") && onset_s.is_some_and(|i| (i[0] - HALF_S).abs() < ONSET_S)
    };
    let friction = o.headline().next().is_some() && o.headline().all(begins);
    let explained = o.verdict != "explained" || friction;
    hold(o, !o.headline().any(|c| c.effect.ends_with("_delay")) && explained)
}

/// The friction is named, and its law too: growing with load, or not constant.
fn grows_with_pressure(o: &Outcome) -> Result<(), String> {
    hold(o, o.names("load_friction") || (o.names("coulomb_friction") && o.verdict != "explained"))
}

fn no_made_up_causes(o: &Outcome) -> Result<(), String> {
    let sensors = ["pressure_sensor_lag", "pressure_delay"];
    let real = o.headline().all(|c| sensors.iter().any(|id| c.covers(id)));
    hold(o, real)
}

fn friction_and_bounds(o: &Outcome) -> Result<(), String> {
    let bounds = o.causes.iter().flat_map(|c| &c.parameters).all(|(name, [_, low, _])| {
        !matches!(name.as_str(), "force_n" | "coulomb_n" | "static_n") || *low >= 0.0
    });
    let proven = o.reduction.is_some_and(|r| r[1] > 0.0);
    hold(o, o.names("coulomb_friction") && bounds && (proven || o.verdict != "explained"))
}

fn gauge_is_told(o: &Outcome) -> Result<(), String> {
    let told = o.error.as_ref().is_some_and(|e| e.contains("gauge"));
    hold(o, (o.verdict == REFUSED && told) || (o.verdict != "explained" && o.causes.is_empty()))
}

fn small_before(o: &Outcome) -> Result<(), String> {
    nothing(o)?;
    let before = o.x_before_mm.unwrap_or(f64::NAN);
    if before < SMALL_X_MM { Ok(()) } else { Err(format!("x before: {before:.3} mm")) }
}

fn not_nothing(o: &Outcome) -> Result<(), String> {
    hold(o, o.verdict != "nothing_found" && o.verdict != REFUSED)
}

fn coulomb(force_n: f64) -> Hidden {
    Hidden::new("coulomb_friction", &[("force_n", force_n)])
}

struct Rows(Vec<Row>);

impl Rows {
    fn add(
        &mut self,
        id: &str,
        factors: Factors,
        hidden: &[Hidden],
        asked: &'static str,
        check: Check,
    ) -> &mut Case {
        let case = Case {
            id: format!("rows-{id}"),
            kind: Kind::Row,
            factors,
            faults: hidden.iter().cloned().map(Fault::Given).collect(),
            conditions: Vec::new(),
            seed: 60_000 + self.0.len() as u64,
            diagnosis_seed: 1,
            repeats: None,
        };
        self.0.push(Row { case, asked, check });
        &mut self.0.last_mut().expect("just added").case
    }
}

/// All rows.
#[must_use]
pub fn all() -> Vec<Row> {
    let mut rows = Rows(Vec::new());
    let usual = Factors::default;
    let found_nothing = "`nothing_found`";
    for set in 1..=6 {
        let factors = Factors {
            pressure_colour: Colour::LowPassed(30.0),
            // 0.04 A of white noise in the current.
            force_noise: Noise::white(5.3),
            duration_s: 40.0,
            ..usual()
        };
        rows.add(&format!("0-{set}"), factors, &[], found_nothing, nothing);
    }
    let long = |duration_s| Factors { duration_s, ..usual() };
    let leak = Hidden::new("leak", &[("extensor_rate_per_s", 7e-4)]);
    let both = "both named, or `partly_explained`";
    rows.add("a", long(40.0), &[leak, coulomb(25.0)], both, all_or_admitted);
    let late = Hidden::new("position_delay", &[("delay_ms", 20.0)]);
    rows.add("b", long(40.0), &[late, coulomb(20.0)], both, all_or_admitted);
    let one = Factors { recordings: 1, ..long(70.0) };
    let begins = "not `nothing_found`";
    rows.add("c", one, &[coulomb(15.0).from_s(48.0)], begins, not_nothing);
    let half = "no delay is named; friction with its onset, or not `explained`";
    rows.add("d", long(40.0), &[coulomb(15.0).from_s(HALF_S)], half, no_delay);
    let grows = Hidden::new("load_friction", &[("force_n_per_kpa", 0.1)]);
    // 138, 310 and 520 kPa of gauge pressure.
    rows.add("e", long(40.0), &[grows], "friction that grows with pressure", grows_with_pressure)
        .conditions = vec![[20.0, 20.0], [45.0, 45.0], [75.0, 75.0]];
    for rate_hz in [25.0, 50.0] {
        let factors = Factors { rate_hz, cutoff_hz: 0.0, ..long(40.0) };
        rows.add(&format!("f-{rate_hz}"), factors, &[], found_nothing, nothing);
    }
    let coloured = Factors { pressure_colour: Colour::Correlated(0.5), ..long(40.0) };
    rows.add("g", coloured, &[], found_nothing, nothing);
    let inertia = Hidden::new("added_inertia", &[("mass_kg", 35.0)]);
    for hz in [8.0, 2.0] {
        let factors = Factors { shape: Shape::Sine(hz), ..usual() };
        let shown = "inertia, or a set that holds it";
        let inertia = std::slice::from_ref(&inertia);
        rows.add(&format!("h-{hz}"), factors, inertia, shown, inertia_and_gain_shown);
    }
    let poor = Factors { model_error: ModelError::Weights(0.03), baseline: true, ..long(40.0) };
    let within = "friction, 15 N within its interval";
    rows.add("i", poor, &[coulomb(15.0)], within, friction_within_its_interval);
    for recordings in [1, 3] {
        let rig = Factors { source: Source::Rig, recordings, ..long(21.0) };
        let real = "no cause but the lag of the pressure sensors";
        rows.add(&format!("j-{recordings}"), rig, &[], real, no_made_up_causes);
    }
    let rig = Factors { source: Source::Rig, baseline: true, ..long(21.0) };
    let bounds = "Coulomb or a set with it; bounds; `explained` only with a proven reduction";
    rows.add("k", rig, &[coulomb(3.0)], bounds, friction_and_bounds);
    let gauge = Factors { gauge: true, ..long(20.0) };
    let told = "gauge pressures are told, or nothing is named";
    rows.add("l", gauge, &[], told, gauge_is_told);
    let lag = Hidden::new("actuator_lag", &[("cutoff_hz", 3.0)]);
    rows.add("m", long(40.0), &[lag], "actuator lag, or a set with it", all_named);
    let five = Factors { recordings: 5, ..long(70.0) };
    let alone = [
        Hidden::new("geometry_coefficient", &[("relative", 0.08)]),
        Hidden::new("pressure_bias", &[("flexor_kpa", 7.0), ("extensor_kpa", -3.0)]),
    ];
    for (n, hidden) in (1..).zip(alone) {
        rows.add(&format!("n-{n}"), five.clone(), &[hidden], "named, or a set with it", all_named);
    }
    for (n, label) in (1..).zip(["creep", "cogging", "polytropic_gas", "stribeck_friction"]) {
        let hidden = crate::magnitudes::at_strength(label, 1.0);
        let only = "named, and nothing else in the headline";
        rows.add(&format!("o-{n}"), long(40.0), &[hidden], only, only_the_hidden);
    }
    let smooth = Factors { smooth_force: true, rate_hz: 25.0, cutoff_hz: 0.0, ..long(40.0) };
    let small = "`nothing_found`, error of x below 0.03 mm";
    rows.add("p", smooth, &[], small, small_before);
    rows.0
}
