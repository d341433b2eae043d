//! One trajectory with its loss, run for the instruction set of the machine.

use crate::adams::Adams;
use crate::cells::CellScheme;
use crate::forcing::{Line, StepForcing, lines_into};
use crate::method::Method;
use crate::nodes::{NodeForce, NodeWorkspace};
use crate::problem::SurrogateProblem;
use crate::result::SurrogateStatistics;
use crate::segments::Log;
use crate::settings::SurrogateSettings;
use crate::surface::{Fidelity, Surface, SurfaceWorkspace, TooRough};
use crate::trajectory::{Control, Mechanics, Motion, MotionSums, Span, Stop};
use pulp::{Simd, WithSimd};

/// Memory of a thread.
#[derive(Debug, Default)]
pub(crate) struct Workspace {
    lines: Vec<Line>,
    forcing: StepForcing,
    pub(crate) surface: SurfaceWorkspace,
    log: Log,
    cotangents: Vec<f64>,
    /// Memory of a network with this number of parameters.
    pub(crate) network: Option<(usize, NodeWorkspace)>,
}

/// Data that all trajectories share.
#[derive(Debug)]
pub(crate) struct Scheme {
    pub(crate) settings: SurrogateSettings,
    pub(crate) method: Method,
    pub(crate) adams: Adams,
    pub(crate) cells: CellScheme,
}

/// Result of one trajectory.
#[derive(Debug, Default)]
pub(crate) struct Solved {
    pub(crate) value: f64,
    pub(crate) network: Vec<f64>,
    pub(crate) masses: [f64; 2],
    pub(crate) sums: MotionSums,
    pub(crate) statistics: SurrogateStatistics,
    pub(crate) stored_bytes: usize,
    pub(crate) stop: Option<Stop>,
    /// Why the request is inconsistent.
    pub(crate) refused: Option<String>,
}

/// The loss of observed states, which writes their cotangents.
pub(crate) type Loss<'a> = dyn Fn(&[f64], &mut [f64]) -> f64 + 'a;

/// One trajectory. Afterwards its states are written; with a gradient the memory of the surface holds the nodes and the
/// cotangents of the force there.
pub(crate) struct Run<'a, 'p> {
    pub(crate) scheme: &'a Scheme,
    pub(crate) mechanics: Mechanics,
    pub(crate) problem: &'a SurrogateProblem<'p>,
    pub(crate) force: &'a mut dyn NodeForce,
    pub(crate) states: &'a mut Vec<f64>,
    pub(crate) workspace: &'a mut Workspace,
    /// The loss of the observed states, and whether it is differentiated.
    pub(crate) loss: Option<(&'a Loss<'a>, bool)>,
}

impl WithSimd for Run<'_, '_> {
    type Output = Solved;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Solved {
        let Self { scheme, mechanics, problem, force, states, workspace, loss } = self;
        let mut solved = Solved { value: f64::NAN, ..Solved::default() };
        let observations = problem.observe_s.len();
        states.clear();
        states.resize(2 * observations, 0.0);
        if let Err(why) = problem.check() {
            solved.refused = Some(why);
            return solved;
        }
        let Workspace { lines, forcing, surface: memory, log, cotangents, .. } = workspace;
        lines_into(&problem.signal, lines);
        let settings = &scheme.settings;
        let fidelity =
            Fidelity { error_mn: settings.force_error_mn, most_patches: settings.most_patches };
        let (origin, width) = problem.expected_area();
        let mut surface = Surface::new(&scheme.cells, fidelity, origin, width);
        let at_start = problem.observed_at_start();
        for state in states[..2 * at_start].as_chunks_mut::<2>().0 {
            *state = problem.y0;
        }
        let span = Span {
            start_s: problem.t0,
            end_s: problem.t1,
            state: problem.y0,
            observe_s: &problem.observe_s[at_start..],
        };
        let control = Control {
            error_mm: settings.step_error_mm,
            longest_s: settings.longest_step_s,
            most_steps: problem.most_steps(settings),
        };
        if surface.make_along(problem.expected_points(), memory, force).is_err() {
            solved.stop = Some(Stop::Rough { time_s: problem.t0 });
            return solved;
        }
        let mut run = Motion {
            method: &scheme.method,
            adams: &scheme.adams,
            mechanics,
            lines,
            surface: &mut surface,
            memory,
            force,
            forcing,
            patch: 0,
        };
        let later = states[2 * at_start..].as_chunks_mut::<2>().0;
        let outcome = run.solve(simd, &span, &control, later, log);
        solved.statistics.steps = log.accepted();
        solved.statistics.rejected = log.rejected;
        solved.stored_bytes = log.bytes();
        match (outcome, loss) {
            (Err(stop), _) => solved.stop = Some(stop),
            (Ok(()), None) => {}
            (Ok(()), Some((loss, differentiated))) => {
                cotangents.clear();
                cotangents.resize(2 * observations, 0.0);
                solved.value = loss(states, cotangents);
                if differentiated {
                    let (first, later) = cotangents.split_at_mut(2 * at_start);
                    match run.pull_back(simd, &span, later.as_chunks_mut::<2>().0, log) {
                        Err(TooRough) => solved.stop = Some(Stop::Rough { time_s: problem.t0 }),
                        Ok(sums) => {
                            solved.sums = sums;
                            for c in first.as_chunks::<2>().0 {
                                solved.sums.start[0] += c[0];
                                solved.sums.start[1] += c[1];
                            }
                            surface.cotangents_into(memory);
                        }
                    }
                }
            }
        }
        solved.statistics.patches = surface.patches.len();
        solved.statistics.evaluations = surface.evaluations;
        solved
    }
}
