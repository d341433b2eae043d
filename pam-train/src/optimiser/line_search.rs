//! A line search for the strong Wolfe conditions.

use super::lbfgs_settings::LbfgsSettings;

/// Value and gradient of a function at a point, or none where it cannot be evaluated.
pub type Evaluate<'a> = dyn FnMut(&[f64]) -> Option<(f64, Vec<f64>)> + 'a;

/// Evaluates and takes for none what is not finite.
pub(super) fn finite(evaluate: &mut Evaluate<'_>, at: &[f64]) -> Option<(f64, Vec<f64>)> {
    evaluate(at).filter(|(value, gradient)| {
        assert_eq!(gradient.len(), at.len(), "one derivative for each coordinate");
        value.is_finite() && gradient.iter().all(|g| g.is_finite())
    })
}

/// `a · b`.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Factor by which a step grows that is too short.
const GROWTH: f64 = 4.0;

/// The function along a line, `φ(a) = f(origin + a · direction)`.
pub(super) struct Line<'a> {
    pub(super) origin: &'a [f64],
    pub(super) direction: &'a [f64],
    /// φ(0).
    pub(super) value: f64,
    /// φ'(0), negative.
    pub(super) slope: f64,
}

/// The line at one step. Where the function cannot be evaluated its value is infinite.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    pub(super) step: f64,
    pub(super) value: f64,
    pub(super) slope: f64,
    pub(super) gradient: Vec<f64>,
}

impl Line<'_> {
    /// The point at a step.
    pub(super) fn point(&self, step: f64) -> Vec<f64> {
        self.origin.iter().zip(self.direction).map(|(x, d)| x + step * d).collect()
    }

    fn trial(&self, step: f64, evaluate: &mut Evaluate<'_>) -> Trial {
        match finite(evaluate, &self.point(step)) {
            Some((value, gradient)) => {
                let slope = dot(&gradient, self.direction);
                Trial { step, value, slope, gradient }
            }
            None => Trial { step, value: f64::INFINITY, slope: f64::NAN, gradient: Vec::new() },
        }
    }

    /// Searches a step with
    ///
    /// ```text
    /// φ(a) ≤ φ(0) + c₁ a φ'(0),   |φ'(a)| ≤ c₂ |φ'(0)|
    /// ```
    ///
    /// by bracketing and zooming with cubic interpolation (Nocedal and Wright 2006, algorithms 3.5 and
    /// 3.6), from `first` on and not beyond `largest`. Returns the step, if one was found, and the
    /// number of evaluations. When these are used up, or the step is the largest, the first condition
    /// alone is enough.
    pub(super) fn search(
        &self,
        settings: &LbfgsSettings,
        first: f64,
        largest: f64,
        evaluate: &mut Evaluate<'_>,
    ) -> (Option<Trial>, usize) {
        let start = Trial { step: 0.0, value: self.value, slope: self.slope, gradient: Vec::new() };
        let falls = |t: &Trial| t.value <= self.value + settings.armijo * t.step * self.slope;
        let flat = |t: &Trial| t.slope.abs() <= settings.curvature * self.slope.abs();
        let mut low = start;
        let mut high: Option<Trial> = None;
        let mut step = first.min(largest);
        let mut evaluations = 0;
        while evaluations < settings.evaluations {
            // Neighbours in the last digit are indistinguishable.
            if step == low.step || high.as_ref().is_some_and(|h| step == h.step) {
                break;
            }
            let trial = self.trial(step, evaluate);
            evaluations += 1;
            if falls(&trial) && flat(&trial) {
                return (Some(trial), evaluations);
            }
            if !falls(&trial) || (low.step > 0.0 && trial.value >= low.value) {
                high = Some(trial);
            } else {
                match &high {
                    None if trial.slope >= 0.0 => high = Some(low),
                    None if step >= largest => return (Some(trial), evaluations),
                    None => {}
                    Some(h) if trial.slope * (h.step - low.step) >= 0.0 => high = Some(low),
                    Some(_) => {}
                }
                low = trial;
            }
            step = match &high {
                Some(high) => between(&low, high),
                None => (GROWTH * low.step).min(largest),
            };
        }
        (Some(low).filter(|t| t.step > 0.0), evaluations)
    }
}

