//! Terms as something that a system can simulate and fit.

use super::space::{Place, Variable, is_dry_level};
use super::term::{Factor, Lag, Term};
use super::unit::Unit;
use pam_vocabulary::ParameterInfo;

/// A fitted number of a definition.
#[derive(Debug, Clone, PartialEq)]
pub struct TermParameter {
    /// Name, with its unit as suffix.
    pub name: String,
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// Whether it is positive and fitted by its logarithm.
    pub logarithmic: bool,
    /// The value at which it contributes nothing.
    pub absent: Option<f64>,
    /// Value from which a fit starts.
    pub start: f64,
    /// Standard deviation of its prior about `absent`; infinite for a free one.
    pub deviation: f64,
}

/// A memory state of a definition.
#[derive(Debug, Clone, PartialEq)]
pub struct Remembered {
    /// Name.
    pub name: String,
    /// Value at the start, an expression.
    pub start: String,
    /// Whether it moves by steps: the law is its value after a step. Else it is its rate.
    pub steps: bool,
    /// Its law, an expression.
    pub law: String,
}

/// Terms with names for their numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// Id.
    pub id: String,
    /// One line: a noun phrase.
    pub description: String,
    /// Its numbers.
    pub parameters: Vec<TermParameter>,
    /// Its memory states.
    pub memory: Vec<Remembered>,
    /// Places of the system's expressions with the expression there.
    pub acts: Vec<[String; 2]>,
}

/// Multiple of its typical size that a coefficient reaches.
const LARGEST: f64 = 1e3;
/// Multiples of their starting value between which scales and times stay.
const SCALE_RANGE: f64 = 1e2;
/// Exponents stay between a smooth picture of a sign and one of a wall.
const EXPONENTS: [f64; 2] = [0.25, 8.0];

impl Definition {
    /// Terms whose coefficients alone are fitted, as multiples of what they are, from zero on, with a prior of this standard
    /// deviation.
    #[must_use]
    pub fn flexible(
        id: &str,
        terms: &[Term],
        deviation: f64,
        variables: &[Variable],
        places: &[Place],
    ) -> Self {
        let mut writer = Writer { variables, places, memory: Vec::new(), sums: Vec::new() };
        let mut parameters = Vec::new();
        for (k, term) in terms.iter().enumerate() {
            let name = format!("c{}", k + 1);
            let product = writer.product(term, &mut |_, _, value| written(value));
            let size = written(term.coefficient);
            let text = if product.is_empty() { size } else { format!("{size} * {product}") };
            writer.add(term.place, &format!("{name} * {text}"));
            parameters.push(TermParameter {
                name,
                range: [-LARGEST, LARGEST],
                logarithmic: false,
                absent: Some(0.0),
                start: 0.0,
                deviation,
            });
        }
        writer.done(id, "terms of a flexible model", parameters)
    }

    /// A law: terms whose coefficients, scales and times are all fitted, from their present values on.
    #[must_use]
    pub fn law(
        id: &str,
        description: &str,
        terms: &[Term],
        variables: &[Variable],
        places: &[Place],
    ) -> Self {
        let mut writer = Writer { variables, places, memory: Vec::new(), sums: Vec::new() };
        let mut parameters: Vec<TermParameter> = Vec::new();
        let mut waves: Vec<(Factor, String)> = Vec::new();
        for (k, term) in terms.iter().enumerate() {
            let suffix = term.unit(variables, places).suffix();
            let name = format!("c{}{suffix}", k + 1);
            let reach = round_up(LARGEST * places[term.place].size / term.size(variables));
            let dry = is_dry_level(term.place, places);
            let low = if dry && term.factors.is_empty() { 0.0 } else { -reach };
            parameters.push(TermParameter {
                name: name.clone(),
                range: [low, reach],
                logarithmic: false,
                absent: Some(0.0),
                start: term.coefficient,
                deviation: f64::INFINITY,
            });
            let mut scales = |f: &Factor, kind: Number, value: f64| {
                let twin = waves.iter().find(|(of, _)| kind != Number::Time && f.is_twin_of(of));
                if let Some((_, name)) = twin {
                    return name.clone();
                }
                let (letter, unit) = match kind {
                    Number::Scale(unit) => ("w", unit),
                    Number::Exponent => ("p", Unit::ONE),
                    Number::Time => ("tau", Unit::S),
                };
                let range = match kind {
                    Number::Exponent => EXPONENTS,
                    _ => [round_up(value / SCALE_RANGE), round_up(value * SCALE_RANGE)],
                };
                let count = parameters.iter().filter(|p| p.name.starts_with(letter)).count();
                let name = format!("{letter}{}{}", count + 1, unit.suffix());
                parameters.push(TermParameter {
                    name: name.clone(),
                    range,
                    logarithmic: true,
                    absent: None,
                    start: value,
                    deviation: f64::INFINITY,
                });
                waves.push((*f, name.clone()));
                name
            };
            let product = writer.product(term, &mut scales);
            let text = if product.is_empty() { name } else { format!("{name} * {product}") };
            writer.add(term.place, &text);
        }
        writer.done(id, description, parameters)
    }
}

