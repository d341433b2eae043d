//! Gradients of bounded length.

/// Scales a gradient down to `largest` if its Euclidean norm exceeds it; returns the norm it had.
pub fn clip_to_norm(gradient: &mut [f64], largest: f64) -> f64 {
    let norm = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
    if norm > largest {
        let factor = largest / norm;
        for g in gradient {
            *g *= factor;
        }
    }
    norm
}