/// The minimum of the cubic through two trials (Nocedal and Wright 2006, equation 3.59), kept away
/// from both; their middle where there is no such cubic.
fn between(low: &Trial, high: &Trial) -> f64 {
    let width = high.step - low.step;
    let d1 = low.slope + high.slope - 3.0 * (high.value - low.value) / width;
    let d2 = width.signum() * (d1 * d1 - low.slope * high.slope).sqrt();
    let share = 1.0 - (high.slope + d2 - d1) / (high.slope - low.slope + 2.0 * d2);
    let share = if share.is_finite() { share.clamp(0.1, 0.9) } else { 0.5 };
    low.step + share * width
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Functions 1 and 2 of Moré and Thuente (1994), with the tolerances and first steps of their
    /// tables: the step that is found must satisfy both conditions.
    #[test]
    fn steps_satisfy_the_strong_wolfe_conditions() {
        let one = |a: f64| (-a / (a * a + 2.0), (a * a - 2.0) / (a * a + 2.0).powi(2));
        let two = |a: f64| {
            let b = a + 0.004;
            (b.powi(5) - 2.0 * b.powi(4), 5.0 * b.powi(4) - 8.0 * b.powi(3))
        };
        type Function<'a> = &'a dyn Fn(f64) -> (f64, f64);
        let cases: [(Function<'_>, f64, f64); 2] = [(&one, 1e-3, 0.1), (&two, 0.1, 0.1)];
        for (function, armijo, curvature) in cases {
            let settings =
                LbfgsSettings { armijo, curvature, evaluations: 30, ..LbfgsSettings::default() };
            let (value, slope) = function(0.0);
            let line = Line { origin: &[0.0], direction: &[1.0], value, slope };
            for first in [1e-3, 1e-1, 1e1, 1e3] {
                let mut evaluate = |at: &[f64]| {
                    let (value, slope) = function(at[0]);
                    Some((value, vec![slope]))
                };
                let (found, count) = line.search(&settings, first, f64::INFINITY, &mut evaluate);
                let t = found.unwrap();
                assert!(t.value <= value + armijo * t.step * slope, "{first}: {t:?}");
                assert!(t.slope.abs() <= curvature * slope.abs(), "{first}: {t:?}");
                assert!(count <= 20, "{count} evaluations");
            }
        }
    }

    /// x² from 1 along −2, known only up to a step of 0.6: the minimum is at 0.5.
    #[test]
    fn it_comes_back_from_where_nothing_is_known() {
        let settings = LbfgsSettings { curvature: 0.5, ..LbfgsSettings::default() };
        let line = Line { origin: &[1.0], direction: &[-2.0], value: 1.0, slope: -4.0 };
        let mut evaluate = |at: &[f64]| (at[0] > -0.2).then(|| (at[0] * at[0], vec![2.0 * at[0]]));
        let (found, _) = line.search(&settings, 100.0, f64::INFINITY, &mut evaluate);
        let t = found.unwrap();
        assert!((0.25..=0.6).contains(&t.step), "{t:?}");
        let (found, count) = line.search(&settings, 1.0, f64::INFINITY, &mut |_| None);
        assert!(found.is_none() && count == settings.evaluations);
    }

    #[test]
    fn it_stays_within_the_largest_step() {
        let line = Line { origin: &[0.0], direction: &[1.0], value: 0.0, slope: -1.0 };
        let settings = LbfgsSettings::default();
        let (found, _) = line.search(&settings, 0.1, 3.0, &mut |at| Some((-at[0], vec![-1.0])));
        assert_eq!(found.unwrap().step, 3.0);
    }
}
