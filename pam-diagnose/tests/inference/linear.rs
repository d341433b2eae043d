//! A linear regression as a system of the search: `y = Σ_j θ_j x_j + b + e`, with one candidate per column `x_j`, off at
//! `θ_j = 0`, and an offset `b` of each experiment with a Gaussian prior where it is asked for.

use pam_diagnose::data::{OpenPart, Roles, Span, TestSource};
use pam_diagnose::diagnosis::{Diagnosis, Prepared, run};
use pam_diagnose::fit::{Hypothesis, Member, Problem, Sensitivities};
use pam_diagnose::noise::{Noise, NoisePrior};
use pam_diagnose::search::{CandidateInfo, Candidates, Nuisance, OutputInfo, Rows};
use pam_diagnose::settings::DataSettings;
use pam_diagnose::{DiagnoseError, DiagnosisSettings};
use pam_effects::effects::ParameterInfo;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::ops::Range;
use std::sync::{Arc, Mutex};

/// One experiment, row by row.
#[derive(Debug, Clone, Default)]
pub(crate) struct Experiment {
    pub(crate) columns: Vec<Vec<f64>>,
    pub(crate) measured: Vec<f64>,
    pub(crate) excitation: Vec<f64>,
    pub(crate) features: Vec<Vec<f64>>,
    pub(crate) factors: Vec<Vec<f64>>,
}

/// The regression.
#[derive(Debug, Clone)]
pub(crate) struct Linear {
    pub(crate) experiments: Vec<Experiment>,
    pub(crate) row_s: f64,
    pub(crate) points_per_row: usize,
    pub(crate) burn_in_s: f64,
    pub(crate) rows_per_block: usize,
    /// Log of the calls: hypothesis, experiment and, for sensitivities, window.
    pub(crate) asked: Arc<Mutex<Vec<String>>>,
    /// Amplitude and wave number of ripples: a slope θ acts as `θ + a sin(kθ)`, and the cost is rugged in it.
    pub(crate) ripples: Option<[f64; 2]>,
    names: Vec<String>,
    ids: Vec<String>,
    /// An offset of all experiments, if any.
    shared: Vec<Nuisance>,
    local: Vec<Nuisance>,
    /// Response of every experiment to a unit of the local nuisance; constant if empty.
    along: Vec<f64>,
    outputs: [OutputInfo; 1],
}

static SLOPE: [ParameterInfo; 1] = [ParameterInfo::linear("slope", [-1e6, 1e6])];

impl Linear {
    /// Rows of 20 ms, each an observation of its own, in blocks of 40.
    pub(crate) fn new(experiments: Vec<Experiment>) -> Self {
        let columns = experiments[0].columns.len();
        let output =
            OutputInfo { key: "y".into(), name: "y".into(), unit: "–".into(), fitted: true };
        Self {
            names: (0..experiments.len()).map(|e| format!("run {e}")).collect(),
            ids: (0..columns).map(|j| format!("x{j}")).collect(),
            experiments,
            row_s: 0.02,
            points_per_row: 1,
            burn_in_s: 0.0,
            rows_per_block: 40,
            asked: Arc::default(),
            ripples: None,
            shared: Vec::new(),
            local: Vec::new(),
            along: Vec::new(),
            outputs: [output],
        }
    }

    /// The same with an offset of each experiment.
    pub(crate) fn with_offset(self, deviation: f64) -> Self {
        Self { local: vec![Nuisance::of(deviation)], ..self }
    }

    /// The same with an offset that all experiments share.
    pub(crate) fn with_shared_offset(self, nuisance: Nuisance) -> Self {
        Self { shared: vec![nuisance], ..self }
    }

    /// The same with a multiple of a series in each experiment.
    pub(crate) fn with_local(self, along: Vec<f64>, deviation: f64) -> Self {
        Self { local: vec![Nuisance::of(deviation)], along, ..self }
    }

    /// The effective slope `θ + a sin(kθ)` and its derivative with respect to θ.
    fn acting(&self, slope: f64) -> [f64; 2] {
        let [amplitude, wave] = self.ripples.unwrap_or([0.0, 1.0]);
        let (sine, cosine) = (wave * slope).sin_cos();
        [slope + amplitude * sine, 1.0 + amplitude * wave * cosine]
    }

    fn along(&self, k: usize) -> f64 {
        self.along.get(k).copied().unwrap_or(1.0)
    }

