//! Products of functions of variables.

use super::function::Function;
use super::space::{Place, Variable};
use super::unit::Unit;

/// A first-order low-pass of a function of a variable, `ż = (f(u) − z)/τ`: what a term remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lag {
    /// The function, one without a scale.
    pub of: Function,
    /// The time constant τ, s.
    pub time_s: f64,
}

/// A function of a variable, or of its low-pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factor {
    /// Index of the variable.
    pub variable: usize,
    /// The low-pass that it goes through first.
    pub lag: Option<Lag>,
    /// The function.
    pub function: Function,
    /// Its scale, in the unit of the argument; unused by functions without one.
    pub scale: f64,
}

impl Factor {
    /// A function of a variable itself.
    #[must_use]
    pub fn of(variable: usize, function: Function, scale: f64) -> Self {
        Self { variable, lag: None, function, scale }
    }

    /// The unit of the function's argument.
    #[must_use]
    pub fn argument_unit(&self, variables: &[Variable]) -> Unit {
        let unit = variables[self.variable].unit;
        self.lag.map_or(unit, |lag| Unit::ONE.times(unit, lag.of.power()))
    }

    /// The typical size of the function's argument.
    #[must_use]
    pub fn argument_size(&self, variables: &[Variable]) -> f64 {
        let size = variables[self.variable].size;
        self.lag.map_or(size, |lag| lag.of.value(size, 1.0).abs())
    }

    /// The typical size of its value.
    #[must_use]
    pub fn size(&self, variables: &[Variable]) -> f64 {
        let size = self.argument_size(variables);
        match self.function {
            Function::Above | Function::Below => (size - self.scale).max(0.1 * size),
            Function::Saturated | Function::Decaying | Function::Sine | Function::Cosine => 1.0,
            Function::Negative => size,
            plain => plain.value(size, 1.0),
        }
    }

    /// The same but for numbers.
    #[must_use]
    pub fn is_like(&self, other: &Self) -> bool {
        self.variable == other.variable
            && self.function == other.function
            && self.lag.map(|l| l.of) == other.lag.map(|l| l.of)
    }

    fn description_length(&self, variables: &[Variable]) -> f64 {
        let lag = self.lag.map_or(0.0, |l| LAG_LENGTH + l.of.description_length());
        variables[self.variable].description_length + self.function.description_length() + lag
    }
}

/// Description length of a memory, nats.
const LAG_LENGTH: f64 = 2.0;

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

    /// Whether it remembers.
    #[must_use]
    pub fn remembers(&self) -> bool {
        self.factors.iter().any(|f| f.lag.is_some())
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
            let mut kept: Option<f64> = None;
            for (p, &u) in product.iter_mut().zip(&variables[f.variable]) {
                let argument = f.lag.map_or(u, |lag| {
                    let now = lag.of.value(u, 1.0);
                    let old = kept.unwrap_or(now);
                    let moved = old - (now - old) * (-step_s / lag.time_s).exp_m1();
                    kept = Some(moved);
                    moved
                });
                *p *= f.function.value(argument, f.scale);
            }
        }
        product
    }
}
