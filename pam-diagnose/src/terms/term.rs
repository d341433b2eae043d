//! Products of functions of variables.

use super::function::Function;
use super::space::{Place, Variable};
use super::unit::Unit;

/// Memory of a term: a state that a variable drives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lag {
    /// A first-order low-pass of a function of the variable, `ż = (f(u) − z)/τ`.
    LowPass {
        /// The function, one without a scale.
        of: Function,
        /// The time constant τ, s.
        time_s: f64,
    },
    /// A first-order high-pass of the variable, `u − z` with `ż = (u − z)/τ`.
    HighPass {
        /// The time constant τ, s.
        time_s: f64,
    },
    /// The stretch of a spring that slips at ±1, `dz = du/w` between −1 and 1 (Maxwell-slip element, rate-independent).
    Slip {
        /// The change `w` of the variable that stretches it from 0 to 1.
        width: f64,
    },
}

impl Lag {
    /// Its number: a time constant or a width.
    #[must_use]
    pub fn number(self) -> f64 {
        match self {
            Self::LowPass { time_s, .. } | Self::HighPass { time_s } => time_s,
            Self::Slip { width } => width,
        }
    }

    /// The same with another number.
    #[must_use]
    pub fn with_number(self, number: f64) -> Self {
        match self {
            Self::LowPass { of, .. } => Self::LowPass { of, time_s: number },
            Self::HighPass { .. } => Self::HighPass { time_s: number },
            Self::Slip { .. } => Self::Slip { width: number },
        }
    }

    /// The same but for the number.
    #[must_use]
    pub fn is_like(self, other: Self) -> bool {
        self.with_number(1.0) == other.with_number(1.0)
    }

    fn description_length(self) -> f64 {
        match self {
            Self::LowPass { of, .. } => LAG_LENGTH + of.description_length(),
            Self::HighPass { .. } | Self::Slip { .. } => LAG_LENGTH,
        }
    }
}

/// A function of a variable, or of a memory state that the variable drives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor {
    /// Index of the variable.
    pub variable: usize,
    /// The memory state that is the argument in place of the variable, if any.
    pub lag: Option<Lag>,
    /// The function.
    pub function: Function,
    /// Its scale, in the unit of the argument, or its exponent; unused by functions without one.
    pub scale: f64,
}

impl Factor {
    /// A function of a variable itself.
    #[must_use]
    pub fn of(variable: usize, function: Function, scale: f64) -> Self {
        Self { variable, lag: None, function, scale }
    }

    /// The low-pass of a function of a variable.
    #[must_use]
    pub fn low_pass(variable: usize, of: Function, time_s: f64) -> Self {
        let lag = Some(Lag::LowPass { of, time_s });
        Self { lag, ..Self::of(variable, Function::Linear, 1.0) }
    }

    /// A variable minus its first-order low-pass.
    #[must_use]
    pub fn high_pass(variable: usize, time_s: f64) -> Self {
        let lag = Some(Lag::HighPass { time_s });
        Self { lag, ..Self::of(variable, Function::Linear, 1.0) }
    }

    /// The unit of the function's argument.
    #[must_use]
    pub fn argument_unit(&self, variables: &[Variable]) -> Unit {
        let unit = variables[self.variable].unit;
        match self.lag {
            None | Some(Lag::HighPass { .. }) => unit,
            Some(Lag::LowPass { of, .. }) => Unit::ONE.times(unit, of.power()),
            Some(Lag::Slip { .. }) => Unit::ONE,
        }
    }

    /// The typical size of the function's argument.
    #[must_use]
    pub fn argument_size(&self, variables: &[Variable]) -> f64 {
        let size = variables[self.variable].size;
        match self.lag {
            None => size,
            Some(Lag::LowPass { of, .. }) => of.value(size, 1.0).abs(),
            Some(Lag::HighPass { .. }) => CHANGING * size,
            Some(Lag::Slip { .. }) => 1.0,
        }
    }

    /// The typical size of its value.
    #[must_use]
    pub fn size(&self, variables: &[Variable]) -> f64 {
        let size = self.argument_size(variables);
        match self.function {
            Function::Above | Function::Below | Function::Outside => {
                (size - self.scale).max(0.1 * size)
            }
            Function::Saturated
            | Function::Decaying
            | Function::Fading
            | Function::Peaked
            | Function::Gaussian
            | Function::Sine
            | Function::Cosine => 1.0,
            Function::Stiffening | Function::Power | Function::SignedPower => {
                self.function.value(size, self.scale)
            }
            Function::Negative => size,
            plain => plain.value(size, 1.0),
        }
    }

    /// The same but for numbers.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        self.variable == other.variable
            && self.function == other.function
            && match (self.lag, other.lag) {
                (Some(own), Some(lag)) => own.is_like(lag),
                (own, lag) => own.is_none() && lag.is_none(),
            }
    }

    /// Whether it is the sine or the cosine beside another one of the same period, which is one number of a law.
    #[must_use]
    pub fn is_twin_of(&self, other: &Self) -> bool {
        let waves = self.function.is_wave() && other.function.is_wave();
        waves
            && self.variable == other.variable
            && self.lag == other.lag
            && self.scale == other.scale
    }

    /// Whether it is the sine of another one that is the cosine of the same period, or the other way round.
    #[must_use]
    pub fn is_other_phase_of(&self, other: &Self) -> bool {
        self.is_twin_of(other) && self.function != other.function
    }

    fn description_length(&self, variables: &[Variable]) -> f64 {
        let lag = self.lag.map_or(0.0, Lag::description_length);
        variables[self.variable].description_length + self.function.description_length() + lag
    }
}

