//! Every elementary function of every number type against its slope from a table of derivatives.

use num_dual::{Dual64, DualNum};
use num_traits::FromPrimitive;
use pam_autodiff::{
    Chunk, ComplexDifference, ComplexStep, DifferenceScheme, Function, Richardson, Tape, Var,
    gradient,
};
use pam_core::Scalar;
use std::f64::consts::{LN_2, LN_10};

/// A function of one variable, with its slope from the textbook.
struct Case {
    name: &'static str,
    function: Elementary,
    slope: fn(f64) -> f64,
    points: &'static [f64],
}

fn agree(found: f64, expected: f64, tolerance: f64, what: &str) {
    let scale = expected.abs().max(1e-290);
    assert!((found - expected).abs() <= tolerance * scale, "{what}: {found} is not {expected}");
}

fn check(case: &Case) {
    let Case { name, function, slope, points } = case;
    fn at<S: Scalar>(function: &Elementary, x: S) -> S {
        let mut out = [S::zero()];
        function.eval(&[x], &mut out);
        out[0]
    }
    for &x in *points {
        let what = format!("{name} at {x}");
        let (value, expected) = (at(function, x), slope(x));
        assert!(value.is_finite() && expected.is_finite(), "{what}: {value}, {expected}");

        let chunk = at(function, Chunk::new(x, [1.0, 0.0, -2.0]));
        assert_eq!(chunk.value, value, "{what}");
        agree(chunk.derivatives[0], expected, 4e-14, &what);
        agree(chunk.derivatives[2], -2.0 * expected, 4e-14, &what);
        assert_eq!(chunk.derivatives[1], 0.0, "{what}");

        agree(gradient(function, &[x])[0], expected, 4e-14, &what);
        let mut tape = Tape::<f64>::new();
        let var = tape.variable(x);
        assert_eq!(tape.record(|| at(function, var)).value(), value, "{what}");

        let complex = at(function, ComplexStep::new(x, 1e-40));
        agree(complex.re, value, 1e-12, &what);
        agree(complex.im / 1e-40, expected, 4e-14, &format!("complex step of {what}"));

        // First derivatives with an inner dual number, and second ones: forward over forward, and
        // forward over reverse.
        let nested = at(function, Chunk::<1, Dual64>::variable(Dual64::new(x, 1.0), 0));
        agree(nested.derivatives[0].re, expected, 4e-14, &what);
        let mut tape = Tape::<Dual64>::new();
        let var = tape.variable(Dual64::new(x, 1.0));
        let result = tape.record(|| at(function, var));
        let adjoint = tape.reverse([(result, Dual64::from_re(1.0))]).of(var);
        agree(adjoint.re, expected, 4e-14, &what);
        let richardson = Richardson { h: 4e-4 * x.abs().min(1.0), levels: 4 };
        let second = richardson.derivative(&mut { *slope }, x);
        if (0.05..5.0).contains(&x.abs()) {
            let scale = second.abs() + expected.abs() / x.abs();
            for found in [nested.derivatives[0].eps, adjoint.eps] {
                assert!((found - second).abs() < 1e-5 * scale, "{what}: {found} {second}");
            }
        }
    }
}

/// A float of the kind below `S`.
fn plain<S: Scalar>(value: f64) -> S::Primitive {
    S::Primitive::from_f64(value).unwrap()
}

/// All functions are one type, so that what differentiates them is instantiated once.
macro_rules! cases {
    ($($name:ident: |$x:ident| $body:expr, |$y:ident| $slope:expr, $points:expr;)+) => {
        #[allow(non_camel_case_types)]
        enum Elementary { $($name),+ }

        impl Function for Elementary {
            fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
                out[0] = match self {
                    $(Self::$name => {
                        let $x = x[0];
                        $body
                    })+
                };
            }
        }

        $(#[test]
        fn $name() {
            check(&Case {
                name: stringify!($name),
                function: Elementary::$name,
                slope: |$y: f64| $slope,
                points: &$points,
            });
        })+
    };
}

const EVERYWHERE: [f64; 9] = [-30.0, -2.5, -0.3, -1e-9, 1e-9, 1e-3, 0.7, 3.0, 40.0];
const POSITIVE: [f64; 6] = [1e-12, 1e-3, 0.4, 1.0, 7.0, 1e9];
const WITHIN_ONE: [f64; 7] = [-0.99, -0.5, -1e-8, 1e-8, 0.1, 0.6, 0.999];

