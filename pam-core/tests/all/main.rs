//! Activations, forces, the joint, scalars and vector kernels against their definitions.

mod activation;
mod choice;
mod own_activation;
mod force {
    mod mlp;
    mod parametric;
}
mod joint {
    mod field;
    mod geometry;
    mod parameters;
}
mod scalar;
mod simd {
    mod gemm;
    mod math;
}
mod units;
