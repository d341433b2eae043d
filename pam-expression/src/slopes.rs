//! A graph as a list of plain numbers, differentiated backwards.
//!
//! Numbers with several first derivatives take many operations in each instruction of a [`Program`](crate::Program), most of them
//! for inputs that have no derivative. Here the values are worked out with plain numbers, the slopes by all inputs in one sweep
//! back, and the derivatives of the inputs are added up once (reverse accumulation at the expression, forward mode outside of it;
//! Griewank and Walther 2008, section 3).

use crate::graph::{Dyadic, Graph, Id, Node, Unary};
use crate::program::{Inputs, dyadic, operands, unary};
use num_dual::Dual64;
use pam_core::Scalar;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// The operation of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Operation {
    Constant,
    Scale,
    Offset,
    One(Unary),
    Add,
    Subtract,
    Multiply,
    Divide,
    Two(Dyadic),
    Choice,
}

/// One number: from those before it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    a: u16,
    b: u16,
    c: u16,
    /// The constant, the scale factor or the offset; zero for other operations.
    number: f64,
}

/// Consecutive steps with the same operation, which is dispatched once for all of them.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Run {
    operation: Operation,
    steps: usize,
}

/// Expressions whose values and slopes are found with plain numbers.
#[derive(Debug, Clone)]
pub(crate) struct Slopes {
    /// The inputs; their numbers come first.
    inputs: Vec<u32>,
    runs: Vec<Run>,
    steps: Vec<Step>,
    outputs: Vec<u16>,
}

/// Numbers of short, longer and the longest lists: all are cleared before each evaluation.
const FEW: usize = 32;
const SOME: usize = 128;
const MANY: usize = 256;
const MOST: usize = 512;

impl Slopes {
    /// The list of these nodes; `None` if it is too long, or calls a function whose slopes it does not know.
    pub(crate) fn new(graph: &Graph, outputs: &[Id]) -> Option<Self> {
        let mut needed = vec![false; graph.nodes.len()];
        outputs.iter().for_each(|&id| needed[id] = true);
        for id in (0..graph.nodes.len()).rev() {
            if needed[id] {
                operands(graph.nodes[id]).into_iter().flatten().for_each(|a| needed[a] = true);
            }
        }
        let is_input = |id: &usize| matches!(graph.nodes[*id], Node::Input(_));
        let (inputs, mut rest): (Vec<usize>, Vec<usize>) =
            (0..graph.nodes.len()).filter(|id| needed[*id]).partition(is_input);
        if inputs.len() + rest.len() > MOST {
            return None;
        }
        // Steps that do not depend on each other are grouped by operation.
        let mut level = vec![0_usize; graph.nodes.len()];
        let mut operations: Vec<Operation> = Vec::new();
        let mut operation_of = vec![0_usize; graph.nodes.len()];
        for &id in &rest {
            let operation = operation(graph.nodes[id])?;
            let known = operations.iter().position(|o| *o == operation);
            operation_of[id] = known.unwrap_or(operations.len());
            if known.is_none() {
                operations.push(operation);
            }
            let before = operands(graph.nodes[id]).into_iter().flatten().map(|a| level[a]);
            level[id] = before.max().map_or(0, |deepest| deepest + 1);
        }
        rest.sort_by_key(|&id| (level[id], operation_of[id]));
        let mut place = vec![0_u16; graph.nodes.len()];
        for (k, &id) in inputs.iter().chain(&rest).enumerate() {
            place[id] = k as u16;
        }
        let step = |&id: &usize| {
            let node = graph.nodes[id];
            let [a, b, c] = operands(node).map(|operand| operand.map_or(0, |a| place[a]));
            let number = match node {
                Node::Constant(bits) => f64::from_bits(bits),
                Node::One(Unary::Scale(bits) | Unary::Offset(bits), _) => f64::from_bits(bits),
                _ => 0.0,
            };
            Step { a, b, c, number }
        };
        let mut runs: Vec<Run> = Vec::new();
        for &id in &rest {
            let operation = operations[operation_of[id]];
            match runs.last_mut() {
                Some(run) if run.operation == operation => run.steps += 1,
                _ => runs.push(Run { operation, steps: 1 }),
            }
        }
        let input = |&id: &usize| match graph.nodes[id] {
            Node::Input(k) => Some(k as u32),
            _ => None,
        };
        Some(Self {
            inputs: inputs.iter().filter_map(input).collect(),
            runs,
            steps: rest.iter().map(step).collect(),
            outputs: outputs.iter().map(|&id| place[id]).collect(),
        })
    }

