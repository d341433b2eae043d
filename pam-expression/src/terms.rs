//! Expressions that are added to the rates of a vector field.

use crate::compiled::too_long;
use crate::graph::Graph;
#[cfg(feature = "files")]
use crate::graph::Id;
use crate::program::{Inputs, Program};
use pam_core::{DryFriction, FieldNames, ParametricField, Scalar, VectorField};
use pam_vocabulary::ParameterInfo;
use pam_vocabulary::expression::{Expression, ExpressionError, Scope};
use std::sync::Arc;

/// A term of a field: what it adds to the rates of states, and its parameters.
#[derive(Debug, Clone)]
pub struct Term {
    /// Name.
    pub name: String,
    /// Parameters.
    pub parameters: Vec<ParameterInfo>,
    /// Values from which a fit may start.
    pub starts: Vec<Vec<f64>>,
    /// States, and what is added to their rates, in this order.
    states: Vec<usize>,
    program: Program,
}

/// Terms for fields with these states and inputs.
///
/// The expressions know the states, the inputs, the time `t` and the parameters of the term, by their names:
///
/// ```
/// use pam_core::{ParametricField, VectorField, field_fn};
/// use pam_expression::Terms;
/// use pam_vocabulary::ParameterInfo;
///
/// // ẍ = u − 4 x, and a spring that hardens, which may be missing in it.
/// let field = field_fn!([4.0], 1 => 2, |_t, y, u, p, dy| {
///     dy[0] = y[1];
///     dy[1] = u[0] - p[0] * y[0];
/// });
/// let cubic = ParameterInfo::linear("cubic_1_mm2s2", [0.0, 10.0]);
/// let terms = Terms::new(&["x", "v"], &["u"])
///     .term("hardening", &[(cubic, 0.1)], &[("v", "-cubic_1_mm2s2 * x^3")])?;
/// let hardening = terms.onto(field);
/// assert_eq!(hardening.parameters(), [4.0, 0.0]);
/// let field = hardening.with_parameters(&[4.0, 0.5]);
/// let (mut dy, mut work) = ([0.0; 2], vec![0.0; field.work_len()]);
/// field.eval_into(0.0, &[2.0, 0.0], &[1.0], &mut dy, &mut work);
/// assert_eq!(dy, [0.0, 1.0 - 8.0 - 4.0]);
/// # Ok::<(), pam_vocabulary::expression::ExpressionError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Terms {
    states: Vec<String>,
    inputs: Vec<String>,
    terms: Vec<Term>,
}

impl Terms {
    /// No terms yet, for fields with these names of states and inputs.
    #[must_use]
    pub fn new(states: &[&str], inputs: &[&str]) -> Self {
        let owned = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
        Self { states: owned(states), inputs: owned(inputs), terms: Vec::new() }
    }

    /// The same with another term: its parameters, each with the value from which a fit starts, and what it adds to the rates
    /// of which states.
    ///
    /// # Errors
    /// [`ExpressionError`] for an expression that cannot be read, or a state that is not there.
    pub fn term(
        self,
        name: &str,
        parameters: &[(ParameterInfo, f64)],
        adds: &[(&str, &str)],
    ) -> Result<Self, ExpressionError> {
        let names: Vec<String> =
            self.variables().chain(parameters.iter().map(|(p, _)| p.name.to_owned())).collect();
        let mut graph = Graph::default();
        let (mut states, mut outputs) = (Vec::new(), Vec::new());
        for (state, text) in adds {
            let tree = Expression::parse(text, &Scope::of(&names))?;
            states.push(self.state(state).ok_or_else(|| {
                let message = format!("no state `{state}`; there are {}", self.states.join(", "));
                ExpressionError::at(text, 0, message)
            })?);
            outputs.push(graph.expression(&tree, &mut |graph, k| graph.input(k)));
        }
        let (parameters, start) = parameters.iter().copied().unzip();
        let program =
            Program::new(&graph, &outputs).ok_or_else(|| ExpressionError::at("", 0, too_long()))?;
        let name = name.to_owned();
        Ok(self.with(Term { name, parameters, starts: vec![start], states, program }))
    }

    /// Terms that a TOML file defines: effects whose places are `d_STATE`, what is added to the rate of a state.
    ///
    /// # Errors
    /// [`ExpressionError`] with line and column.
    #[cfg(feature = "files")]
    pub fn read(self, text: &str) -> Result<Self, ExpressionError> {
        use pam_vocabulary::definition::{EffectDefinition, Language, Symbol};
        let states: Vec<&str> = self.states.iter().map(String::as_str).collect();
        let inputs: Vec<&str> = self.inputs.iter().map(String::as_str).collect();
        let definitions = EffectDefinition::read_all(text, &Language::field(&states, &inputs))?;
        let mut all = self.clone();
        for definition in definitions {
            fn input(definition: &EffectDefinition, graph: &mut Graph, k: usize) -> Id {
                match definition.symbol(k) {
                    Symbol::Let(k) => graph
                        .expression(&definition.lets[k].1.tree, &mut |graph, k| {
                            input(definition, graph, k)
                        }),
                    _ => graph.input(k),
                }
            }
            let mut graph = Graph::default();
            let outputs: Vec<Id> = definition
                .acts
                .iter()
                .map(|(_, formula)| {
                    graph.expression(&formula.tree, &mut |graph, k| input(&definition, graph, k))
                })
                .collect();
            let program = Program::new(&graph, &outputs)
                .ok_or_else(|| ExpressionError::at(text, 0, too_long()))?;
            // The values of a field are its parameters; switches are tried by none.
            if let Some(switch) = definition.switches.first() {
                let message = format!("a term of a field has no switches, as `{}`", switch.name);
                return Err(ExpressionError::at(text, 0, message));
            }
            let mut starts = vec![Vec::new()];
            for parameter in &definition.parameters {
                let values: Vec<f64> =
                    parameter.starts.iter().filter_map(|s| number(&s.tree)).collect();
                let with = |row: &Vec<f64>| -> Vec<Vec<f64>> {
                    values.iter().map(|v| [row.as_slice(), &[*v]].concat()).collect()
                };
                starts = starts.iter().flat_map(with).collect();
            }
            all = all.with(Term {
                name: definition.id.clone(),
                parameters: definition.info().parameters.to_vec(),
                starts,
                states: definition.acts.iter().map(|(k, _)| *k).collect(),
                program,
            });
        }
        Ok(all)
    }

