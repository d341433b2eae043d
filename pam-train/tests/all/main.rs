//! Optimisers, curricula, regularisers and training against known functions and gradients.

mod coordinates;
mod curriculum {
    mod data;
    mod overrides;
    mod settings;
}
mod events;
mod field;
mod optimiser {
    mod adam;
    mod clip;
    mod lbfgs;
    mod settings;
}
mod regulariser {
    mod kinds;
    mod l2;
    mod passivity;
    mod testing;
}
mod schedule;
mod segments;
mod training {
    mod exact;
    mod own_activation;
}
mod warm_start {
    mod initial;
}