impl Definition {
    /// What it adds and where, `force_n = c1_n_per_mm3 * x^3`, with the rates of what it remembers.
    #[must_use]
    pub fn expression(&self) -> String {
        let acts = self.acts.iter().map(|[place, text]| format!("{place} = {text}"));
        let memory = self.memory.iter().map(|m| match m.steps {
            true => format!("{} := {} at each step", m.name, m.law),
            false => format!("d{}/dt = {}", m.name, m.law),
        });
        acts.chain(memory).collect::<Vec<_>>().join(", ")
    }

    /// The definition as a file of effects.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut out = String::from("[[effect]]\n");
        let mut line = |text: String| {
            out += &text;
            out.push('\n');
        };
        line(format!("id = \"{}\"", self.id));
        line(format!("description = \"{}\"", self.description));
        for p in &self.parameters {
            let mut entry = format!("range = [{:?}, {:?}]", p.range[0], p.range[1]);
            if let Some(absent) = p.absent {
                entry += &format!(", absent = {absent:?}");
            }
            if p.logarithmic {
                entry += ", log = true";
            }
            line(format!("parameters.{} = {{ {entry}, start = [{:?}] }}", p.name, p.start));
        }
        for Remembered { name, start, steps, law } in &self.memory {
            let key = if *steps { "step" } else { "rate" };
            line(format!("memory.{name} = {{ start = \"{start}\", {key} = \"{law}\" }}"));
        }
        for [place, text] in &self.acts {
            line(format!("acts.{place} = \"{text}\""));
        }
        out
    }

    /// The same with another description.
    #[must_use]
    pub fn describe(self, description: &str) -> Self {
        Self { description: description.to_owned(), ..self }
    }

    /// The same with other values from which a fit starts.
    #[must_use]
    pub fn starting_at(&self, values: &[f64]) -> Self {
        let mut other = self.clone();
        other.parameters.iter_mut().zip(values).for_each(|(p, v)| p.start = *v);
        other
    }

    /// The terms of a [`law`](Self::law) with the values of its parameters.
    #[must_use]
    pub fn with_values(&self, terms: &[Term], values: &[f64]) -> Vec<Term> {
        let mut rest = values.iter().copied();
        let mut next = |old: f64| rest.next().unwrap_or(old);
        let mut fitted = Vec::with_capacity(terms.len());
        let mut waves: Vec<(Factor, f64)> = Vec::new();
        // In the order in which `law` names them.
        for term in terms {
            let mut term = term.clone();
            term.coefficient = next(term.coefficient);
            for f in &mut term.factors {
                let old = *f;
                if let Some(lag) = &mut f.lag {
                    *lag = lag.with_number(next(lag.number()));
                }
                if f.function.has_scale() {
                    let twin = waves.iter().find(|(of, _)| old.is_twin_of(of));
                    f.scale = twin.map_or_else(|| next(f.scale), |twin| twin.1);
                    waves.push((old, f.scale));
                }
            }
            fitted.push(term);
        }
        fitted
    }
}

/// A number inside a product.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Number {
    /// A scale of a function, with its unit.
    Scale(Unit),
    /// An exponent.
    Exponent,
    /// A time constant.
    Time,
}

/// Writes terms as sums at the places of a system.
struct Writer<'a> {
    variables: &'a [Variable],
    places: &'a [Place],
    memory: Vec<Remembered>,
    /// The place and the sum of its terms.
    sums: Vec<(usize, String)>,
}