    /// All experiments as one problem, with a known noise.
    pub(crate) fn problem<'a>(
        &'a self,
        noise: f64,
        settings: &'a DiagnosisSettings,
    ) -> Problem<'a, dyn Candidates + 'a> {
        let system: &dyn Candidates = self;
        Problem::new(
            system,
            (0..self.experiments.len()).collect(),
            Noise::white(&[noise]),
            settings,
        )
    }

    pub(crate) fn roles(
        &self,
        source: TestSource,
        seed: u64,
        settings: &DiagnosisSettings,
    ) -> Roles {
        let span = |e: usize| Span {
            name: self.names[e].clone(),
            duration_s: self.row_s * (self.points(e) - 1) as f64,
            ranges: Vec::new(),
        };
        let spans: Vec<Span> = (0..self.experiments.len()).map(span).collect();
        let data = DataSettings { split_seed: seed as usize, ..settings.data };
        Roles::assign(&spans, source, &data).expect("long enough")
    }

    /// Training and validation rows for a search, with a known noise.
    pub(crate) fn rows<'a>(
        &'a self,
        roles: &Roles,
        noise: f64,
        settings: &'a DiagnosisSettings,
    ) -> Rows<'a, dyn Candidates + 'a> {
        let system: &dyn Candidates = self;
        let white = Noise::white(&[noise]);
        let (choosing, whole) =
            (roles.split(system, &white, settings), roles.whole(system, &white, settings));
        Rows::new(choosing, whole, NoisePrior::at_least(vec![noise]))
    }

    /// The whole diagnosis, with at least this noise.
    pub(crate) fn diagnosed(
        &self,
        source: TestSource,
        noise: f64,
        baseline: Option<&Self>,
        settings: &DiagnosisSettings,
        seed: u64,
    ) -> Diagnosis<()> {
        let roles = self.roles(source, seed, settings);
        let prepared = Prepared {
            system: self,
            roles: &roles,
            noise: vec![noise],
            prior: NoisePrior::at_least(vec![noise]),
            baseline_discrepancy: Vec::new(),
            baseline: baseline.map(|b| b.problem(noise, settings)),
            settings,
            seed,
        };
        run(&prepared, &|_, _| {}, |_| ()).expect("a regression can be evaluated")
    }

    fn response(&self, hypothesis: &Hypothesis, local: &[f64], experiment: usize) -> Vec<f64> {
        let e = &self.experiments[experiment];
        let local = local.first().copied().unwrap_or(0.0);
        let shared = hypothesis.shared.first().copied().unwrap_or(0.0);
        let mut y: Vec<f64> =
            (0..e.measured.len()).map(|k| shared + local * self.along(k)).collect();
        for m in &hypothesis.members {
            let [slope, _] = self.acting(m.values[0]);
            y.iter_mut().zip(&e.columns[m.candidate]).for_each(|(y, x)| *y += slope * x);
        }
        y
    }

    fn note(&self, hypothesis: &Hypothesis, local: &[f64], of: String) {
        let members: Vec<_> = hypothesis.members.iter().map(|m| (m.candidate, &m.values)).collect();
        self.asked
            .lock()
            .unwrap()
            .push(format!("{members:?}, {} fixed, {local:?}: {of}", hypothesis.fixed));
    }

    /// The parts of all experiments as a whole.
    pub(crate) fn open(&self) -> Vec<OpenPart> {
        OpenPart::whole(self.experiments.len())
    }
}

/// Independent normal values of unit variance.
pub(crate) fn white(random: &mut ChaCha8Rng, rows: usize) -> Vec<f64> {
    (0..rows).map(|_| StandardNormal.sample(random)).collect()
}

/// A first-order autoregression of unit variance, `e_k = ρ e_{k−1} + √(1 − ρ²) w_k`.
pub(crate) fn coloured(random: &mut ChaCha8Rng, rows: usize, rho: f64) -> Vec<f64> {
    let mut e = white(random, rows);
    for k in 1..rows {
        e[k] = rho * e[k - 1] + (1.0 - rho * rho).sqrt() * e[k];
    }
    e
}

/// `Σ_j θ_j x_j + σ e`.
pub(crate) fn combined(
    columns: &[Vec<f64>],
    slopes: &[f64],
    noise: &[f64],
    sigma: f64,
) -> Vec<f64> {
    let mut y: Vec<f64> = noise.iter().map(|e| sigma * e).collect();
    for (x, slope) in columns.iter().zip(slopes) {
        y.iter_mut().zip(x).for_each(|(y, x)| *y += slope * x);
    }
    y
}

/// The smallest and the largest count of a binomial variable beyond which at most `tail` of its probability lies on each
/// side.
pub(crate) fn binomial_range(n: usize, p: f64, tail: f64) -> [usize; 2] {
    let (mut log_mass, step) = (n as f64 * (1.0 - p).ln(), (p / (1.0 - p)).ln());
    let (mut below, mut low) = (0.0, None);
    for k in 0..=n {
        let mass = log_mass.exp();
        if low.is_none() && below + mass > tail {
            low = Some(k);
        }
        below += mass;
        if 1.0 - below <= tail {
            return [low.unwrap_or(0), k];
        }
        log_mass += ((n - k) as f64 / (k + 1) as f64).ln() + step;
    }
    [low.unwrap_or(0), n]
}