cases! {
    plus: |x| x + x + S::constant(2.0) + plain::<S>(1.0), |_x| 2.0, EVERYWHERE;
    minus: |x| S::constant(2.0) - x - x * S::constant(3.0) - S::zero(), |_x| -4.0, EVERYWHERE;
    product: |x| x * x * x * plain::<S>(0.5), |x| 1.5 * x * x, EVERYWHERE;
    quotient: |x| (x * x + S::one()) / x / plain::<S>(2.0),
        |x| 0.5 * (1.0 - 1.0 / x / x), [-30.0, -2.5, -0.3, 1e-3, 0.7, 3.0, 40.0];
    negation: |x| -x, |_x| -1.0, EVERYWHERE;
    absolute: |x| x.abs(), |x| x.signum(), EVERYWHERE;
    remainder: |x| x % S::constant(0.75), |_x| 1.0, [-30.0, -2.5, -0.3, 0.7, 3.2, 40.0];
    remainder_of: |x| S::constant(7.3) % x, |x| -(7.3 / x).trunc(), [-2.5, -0.3, 0.7, 3.2, 40.0];
    recip: |x| x.recip(), |x| -1.0 / (x * x), EVERYWHERE;
    sqrt: |x| x.sqrt(), |x| 0.5 / x.sqrt(), POSITIVE;
    cbrt: |x| x.cbrt(), |x| 1.0 / (3.0 * x.cbrt().powi(2)), EVERYWHERE;
    exp: |x| x.exp(), |x| x.exp(), EVERYWHERE;
    exp2: |x| x.exp2(), |x| LN_2 * x.exp2(), EVERYWHERE;
    exp_m1: |x| x.exp_m1(), |x| x.exp(), EVERYWHERE;
    ln: |x| x.ln(), |x| 1.0 / x, POSITIVE;
    log: |x| x.log(plain::<S>(3.0)), |x| 1.0 / (x * 3.0_f64.ln()), POSITIVE;
    log2: |x| x.log2(), |x| 1.0 / (x * LN_2), POSITIVE;
    log10: |x| x.log10(), |x| 1.0 / (x * LN_10), POSITIVE;
    ln_1p: |x| x.ln_1p(), |x| 1.0 / (1.0 + x), [-0.999, -0.5, -1e-9, 1e-9, 0.3, 2.0, 1e9];
    sin: |x| x.sin(), |x| x.cos(), EVERYWHERE;
    cos: |x| x.cos(), |x| -x.sin(), EVERYWHERE;
    sin_cos: |x| { let (s, c) = x.sin_cos(); s * c }, |x| (2.0 * x).cos(),
        [-2.5, -0.3, -1e-9, 1e-9, 1e-3, 0.7, 3.0];
    tan: |x| x.tan(), |x| 1.0 / x.cos().powi(2), EVERYWHERE;
    asin: |x| x.asin(), |x| 1.0 / ((1.0 - x) * (1.0 + x)).sqrt(), WITHIN_ONE;
    acos: |x| x.acos(), |x| -1.0 / ((1.0 - x) * (1.0 + x)).sqrt(), WITHIN_ONE;
    atan: |x| x.atan(), |x| 1.0 / (1.0 + x * x), [-1e9, -30.0, -0.3, -1e-9, 1e-9, 0.7, 1.0, 40.0];
    atan2: |x| x.atan2(S::constant(-2.0)), |x| -2.0 / (x * x + 4.0), EVERYWHERE;
    atan2_of: |x| S::constant(-3.0).atan2(x), |x| 3.0 / (x * x + 9.0), EVERYWHERE;
    sinh: |x| x.sinh(), |x| x.cosh(), EVERYWHERE;
    cosh: |x| x.cosh(), |x| x.sinh(), EVERYWHERE;
    tanh: |x| x.tanh(), |x| 1.0 / x.cosh().powi(2),
        [-300.0, -19.0, -2.5, -0.3, -1e-9, 1e-9, 0.7, 21.0, 300.0];
    asinh: |x| x.asinh(), |x| 1.0 / x.hypot(1.0), EVERYWHERE;
    acosh: |x| x.acosh(), |x| 1.0 / ((x - 1.0) * (x + 1.0)).sqrt(), [1.001, 1.5, 7.0, 1e9];
    atanh: |x| x.atanh(), |x| 1.0 / ((1.0 - x) * (1.0 + x)), WITHIN_ONE;
    powi_0: |x| x.powi(0) + x, |_x| 1.0, EVERYWHERE;
    powi_5: |x| x.powi(5), |x| 5.0 * x.powi(4), EVERYWHERE;
    powi_negative: |x| x.powi(-3), |x| -3.0 * x.powi(-4), EVERYWHERE;
    powf: |x| x.powf(plain::<S>(2.7)), |x| 2.7 * x.powf(1.7), POSITIVE;
    powf_whole: |x| x.powf(plain::<S>(3.0)), |x| 3.0 * x * x, EVERYWHERE;
    powd: |x| S::constant(1.7).powd(x), |x| 1.7_f64.ln() * 1.7_f64.powf(x), EVERYWHERE;
    powd_both: |x| x.powd(x), |x| x.powf(x) * (x.ln() + 1.0), [1e-3, 0.4, 1.0, 7.0];
    softplus: |x| x.softplus(), |x| 1.0 / (1.0 + (-x).exp()), EVERYWHERE;
    softplus_inverse: |x| x.softplus_inverse(), |x| 1.0 / -(-x).exp_m1(), [1e-3, 0.4, 1.0, 40.0];
    sigmoid: |x| x.sigmoid(), |x| 0.25 / (0.5 * x).cosh().powi(2), EVERYWHERE;
    scaled: |x| x.scaled(-3.5), |_x| -3.5, EVERYWHERE;
    clamped: |x| x.clamped(S::constant(-1.0), S::constant(1.0)) + x,
        |x| if x.abs() < 1.0 { 2.0 } else { 1.0 }, EVERYWHERE;
    sum_and_product: |x| [x, x, S::one()].iter().copied().sum::<S>() * [x, x].into_iter().product::<S>(),
        |x| 6.0 * x * x + 2.0 * x, [-2.5, 1e-3, 0.7, 3.0];
    mul_add: |x| x.mul_add(x, x), |x| 2.0 * x + 1.0, [-2.5, 1e-3, 0.7, 3.0];
    sph_j0: |x| x.sph_j0(), |x| (x * x.cos() - x.sin()) / (x * x), [-30.0, -2.5, 1.3, 3.0, 40.0];
    sph_j1: |x| x.sph_j1(), |x| (x * x - 2.0) / x.powi(3) * x.sin() + 2.0 * x.cos() / (x * x),
        [-30.0, -2.5, 1.3, 3.0, 40.0];
    sph_j2: |x| x.sph_j2(),
        |x| ((9.0 * x - x.powi(3)) * x.cos() + (4.0 * x * x - 9.0) * x.sin()) / x.powi(4),
        [-30.0, -2.5, 2.0, 3.0, 40.0];
}