/// Description length of a memory, nats.
const LAG_LENGTH: f64 = 2.0;
/// Typical size of a high-passed pressure, relative to that of the pressure. Air that flows back and forth is some ten times
/// as much as air that leaks, by which the size of a flow is judged.
const CHANGING: f64 = 0.01;

/// A coefficient times a product of factors, at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// Index of the place.
    pub place: usize,
    /// The factors; none for a constant.
    pub factors: Vec<Factor>,
    /// The coefficient.
    pub coefficient: f64,
}

impl Term {
    /// A term whose size is that of its place.
    #[must_use]
    pub fn new(
        place: usize,
        factors: Vec<Factor>,
        variables: &[Variable],
        places: &[Place],
    ) -> Self {
        let mut term = Self { place, factors, coefficient: 1.0 };
        term.coefficient = places[place].size / term.size(variables);
        term
    }

    /// Other factors in the place of its own, with a coefficient that makes them about as large.
    #[must_use]
    pub fn with_factors(
        &self,
        factors: Vec<Factor>,
        variables: &[Variable],
        places: &[Place],
    ) -> Self {
        let mut other = Self::new(self.place, factors, variables, places);
        other.coefficient = self.coefficient * self.size(variables) / other.size(variables);
        other
    }

    /// The typical size of the product of the factors.
    #[must_use]
    pub fn size(&self, variables: &[Variable]) -> f64 {
        self.factors.iter().map(|f| f.size(variables)).product()
    }

    /// The unit of the coefficient.
    #[must_use]
    pub fn unit(&self, variables: &[Variable], places: &[Place]) -> Unit {
        let unit = places[self.place].unit;
        self.factors
            .iter()
            .fold(unit, |unit, f| unit.times(f.argument_unit(variables), -f.function.power()))
    }

    /// The same but for numbers: factors may stand in any order.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        let holds =
            |a: &Self, b: &Self| a.factors.iter().all(|f| b.factors.iter().any(|g| f.is_like(g)));
        self.place == other.place
            && self.factors.len() == other.factors.len()
            && holds(self, other)
            && holds(other, self)
    }

    /// Whether it is the same at another place, but for numbers.
    #[must_use]
    pub fn acts_like(&self, other: &Self) -> bool {
        let mut factors = self.factors.iter().zip(&other.factors);
        self.place != other.place
            && self.factors.len() == other.factors.len()
            && factors.all(|(f, g)| f.is_like(g))
    }

    /// Whether it remembers.
    #[must_use]
    pub fn remembers(&self) -> bool {
        self.factors.iter().any(|f| f.lag.is_some())
    }

    /// Whether it is a sine or a cosine of the time.
    #[must_use]
    pub fn repeats_in_time(&self, variables: &[Variable]) -> bool {
        let is_wave = |f: &Factor| f.function.is_wave() && variables[f.variable].is_time();
        matches!(self.factors.as_slice(), [one] if is_wave(one))
    }

    /// Indices of its variables, in ascending order.
    #[must_use]
    pub fn variables(&self) -> Vec<usize> {
        let mut all: Vec<usize> = self.factors.iter().map(|f| f.variable).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Length of its description without the values of its numbers, nats.
    #[must_use]
    pub fn description_length(&self, variables: &[Variable], places: &[Place]) -> f64 {
        let factors = self.factors.iter().map(|f| f.description_length(variables));
        places[self.place].description_length + factors.sum::<f64>()
    }

    /// The term over series of the variables, sampled every `step_s`.
    #[must_use]
    pub fn series(&self, variables: &[Vec<f64>], step_s: f64) -> Vec<f64> {
        let rows = variables.first().map_or(0, Vec::len);
        let mut product = vec![self.coefficient; rows];
        for f in &self.factors {
            // The state and the variable of the row before.
            let mut kept: Option<[f64; 2]> = None;
            for (p, &u) in product.iter_mut().zip(&variables[f.variable]) {
                let low_pass = |now: f64, time_s: f64| {
                    let old = kept.map_or(now, |k| k[0]);
                    old - (now - old) * (-step_s / time_s).exp_m1()
                };
                let state = match f.lag {
                    None => u,
                    Some(Lag::LowPass { of, time_s }) => low_pass(of.value(u, 1.0), time_s),
                    Some(Lag::HighPass { time_s }) => low_pass(u, time_s),
                    Some(Lag::Slip { width }) => {
                        let [old, before] = kept.unwrap_or([0.0, u]);
                        (old + (u - before) / width).clamp(-1.0, 1.0)
                    }
                };
                kept = Some([state, u]);
                let argument = match f.lag {
                    Some(Lag::HighPass { .. }) => u - state,
                    _ => state,
                };
                *p *= f.function.value(argument, f.scale);
            }
        }
        product
    }
}

/// Most terms that one definition holds: as many as its expression has room for, and fewer that remember.
const MOST: usize = 24;
const MOST_REMEMBERING: usize = 12;

/// Terms by the definitions that may hold them: a few of one place that all remember or none does, since an effect with memory acts
/// in one way and holds few numbers at once.
pub(crate) fn grouped(terms: &[Term]) -> impl Iterator<Item = &[Term]> {
    let kind = |t: &Term| (t.place, t.remembers());
    terms
        .chunk_by(move |a, b| kind(a) == kind(b))
        .flat_map(|own| own.chunks(if own[0].remembers() { MOST_REMEMBERING } else { MOST }))
}
