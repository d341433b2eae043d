//! Inner products.

/// `Σ a_k b_k` over the shorter of both, in eight sums that do not wait for each other.
///
/// The order of the sums is fixed, so results repeat bit for bit.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let mut sums = [0.0; 8];
    let (blocks_a, rest_a) = a[..n].as_chunks::<8>();
    let (blocks_b, rest_b) = b[..n].as_chunks::<8>();
    for (x, y) in blocks_a.iter().zip(blocks_b) {
        for ((sum, x), y) in sums.iter_mut().zip(x).zip(y) {
            *sum += x * y;
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(x, y)| x * y).sum();
    sums.iter().sum::<f64>() + rest
}
