//! Sweeps, their folders and their statistics.

mod statistics;
mod sweep {
    mod parse;
}
mod table;
