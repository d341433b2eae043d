//! Effect files: TOML to definitions.

use super::{
    EffectDefinition, Formula, Language, MemoryDefinition, MemoryLaw, Moment, ParameterDefinition,
    SwitchDefinition, Symbol,
};
use crate::Group;
use crate::expression::{CONSTANTS, Expression, ExpressionError, Function, Scope, nearest};
use serde::Deserialize;
use serde_spanned::Spanned;
use std::collections::BTreeMap;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    effect: Vec<RawEffect>,
}

type Table<T> = BTreeMap<Spanned<String>, T>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawEffect {
    id: Spanned<String>,
    description: String,
    group: Option<Spanned<String>>,
    #[serde(default)]
    excited_by: String,
    #[serde(default)]
    parameters: Table<RawParameter>,
    #[serde(default)]
    switches: Table<RawSwitch>,
    #[serde(default, rename = "let")]
    lets: Table<Spanned<String>>,
    #[serde(default)]
    memory: Table<RawMemory>,
    acts: Table<Spanned<String>>,
    valid: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawParameter {
    range: Spanned<[f64; 2]>,
    absent: Option<Spanned<f64>>,
    #[serde(default)]
    log: bool,
    not_below: Option<Spanned<String>>,
    #[serde(default)]
    meaning: String,
    #[serde(default)]
    start: Vec<Spanned<Number>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSwitch {
    values: Vec<f64>,
    #[serde(default)]
    meaning: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawMemory {
    start: Option<Spanned<String>>,
    rate: Option<Spanned<String>>,
    step: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Number {
    Number(f64),
    Text(String),
}

/// Most values of an effect, and most remembered numbers.
const MOST_VALUES: usize = 64;
const MOST_MEMORIES: usize = 16;
/// Most operations and operands of an expression in which the named parts are written out. Parts of parts grow
/// exponentially: a file of a few lines would take any time and memory.
const MOST_WRITTEN_OUT: usize = 4000;
/// Variables of the joint that the starting value of a memory state in the balance of forces may depend on.
const KNOWN_AT_START: [&str; 3] = ["x", "pf", "pe"];

/// Most starting values of a fit: the product over the parameters and switches.
const MOST_STARTS: usize = 24;

impl EffectDefinition {
    /// Reads a file of effects.
    ///
    /// # Errors
    /// [`ExpressionError`] with line, column and the unknown word or the impossible value.
    pub fn read_all(text: &str, language: &Language) -> Result<Vec<Self>, ExpressionError> {
        let file: File = toml::from_str(text).map_err(|e| {
            let at = e.span().map_or(0, |span| span.start);
            ExpressionError::at(text, at, e.message().replace('\n', "; "))
        })?;
        let reader = Reader { text, language };
        let mut effects: Vec<Self> = Vec::new();
        for raw in file.effect {
            let (id, at) = (raw.id.get_ref().clone(), raw.id.span().start);
            if effects.iter().any(|e| e.id == id) {
                return Err(reader.fail(at, format!("there are two effects `{id}`")));
            }
            effects.push(reader.effect(raw)?);
        }
        Ok(effects)
    }
}

struct Reader<'a> {
    text: &'a str,
    language: &'a Language,
}

/// The entries of a table in the order of the file.
fn in_order<T>(table: Table<T>) -> Vec<(Spanned<String>, T)> {
    let mut entries: Vec<_> = table.into_iter().collect();
    entries.sort_by_key(|(name, _)| name.span().start);
    entries
}

/// Names that the earlier parts use, directly and through others.
#[derive(Default, Clone)]
struct Uses {
    variables: Vec<usize>,
    memory: bool,
    network: bool,
    /// Operations and operands with the named parts written out.
    size: usize,
}

/// Where an expression stands.
#[derive(Clone, Copy, PartialEq)]
enum Position {
    /// A named part, which is checked where it is used.
    Let,
    At(Moment),
    Step(Moment),
    Start(Moment),
}

impl Reader<'_> {
    fn fail(&self, at: usize, message: String) -> ExpressionError {
        ExpressionError::at(self.text, at, message)
    }

    /// Checks a new name.
    fn name(&self, name: &Spanned<String>, taken: &[String]) -> Result<String, ExpressionError> {
        let (word, at) = (name.get_ref(), name.span().start);
        let letters = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !word.chars().all(letters) || !word.starts_with(|c: char| c.is_ascii_alphabetic()) {
            let message = format!(
                "`{word}` is no name: letters without accents, digits and `_`, a letter first"
            );
            return Err(self.fail(at, message));
        }
        let fixed = CONSTANTS.iter().map(|c| c.0).chain(Function::ALL.iter().map(|f| f.0));
        if taken.iter().map(String::as_str).chain(fixed).any(|known| known == word) {
            let message = format!("`{word}` has a meaning already; take another name");
            return Err(self.fail(at, message));
        }
        Ok(word.clone())
    }

    /// The place in the file of a byte of a value, if the value stands there as it is.
    fn parse(&self, text: &Spanned<String>, scope: &Scope<'_>) -> Result<Formula, ExpressionError> {
        let value = text.get_ref();
        let tree = Expression::parse(value, scope).map_err(|e| {
            let span = text.span();
            let start = self.text.get(span.clone()).and_then(|raw| raw.find(value.as_str()));
            let lines = value.split_inclusive('\n').take(e.line - 1).map(str::len).sum::<usize>();
            let line = &value[lines..];
            let within = line.char_indices().nth(e.column - 1).map_or(line.len(), |(k, _)| k);
            let at = start.map_or(span.start, |start| span.start + start + lines + within);
            self.fail(at, e.message)
        })?;
        Ok(Formula { text: value.trim().to_owned(), tree })
    }

    /// An expression over the names of an effect so far.
    fn formula(
        &self,
        effect: &EffectDefinition,
        uses: &[Uses],
        text: &Spanned<String>,
        position: Position,
    ) -> Result<Formula, ExpressionError> {
        let refuses = |name: usize| self.refuses(effect, uses, name, position);
        let network = match position {
            Position::Let | Position::At(Moment::Motion) | Position::Step(Moment::Motion) => {
                self.language.network
            }
            _ => false,
        };
        let formula =
            self.parse(text, &Scope { names: &effect.names, refuses: &refuses, network })?;
        if written_out(effect, uses, &formula.tree) > MOST_WRITTEN_OUT {
            let message = format!(
                "the expression has more than {MOST_WRITTEN_OUT} operations once its named parts are written out"
            );
            return Err(self.fail(text.span().start, message));
        }
        Ok(formula)
    }

    fn refuses(
        &self,
        effect: &EffectDefinition,
        uses: &[Uses],
        name: usize,
        position: Position,
    ) -> Option<String> {
        let variable = |k: usize| match position {
            Position::Let => None,
            Position::At(moment) => self.language.refuses(k, moment, false),
            Position::Step(moment) => self.language.refuses(k, moment, true),
            Position::Start(Moment::Motion)
                if !KNOWN_AT_START.contains(&effect.names[k].as_str()) =>
            {
                Some(format!(
                    "`{}` is not known at the beginning; there are {}",
                    effect.names[k],
                    KNOWN_AT_START.join(", ")
                ))
            }
            Position::Start(moment) => self.language.refuses(k, moment, false),
        };
        let memory = || match position {
            Position::At(Moment::Once) => {
                Some("a constant of the effect knows no memory".to_owned())
            }
            Position::Start(_) => Some("the memory is not known at the beginning".to_owned()),
            _ => None,
        };
        match effect.symbol(name) {
            Symbol::Variable(k) => variable(k),
            Symbol::Value(_) => None,
            Symbol::Memory(_) => memory(),
            Symbol::Let(k) => {
                let own = &uses[k];
                let network = own.network
                    && !matches!(
                        position,
                        Position::Let
                            | Position::At(Moment::Motion)
                            | Position::Step(Moment::Motion)
                    );
                let why = own
                    .variables
                    .iter()
                    .find_map(|&k| variable(k))
                    .or_else(|| memory().filter(|_| own.memory))
                    .or_else(|| network.then(|| "`network(…)` is not known here".to_owned()))?;
                Some(format!("`{}`: {why}", effect.names[name]))
            }
        }
    }

    fn effect(&self, raw: RawEffect) -> Result<EffectDefinition, ExpressionError> {
        let at = raw.id.span().start;
        let variables: Vec<String> =
            self.language.variables().map(|(name, _)| name.to_owned()).collect();
        let mut effect = EffectDefinition {
            id: self.name(&raw.id, &[])?,
            group: self.group(raw.group.as_ref())?,
            description: raw.description.trim().to_owned(),
            excited_by: raw.excited_by.trim().to_owned(),
            parameters: Vec::new(),
            switches: Vec::new(),
            lets: Vec::new(),
            memory: Vec::new(),
            acts: Vec::new(),
            valid: None,
            names: variables,
            valid_names: Vec::new(),
        };
        let acts = in_order(raw.acts);
        let memory = in_order(raw.memory);
        let places = self.places(&acts)?;
        let moments: Vec<Moment> = places.iter().map(|&k| self.language.places[k].moment).collect();
        let mut changing: Vec<Moment> = Vec::new();
        for moment in moments.iter().copied().filter(|m| *m != Moment::Once) {
            if !changing.contains(&moment) {
                changing.push(moment);
            }
        }
        if acts.is_empty() {
            return Err(self.fail(at, format!("`{}` acts nowhere; give `acts`", effect.id)));
        }
        if let Some((name, _)) = memory.first()
            && (changing.len() != 1 || self.language.scales.is_empty())
        {
            let message = if self.language.scales.is_empty() {
                "a field has no memory besides its states; make it a state".to_owned()
            } else {
                "an effect with memory acts in one of three ways: on the joint, on the command, or on sensors"
                    .to_owned()
            };
            return Err(self.fail(name.span().start, message));
        }

        let (mut starts, mut bounds) = (Vec::new(), Vec::new());
        for (name, mut raw) in in_order(raw.parameters) {
            let name = self.name(&name, &effect.names)?;
            effect.names.push(name.clone());
            starts.push(raw.start.len());
            bounds.push(raw.not_below.take());
            effect.parameters.push(self.parameter(name, raw)?);
        }
        for (k, bound) in bounds.iter().enumerate() {
            effect.parameters[k].not_below = bound
                .as_ref()
                .map(|other| self.lower_bound(&effect.parameters, k, other))
                .transpose()?;
        }
        for (name, raw) in in_order(raw.switches) {
            let word = self.name(&name, &effect.names)?;
            if raw.values.is_empty() {
                let message = format!("`{word}` has no values that could be tried");
                return Err(self.fail(name.span().start, message));
            }
            effect.names.push(word.clone());
            let (values, meaning) = (raw.values, raw.meaning);
            effect.switches.push(SwitchDefinition { name: word, meaning, values });
        }
        effect.valid_names = effect.names[self.language.variables().count()..].to_vec();
        effect.valid_names.extend(self.language.scales.iter().cloned());
        for scale in &self.language.scales {
            if effect.names.contains(scale) {
                let message = format!("`{scale}` is a magnitude of the data; take another name");
                return Err(self.fail(at, message));
            }
        }
        // All remembered numbers have their names before a law uses them.
        for (name, _) in &memory {
            let word = self.name(name, &effect.names)?;
            effect.names.push(word.clone());
            let zero = Formula { text: "0".into(), tree: Expression::Number(0.0) };
            let law = MemoryLaw::Rate(zero.clone());
            effect.memory.push(MemoryDefinition { name: word, start: zero, law });
        }
        let uses = self.lets(&mut effect, in_order(raw.lets))?;
        if effect.value_len() > MOST_VALUES || effect.memory.len() > MOST_MEMORIES {
            let message = format!(
                "`{}` has more than {MOST_VALUES} values or {MOST_MEMORIES} memories",
                effect.id
            );
            return Err(self.fail(at, message));
        }
        let moment = changing.first().copied().unwrap_or(Moment::Motion);
        for (k, (name, raw)) in memory.into_iter().enumerate() {
            let (text, law, position): (_, fn(Formula) -> MemoryLaw, _) = match (raw.rate, raw.step)
            {
                (Some(rate), None) => (rate, MemoryLaw::Rate, Position::At(moment)),
                (None, Some(step)) => (step, MemoryLaw::Step, Position::Step(moment)),
                _ => {
                    let message = format!("`{}` needs either `rate` or `step`", name.get_ref());
                    return Err(self.fail(name.span().start, message));
                }
            };
            let formula = self.formula(&effect, &uses, &text, position)?;
            if let Some(start) = raw.start {
                effect.memory[k].start =
                    self.formula(&effect, &uses, &start, Position::Start(moment))?;
            }
            effect.memory[k].law = law(formula);
        }
        for (k, (_, text)) in places.into_iter().zip(acts) {
            let position = Position::At(self.language.places[k].moment);
            let formula = self.formula(&effect, &uses, &text, position)?;
            effect.acts.push((k, formula));
        }
        if let Some(valid) = &raw.valid {
            effect.valid = Some(self.parse(valid, &Scope::of(&effect.valid_names))?);
        }
        self.default_starts(&mut effect, &starts);
        let count: usize = effect.parameters.iter().map(|p| p.starts.len()).product::<usize>()
            * effect.switches.iter().map(|s| s.values.len()).product::<usize>();
        if count > MOST_STARTS {
            let message = format!(
                "`{}` has {count} combinations of starting values; a fit takes at most {MOST_STARTS}: give fewer in `start`",
                effect.id
            );
            return Err(self.fail(at, message));
        }
        Ok(effect)
    }

    fn group(&self, group: Option<&Spanned<String>>) -> Result<Group, ExpressionError> {
        let Some(group) = group else { return Ok(Group::Mechanics) };
        match group.get_ref().as_str() {
            "mechanics" => Ok(Group::Mechanics),
            "gas" => Ok(Group::Gas),
            "sensing" => Ok(Group::Sensing),
            other => {
                let message =
                    format!("there is no group `{other}`; there are mechanics, gas, sensing");
                Err(self.fail(group.span().start, message))
            }
        }
    }

    /// The places of the acts.
    fn places(
        &self,
        acts: &[(Spanned<String>, Spanned<String>)],
    ) -> Result<Vec<usize>, ExpressionError> {
        let known: Vec<&str> = self.language.places.iter().map(|p| p.name.as_str()).collect();
        let place = |(name, _): &(Spanned<String>, Spanned<String>)| {
            let word = name.get_ref();
            known.iter().position(|p| p == word).ok_or_else(|| {
                let near = nearest(word, known.iter().copied())
                    .map_or(String::new(), |near| format!("; did you mean `{near}`?"));
                let all = known.join(", ");
                let message = format!("nothing acts on `{word}`{near}; there are {all}");
                self.fail(name.span().start, message)
            })
        };
        acts.iter().map(place).collect()
    }

    fn parameter(
        &self,
        name: String,
        raw: RawParameter,
    ) -> Result<ParameterDefinition, ExpressionError> {
        let (range, at) = (*raw.range.get_ref(), raw.range.span().start);
        let [low, high] = range;
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Err(self
                .fail(at, format!("the range of `{name}` needs two numbers, the smaller first")));
        }
        if raw.log && low <= 0.0 {
            return Err(self.fail(
                at,
                format!("`{name}` is fitted by its logarithm; its range must be positive"),
            ));
        }
        if let Some(absent) = &raw.absent
            && !(low..=high).contains(absent.get_ref())
        {
            let message = format!("`absent` of `{name}` is outside its range");
            return Err(self.fail(absent.span().start, message));
        }
        let mut starts = Vec::new();
        for start in raw.start {
            let span = start.span();
            let formula = match start.into_inner() {
                Number::Number(value) => number(value),
                Number::Text(text) => {
                    let scope = Scope::of(&self.language.scales);
                    self.parse(&Spanned::new(span, text), &scope)?
                }
            };
            starts.push(formula);
        }
        let (meaning, logarithmic) = (raw.meaning.trim().to_owned(), raw.log);
        let absent = raw.absent.map(Spanned::into_inner);
        let not_below = None;
        Ok(ParameterDefinition { name, meaning, range, logarithmic, absent, not_below, starts })
    }

    /// The index of the parameter that is a lower bound of the one at `place`.
    fn lower_bound(
        &self,
        parameters: &[ParameterDefinition],
        place: usize,
        bound: &Spanned<String>,
    ) -> Result<usize, ExpressionError> {
        let other = bound.get_ref();
        let others = || parameters.iter().enumerate().filter(|(k, _)| *k != place);
        others().find(|(_, p)| p.name == *other).map(|(k, _)| k).ok_or_else(|| {
            let near = nearest(other, others().map(|(_, p)| p.name.as_str()))
                .map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            let message = format!(
                "`not_below` of `{}` names another parameter of the effect; `{other}` is none{near}",
                parameters[place].name
            );
            self.fail(bound.span().start, message)
        })
    }

    fn lets(
        &self,
        effect: &mut EffectDefinition,
        lets: Vec<(Spanned<String>, Spanned<String>)>,
    ) -> Result<Vec<Uses>, ExpressionError> {
        let mut uses: Vec<Uses> = Vec::new();
        for (name, text) in lets {
            let formula = self.formula(effect, &uses, &text, Position::Let)?;
            let mut own =
                Uses { size: written_out(effect, &uses, &formula.tree), ..Uses::default() };
            formula.tree.visit(&mut |part| match part {
                Expression::Call(Function::Network, _) => own.network = true,
                Expression::Name(k) => match effect.symbol(*k) {
                    Symbol::Variable(k) => own.variables.push(k),
                    Symbol::Memory(_) => own.memory = true,
                    Symbol::Value(_) => {}
                    Symbol::Let(k) => {
                        own.variables.extend(&uses[k].variables);
                        own.memory |= uses[k].memory;
                        own.network |= uses[k].network;
                    }
                },
                _ => {}
            });
            own.variables.sort_unstable();
            own.variables.dedup();
            let word = self.name(&name, &effect.names)?;
            effect.names.push(word.clone());
            effect.lets.push((word, formula));
            uses.push(own);
        }
        Ok(uses)
    }

    /// Starting values of parameters without `start`: scales over their range, amplitudes at the value at which they are
    /// absent, or near it where the derivative by another parameter would vanish there.
    fn default_starts(&self, effect: &mut EffectDefinition, given: &[usize]) {
        let rough = self.language.places.iter().position(|p| p.name == "dry_friction_n");
        let shaped = effect.parameters.iter().any(|p| p.absent.is_none())
            || effect.acts.iter().any(|(k, _)| Some(*k) == rough);
        for (parameter, given) in effect.parameters.iter_mut().zip(given) {
            if *given > 0 {
                continue;
            }
            let [low, high] = parameter.range;
            let shares = [0.25, 0.5, 0.75];
            let starts = match parameter.absent {
                Some(absent) if shaped => {
                    let end = if high > absent { high } else { low };
                    vec![absent + 0.02 * (end - absent)]
                }
                Some(absent) => vec![absent],
                None if parameter.logarithmic => {
                    shares.map(|s| low * (high / low).powf(s)).to_vec()
                }
                None => shares.map(|s| low + s * (high - low)).to_vec(),
            };
            parameter.starts = starts.into_iter().map(number).collect();
        }
    }
}

/// Operations and operands of a tree with its named parts written out.
fn written_out(effect: &EffectDefinition, uses: &[Uses], tree: &Expression) -> usize {
    let mut size = 0_usize;
    tree.visit(&mut |part| {
        let own = match part {
            Expression::Name(k) => match effect.symbol(*k) {
                Symbol::Let(k) => uses[k].size,
                _ => 1,
            },
            _ => 1,
        };
        size = size.saturating_add(own);
    });
    size
}

fn number(value: f64) -> Formula {
    let tree = if value < 0.0 {
        Expression::Negative(Box::new(Expression::Number(-value)))
    } else {
        Expression::Number(value)
    };
    Formula { text: format!("{value:?}"), tree }
}
