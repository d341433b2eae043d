//! Fewer points than a screen can show.

/// At most about `2 · buckets` points of a time series that keep its envelope: the smallest and the
/// largest value of each bucket, in their order.
#[must_use]
pub fn envelope(x: &[f64], y: &[f64], buckets: usize) -> Vec<(f64, f64)> {
    let n = x.len().min(y.len());
    if n <= 2 * buckets {
        return x.iter().copied().zip(y.iter().copied()).collect();
    }
    let mut out = Vec::with_capacity(2 * buckets + 2);
    out.push((x[0], y[0]));
    for b in 0..buckets {
        let range = b * n / buckets..(b + 1) * n / buckets;
        let low = range.clone().min_by(|&i, &j| y[i].total_cmp(&y[j]));
        let high = range.max_by(|&i, &j| y[i].total_cmp(&y[j]));
        if let (Some(low), Some(high)) = (low, high) {
            let (first, second) = if low < high { (low, high) } else { (high, low) };
            out.push((x[first], y[first]));
            if second != first {
                out.push((x[second], y[second]));
            }
        }
    }
    out.push((x[n - 1], y[n - 1]));
    out
}

/// Every k-th point of a curve, so that at most about `most` remain.
#[must_use]
pub fn thin(x: &[f64], y: &[f64], most: usize) -> Vec<(f64, f64)> {
    let stride = x.len().div_ceil(most.max(1)).max(1);
    x.iter().copied().zip(y.iter().copied()).step_by(stride).collect()
}
