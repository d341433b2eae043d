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

/// One number: from those before it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    Constant(f64),
    Scale(f64, u16),
    Offset(f64, u16),
    One(Unary, u16),
    Add(u16, u16),
    Subtract(u16, u16),
    Multiply(u16, u16),
    Divide(u16, u16),
    Two(Dyadic, u16, u16),
    Choice(u16, u16, u16),
}

/// Expressions whose values and slopes are found with plain numbers.
#[derive(Debug, Clone)]
pub(crate) struct Slopes {
    /// The inputs; their numbers come first.
    inputs: Vec<u32>,
    steps: Vec<Step>,
    outputs: Vec<u16>,
}

/// Numbers of short, longer and the longest lists: all are cleared before each evaluation.
const FEW: usize = 32;
const SOME: usize = 128;
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
        let (inputs, rest): (Vec<usize>, Vec<usize>) =
            (0..graph.nodes.len()).filter(|id| needed[*id]).partition(is_input);
        if inputs.len() + rest.len() > MOST {
            return None;
        }
        let mut place = vec![0_u16; graph.nodes.len()];
        for (k, &id) in inputs.iter().chain(&rest).enumerate() {
            place[id] = k as u16;
        }
        let step = |&id: &usize| match graph.nodes[id] {
            Node::Input(_) | Node::Two(Dyadic::Network, ..) => None,
            Node::Constant(bits) => Some(Step::Constant(f64::from_bits(bits))),
            Node::One(Unary::Scale(bits), a) => Some(Step::Scale(f64::from_bits(bits), place[a])),
            Node::One(Unary::Offset(bits), a) => Some(Step::Offset(f64::from_bits(bits), place[a])),
            Node::One(function, a) => Some(Step::One(function, place[a])),
            Node::Two(Dyadic::Add, a, b) => Some(Step::Add(place[a], place[b])),
            Node::Two(Dyadic::Subtract, a, b) => Some(Step::Subtract(place[a], place[b])),
            Node::Two(Dyadic::Multiply, a, b) => Some(Step::Multiply(place[a], place[b])),
            Node::Two(Dyadic::Divide, a, b) => Some(Step::Divide(place[a], place[b])),
            Node::Two(function, a, b) => Some(Step::Two(function, place[a], place[b])),
            Node::Choice(a, b, c) => Some(Step::Choice(place[a], place[b], place[c])),
        };
        let input = |&id: &usize| match graph.nodes[id] {
            Node::Input(k) => Some(k as u32),
            _ => None,
        };
        Some(Self {
            inputs: inputs.iter().filter_map(input).collect(),
            steps: rest.iter().map(step).collect::<Option<_>>()?,
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
            *value = inputs.input(k as usize).real();
        }
        self.forward(&mut values);
        for (out, &output) in out.iter_mut().zip(&self.outputs) {
            let at = output as usize & (N - 1);
            let mut slopes = [0.0; N];
            slopes[at] = 1.0;
            self.backward(&values, &mut slopes, at);
            *out = S::constant(values[at]);
            for (slope, &k) in slopes.iter().zip(&self.inputs) {
                if *slope != 0.0 {
                    out.add_along(&inputs.input(k as usize), *slope);
                }
            }
        }
    }

    #[inline(always)]
    fn forward<const N: usize>(&self, values: &mut [f64; N]) {
        // Every index is below N as it is; the compiler sees it by the mask.
        let within = |k: u16| k as usize & (N - 1);
        for (k, step) in (self.inputs.len()..).zip(&self.steps) {
            let v = |k: u16| values[within(k)];
            values[k & (N - 1)] = match *step {
                Step::Constant(value) => value,
                Step::Scale(factor, a) => v(a) * factor,
                Step::Offset(value, a) => v(a) + value,
                Step::One(Unary::Abs, a) => v(a).abs(),
                Step::One(Unary::Square, a) => v(a) * v(a),
                Step::One(function, a) => unary(function, &v(a)),
                Step::Add(a, b) => v(a) + v(b),
                Step::Subtract(a, b) => v(a) - v(b),
                Step::Multiply(a, b) => v(a) * v(b),
                Step::Divide(a, b) => v(a) / v(b),
                Step::Two(Dyadic::Maximum, a, b) => Scalar::maximum(v(a), v(b)),
                Step::Two(Dyadic::Minimum, a, b) => Scalar::minimum(v(a), v(b)),
                Step::Two(function, a, b) => dyadic(function, &v(a), &v(b)),
                Step::Choice(a, b, c) => v(if v(a) == 0.0 { c } else { b }),
            };
        }
    }

    /// The slopes of the number at `last` by all numbers before it.
    #[inline(always)]
    fn backward<const N: usize>(&self, values: &[f64; N], slopes: &mut [f64; N], last: usize) {
        let within = |k: u16| k as usize & (N - 1);
        let first = self.inputs.len();
        let upto = (last + 1).saturating_sub(first);
        for (k, step) in self.steps[..upto].iter().enumerate().rev() {
            let k = (first + k) & (N - 1);
            let own = slopes[k];
            if own == 0.0 {
                continue;
            }
            let v = |k: u16| values[within(k)];
            let mut add = |k: u16, slope: f64| slopes[within(k)] += own * slope;
            match *step {
                Step::Constant(_) => {}
                Step::Scale(factor, a) => add(a, factor),
                Step::Offset(_, a) => add(a, 1.0),
                Step::One(function, a) => add(a, slope(function, v(a), values[k])),
                Step::Add(a, b) => {
                    add(a, 1.0);
                    add(b, 1.0);
                }
                Step::Subtract(a, b) => {
                    add(a, 1.0);
                    add(b, -1.0);
                }
                Step::Multiply(a, b) => {
                    add(a, v(b));
                    add(b, v(a));
                }
                Step::Divide(a, b) => {
                    let reciprocal = v(b).recip();
                    add(a, reciprocal);
                    add(b, -values[k] * reciprocal);
                }
                Step::Two(Dyadic::Maximum, a, b) => add(if v(b) > v(a) { b } else { a }, 1.0),
                Step::Two(Dyadic::Minimum, a, b) => add(if v(b) < v(a) { b } else { a }, 1.0),
                Step::Two(Dyadic::Less | Dyadic::LessEqual | Dyadic::Equal, ..) => {}
                Step::Two(function, a, b) => {
                    let seeded = |by_a: f64, by_b: f64| {
                        dyadic(function, &Dual64::new(v(a), by_a), &Dual64::new(v(b), by_b)).eps
                    };
                    let (by_a, by_b) = (seeded(1.0, 0.0), seeded(0.0, 1.0));
                    add(a, by_a);
                    add(b, by_b);
                }
                Step::Choice(a, b, c) => add(if v(a) == 0.0 { c } else { b }, 1.0),
            }
        }
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
        Unary::Sign | Unary::Step | Unary::Floor => 0.0,
        Unary::Scale(bits) => f64::from_bits(bits),
        Unary::Offset(_) => 1.0,
        _ => unary(function, &Dual64::new(a, 1.0)).eps,
    }
}