    fn with(mut self, term: Term) -> Self {
        self.terms.push(term);
        self
    }

    fn variables(&self) -> impl Iterator<Item = String> {
        self.states.iter().chain(&self.inputs).cloned().chain(["t".to_owned()])
    }

    fn state(&self, name: &str) -> Option<usize> {
        self.states.iter().position(|s| s == name)
    }

    /// A field with these terms, all of them absent: parameters have the value at which they contribute nothing, scales the
    /// first of their starting values. They follow the field's own.
    #[must_use]
    pub fn onto<F: ParametricField>(self, field: F) -> WithTerms<F> {
        let absent = |term: &Term| -> Vec<f64> {
            let start = term.starts.first();
            let value = |(k, p): (usize, &ParameterInfo)| {
                p.off.unwrap_or_else(|| start.map_or(p.range[0], |start| start[k]))
            };
            term.parameters.iter().enumerate().map(value).collect()
        };
        let values = self.terms.iter().flat_map(absent).collect();
        let known = [self.states.len(), self.inputs.len()];
        WithTerms { own: field.parameter_len(), field, known, terms: self.terms.into(), values }
    }
}

/// The number that an expression without names is.
#[cfg(feature = "files")]
fn number(tree: &Expression) -> Option<f64> {
    Some(crate::Compiled::of_tree(tree)?.value(&[]))
}

/// A field with terms.
#[derive(Debug, Clone)]
pub struct WithTerms<F, S = f64> {
    field: F,
    /// Number of the field's own parameters.
    own: usize,
    /// Number of states and of inputs that expressions know.
    known: [usize; 2],
    terms: Arc<[Term]>,
    values: Vec<S>,
}

impl<F> WithTerms<F> {
    /// The terms, and the index of the first parameter of each among those of the field.
    pub fn terms(&self) -> impl Iterator<Item = (usize, &Term)> {
        self.terms.iter().scan(self.own, |first, term| {
            let at = *first;
            *first += term.parameters.len();
            Some((at, term))
        })
    }
}

/// States, inputs, time and parameters of a term.
struct At<'a, S> {
    t: f64,
    y: &'a [S],
    u: &'a [S],
    p: &'a [S],
}

impl<S: Scalar> Inputs<S> for At<'_, S> {
    #[inline]
    fn input(&self, index: usize) -> S {
        let (y, u) = (self.y.len(), self.u.len());
        match index {
            k if k < y => self.y[k],
            k if k < y + u => self.u[k - y],
            k if k == y + u => S::constant(self.t),
            k => self.p[k - y - u - 1],
        }
    }
}

impl<S: Scalar, F: VectorField<S>> VectorField<S> for WithTerms<F, S> {
    fn state_len(&self) -> usize {
        self.field.state_len()
    }
    fn input_len(&self) -> usize {
        self.field.input_len()
    }
    fn work_len(&self) -> usize {
        self.field.work_len() + self.field.state_len()
    }
    fn eval_into(&self, t: f64, y: &[S], u: &[S], dy: &mut [S], work: &mut [S]) {
        let (added, work) = work.split_at_mut(self.field.state_len());
        self.field.eval_into(t, y, u, dy, work);
        let [states, inputs] = self.known;
        let mut values = self.values.as_slice();
        for term in self.terms.iter() {
            let (p, rest) = values.split_at(term.parameters.len());
            values = rest;
            let added = &mut added[..term.states.len()];
            term.program.values(&At { t, y: &y[..states], u: &u[..inputs], p }, added);
            for (&state, added) in term.states.iter().zip(added) {
                dy[state] += *added;
            }
        }
    }
    fn output_len(&self) -> usize {
        self.field.output_len()
    }
    fn outputs_into(&self, t: f64, y: &[S], u: &[S], out: &mut [S]) {
        self.field.outputs_into(t, y, u, out);
    }
}

impl<F: ParametricField> ParametricField for WithTerms<F> {
    type With<S: Scalar> = WithTerms<F::With<S>, S>;

    fn parameters(&self) -> Vec<f64> {
        [self.field.parameters(), self.values.clone()].concat()
    }

    fn parameter_len(&self) -> usize {
        self.own + self.values.len()
    }

    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S> {
        assert_eq!(parameters.len(), self.parameter_len(), "as many parameters as the field has");
        let (own, values) = parameters.split_at(self.own);
        WithTerms {
            field: self.field.with_parameters(own),
            own: self.own,
            known: self.known,
            terms: Arc::clone(&self.terms),
            values: values.to_vec(),
        }
    }

    fn names(&self) -> FieldNames {
        let mut names = self.field.names();
        names.parameters = (0..self.own).map(|k| names.parameter(k)).collect();
        let of = |term: &Term| -> Vec<String> {
            term.parameters.iter().map(|p| format!("{}.{}", term.name, p.name)).collect()
        };
        names.parameters.extend(self.terms.iter().flat_map(of));
        names
    }

    fn dry_friction(&self) -> Option<DryFriction> {
        self.field.dry_friction()
    }
}
