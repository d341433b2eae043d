//! The comparison at work.

use super::cache::{ModelCache, key, stems};
use super::config::ComparisonConfig;
use super::result::{Comparison, FinishedModel, ModelTimes};
use super::score::{Scoring, all, draw};
use super::split::Split;
use crate::error::BaselineError;
use crate::method::TrainingSet;
use pam_data::MuscleSurfaces;
use pam_data::Subject;
use std::time::Instant;

/// Progress events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<'a> {
    /// A model is fitted: its name and the share that is done.
    Fitting(&'a str, f64),
    /// A model predicts: its name and the share that is done.
    Predicting(&'a str, f64),
    /// A model is done.
    Done(&'a FinishedModel),
    /// A model was done before.
    Kept(&'a str),
}

/// Fits and scores all models of a configuration. With a folder, each model that is done is kept there, and
/// those that the same program kept for the same data, settings and seed are taken over if asked for.
///
/// # Errors
/// [`BaselineError`] of the first model that cannot be fitted; [`BaselineError::Interrupted`] if `event`
/// returns that it should stop.
pub fn compare(
    config: &ComparisonConfig,
    sets: &Split,
    surfaces: Option<&MuscleSurfaces>,
    seed: u64,
    cache: Option<ModelCache<'_>>,
    event: &(dyn Fn(Event<'_>) -> bool + Sync),
) -> Result<Comparison, BaselineError> {
    let drawn = drawn_names(config, sets);
    let scoring = Scoring::new(sets, config.evaluation.warm_up, &drawn);
    let key_of = key(config, sets, surfaces, seed, cache.map_or("", |k| k.program));
    let mut models = Vec::new();
    for (model, stem) in config.models.iter().zip(stems(&config.models)) {
        let key = key_of(model);
        if let Some(finished) = cache.and_then(|k| k.read(&stem, &key)) {
            event(Event::Kept(&model.name));
            models.push(finished);
            continue;
        }
        let training = TrainingSet { subjects: &sets.train, surfaces, seed };
        let begun = Instant::now();
        let fitted = model
            .method
            .method()
            .fit(&training, &|share| event(Event::Fitting(&model.name, share)))?;
        let fit_s = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let (result, drawn) = scoring.score(&model.name, model.method.kind(), &*fitted, &|share| {
            event(Event::Predicting(&model.name, share));
        });
        let times = ModelTimes { fit_s, predict_s: begun.elapsed().as_secs_f64() };
        let finished = FinishedModel { result, times, drawn };
        if let Some(cache) = cache {
            cache.write(&stem, key, &finished, &fitted.arrays())?;
        }
        if !event(Event::Done(&finished)) {
            return Err(BaselineError::Interrupted);
        }
        models.push(finished);
    }
    let names = |subjects: &[Subject]| subjects.iter().map(|s| s.recording.name.clone()).collect();
    let measured = all(sets)
        .into_iter()
        .filter(|s| drawn.contains(&s.recording.name))
        .map(|s| draw(&s.recording, &s.recording.displacement_mm))
        .collect();
    Ok(Comparison {
        name: config.name.clone(),
        train: names(&sets.train),
        held_out: names(&sets.held_out),
        warm_up: config.evaluation.warm_up,
        seed,
        models,
        measured,
    })
}

fn drawn_names(config: &ComparisonConfig, sets: &Split) -> Vec<String> {
    if !config.evaluation.figures.is_empty() {
        return config.evaluation.figures.clone();
    }
    let first = sets.held_out.first().or(sets.train.first());
    first.map(|s| s.recording.name.clone()).into_iter().collect()
}
