//! Every effect does what the vocabulary says: with its number, its unit and its sign, on truth and log.

#[path = "../common/mod.rs"]
mod common;
mod expressions;
mod gas;
mod mechanics;
mod pairs;
mod sensing;
mod unlisted;
mod vocabulary;