impl Writer<'_> {
    /// The product of the factors of a term, its numbers as `number` writes them.
    fn product(
        &mut self,
        term: &Term,
        number: &mut dyn FnMut(&Factor, Number, f64) -> String,
    ) -> String {
        let mut parts = Vec::new();
        for f in &term.factors {
            let variable = &self.variables[f.variable];
            let argument = match f.lag {
                None => variable.text.clone(),
                Some(lag) => {
                    let unit = match lag {
                        Lag::LowPass { .. } | Lag::HighPass { .. } => Number::Time,
                        Lag::Slip { .. } => Number::Scale(variable.unit),
                    };
                    let number = number(f, unit, lag.number());
                    let state = self.remembered(variable, lag, &number);
                    match lag {
                        Lag::HighPass { .. } => format!("({} - {state})", variable.text),
                        _ => state,
                    }
                }
            };
            let scale = if f.function.has_scale() {
                let kind = match f.function.has_exponent() {
                    true => Number::Exponent,
                    false => Number::Scale(f.argument_unit(self.variables)),
                };
                number(f, kind, f.scale)
            } else {
                String::new()
            };
            parts.push(f.function.text(&argument, &scale));
        }
        parts.join(" * ")
    }

    /// The name of a remembered number whose time or width is a number; equal ones are one.
    fn remembered(&mut self, variable: &Variable, lag: Lag, number: &str) -> String {
        let start = variable.at_start.as_deref().unwrap_or("0");
        let (start, steps) = match lag {
            Lag::LowPass { of, .. } if start != "0" => (of.text(start, ""), false),
            Lag::LowPass { .. } => ("0".to_owned(), false),
            Lag::HighPass { .. } => (start.to_owned(), false),
            Lag::Slip { .. } => ("0".to_owned(), true),
        };
        let law = |name: &str| match lag {
            Lag::LowPass { of, .. } => {
                format!("({} - {name}) / {number}", of.text(&variable.text, ""))
            }
            Lag::HighPass { .. } => format!("({} - {name}) / {number}", variable.text),
            Lag::Slip { .. } => {
                let change = variable.change.as_deref().unwrap_or("0");
                format!("clamp({name} + {change} / {number}, -1, 1)")
            }
        };
        if let Some(known) = self.memory.iter().find(|m| m.law == law(&m.name)) {
            return known.name.clone();
        }
        let name = format!("z{}", self.memory.len() + 1);
        let law = law(&name);
        self.memory.push(Remembered { name: name.clone(), start, steps, law });
        name
    }

    fn add(&mut self, place: usize, text: &str) {
        let text = as_quotient(text);
        match self.sums.iter_mut().find(|s| s.0 == place) {
            Some((_, sum)) => *sum += &format!(" + {text}"),
            None => self.sums.push((place, text)),
        }
    }

    fn done(self, id: &str, description: &str, parameters: Vec<TermParameter>) -> Definition {
        let mut acts: Vec<[String; 2]> = Vec::new();
        for (place, sum) in &self.sums {
            for (target, base, factor) in &self.places[*place].targets {
                let part = match *factor {
                    1.0 => sum.clone(),
                    -1.0 => format!("-({sum})"),
                    factor => format!("{} * ({sum})", written(factor)),
                };
                match acts.iter_mut().find(|a| a[0] == *target) {
                    Some([_, text]) => *text += &format!(" + {part}"),
                    None => {
                        let base =
                            if base.is_empty() { String::new() } else { format!("{base} + ") };
                        acts.push([target.clone(), base + &part]);
                    }
                }
            }
        }
        Definition {
            id: id.to_owned(),
            description: description.to_owned(),
            parameters,
            memory: self.memory,
            acts,
        }
    }
}

/// A product with the reciprocal of something as a quotient.
pub(crate) fn as_quotient(text: &str) -> String {
    text.replace(" * 1 / (", " / (")
}

/// A number in an expression.
fn written(value: f64) -> String {
    if value < 0.0 { format!("({value:?})") } else { format!("{value:?}") }
}

/// The next power of ten.
fn round_up(value: f64) -> f64 {
    10f64.powf((value.log10() - 1e-9).ceil())
}

impl TermParameter {
    /// As the vocabulary describes a parameter, under a name that stays.
    #[must_use]
    pub fn info(&self, name: &'static str) -> ParameterInfo {
        ParameterInfo {
            name,
            meaning: "",
            range: self.range,
            logarithmic: self.logarithmic,
            off: self.absent,
            not_below: None,
        }
    }
}