/// Of ten throws of a fair coin, 0 to 10 have the probabilities 1, 10, 45, … of 1024; of 1000 of 95 %, the standard deviation
/// is 6.9 and 3.09 of them leave out one in 1000.
#[test]
fn binomial_ranges_are_those_of_tables() {
    assert_eq!(binomial_range(10, 0.5, 0.06), [3, 7]);
    assert_eq!(binomial_range(10, 0.5, 0.005), [1, 9]);
    let [low, high] = binomial_range(1000, 0.95, 1e-3);
    assert!((927..=929).contains(&low) && (969..=971).contains(&high), "{low} {high}");
}

impl Candidates for Linear {
    fn candidate_len(&self) -> usize {
        self.ids.len()
    }
    fn candidate(&self, index: usize) -> CandidateInfo<'_> {
        CandidateInfo {
            id: &self.ids[index],
            description: "",
            excited_by: "",
            parameters: &SLOPE,
            value_len: 1,
        }
    }
    fn starts(&self, _index: usize) -> Vec<Vec<f64>> {
        vec![vec![0.1]]
    }
    fn is_rugged(&self, _index: usize, _values: &[f64]) -> bool {
        self.ripples.is_some()
    }
    fn shared(&self) -> &[Nuisance] {
        &self.shared
    }
    fn local(&self) -> &[Nuisance] {
        &self.local
    }
    fn experiment_len(&self) -> usize {
        self.experiments.len()
    }

    fn outputs(&self) -> &[OutputInfo] {
        &self.outputs
    }
    fn name(&self, experiment: usize) -> &str {
        &self.names[experiment]
    }
    fn points(&self, experiment: usize) -> usize {
        self.experiments[experiment].measured.len()
    }
    fn time_s(&self, _experiment: usize, point: usize) -> f64 {
        self.row_s * point as f64
    }
    fn point_at(&self, experiment: usize, time_s: f64) -> usize {
        ((time_s / self.row_s) as usize).min(self.points(experiment))
    }
    fn measured(&self, experiment: usize, _output: usize) -> &[f64] {
        &self.experiments[experiment].measured
    }
    fn points_per_row(&self) -> usize {
        self.points_per_row
    }
    fn burn_in_s(&self) -> f64 {
        self.burn_in_s
    }
    fn rows_per_block(&self, _rows: usize, _row_s: f64) -> usize {
        self.rows_per_block
    }
    fn simulate(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        _until: usize,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        self.note(hypothesis, local, format!("{experiment}"));
        Ok(vec![self.response(hypothesis, local, experiment)])
    }
    fn sensitivities(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let e = &self.experiments[experiment];
        self.note(hypothesis, local, format!("{experiment}, {window:?}"));
        let y = self.response(hypothesis, local, experiment);
        let errors: Vec<f64> = e.measured.iter().zip(&y).map(|(m, y)| m - y).collect();
        let rows = |series: &[f64]| -> Vec<Vec<f64>> {
            let mean = |row: &[f64]| row.iter().sum::<f64>() / row.len() as f64;
            vec![series[window.clone()].chunks_exact(self.points_per_row).map(mean).collect()]
        };
        let fitted = hypothesis.members[hypothesis.fixed..].iter();
        let column = |m: &Member| {
            let [_, derivative] = self.acting(m.values[0]);
            let column = e.columns[m.candidate].iter().map(|x| derivative * x);
            rows(&column.collect::<Vec<f64>>())
        };
        let mut columns: Vec<Vec<Vec<f64>>> = fitted.map(column).collect();
        columns.extend(self.shared.iter().map(|_| rows(&vec![1.0; e.measured.len()])));
        let along: Vec<f64> = (0..e.measured.len()).map(|k| self.along(k)).collect();
        columns.extend(self.local.iter().map(|_| rows(&along)));
        Ok(Sensitivities { residuals: rows(&errors), columns })
    }
    fn features(
        &self,
        _hypothesis: &Hypothesis,
        _local: &[f64],
        experiment: usize,
        _simulated: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let e = &self.experiments[experiment];
        let one = vec![vec![1.0; e.measured.len()]];
        Ok(one.into_iter().chain(e.features.iter().cloned()).collect())
    }
    fn factor_names(&self) -> Vec<(String, String)> {
        let count = self.experiments[0].factors.len();
        (0..count).map(|k| (format!("factor {k}"), "–".into())).collect()
    }
    fn factors(
        &self,
        _hypothesis: &Hypothesis,
        _local: &[f64],
        experiment: usize,
        window: Range<usize>,
    ) -> Result<Vec<Vec<f64>>, DiagnoseError> {
        let factors = &self.experiments[experiment].factors;
        Ok(factors.iter().map(|f| f[window.clone()].to_vec()).collect())
    }
    fn excitation_label(&self) -> String {
        "u".into()
    }
    fn excitation(&self, experiment: usize) -> Vec<f64> {
        self.experiments[experiment].excitation.clone()
    }
}
