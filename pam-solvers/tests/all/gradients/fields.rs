//! The fields whose solutions are differentiated.

use pam_core::activation::{LeakyRelu, Tanh};
use pam_core::force::Dense;
use pam_core::{
    Activation, JointField, JointModel, Mlp, NetworkForce, ParametricField, Scalar, VectorField,
};

/// `ẏ = A y + B u`, two states; parameters are A (rows) and B (rows).
pub(crate) struct Linear<S> {
    pub(crate) a: [S; 4],
    pub(crate) b: Vec<S>,
}

impl Linear<f64> {
    pub(crate) fn with_inputs(inputs: usize) -> Self {
        let b = (0..2 * inputs).map(|k| 0.4 + 0.3 * (k as f64).cos()).collect();
        Self { a: [-0.3, 1.7, -2.1, -0.2], b }
    }
}

impl<S: Scalar> VectorField<S> for Linear<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        self.b.len() / 2
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        for (i, dy) in dy.iter_mut().enumerate() {
            *dy = self.a[2 * i] * y[0] + self.a[2 * i + 1] * y[1];
            for (&b, &u) in self.b[i * u.len()..].iter().zip(u) {
                *dy += b * u;
            }
        }
    }
}

impl ParametricField for Linear<f64> {
    type With<S: Scalar> = Linear<S>;
    fn parameters(&self) -> Vec<f64> {
        [&self.a[..], &self.b[..]].concat()
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Linear<S> {
        Linear { a: [p[0], p[1], p[2], p[3]], b: p[4..].to_vec() }
    }
}

/// `ẍ = μ (1 − x²) ẋ − x + Σ u`
pub(crate) struct VanDerPol<S> {
    pub(crate) mu: S,
    pub(crate) inputs: usize,
}

impl<S: Scalar> VectorField<S> for VanDerPol<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        self.inputs
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = y[1];
        dy[1] = self.mu * (S::constant(1.0) - y[0] * y[0]) * y[1] - y[0];
        for &u in u {
            dy[1] += u;
        }
    }
}

impl ParametricField for VanDerPol<f64> {
    type With<S: Scalar> = VanDerPol<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.mu]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> VanDerPol<S> {
        VanDerPol { mu: p[0], inputs: self.inputs }
    }
}

/// Another field with one more state, a creep `ż = r (x − z)` of its first state that pulls on its second,
/// `v̇ += c z`.
pub(crate) struct WithCreep<S: Scalar> {
    pub(crate) field: Box<AnyField<S>>,
    pub(crate) rate: S,
    pub(crate) coupling: S,
}

impl<S: Scalar> VectorField<S> for WithCreep<S> {
    fn state_len(&self) -> usize {
        self.field.state_len() + 1
    }
    fn input_len(&self) -> usize {
        self.field.input_len()
    }
    fn work_len(&self) -> usize {
        self.field.work_len()
    }
    fn eval_into(&self, t: f64, y: &[S], u: &[S], dy: &mut [S], work: &mut [S]) {
        let n = self.field.state_len();
        self.field.eval_into(t, &y[..n], u, &mut dy[..n], work);
        dy[1] += self.coupling * y[n];
        dy[n] = self.rate * (y[0] - y[n]);
    }
}