    /// As many outputs as `out` has room for.
    pub(crate) fn values<S: Scalar>(&self, inputs: &impl Inputs<S>, out: &mut [S]) {
        let count = self.inputs.len() + self.steps.len();
        if count <= FEW {
            self.run::<FEW, S>(inputs, out);
        } else if count <= SOME {
            self.run::<SOME, S>(inputs, out);
        } else if count <= MANY {
            self.run::<MANY, S>(inputs, out);
        } else {
            self.run::<MOST, S>(inputs, out);
        }
    }

    fn run<const N: usize, S: Scalar>(&self, inputs: &impl Inputs<S>, out: &mut [S]) {
        arch().dispatch(Running::<N, _, _> { slopes: self, inputs, out });
    }

    #[inline(always)]
    fn evaluate<const N: usize, S: Scalar>(&self, inputs: &impl Inputs<S>, out: &mut [S]) {
        const { assert!(N.is_power_of_two()) };
        let mut values = [0.0; N];
        for (value, &k) in values.iter_mut().zip(&self.inputs) {
            *value = inputs.real(k as usize);
        }
        self.forward(&mut values);
        for (out, &output) in out.iter_mut().zip(&self.outputs) {
            let at = output as usize & (N - 1);
            *out = S::constant(values[at]);
            if S::NDERIV == 0 {
                continue;
            }
            let mut slopes = [0.0; N];
            slopes[at] = 1.0;
            self.backward(&values, &mut slopes);
            for (slope, &k) in slopes.iter().zip(&self.inputs) {
                if *slope != 0.0 {
                    inputs.add_along(k as usize, *slope, out);
                }
            }
        }
    }

    #[inline(always)]
    fn forward<const N: usize>(&self, values: &mut [f64; N]) {
        // Every index is below N as it is; the compiler sees it by the mask.
        let within = |k: u16| k as usize & (N - 1);
        let mut first = 0;
        for run in &self.runs {
            let steps = &self.steps[first..first + run.steps];
            let own = self.inputs.len() + first;
            first += run.steps;
            macro_rules! each {
                (|$step:ident, $v:ident| $value:expr) => {
                    for (k, $step) in (own..).zip(steps) {
                        let $v = |k: u16| values[within(k)];
                        values[k & (N - 1)] = $value;
                    }
                };
            }
            match run.operation {
                Operation::Constant => each!(|s, _v| s.number),
                Operation::Scale => each!(|s, v| v(s.a) * s.number),
                Operation::Offset => each!(|s, v| v(s.a) + s.number),
                Operation::One(Unary::Abs) => each!(|s, v| v(s.a).abs()),
                Operation::One(Unary::Square) => each!(|s, v| v(s.a) * v(s.a)),
                Operation::One(function) => each!(|s, v| unary(function, &v(s.a))),
                Operation::Add => each!(|s, v| v(s.a) + v(s.b)),
                Operation::Subtract => each!(|s, v| v(s.a) - v(s.b)),
                Operation::Multiply => each!(|s, v| v(s.a) * v(s.b)),
                Operation::Divide => each!(|s, v| v(s.a) / v(s.b)),
                Operation::Two(Dyadic::Maximum) => {
                    each!(|s, v| Scalar::maximum(v(s.a), v(s.b)));
                }
                Operation::Two(Dyadic::Minimum) => {
                    each!(|s, v| Scalar::minimum(v(s.a), v(s.b)));
                }
                Operation::Two(function) => each!(|s, v| dyadic(function, &v(s.a), &v(s.b))),
                Operation::Choice => each!(|s, v| v(if v(s.a) == 0.0 { s.c } else { s.b })),
            }
        }
    }

