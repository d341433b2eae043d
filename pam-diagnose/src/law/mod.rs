//! Laws.

mod design;
mod find;
mod library;
mod refine;
mod select;

pub(crate) use find::find;