impl ParametricField for WithCreep<f64> {
    type With<S: Scalar> = WithCreep<S>;
    fn parameters(&self) -> Vec<f64> {
        let mut p = self.field.parameters();
        p.extend([self.rate, self.coupling]);
        p
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Self::With<S> {
        let (inner, own) = p.split_at(p.len() - 2);
        let field = Box::new(self.field.with_parameters(inner));
        WithCreep { field, rate: own[0], coupling: own[1] }
    }
}

/// Any function of time, state and parameters as a field.
macro_rules! field {
    ($name:ident, $states:literal, [$($p:ident),*], |$t:pat, $y:ident, $dy:ident| $body:block) => {
        pub(crate) struct $name<S> { $(pub(crate) $p: S),* }
        impl<S: Scalar> VectorField<S> for $name<S> {
            fn state_len(&self) -> usize { $states }
            fn input_len(&self) -> usize { 0 }
            fn eval_into(&self, $t: f64, $y: &[S], _u: &[S], $dy: &mut [S], _work: &mut [S]) {
                let Self { $($p),* } = self;
                $(let $p = *$p;)*
                $body
            }
        }
        impl ParametricField for $name<f64> {
            type With<S: Scalar> = $name<S>;
            fn parameters(&self) -> Vec<f64> { vec![$(self.$p),*] }
            fn with_parameters<S: Scalar>(&self, p: &[S]) -> $name<S> {
                let mut p = p.iter();
                $(let $p = *p.next().unwrap();)*
                $name { $($p),* }
            }
        }
    };
}

field!(Decay, 1, [rate], |_, y, dy| { dy[0] = -rate * y[0] });
// Logistic growth.
field!(Logistic, 1, [rate, capacity], |_, y, dy| {
    dy[0] = rate * y[0] * (S::constant(1.0) - y[0] / capacity);
});
field!(Quartic, 1, [theta], |t, _y, dy| { dy[0] = (S::constant(t) - theta).powi(4) });
// Lotka and Volterra's equations with one parameter.
field!(Cycle, 2, [a], |_, y, dy| {
    dy[0] = a * y[0] - y[0] * y[1];
    dy[1] = y[0] * y[1] - a * y[1];
});
// A slow state and a fast one that follows it.
field!(SlowFast, 2, [p, k], |_, y, dy| {
    dy[0] = -p * y[0] * y[1];
    dy[1] = k * (y[0] - y[1]);
});
field!(LinearSlowFast, 2, [p, k], |_, y, dy| {
    dy[0] = -p * y[1];
    dy[1] = k * (y[0] - y[1]);
});

/// One type for all fields, so that the gradient methods are instantiated once.
macro_rules! any_field {
    ($($name:ident($field:ty)),* $(,)?) => {
        pub(crate) enum AnyField<S: Scalar> { $($name($field)),* }
        $(impl<S: Scalar> From<$field> for AnyField<S> {
            fn from(field: $field) -> Self {
                Self::$name(field)
            }
        })*
        impl<S: Scalar> VectorField<S> for AnyField<S> {
            fn state_len(&self) -> usize {
                match self { $(Self::$name(field) => field.state_len()),* }
            }
            fn input_len(&self) -> usize {
                match self { $(Self::$name(field) => field.input_len()),* }
            }
            fn work_len(&self) -> usize {
                match self { $(Self::$name(field) => field.work_len()),* }
            }
            fn eval_into(&self, t: f64, y: &[S], u: &[S], dy: &mut [S], work: &mut [S]) {
                match self { $(Self::$name(field) => field.eval_into(t, y, u, dy, work)),* }
            }
        }
        impl ParametricField for AnyField<f64> {
            type With<S: Scalar> = AnyField<S>;
            fn parameters(&self) -> Vec<f64> {
                match self { $(Self::$name(field) => field.parameters()),* }
            }
            fn parameter_len(&self) -> usize {
                match self { $(Self::$name(field) => field.parameter_len()),* }
            }
            fn with_parameters<S: Scalar>(&self, p: &[S]) -> AnyField<S> {
                match self { $(Self::$name(field) => AnyField::$name(field.with_parameters(p))),* }
            }
        }
    };
}

any_field! {
    Cycle(Cycle<S>),
    Decay(Decay<S>),
    Joint(JointField<S, NetworkForce<S>>),
    Linear(Linear<S>),
    LinearSlowFast(LinearSlowFast<S>),
    Logistic(Logistic<S>),
    Quartic(Quartic<S>),
    SlowFast(SlowFast<S>),
    VanDerPol(VanDerPol<S>),
    WithCreep(WithCreep<S>),
}

/// The field of a joint, with its own copy of the force.
pub(crate) fn owned(field: &JointField<f64, &NetworkForce<f64>>) -> AnyField<f64> {
    AnyField::Joint(field.with_parameters(&field.parameters()))
}

/// A joint whose force is a 12 × 12 network of moderate size.
fn joint(activation: Activation) -> JointModel<f64, NetworkForce<f64>> {
    let mut state = 4711_u64;
    let mut next = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut layer = |outputs: usize, inputs: &[f64], size: f64| {
        let mut weights = Vec::new();
        for _ in 0..outputs {
            weights.extend(inputs.iter().map(|scale| scale * next()));
        }
        Dense::from_rows(&weights, (0..outputs).map(|_| size * next()).collect()).unwrap()
    };
    // Inputs are masses of 0.06 g, millimetres and tens of millimetres a second.
    let first = layer(8, &[8.0, 8.0, 2.0, 0.05], 1.0);
    let second = layer(8, &[1.8; 8], 1.0);
    let third = layer(1, &[7e4; 8], 1e4);
    let force = NetworkForce::new(Mlp::new(vec![first, second, third], activation).unwrap());
    let mut model = JointModel::datasheet(force.unwrap());
    // The network is arbitrary and holds little back; damping keeps the motion moderate.
    model.auxiliary_damping_kg_s = 9000.0;
    model
}

pub(crate) fn leaky_relu_joint() -> JointModel<f64, NetworkForce<f64>> {
    joint(Activation::LeakyRelu(LeakyRelu::default()))
}

pub(crate) fn tanh_joint() -> JointModel<f64, NetworkForce<f64>> {
    joint(Activation::Tanh(Tanh))
}
