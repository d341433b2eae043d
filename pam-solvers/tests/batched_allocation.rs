//! A repeated batched gradient allocates the same few times however long its trajectories are.

use pam_autodiff::batch::SealedMotion;
use pam_core::force::{Dense, Mlp};
use pam_core::{Activation, JointModel, NetworkForce, SealedMasses};
use pam_solvers::{
    BatchWorkspace, BatchedIntegrator, ConstantStep, Interpolation, PidController, SampledInput,
    StepController, Tableau, TrajectoryProblem,
};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Allocations on all threads; this file holds one test, so nobody else counts.
static COUNT: AtomicUsize = AtomicUsize::new(0);

struct Counting;

// SAFETY: every call is handed to the system allocator unchanged.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations<C: StepController + Sync>(
    controller: C,
    interpolation: Interpolation,
    samples: usize,
) -> usize {
    let layer = |inputs: usize, outputs: usize, scale: f64| {
        let weights: Vec<f64> =
            (0..inputs * outputs).map(|k| scale * (k as f64 * 1.313).sin()).collect();
        Dense::from_rows(&weights, vec![0.1; outputs]).unwrap()
    };
    let layers = vec![layer(4, 96, 0.3), layer(96, 96, 0.1), layer(96, 1, 1e3)];
    let mlp = Mlp::new(layers, Activation::from_name("leaky_relu").unwrap()).unwrap();
    let mut model = JointModel::datasheet(NetworkForce::new(mlp).unwrap());
    model.auxiliary_damping_kg_s = 1e5;
    let motion = SealedMotion::<f32>::new(&model, &model.force);
    let times: Vec<f64> = (0..samples).map(|k| k as f64 * 1e-3).collect();
    let force: Vec<f64> = times.iter().map(|t| 1e5 * (3.0 * t).sin()).collect();
    let problems: Vec<_> = (1..=3)
        .map(|i| TrajectoryProblem {
            condition: motion.condition(SealedMasses::new(0.02 * f64::from(i), 0.07).unwrap()),
            input: SampledInput::new(&times, &force, interpolation).unwrap(),
            t0: 0.0,
            t1: times[samples - 1],
            y0: vec![0.0, 0.0],
            observe_s: &times,
        })
        .collect();
    let batched = BatchedIntegrator::new(Tableau::tsit5(), controller);
    let mut memory = BatchWorkspace::default();
    let loss = |_: usize, states: &[f64], cotangents: &mut [f64]| {
        cotangents.copy_from_slice(states);
        0.5 * states.iter().map(|y| y * y).sum::<f64>()
    };
    // One thread: the pool's own bookkeeping must not blur the count.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let warm_up = batched.value_and_gradient(&motion, &problems, &loss, &mut memory);
        assert!(warm_up.failures.is_empty() && warm_up.accepted >= 3 * samples / 60);
        // The fewest of a few: the test's own runner allocates now and then, too.
        let counts = (0..4).map(|_| {
            let before = COUNT.load(Ordering::Relaxed);
            let again = batched.value_and_gradient(&motion, &problems, &loss, &mut memory);
            let count = COUNT.load(Ordering::Relaxed) - before;
            assert_eq!(warm_up, again);
            count
        });
        counts.min().unwrap()
    })
}

#[test]
fn steps_forward_and_back_do_not_allocate() {
    for interpolation in [Interpolation::Hold, Interpolation::Linear] {
        let constant = |samples| allocations(ConstantStep::new(2.5e-3), interpolation, samples);
        let adaptive =
            |samples| allocations(PidController::new(1e-5, 1e-5), interpolation, samples);
        let (short, long) = (constant(300), constant(4000));
        assert!(short > 0, "the counter counts");
        assert_eq!(short, long, "constant {interpolation:?}");
        assert_eq!(adaptive(300), adaptive(4000), "adaptive {interpolation:?}");
    }
}
