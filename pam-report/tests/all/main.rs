//! Figures and reports against the numbers that they show.

mod figure {
    mod colour_map;
    mod decimate;
    mod line;
    mod polygon_map;
}
mod force_curves;
mod parameters;