    /// The slopes of an output, whose own is 1, by all numbers before it.
    #[inline(always)]
    fn backward<const N: usize>(&self, values: &[f64; N], slopes: &mut [f64; N]) {
        let within = |k: u16| k as usize & (N - 1);
        let v = |k: u16| values[within(k)];
        let mut last = self.steps.len();
        for run in self.runs.iter().rev() {
            let first = last - run.steps;
            let steps = &self.steps[first..last];
            let own = self.inputs.len() + first;
            last = first;
            // A zero slope is skipped: the derivative of the operation may be infinite there.
            macro_rules! each {
                (|$step:ident, $value:ident| $(($operand:ident, $slope:expr)),*) => {
                    for (k, $step) in steps.iter().enumerate().rev() {
                        let k = (own + k) & (N - 1);
                        let (slope, $value) = (slopes[k], values[k]);
                        if slope != 0.0 {
                            $(slopes[within($step.$operand)] += slope * $slope;)*
                        }
                    }
                };
            }
            // Only the selected operand gets the slope: zero times an infinite slope would be NaN.
            macro_rules! to_one {
                (|$step:ident| $operand:expr) => {
                    for (k, $step) in steps.iter().enumerate().rev() {
                        let slope = slopes[(own + k) & (N - 1)];
                        if slope != 0.0 {
                            slopes[within($operand)] += slope;
                        }
                    }
                };
            }
            match run.operation {
                Operation::Constant
                | Operation::Two(Dyadic::Less | Dyadic::LessEqual | Dyadic::Equal) => {}
                Operation::Scale => each!(|s, _y| (a, s.number)),
                Operation::Offset => each!(|s, _y| (a, 1.0)),
                Operation::One(function) => each!(|s, y| (a, slope(function, v(s.a), y))),
                Operation::Add => each!(|s, _y| (a, 1.0), (b, 1.0)),
                Operation::Subtract => {
                    let [one, less] = [1.0, -1.0];
                    each!(|s, _y| (a, one), (b, less));
                }
                Operation::Multiply => each!(|s, _y| (a, v(s.b)), (b, v(s.a))),
                Operation::Divide => each!(|s, y| (a, v(s.b).recip()), (b, -y * v(s.b).recip())),
                Operation::Two(Dyadic::Maximum) => {
                    to_one!(|s| if v(s.b) > v(s.a) { s.b } else { s.a });
                }
                Operation::Two(Dyadic::Minimum) => {
                    to_one!(|s| if v(s.b) < v(s.a) { s.b } else { s.a });
                }
                Operation::Two(function) => {
                    let seeded = |s: &Step, by_a: f64, by_b: f64| {
                        dyadic(function, &Dual64::new(v(s.a), by_a), &Dual64::new(v(s.b), by_b)).eps
                    };
                    each!(|s, _y| (a, seeded(s, 1.0, 0.0)), (b, seeded(s, 0.0, 1.0)));
                }
                Operation::Choice => to_one!(|s| if v(s.a) == 0.0 { s.c } else { s.b }),
            }
        }
    }
}

/// The operation of a node; `None` for inputs and functions whose derivative is unknown.
fn operation(node: Node) -> Option<Operation> {
    match node {
        Node::Input(_) | Node::Two(Dyadic::Network, ..) => None,
        Node::Constant(_) => Some(Operation::Constant),
        Node::One(Unary::Scale(_), _) => Some(Operation::Scale),
        Node::One(Unary::Offset(_), _) => Some(Operation::Offset),
        Node::One(function, _) => Some(Operation::One(function)),
        Node::Two(Dyadic::Add, ..) => Some(Operation::Add),
        Node::Two(Dyadic::Subtract, ..) => Some(Operation::Subtract),
        Node::Two(Dyadic::Multiply, ..) => Some(Operation::Multiply),
        Node::Two(Dyadic::Divide, ..) => Some(Operation::Divide),
        Node::Two(function, ..) => Some(Operation::Two(function)),
        Node::Choice(..) => Some(Operation::Choice),
    }
}

/// An evaluation, for the vectors of this machine: the derivatives of the inputs are added in them.
struct Running<'r, const N: usize, I, S> {
    slopes: &'r Slopes,
    inputs: &'r I,
    out: &'r mut [S],
}

impl<const N: usize, I: Inputs<S>, S: Scalar> WithSimd for Running<'_, N, I, S> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, _: V) {
        self.slopes.evaluate::<N, S>(self.inputs, self.out);
    }
}

/// The slope of a function at `a`, where it has this value.
#[inline]
fn slope(function: Unary, a: f64, value: f64) -> f64 {
    match function {
        Unary::Negative => -1.0,
        Unary::Square => 2.0 * a,
        Unary::Abs => 1.0_f64.copysign(a),
        Unary::Exp => value,
        Unary::Tanh => 1.0 - value * value,
        Unary::Reciprocal => -value * value,
        Unary::Sign | Unary::Step | Unary::Floor => 0.0,
        Unary::Scale(bits) => f64::from_bits(bits),
        Unary::Offset(_) => 1.0,
        _ => unary(function, &Dual64::new(a, 1.0)).eps,
    }
}
