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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_gradients_are_cut_and_short_ones_left() {
        let mut g = [3.0, 4.0];
        assert_eq!(clip_to_norm(&mut g, 1.0), 5.0);
        assert!((g[0] - 0.6).abs() < 1e-15 && (g[1] - 0.8).abs() < 1e-15);
        let mut g = [0.3, 0.4];
        clip_to_norm(&mut g, 1.0);
        assert_eq!(g, [0.3, 0.4]);
    }
}