/// Near zero the closed forms of the spherical Bessel functions cancel; their slopes must not.
#[test]
fn spherical_bessel_slopes_are_exact_near_zero() {
    for x in [-0.4, -1e-5, 1e-12, 1e-3, 0.2] {
        let slope = |f: fn(&Chunk<1>) -> Chunk<1>| f(&Chunk::variable(x, 0)).derivatives[0];
        let series = |c: [f64; 4]| c.iter().rev().fold(0.0, |s, c| s * x * x + c);
        // j0' = −j1, j1' = 1/3 − x²/10 + …, j2' = 2x/15 − 2x³/105 + …
        let expected = [
            -x * series([1.0 / 3.0, -1.0 / 30.0, 1.0 / 840.0, -1.0 / 45360.0]),
            series([1.0 / 3.0, -0.1, 1.0 / 168.0, -1.0 / 6480.0]),
            x * series([2.0 / 15.0, -2.0 / 105.0, 1.0 / 1260.0, -1.0 / 62370.0]),
        ];
        agree(slope(DualNum::sph_j0), expected[0], 1e-8, "j0");
        agree(slope(DualNum::sph_j1), expected[1], 1e-8, "j1");
        agree(slope(DualNum::sph_j2), expected[2], 1e-8, "j2");
        let complex = ComplexDifference::default().derivative(DualNum::sph_j1, x);
        agree(complex, slope(DualNum::sph_j1), 1e-14, "complex j1");
    }
}

