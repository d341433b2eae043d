//! Values and derivatives of expressions against the same formulas in Rust, and terms of a field.

use num_dual::{Dual64, DualNum};
use pam_autodiff::Chunk;
use pam_core::{ParametricField, Scalar, VectorField, field_fn};
use pam_expression::{Compiled, Graph, Inputs, Program, Terms};
use pam_vocabulary::ParameterInfo;
use pam_vocabulary::expression::{Expression, Scope};

/// Expressions over a and b with the same in Rust.
type Case = (&'static str, fn(Dual64, Dual64) -> Dual64);

const CASES: [Case; 24] = [
    ("a - b - 1", |a, b| a - b - 1.0),
    ("a / b / 2", |a, b| a / b / 2.0),
    ("-a^2", |a, _| -(a * a)),
    ("2^-b", |_, b| (-b * 2.0_f64.ln()).exp()),
    ("a^3^0.5", |a, _| a.powf(3.0_f64.sqrt())),
    ("a^-2 + b^5", |a, b| a.powi(-2) + b.powi(5)),
    ("a^b", |a, b| (b * a.ln()).exp()),
    ("3 - 2 / (a + 1)", |a, _| -(a + 1.0).recip() * 2.0 + 3.0),
    ("abs(a - b) * sign(a - b)", |a, b| a - b),
    ("exp(a) - expm1(b)", |a, b| a.exp() - b.exp_m1()),
    ("log(a) + log1p(b) * sqrt(a * b)", |a, b| a.ln() + b.ln_1p() * (a * b).sqrt()),
    ("sin(a) * cos(b) + tan(a / 9)", |a, b| a.sin() * b.cos() + (a / 9.0).tan()),
    ("asin(a / 9) + acos(b / 9) + atan(a * b)", |a, b| {
        (a / 9.0).asin() + (b / 9.0).acos() + (a * b).atan()
    }),
    ("sinh(a) + cosh(b) + tanh(a - b)", |a, b| a.sinh() + b.cosh() + (a - b).tanh()),
    ("atan2(a, b)", |a, b| a.atan2(b)),
    ("min(a, b, 1.3) + max(a, 2 * b)", |a, b| {
        a.minimum(b).minimum(Dual64::from(1.3)) + a.maximum(b * 2.0)
    }),
    ("clamp(a * b, 0.5, 2)", |a, b| (a * b).clamped(Dual64::from(0.5), Dual64::from(2.0))),
    ("if(a < b, a * b, a / b)", |a, b| if a.re < b.re { a * b } else { a / b }),
    ("step(a - b) * b + (a >= b) * a", |a, b| if a.re >= b.re { a + b } else { Dual64::from(0.0) }),
    ("(a != b) + (a == b) + floor(a) * b", |a, b| b * a.re.floor() + 1.0),
    ("pi * a + p_atm", |a, _| a * std::f64::consts::PI + 101.325),
    ("1e-3 * a + 2.5E2*b - .5", |a, b| a * 1e-3 + b * 250.0 - 0.5),
    ("a * b + b * a - (a * b) * 2", |_, _| Dual64::from(0.0)),
    ("(a <= b) * (a + b)", |a, b| if a.re <= b.re { a + b } else { Dual64::from(0.0) }),
];

const POINTS: [[f64; 2]; 4] = [[0.7, 1.9], [2.3, 0.4], [1.1, 1.1], [0.31, 0.62]];

/// The value, the derivative in dual numbers and the differentiated expression are those of the formula.
#[test]
fn expressions_are_their_formulas() {
    let names = ["a".to_owned(), "b".to_owned()];
    for (text, formula) in CASES {
        let compiled = Compiled::new(text, &["a", "b"]).expect(text);
        let tree = Expression::parse(text, &Scope::of(&names)).expect(text);
        let mut graph = Graph::default();
        let value = graph.expression(&tree, &mut |graph, k| graph.input(k));
        let slopes = [0, 1].map(|k| graph.derivative(value, k).expect("no `network`"));
        let program = Program::new(&graph, &slopes).expect("it is short");
        for [a, b] in POINTS {
            let mut differentiated = [0.0; 2];
            program.values(&&[a, b][..], &mut differentiated);
            for (k, by_rules) in differentiated.into_iter().enumerate() {
                let seed =
                    |value: f64, j: usize| Dual64::new(value, if j == k { 1.0 } else { 0.0 });
                let (a, b) = (seed(a, 0), seed(b, 1));
                let (own, expected) = (compiled.value(&[a, b]), formula(a, b));
                let near = |x: f64, y: f64| (x - y).abs() <= 1e-12 * (1.0 + y.abs());
                assert!(near(own.re, expected.re), "{text} at {a}, {b}: {own} not {expected}");
                // On a tie of `min` and the like there are two derivatives.
                if a.re != b.re {
                    assert!(
                        near(own.eps, expected.eps),
                        "{text} at {a}, {b}: {own} not {expected}"
                    );
                    assert!(near(by_rules, expected.eps), "{text} at {a}, {b}, by {k}: {by_rules}");
                }
            }
        }
    }
}

/// Numbers with several derivatives, whose slopes are swept back, are the formula's in dual numbers, also on ties and kinks that have
/// one derivative; expressions with several outputs too.
#[test]
fn several_derivatives_at_once_are_those_of_dual_numbers() {
    let names = ["a".to_owned(), "b".to_owned()];
    let mut graph = Graph::default();
    let mut outputs = Vec::new();
    for (text, _) in CASES {
        let tree = Expression::parse(text, &Scope::of(&names)).expect(text);
        outputs.push(graph.expression(&tree, &mut |graph, k| graph.input(k)));
    }
    let program = Program::new(&graph, &outputs).expect("it is short enough");
    for [a, b] in POINTS {
        // Three directions, of which the last moves both.
        let (x, y) = (Chunk::new(a, [1.0, 0.0, 0.3]), Chunk::new(b, [0.0, 1.0, -2.0]));
        let mut together = [Chunk::<3>::constant(0.0); CASES.len()];
        program.values(&&[x, y][..], &mut together);
        for ((text, formula), own) in CASES.iter().zip(together) {
            let alone = Compiled::new(text, &["a", "b"]).expect(text).value(&[x, y]);
            assert_eq!((own.value, own.derivatives), (alone.value, alone.derivatives), "{text}");
            for (k, derivative) in own.derivatives.into_iter().enumerate() {
                let seeded = |c: Chunk<3>| Dual64::new(c.value, c.derivatives[k]);
                let expected = formula(seeded(x), seeded(y));
                let near = |x: f64, y: f64| (x - y).abs() <= 1e-12 * (1.0 + y.abs());
                assert!(near(own.value, expected.re), "{text} at {a}, {b}");
                if a != b {
                    assert!(near(derivative, expected.eps), "{text} at {a}, {b}: {own}");
                }
            }
        }
    }
}

/// What cannot be an expression is refused at its place, and nothing overflows.
#[test]
fn wrong_texts_are_refused_where_they_are_wrong() {
    let deep = format!("{}a{}", "(".repeat(900), ")".repeat(900));
    let long = vec!["a"; 3000].join("+");
    for (text, column, word) in [
        ("a +", 4, "expected"),
        ("a b", 3, "not expected"),
        ("a < b < a", 7, "chained"),
        ("a = b", 3, "=="),
        ("a $ b", 3, "meaning"),
        ("2a", 2, "not expected"),
        ("1e999", 1, "too large"),
        ("1.2.3", 1, "no number"),
        ("sin", 1, "function"),
        ("a(b)", 1, "multiply"),
        ("sqrt(a, b)", 1, "1 argument,"),
        ("network(a, b)", 1, "no function"),
        ("aa", 1, "did you mean `a`"),
        ("", 1, "expected"),
        (&deep, 101, "nested"),
        (&long, 2001, "more than"),
    ] {
        let error = Compiled::new(text, &["a", "b"]).expect_err("it is wrong");
        let shown = &text[..text.len().min(20)];
        assert!(error.column == column && error.message.contains(word), "{shown}: {error}");
    }
}

/// A field with terms is the field that has them written into it, in every number.
#[test]
fn terms_are_part_of_a_field() {
    let bare = field_fn!([4.0], 1 => 2, |_t, y, u, p, dy| {
        dy[0] = y[1];
        dy[1] = u[0] - p[0] * y[0];
    });
    let whole = field_fn!([4.0, 0.3, 0.2, 1.5], 1 => 2, |t, y, u, p, dy| {
        dy[0] = y[1] + p[1] * u[0];
        dy[1] = u[0] - p[0] * y[0] - p[1] * y[0].powi(3) + p[2] * (p[3] * S::constant(t)).sin();
    });
    let info = |name| ParameterInfo::linear(name, [0.0, 10.0]);
    let terms = Terms::new(&["x", "v"], &["u"])
        .term("spring", &[(info("c"), 0.1)], &[("v", "-c * x^3"), ("x", "c * u")])
        .and_then(|terms| {
            let rate = ParameterInfo::scale("rate", [0.1, 10.0]);
            terms.term(
                "shaker",
                &[(info("force"), 0.1), (rate, 1.0)],
                &[("v", "force * sin(rate * t)")],
            )
        })
        .expect("they can be read");
    let field = terms.onto(bare);
    assert_eq!(field.parameters(), [4.0, 0.0, 0.0, 1.0]);
    assert_eq!(field.names().parameter(2), "shaker.force");
    let parameters = [4.0, 0.3, 0.2, 1.5];
    let with: Vec<Dual64> = parameters.iter().map(|p| Dual64::new(*p, 1.0)).collect();
    let (a, b) = (field.with_parameters(&with), whole.with_parameters(&with));
    let (y, u) = ([0.7, -0.2].map(Dual64::from), [1.3].map(Dual64::from));
    let mut rates = [[Dual64::from(0.0); 2]; 2];
    let mut work = vec![Dual64::from(0.0); VectorField::<Dual64>::work_len(&a)];
    a.eval_into(0.9, &y, &u, &mut rates[0], &mut work);
    b.eval_into(0.9, &y, &u, &mut rates[1], &mut []);
    for (own, expected) in rates[0].iter().zip(&rates[1]) {
        assert!((own.re - expected.re).abs() < 1e-14 && (own.eps - expected.eps).abs() < 1e-14);
    }
    let error = Terms::new(&["x"], &[]).term("t", &[], &[("w", "x")]).expect_err("no such state");
    assert!(error.message.contains("there are x"), "{error}");
}

/// A program reads what it needs and nothing else.
#[test]
fn programs_know_what_they_read() {
    struct Only;
    impl Inputs<f64> for Only {
        fn input(&self, index: usize) -> f64 {
            assert_eq!(index, 1, "the first name cancels");
            2.0
        }
    }
    let names = ["a".to_owned(), "b".to_owned()];
    let tree = Expression::parse("0 * a + b^2", &Scope::of(&names)).expect("it is right");
    let mut graph = Graph::default();
    let id = graph.expression(&tree, &mut |graph, k| graph.input(k));
    let program = Program::new(&graph, &[id]).expect("it is short");
    assert!(program.reads(1) && !program.reads(0));
    assert_eq!(program.value(&Only), 4.0);
}

/// Where a root of zero is chosen, the operand that was not chosen has no slope, although the root's is infinite.
#[test]
fn what_is_not_chosen_has_no_slope() {
    for text in ["sqrt(max(a - 1, 0))", "sqrt(-min(1 - a, 0))", "sqrt(if(a > 1, a - 1, 0))"] {
        let program = Compiled::new(text, &["a", "b"]).expect(text);
        let inputs = [Chunk::<2>::variable(0.5, 0), Chunk::<2>::variable(2.0, 1)];
        let value = program.value(&inputs);
        assert_eq!((value.value, value.derivatives), (0.0, [0.0; 2]), "{text}");
        let inputs = [Chunk::<2>::variable(5.0, 0), Chunk::<2>::variable(2.0, 1)];
        let value = program.value(&inputs);
        assert_eq!((value.value, value.derivatives), (2.0, [0.25, 0.0]), "{text}");
    }
}
