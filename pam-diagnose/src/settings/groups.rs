//! The settings, group by group: meaning, default, unit, range and origin of each default.

use serde::{Deserialize, Serialize};

/// One row of the reference table.
pub(super) struct Row {
    pub(super) key: &'static str,
    pub(super) meaning: String,
    pub(super) unit: &'static str,
    pub(super) default: &'static str,
    pub(super) range: [f64; 2],
    pub(super) origin: &'static str,
}

/// Numbers of a setting, for the check of its range.
trait Numbers {
    fn numbers(&self) -> Vec<f64>;
}

impl Numbers for f64 {
    fn numbers(&self) -> Vec<f64> {
        vec![*self]
    }
}

impl Numbers for usize {
    fn numbers(&self) -> Vec<f64> {
        vec![*self as f64]
    }
}

impl<const N: usize> Numbers for [f64; N] {
    fn numbers(&self) -> Vec<f64> {
        self.to_vec()
    }
}

/// Declares a group of settings: the struct with its documentation, the defaults, the check of the ranges and the
/// rows of the reference table, all from one list.
macro_rules! settings {
    ($(#[doc = $about:literal])+ $group:literal $name:ident {
        $($(#[doc = $doc:literal])+ $field:ident: $kind:ty = $default:expr, $unit:literal, $range:expr, $origin:ident;)+
    }) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $($(#[doc = $doc])+ #[doc = concat!("\n\nUnit: ", $unit, ". Default: `", stringify!($default), "`.")] pub $field: $kind,)+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default),+ }
            }
        }

        impl $name {
            /// Refuses values outside their range, naming the key.
            pub(super) fn check(&self) -> Result<(), String> {
                $(let [low, high]: [f64; 2] = $range;
                for value in self.$field.numbers() {
                    if !(low..=high).contains(&value) {
                        let key = concat!($group, ".", stringify!($field));
                        return Err(format!("`{key}` must be from {low} to {high}, got {value}"));
                    }
                })+
                Ok(())
            }

            pub(super) fn rows() -> Vec<Row> {
                vec![$(Row {
                    key: concat!($group, ".", stringify!($field)),
                    meaning: [$($doc),+].concat().trim().to_owned(),
                    unit: $unit,
                    default: stringify!($default),
                    range: $range,
                    origin: $origin,
                }),+]
            }
        }
    };
}

/// The default was chosen on the studies of `docs/studies`: names right, no false alarms.
const STUDIES: &str = "chosen on docs/studies";
/// The default follows from the instruments of the rig.
const RIG: &str = "instruments of the rig";
/// The default is a usual value of the method.
const USUAL: &str = "usual for the method";
/// The default bounds the computing time; a larger value changes no verdict of the studies.
const TIME: &str = "computing time";

const SHARE: [f64; 2] = [0.0, 1.0];
const COUNT: [f64; 2] = [1.0, 1e6];
const POSITIVE: [f64; 2] = [1e-12, 1e12];
const COST: [f64; 2] = [0.0, 1e12];
/// Factors that are at least one.
const FACTOR: [f64; 2] = [1.0, 1e12];

settings! {
    /// How recordings become rows, and which rows train, validate and test.
    "data" DataSettings {
        /// Share of the recordings that is kept for the test set, and of the rest for validation; of one or two
        /// recordings a share of each for validation.
        kept_share: f64 = 1.0 / 3.0, "–", [0.05, 0.9], USUAL;
        /// Seed that draws the recordings of the test set and of validation among those without which the ranges of
        /// displacement, velocity, pressures and force narrow least. `--seed` does not change them.
        split_seed: usize = 1, "–", [0.0, 1e9], USUAL;
        /// Shortest recording of the joint.
        shortest_s: f64 = 3.0, "s", COST, STUDIES;
        /// Time at the start of a recording of the joint that is not fitted: transients of an unknown start.
        burn_in_s: f64 = 0.5, "s", COST, RIG;
        /// Time at the end of a recording of the joint that is not fitted: a zero-phase low-pass of 20 Hz has not settled
        /// there.
        burn_out_s: f64 = 0.1, "s", COST, RIG;
        /// Largest share of a recording that is not fitted at its start for that reason.
        burn_in_share: f64 = 0.25, "–", SHARE, USUAL;
        /// Grid points of 4 ms that are averaged into one row of residuals of the joint; more where the samples are
        /// further apart.
        points_per_row: usize = 5, "points", COUNT, STUDIES;
        /// Most substeps of a grid step that the model of the joint may need: the time of a diagnosis grows with them. Eight
        /// follow a joint of 0.5 kg on a spring of 3000 N/mm.
        most_substeps: usize = 8, "substeps", COUNT, TIME;
        /// Quantile of the sizes of force, travel and speed of the joint from which starting values follow.
        scale_quantile: f64 = 0.95, "–", SHARE, STUDIES;
        /// Quantile of the size of the force that counts as its peak.
        peak_quantile: f64 = 0.999, "–", SHARE, STUDIES;
        /// Samples of the missing force that starting values may use.
        scale_samples: usize = 6000, "samples", COUNT, TIME;
    }
}

settings! {
    /// The noise of each channel, from what a flexible model cannot learn.
    "noise" NoiseSettings {
        /// Part of a channel's variation that the errors of solver, grid and filters may have: it joins the first estimate of the
        /// noise, which serves until the noise is learned, and no spectral line is smaller.
        relative: f64 = 4e-3, "–", SHARE, STUDIES;
        /// Standard deviation of the model's own error where no baseline recordings tell it, as a part of a channel's
        /// variation: it moves as the channel does.
        discrepancy: f64 = 2e-4, "–", SHARE, STUDIES;
        /// Highest order of the autoregression.
        order: usize = 8, "–", [0.0, 100.0], USUAL;
        /// Rows of the shortest recording for each order.
        rows_per_order: usize = 15, "rows", COUNT, USUAL;
        /// Multiple of the robust standard deviation to which outliers are limited before the noise is learned.
        largest_deviations: f64 = 5.0, "–", FACTOR, USUAL;
        /// Least share of the rows that count as degrees of freedom next to a flexible model.
        least_freedom: f64 = 0.25, "–", [1e-3, 1.0], USUAL;
        /// Weight of the common size of the noise relative to the observations of each recording.
        relative_observations: f64 = 50.0, "observations", COST, USUAL;
        /// Largest share of the power of the force that may lie at quiet frequencies, those without excitation; there a part of the
        /// measured force, which is fitted, may be noise. With 0 the force is used as measured.
        quiet_share: f64 = 0.01, "–", SHARE, USUAL;
        /// Longest lag at which the autocorrelation of a residual is summed, as a share of its rows.
        lag_share: f64 = 0.25, "–", SHARE, USUAL;
        /// Largest number of rows that count as one observation, as a share of the rows.
        correlated_share: f64 = 0.1, "–", SHARE, USUAL;
    }
}

settings! {
    /// The fit of one hypothesis by Levenberg–Marquardt, and the priors of the nuisance values.
    "fit" FitSettings {
        /// Damping of the first step, relative to the diagonal.
        first_damping: f64 = 1e-3, "–", COST, USUAL;
        /// Factor on the damping after a step that lowers the cost.
        damping_after_success: f64 = 0.2, "–", SHARE, USUAL;
        /// Factor on the damping after a step that does not.
        damping_after_failure: f64 = 12.0, "–", FACTOR, USUAL;
        /// Least damping.
        least_damping: f64 = 1e-9, "–", COST, USUAL;
        /// Least and greatest ratio of the drop of the cost to the predicted drop at which a further step reuses the Jacobian.
        jacobian_reuse_share: [f64; 2] = [0.25, 2.0], "–", POSITIVE, TIME;
        /// Dampings that are tried per iteration.
        dampings_per_iteration: usize = 4, "–", COUNT, TIME;
        /// Drop of the cost below which a fit has converged.
        converged_drop: f64 = 0.05, "cost", COST, STUDIES;
        /// Largest change of the logarithm of a scale in one step: a factor of three.
        largest_log_step: f64 = 1.1, "–", POSITIVE, USUAL;
        /// Prior standard deviation of the logarithms of the model's mass and deformation coefficient.
        model_deviation: f64 = 2e-3, "–", POSITIVE, RIG;
        /// Prior standard deviation of the lead of the recorded force before a held one.
        lead_deviation_samples: f64 = 0.3, "samples", POSITIVE, RIG;
        /// Largest lead: a force that is smooth between its samples is half a sample before a held one.
        lead_limit_samples: f64 = 0.5, "samples", COST, RIG;
        /// Largest lag behind a held force; beyond it, a delay has to be named.
        lag_limit_samples: f64 = 0.1, "samples", COST, RIG;
        /// Prior standard deviation of the share of the force at quiet frequencies that is noise; it lies between 0 and 1.
        force_noise_deviation: f64 = 1.0, "–", POSITIVE, USUAL;
        /// Least prior standard deviation of the share of an effect from baseline recordings that the data have.
        share_deviation: f64 = 0.1, "–", POSITIVE, STUDIES;
        /// Least prior standard deviation of the displacement at the start; the noise of the measured one is added.
        start_deviation_mm: f64 = 0.02, "mm", POSITIVE, RIG;
        /// Least prior standard deviation of the velocity at the start; the noise of the measured one is added.
        start_deviation_mm_s: f64 = 1.0, "mm/s", POSITIVE, RIG;
        /// Prior standard deviation of the logarithms of the sealed masses.
        air_deviation: f64 = 2e-3, "–", POSITIVE, RIG;
        /// Least prior standard deviation of the offset of the first pressure samples; their noise is added.
        offset_deviation_kpa: f64 = 0.5, "kPa", POSITIVE, RIG;
    }
}

settings! {
    /// The search: how candidates are screened, which sets are fitted, and how they are compared.
    "search" SearchSettings {
        /// Most causes that are named together.
        max_causes: usize = 3, "causes", COUNT, STUDIES;
        /// Odds that a further cause must reach.
        odds: f64 = 20.0, "–", FACTOR, USUAL;
        /// Odds that a further cause must reach where there are fewer blocks of rows than `rejection.fewest_blocks`.
        odds_of_few_blocks: f64 = 150.0, "–", FACTOR, USUAL;
        /// Cost of a scale that ends at a limit of its range: the fit has degenerated there.
        limit_cost: f64 = 12.0, "cost", COST, STUDIES;
        /// Candidates that are fitted alone.
        singles: usize = 8, "candidates", COUNT, TIME;
        /// Pairs that are fitted after the screening.
        pairs: usize = 4, "pairs", [0.0, 50.0], TIME;
        /// Starting values of each candidate, the best of the first screening, that are screened in addition to a set.
        starts: usize = 2, "values", COUNT, TIME;
        /// Candidates that are fitted in addition to a set.
        additions: usize = 4, "candidates", COUNT, TIME;
        /// Candidates that are fitted in place of a member.
        exchanges: usize = 6, "candidates", COUNT, TIME;
        /// Imitators of a member, candidates with nearly the same response, that are fitted in its place whatever the screening says.
        imitators: usize = 6, "candidates", COUNT, TIME;
        /// Least share of a candidate's first-order response that another candidate must reproduce to count as its imitator.
        imitated_share: f64 = 0.9, "–", SHARE, STUDIES;
        /// Factors on the amplitudes of an imitator's starting values, of which the best is taken.
        amplitude_factors: [f64; 3] = [2.0, 4.0, 8.0], "–", POSITIVE, STUDIES;
        /// Pairs that are fitted in place of a member.
        exchanges_for_two: usize = 2, "pairs", [0.0, 20.0], TIME;
        /// Sets of the round before that are fitted again with the noise of the present one.
        rivals: usize = 4, "sets", COUNT, TIME;
        /// Power of the share of the error that a set leaves to first order which it may leave when it is fitted: only sets
        /// that may come near the present one are.
        nonlinear_power: f64 = 2.0, "–", FACTOR, STUDIES;
        /// Rounds of additions and exchanges.
        rounds: usize = 4, "rounds", COUNT, TIME;
        /// Iterations after which starts are given up that cannot come near the best one any more.
        first_iterations: usize = 2, "iterations", COUNT, TIME;
        /// Iterations after which only the most promising starts are followed.
        tried_iterations: usize = 4, "iterations", COUNT, TIME;
        /// Starts that are followed.
        followed: usize = 3, "starts", COUNT, TIME;
        /// Drop of the cost below which a fit of the search has converged: sets are compared by larger differences.
        converged_drop: f64 = 0.5, "cost", [0.05, 1e6], TIME;
        /// Iterations to convergence.
        iterations: usize = 12, "iterations", COUNT, TIME;
        /// Iterations from each start of the last refit.
        multi_start_iterations: usize = 12, "iterations", COUNT, TIME;
        /// Step sizes of the compass search in the parameters of dry friction, along which the cost has many local minima: factors by which
        /// a parameter is multiplied or divided when a fit has converged. Fits of the search try the first one only.
        rugged_factors: [f64; 2] = [1.33, 1.1], "–", POSITIVE, STUDIES;
    }
}

settings! {
    /// When a name is rejected.
    "rejection" RejectionSettings {
        /// Relative spread of a parameter over parts of the recordings beyond which the name only mimics.
        mimic_spread: f64 = 0.6, "–", COST, STUDIES;
        /// Share of the removable error from which a name stands whatever its spread.
        mimic_share: f64 = 0.8, "–", SHARE, STUDIES;
        /// Ratio of the ends of a scale's interval beyond which it says nothing, unless the magnitude of the cause is certain.
        vague_ratio: f64 = 100.0, "–", FACTOR, STUDIES;
        /// Parts of each recording in which a cause is refitted.
        stability_parts: usize = 3, "parts", COUNT, STUDIES;
        /// Iterations of these fits.
        stability_iterations: usize = 2, "iterations", COUNT, TIME;
        /// Fewest parts that have a spread.
        spread_fewest_parts: usize = 3, "parts", COUNT, USUAL;
        /// Fewest parts from which intervals are widened.
        stability_fewest_parts: usize = 4, "parts", [2.0, 1e6], USUAL;
        /// Draws of the max-statistic null test.
        null_draws: usize = 400, "draws", [20.0, 1e6], USUAL;
        /// Quantile of the null distribution that names must exceed.
        null_quantile: f64 = 0.95, "–", [0.5, 0.999], USUAL;
        /// Number of blocks of rows below which their scatter alone does not measure chance. Below it the null test uses shorter blocks, which
        /// are independent only as far as the noise model is right, a cause must reach higher odds, and cross-validation estimates how well
        /// the learned noise describes other rows.
        fewest_blocks: usize = 20, "blocks", COUNT, USUAL;
        /// Quantile of the null distribution that a change of a parameter in time, or between recordings, must exceed.
        stability_test_quantile: f64 = 0.999, "–", [0.5, 0.999999], USUAL;
    }
}

settings! {
    /// Causes that begin, end or grow at a time.
    "onset" OnsetSettings {
        /// Rows of a cell of time: times are tried at its edges, and then fitted. Of the joint half a second; more where there
        /// would be too many cells.
        cell_rows: usize = 25, "rows", COUNT, TIME;
        /// Fewest cells of all recordings together; shorter cells are taken in short recordings.
        fewest_cells: usize = 60, "cells", COUNT, USUAL;
        /// Fewest rows of a cell for that reason.
        fewest_cell_rows: usize = 5, "rows", COUNT, USUAL;
        /// Fewest cells in which a cause must act, and not act.
        margin_cells: usize = 3, "cells", COUNT, USUAL;
        /// Cells of a block whose sign is drawn at once in the test against chance.
        block_cells: usize = 2, "cells", COUNT, USUAL;
        /// Draws of that test.
        draws: usize = 200, "draws", [20.0, 1e4], USUAL;
        /// Quantile of the largest score by chance that a time must exceed.
        probability: f64 = 0.99, "–", [0.5, 0.9999], USUAL;
        /// Odds that a set with a time must reach against those without.
        odds: f64 = 150.0, "–", FACTOR, STUDIES;
        /// Least rise of the mean square of some channel, in variances of its noise, where causes that come or go are always there
        /// or absent: errors of the model change with the excitation as well.
        least_rise: f64 = 0.15, "–", POSITIVE, STUDIES;
        /// Candidates that are fitted from the scan.
        candidates: usize = 6, "candidates", COUNT, TIME;
    }
}

settings! {
    /// Where the verdict falls.
    "verdict" VerdictSettings {
        /// Share of the error above the noise below which no name is given.
        named_share: f64 = 0.25, "–", SHARE, STUDIES;
        /// Probability with which the residual of the test data goes with the change of the simulation by chance, below which
        /// causes are confirmed.
        score_p_value: f64 = 0.005, "–", SHARE, USUAL;
        /// Power of this test below which causes that the other data establish are named although it is not significant, if the test data
        /// are more probable with them.
        power: f64 = 0.95, "–", [0.5, 0.9999], USUAL;
        /// Drop of minus two times the logarithm of the posterior probability on the test data that confirms causes which the other
        /// data establish, even if most of it is in one block, if fitted starts and masses are about as likely with them. Where the causes leave
        /// nothing but noise, `confusable_odds` are enough.
        decisive_evidence: f64 = 100.0, "–", COST, STUDIES;
        /// Probability with which a channel without error is inside its noise band.
        band_probability: f64 = 0.999, "–", [0.5, 0.999999], USUAL;
        /// Weight of the Gaussian scatter of the blocks, in blocks, relative to their observed scatter.
        band_observations: f64 = 3.0, "blocks", COST, USUAL;
        /// Least share of a channel's remaining error that a flexible model must learn for it to count as a model error.
        learnable_share: f64 = 0.05, "–", SHARE, STUDIES;
        /// Multiple of the noise from which a channel is outside its band although a flexible model learns nothing of it:
        /// the noise of recordings differs by less.
        unlearnable_ratio: f64 = 2.0, "–", FACTOR, STUDIES;
        /// Share of a channel's variation above which an error that a flexible model cannot learn is too large to be noise.
        unmodelled_share: f64 = 0.1, "–", SHARE, STUDIES;
        /// Multiple of the noise from one row to the next that it must be as well.
        unmodelled_ratio: f64 = 5.0, "–", FACTOR, STUDIES;
        /// Probability that stationary noise passes the test of stationarity.
        stationary_probability: f64 = 0.999, "–", [0.5, 0.999999], USUAL;
        /// Probability that no row of noise counts as an event.
        event_probability: f64 = 0.999, "–", [0.5, 0.999999], USUAL;
        /// Degrees of freedom of Student's t by which events are judged: noise has heavier tails than a Gaussian.
        event_freedom: f64 = 10.0, "–", FACTOR, USUAL;
        /// Multiple of its standard error from which a step of the mean of a residual counts.
        step_ratio: f64 = 6.0, "–", FACTOR, STUDIES;
        /// A cause is minor if it removes less than this share of what all named causes remove.
        minor_share: f64 = 0.02, "–", SHARE, STUDIES;
        /// All causes are minor if they remove less than this share of the squared residual.
        minor_of_residual: f64 = 0.05, "–", SHARE, STUDIES;
        /// A cause is not minor if without it the mean square of some channel rises by at least this multiple of the variance
        /// of its noise: the error is then a twentieth above the noise.
        minor_rise: f64 = 0.1, "–", POSITIVE, STUDIES;
        /// Beside a larger cause, a cause without which this rise is smaller is minor, whatever it removes: the larger one leaves as much
        /// if its law or the measured force is slightly wrong.
        minor_rise_beside: f64 = 0.05, "–", POSITIVE, STUDIES;
        /// A cause is minor as well if it removes less than this share of what all named causes remove, whatever the noise is: other
        /// causes whose forces are wrong by 3 % leave as much.
        negligible_share: f64 = 0.001, "–", SHARE, STUDIES;
        /// A cause below `negligible_share` is not minor if the error without it exceeds the noise and its value is at least this many
        /// half-widths of its interval away from absence. A cause that stands in for a wrong law of another one is less certain.
        certain_ratio: f64 = 10.0, "–", FACTOR, STUDIES;
        /// The model is inadequate if its own errors on baseline recordings are more than this multiple of the noise, and
        /// the errors in the data less than this multiple of those. Errors of a channel below this multiple are within its band.
        inadequate_ratio: f64 = 2.0, "–", FACTOR, STUDIES;
        /// Least share of a channel's variation that these errors are.
        inadequate_share: f64 = 0.1, "–", SHARE, USUAL;
        /// A candidate is confusable with a cause if the odds of the cause against it are less than this. Causes with larger odds against none are
        /// established.
        confusable_odds: f64 = 1000.0, "–", FACTOR, STUDIES;
        /// A candidate is also confusable with a cause if it removes at least this share of the error that the cause removes.
        confusable_share: f64 = 0.95, "–", SHARE, STUDIES;
        /// Least ridge of the flexible model, relative to unit columns.
        explainable_ridge: f64 = 1e-3, "–", POSITIVE, STUDIES;
        /// Most weights of the flexible model, as a share of the rows from which it learns; the ridge is raised up to there.
        explainable_weights: f64 = 0.5, "–", SHARE, USUAL;
        /// Size at which the direction of a motion turns in the flexible model, relative to its root mean square.
        direction_width: f64 = 0.05, "–", POSITIVE, STUDIES;
        /// Widths of plays in the flexible model of the joint, relative to the root mean square of the displacement.
        play_widths: [f64; 3] = [0.05, 0.2, 0.6], "–", POSITIVE, STUDIES;
        /// Time constants of relaxations in the flexible model of the joint.
        relaxations_s: [f64; 3] = [0.1, 1.0, 10.0], "s", POSITIVE, STUDIES;
        /// Fewest causes that may be learned from baseline recordings.
        baseline_causes: usize = 2, "causes", COUNT, STUDIES;
    }
}

settings! {
    /// The residual summary. Lengths of time and frequencies are those of the joint; for a field they follow from the
    /// length of its experiments.
    "residual" ResidualSettings {
        /// Groups of equal size in which a residual is averaged over a factor.
        groups: usize = 12, "groups", [2.0, 1e4], USUAL;
        /// Length of the pieces of the averaged periodogram.
        spectrum_piece_s: f64 = 8.0, "s", POSITIVE, RIG;
        /// Highest frequency of the spectrum.
        spectrum_highest_hz: f64 = 8.0, "Hz", POSITIVE, RIG;
        /// Spectral lines in `diagnosis.json`.
        lines: usize = 4, "lines", COUNT, USUAL;
        /// Strongest lines among which one is looked for that the excitation does not have.
        foreign_lines: usize = 8, "lines", COUNT, USUAL;
        /// Least share of the power of a line that the excitation does not have.
        foreign_line_share: f64 = 0.2, "–", SHARE, STUDIES;
        /// Largest power of the excitation at such a line, relative to the residual's.
        foreign_line_excitation: f64 = 0.02, "–", SHARE, STUDIES;
        /// Length of a block of the time profile.
        profile_block_s: f64 = 1.0, "s", POSITIVE, USUAL;
        /// Drop of the logarithm of the variance from which a split of a recording counts as a jump.
        jump_drop: f64 = 0.7, "–", COST, STUDIES;
        /// Shortest stretch on both sides of a jump.
        jump_margin_s: f64 = 3.0, "s", COST, STUDIES;
        /// Fewest rows on both sides of a jump.
        jump_margin_rows: usize = 8, "rows", COUNT, USUAL;
        /// Fewest of these stretches in a recording in which a jump is looked for.
        jump_fewest_margins: usize = 4, "stretches", [2.0, 1e6], USUAL;
        /// Size at which the direction of a motion turns as a factor, relative to the root mean square of the velocity.
        direction_width: f64 = 0.1, "–", POSITIVE, USUAL;
        /// Time before and after an instant from which phase and amplitude of the joint's motion are taken.
        cycle_window_s: f64 = 1.0, "s", POSITIVE, RIG;
        /// Every how many grid points of it are read.
        cycle_stride: usize = 8, "points", COUNT, TIME;
        /// Pieces of the averaged periodogram in the shortest experiment of a field.
        field_spectrum_pieces: f64 = 5.0, "pieces", FACTOR, USUAL;
        /// Frequencies of the spectrum of a field.
        field_spectrum_lines: f64 = 64.0, "lines", FACTOR, USUAL;
        /// Blocks of the time profile in the shortest experiment of a field.
        field_profile_blocks: f64 = 20.0, "blocks", FACTOR, USUAL;
        /// Shortest stretch on both sides of a jump, as a share of the shortest experiment of a field.
        field_jump_margin: f64 = 0.1, "–", SHARE, USUAL;
        /// Share of the root mean square from which the mean of a residual is mentioned.
        steady_share: f64 = 0.5, "–", SHARE, USUAL;
        /// Most factors that are mentioned.
        mentioned_factors: usize = 3, "factors", COUNT, USUAL;
        /// Most jumps that are mentioned.
        mentioned_jumps: usize = 2, "jumps", COUNT, USUAL;
        /// Multiple of the noise below which the structure of a residual is not described.
        nothing_ratio: f64 = 2.0, "–", COST, STUDIES;
        /// Share of the variance from which a factor is mentioned.
        mentioned_share: f64 = 0.15, "–", SHARE, STUDIES;
    }
}

settings! {
    /// Confidence intervals of parameters and of the error reduction.
    "intervals" IntervalSettings {
        /// Length of a block of rows of the joint for clustered covariances, the null test and the bootstrap.
        block_s: f64 = 2.0, "s", POSITIVE, STUDIES;
        /// Blocks of the window of one experiment of a field.
        field_blocks: usize = 10, "blocks", [2.0, 1e6], USUAL;
        /// Difference of the cost below which two shapes of one effect, or two alternatives, fit equally well.
        equal_cost: f64 = 12.0, "cost", COST, STUDIES;
        /// Iterations of the fits of other shapes.
        shape_iterations: usize = 8, "iterations", COUNT, TIME;
        /// Iterations of the fit of a named effect to the baseline recordings.
        baseline_iterations: usize = 6, "iterations", COUNT, TIME;
        /// Fraction of the magnitudes of a named effect from which a second fit to the baseline recordings starts: where the effect is absent,
        /// a fit from its own values may stop at a local minimum.
        baseline_small_share: f64 = 0.05, "–", SHARE, STUDIES;
        /// Resamplings of the bootstrap of the error reduction.
        resamples: usize = 1000, "draws", [40.0, 1e5], USUAL;
        /// Fewest blocks of one excitation frequency of a recording in the bootstrap.
        stratum_blocks: usize = 3, "blocks", COUNT, STUDIES;
        /// Shortest block of the bootstrap of the joint.
        shortest_block_s: f64 = 0.5, "s", POSITIVE, STUDIES;
    }
}

settings! {
    /// What is learned of an error that no listed cause explains, and the search for a law in it.
    "remainder" RemainderSettings {
        /// Total length of the joint's training and validation recordings from which corrections are learned and laws are selected;
        /// shorter in proportion where a step of 4 ms needs more than two integration steps. Longer recordings are represented by
        /// pieces that cover the motion; the selected laws are fitted to all rows.
        most_s: f64 = 20.0, "s", [1.0, 1e6], TIME;
        /// The same of one recording: longer motion of the same pressures repeats itself.
        most_of_one_s: f64 = 10.0, "s", [1.0, 15.0], TIME;
        /// Total length of all training and validation recordings, in the same proportion, up to which all of them are learned from if
        /// the pieces, each with an offset of its own, show no error and the recordings do.
        most_slow_s: f64 = 80.0, "s", COST, TIME;
        /// Work of the diagnosis of a single recording after which no further corrections and laws are tried, as simulations of it without
        /// effects in steps of 4 ms, or of 70 s if it is shorter. Several recordings have no limit.
        most_simulations: f64 = 3500.0, "simulations", COST, TIME;
        /// Length of the shortest of these pieces.
        piece_s: f64 = 6.0, "s", [1.0, 1e6], TIME;
        /// Prior standard deviation of the offset of the first pressure samples of a piece: what remembers the time before it is
        /// unknown there.
        piece_offset_kpa: f64 = 5.0, "kPa", POSITIVE, STUDIES;
        /// Standard deviations of the prior of the coefficients of a smooth correction, relative to the size of what acts where
        /// it acts; the validation data choose.
        deviations: [f64; 4] = [0.03, 0.1, 0.3, 0.01], "–", POSITIVE, STUDIES;
        /// Most further steps with the same Jacobian in an iteration of a fit of corrections and laws, which are nearly linear.
        jacobian_reuses: usize = 3, "steps", [0.0, 20.0], TIME;
        /// Iterations of the fit of a correction.
        iterations: usize = 4, "iterations", COUNT, TIME;
        /// Share of the squared error of the validation data that a correction must remove.
        learned_share: f64 = 0.1, "–", SHARE, STUDIES;
        /// Probability by chance of the share that it removes, over blocks of time, below which it is learned.
        learned_probability: f64 = 0.01, "–", SHARE, USUAL;
        /// Drop of minus two times the logarithm of the posterior probability on the validation or the test data that shows that the
        /// error is smaller, wherever it is.
        clear_evidence: f64 = 20.0, "–", COST, USUAL;
        /// Share of the squared error of the validation data from which a correction needs no memory and no further place.
        enough_share: f64 = 0.99, "–", SHARE, TIME;
        /// Multiple of the first estimate of the noise below which a channel has nothing to learn.
        nothing_ratio: f64 = 1.25, "–", FACTOR, STUDIES;
        /// The same where the diagnosis found nothing, or called the error explained.
        doubt_ratio: f64 = 3.0, "–", FACTOR, STUDIES;
        /// Most terms of a law.
        terms: usize = 3, "terms", [1.0, 6.0], STUDIES;
        /// Sums of terms that are followed while laws are put together.
        beam: usize = 12, "sums", COUNT, TIME;
        /// Laws of each length that are fitted through the simulation.
        refined: usize = 7, "laws", COUNT, TIME;
        /// Iterations of these fits.
        law_iterations: usize = 10, "iterations", COUNT, TIME;
        /// Rounds in which laws are put together anew about the best one so far.
        rounds: usize = 2, "rounds", COUNT, TIME;
        /// Rise of the mean square of a channel, relative to it or to its noise, below which a shorter law is as good.
        notable_rise: f64 = 0.1, "–", POSITIVE, STUDIES;
        /// Share of the squared error that a law removes which a further term must carry.
        term_share: f64 = 0.02, "–", SHARE, STUDIES;
        /// Rise of minus two times the log-likelihood per row of the validation data, summed over the channels, from which a correction is
        /// much worse than the causes that a law would replace: the mean square of one channel is larger by a tenth.
        much_worse: f64 = 0.1, "–", POSITIVE, STUDIES;
        /// A law replaces the correction if it removes at least this share of the squared error that the correction removes.
        law_share: f64 = 0.8, "–", SHARE, STUDIES;
        /// Blocks of data that are left out in turn to see on which variables a correction depends.
        folds: usize = 8, "folds", [2.0, 1e3], USUAL;
    }
}