#[test]
fn both_arguments_of_two_argument_functions_count() {
    for (y, x) in [(0.3, 2.0), (3.0, -0.2), (-1e200, 1e199), (-4.0, -5.0), (0.5, 0.0)] {
        let (a, b) = (Chunk::<2>::variable(y, 0), Chunk::<2>::variable(x, 1));
        let angle = a.atan2(b);
        let (r2_y, r2_x) = (y + x * (x / y), x + y * (y / x));
        assert_eq!(angle.value, y.atan2(x));
        agree(angle.derivatives[0], if x == 0.0 { 0.0 } else { 1.0 / r2_x }, 1e-14, "y");
        agree(angle.derivatives[1], -1.0 / r2_y, 1e-14, "x");
    }
    let power = Chunk::<2>::variable(2.0, 0).powd(Chunk::variable(3.0, 1));
    assert_eq!(power.derivatives[0], 12.0);
    agree(power.derivatives[1], 8.0 * LN_2, 1e-15, "exponent");
    // A constant exponent goes with a negative base.
    let square = Chunk::<1>::variable(-3.0, 0).powd(Chunk::constant(2.0));
    assert_eq!((square.value, square.derivatives), (9.0, [-6.0]));
}

#[test]
fn complex_numbers_are_defined_where_the_real_functions_are() {
    type Unary = fn(&ComplexStep) -> ComplexStep;
    let undefined: [(Unary, f64); 7] = [
        (DualNum::ln, -1.0),
        (DualNum::sqrt, -1.0),
        (DualNum::asin, 1.5),
        (DualNum::acos, -1.5),
        (DualNum::acosh, 0.5),
        (DualNum::atanh, 1.5),
        (DualNum::ln_1p, -1.5),
    ];
    for (k, (f, x)) in undefined.into_iter().enumerate() {
        assert!(f(&ComplexStep::new(x, 1e-40)).re.is_nan(), "{k}");
    }
}

/// Complex arithmetic is true complex arithmetic: identities hold for imaginary parts that are not small.
#[test]
fn complex_identities_hold_for_finite_steps() {
    let close = |a: ComplexStep, b: ComplexStep, what: &str| {
        assert!((a.re - b.re).hypot(a.im - b.im) < 1e-13, "{what}: {a} {b}");
    };
    for (re, im) in [(0.3, 0.4), (0.8, -0.6), (0.1, 0.9)] {
        let z = ComplexStep::new(re, im);
        close(z.exp().ln(), z, "ln exp");
        close(z.ln_1p().exp_m1(), z, "exp_m1 ln_1p");
        close(z.sqrt() * z.sqrt(), z, "sqrt²");
        close(z.cbrt().powi(3), z, "cbrt³");
        close(z.asin().sin(), z, "sin asin");
        close(z.acos().cos(), z, "cos acos");
        close(z.atan().tan(), z, "tan atan");
        close(z.asinh().sinh(), z, "sinh asinh");
        close(z.atanh().tanh(), z, "tanh atanh");
        let w = z + 1.0;
        close(w.acosh().cosh(), w, "cosh acosh");
        close(z.sin() * z.sin() + z.cos() * z.cos(), ComplexStep::new(1.0, 0.0), "sin² + cos²");
        close(z / w * w, z, "division");
        close(z.powf(2.5), z * z * z.sqrt(), "powf");
        close(z.atan2(w), (z / w).atan(), "atan2");
        close(z.exp2(), (z * LN_2).exp(), "exp2");
        close(z.tanh(), z.sinh() / z.cosh(), "tanh");
    }
}

#[test]
fn comparisons_look_at_values() {
    let (a, b) = (Chunk::new(1.0, [5.0]), Chunk::new(2.0, [1.0]));
    assert!(a < b && a == Chunk::new(1.0, [0.0]) && a == 1.0 && b > 1.5);
    let (a, b) = (Var::<f64>::constant_of(1.0), Var::constant_of(2.0));
    assert!(a < b && a.maximum(b) == 2.0);
    assert_eq!(format!("{}", Chunk::new(1.5, [2.0, 3.0])), "1.5 + 2ε0 + 3ε1");
}
