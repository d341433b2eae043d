//! Forward and backward passes over a block of points.

use super::{BatchNetwork, NetworkSums};
use pam_core::ActivationFunction;
use pam_core::simd::gemm::{Finish, Layout, Product, Start};
use pam_core::simd::{AlignedVec, Float, arch};
use pulp::{Simd, WithSimd};

/// Memory for one block of points: per hidden layer the values, the slopes of the activation and the
/// cotangents before it.
#[derive(Debug, Clone)]
pub struct NetworkBlock<T> {
    capacity: usize,
    values: Vec<AlignedVec<T>>,
    slopes: Vec<AlignedVec<T>>,
    cotangents: Vec<AlignedVec<T>>,
    /// Output cotangents times the weights of the points.
    weighted: AlignedVec<T>,
}

impl<T: Float> NetworkBlock<T> {
    /// Number of points that fit.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.capacity
    }
}

impl<T: Float, A: ActivationFunction> BatchNetwork<T, A> {
    /// Memory for up to `capacity` points.
    #[must_use]
    pub fn block(&self, capacity: usize) -> NetworkBlock<T> {
        let hidden = &self.layers[..self.hidden()];
        let buffers =
            || hidden.iter().map(|l| AlignedVec::zeros(capacity * l.output_stride)).collect();
        NetworkBlock {
            capacity,
            values: buffers(),
            slopes: buffers(),
            cotangents: buffers(),
            weighted: AlignedVec::zeros(capacity * self.outputs()),
        }
    }

    /// How many numbers of a point [`values_into`](Self::values_into) keeps: the hidden layers but the
    /// first, which is cheap to compute again.
    #[must_use]
    pub fn kept_len(&self) -> usize {
        self.layers[..self.hidden()].iter().skip(1).map(|l| l.output_stride).sum()
    }

    /// Values only: writes the outputs of `points` points to `out`, `[points, output_stride]`.
    ///
    /// `input` is `[points, input_stride]`; `bias` is the (folded) first bias, one for all points or
    /// one for each. Unless `kept` is empty it receives, `[points, kept_len]`, what lets
    /// [`forward_into`](Self::forward_into) do without the large products.
    ///
    /// # Panics
    /// If a slice is too short for `points`, or these are more than the block holds.
    pub fn values_into(
        &self,
        points: usize,
        bias: &[T],
        input: &[T],
        out: &mut [T],
        kept: &mut [T],
        block: &mut NetworkBlock<T>,
    ) {
        let relu = self.relu_slope();
        let kept_len = self.kept_len();
        let mut offset = 0;
        for k in 0..self.hidden() {
            let finish = relu.map_or(Finish::Store, Finish::LeakyRelu);
            self.layer_product(k, points, bias, input, finish, block);
            let layer = &self.layers[k];
            let values = &mut block.values[k][..points * layer.output_stride];
            if k > 0 && !kept.is_empty() {
                // The value of a leaky ReLU determines its slope; other activations need their argument.
                let width = layer.output_stride;
                for (from, to) in
                    values.chunks_exact(width).zip(kept.chunks_exact_mut(kept_len.max(1)))
                {
                    to[offset..offset + width].copy_from_slice(from);
                }
                offset += width;
            }
            if relu.is_none() {
                self.activation.apply_to_batch(values);
            }
        }
        self.output_layer(points, bias, input, out, &[], block);
    }

    /// Like [`values_into`](Self::values_into), and leaves in `block` what the other passes need.
    /// `kept` is what was kept of these points, or empty.
    ///
    /// # Panics
    /// As [`values_into`](Self::values_into).
    pub fn forward_into(
        &self,
        points: usize,
        bias: &[T],
        input: &[T],
        out: &mut [T],
        kept: &[T],
        block: &mut NetworkBlock<T>,
    ) {
        let relu = self.relu_slope();
        let kept_len = self.kept_len();
        let mut offset = 0;
        for k in 0..self.hidden() {
            let width = self.layers[k].output_stride;
            let len = points * width;
            if k == 0 || kept.is_empty() {
                let finish = relu.map_or(Finish::Store, Finish::LeakyRelu);
                self.layer_product(k, points, bias, input, finish, block);
            } else if !self.stays_kept(k, kept) {
                let kept = kept.chunks_exact(kept_len.max(1)).map(|p| &p[offset..offset + width]);
                for (to, from) in block.values[k][..len].chunks_exact_mut(width).zip(kept) {
                    to.copy_from_slice(from);
                }
                offset += width;
            }
            if relu.is_none() {
                let (values, slopes) = (&mut block.values[k][..len], &mut block.slopes[k][..len]);
                self.activation.apply_to_batch_with_slopes(values, slopes);
            }
        }
        self.output_layer(points, bias, input, out, kept, block);
    }

    /// Returns `true` if the values of hidden layer `k` are read where they were kept: for a leaky ReLU,
    /// whose values determine its slopes, if it is the only layer there.
    fn stays_kept(&self, k: usize, kept: &[T]) -> bool {
        k == 1 && self.hidden() == 2 && !kept.is_empty() && self.relu_slope().is_some()
    }

    /// The values of hidden layer `k`.
    fn hidden_values<'b>(&self, k: usize, kept: &'b [T], values: &'b [AlignedVec<T>]) -> &'b [T] {
        if self.stays_kept(k, kept) { kept } else { &values[k] }
    }

    /// The slope of a leaky ReLU, which the product itself applies.
    fn relu_slope(&self) -> Option<T> {
        self.activation.relu_slope().map(T::narrow)
    }

    /// The product of hidden layer `k` into its values.
    fn layer_product(
        &self,
        k: usize,
        points: usize,
        bias: &[T],
        input: &[T],
        finish: Finish<'_, T>,
        block: &mut NetworkBlock<T>,
    ) {
        assert!(points <= block.capacity, "{points} points do not fit the block");
        let layer = &self.layers[k];
        let (done, rest) = block.values.split_at_mut(k);
        Product {
            rows: layer.output_stride,
            inner: layer.inputs,
            columns: points,
            a: &layer.columns,
            b: if k == 0 { input } else { &done[k - 1] },
            layout: Layout::Columns,
            b_stride: layer.input_stride,
            start: Start::Columns(self.start(k, points, bias)),
            finish,
            c: &mut rest[0],
        }
        .run();
    }

    /// The bias that layer `k` starts from.
    fn start<'b>(&'b self, k: usize, points: usize, bias: &'b [T]) -> &'b [T] {
        let layer = &self.layers[k];
        match k {
            0 if bias.len() >= points * layer.output_stride => bias,
            0 => &bias[..layer.output_stride],
            _ => &layer.bias,
        }
    }

    /// The last layer, which has no activation.
    fn output_layer(
        &self,
        points: usize,
        bias: &[T],
        input: &[T],
        out: &mut [T],
        kept: &[T],
        block: &NetworkBlock<T>,
    ) {
        let (last, layer) = (self.hidden(), self.last());
        let source =
            if last == 0 { input } else { self.hidden_values(last - 1, kept, &block.values) };
        if last > 0 && layer.outputs < 4 {
            self.few_outputs(points, source, out);
            return;
        }
        Product {
            rows: layer.output_stride,
            inner: layer.inputs,
            columns: points,
            a: &layer.columns,
            b: source,
            layout: Layout::Columns,
            b_stride: layer.input_stride,
            start: Start::Columns(self.start(last, points, bias)),
            finish: Finish::Store,
            c: out,
        }
        .run();
    }

    /// The last layer when it has so few outputs that dot products are cheaper.
    fn few_outputs(&self, points: usize, source: &[T], target: &mut [T]) {
        let layer = self.last();
        arch().dispatch(Dots {
            points,
            vectors: &layer.rows,
            source,
            stride: layer.input_stride,
            start: &layer.bias[..layer.outputs],
            target,
            out_stride: layer.output_stride,
        });
    }

    /// From cotangents of the outputs, `[points, outputs]`, to cotangents of the inputs,
    /// `[points, inputs]`, after [`forward_into`](Self::forward_into) with the same `kept`. Holds the
    /// cotangents of the layers for [`accumulate`](Self::accumulate).
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn pull_back(
        &self,
        points: usize,
        cotangent: &[T],
        input_cotangent: &mut [T],
        kept: &[T],
        block: &mut NetworkBlock<T>,
    ) {
        let last = self.hidden();
        for k in (1..=last).rev() {
            let layer = &self.layers[k];
            let len = points * layer.input_stride;
            let (below, above) = block.cotangents.split_at_mut(k);
            let target = &mut below[k - 1][..len];
            let (source, b_stride) = if k == last {
                (cotangent, layer.outputs)
            } else {
                (&above[0][..], layer.output_stride)
            };
            Product {
                rows: layer.input_stride,
                inner: layer.outputs,
                columns: points,
                a: &layer.rows,
                b: source,
                layout: Layout::Columns,
                b_stride,
                start: Start::Zero,
                finish: self.slopes_of(k - 1, kept, &block.values, &block.slopes),
                c: target,
            }
            .run();
        }
        let first = &self.layers[0];
        let target = &mut input_cotangent[..points * first.inputs];
        if last == 0 {
            target.fill(T::default());
            for (c, t) in cotangent
                .chunks_exact(first.outputs)
                .zip(target.chunks_exact_mut(first.inputs))
                .take(points)
            {
                for (column, t) in first.columns.chunks_exact(first.output_stride).zip(t) {
                    for (&w, &c) in column.iter().zip(c) {
                        *t += w * c;
                    }
                }
            }
            return;
        }
        arch().dispatch(Dots {
            points,
            vectors: &first.columns,
            source: &block.cotangents[0],
            stride: first.output_stride,
            start: &[],
            target,
            out_stride: first.inputs,
        });
    }

    /// Multiplication by the slopes of hidden layer `k`.
    fn slopes_of<'b>(
        &self,
        k: usize,
        kept: &'b [T],
        values: &'b [AlignedVec<T>],
        slopes: &'b [AlignedVec<T>],
    ) -> Finish<'b, T> {
        match self.relu_slope() {
            Some(slope) => Finish::Gate { values: self.hidden_values(k, kept, values), slope },
            None => Finish::Multiply(&slopes[k]),
        }
    }

    /// Adds the weight cotangents of all points, each weighed by `weights[point]`, to `sums`. To be
    /// called once after [`pull_back`](Self::pull_back) with the same `input`, `cotangent` and `kept`; it
    /// uses up the cotangents in `block`.
    ///
    /// # Panics
    /// If a slice is too short.
    #[allow(clippy::too_many_arguments)]
    pub fn accumulate(
        &self,
        points: usize,
        weights: &[T],
        input: &[T],
        cotangent: &[T],
        kept: &[T],
        sums: &mut NetworkSums<T>,
        block: &mut NetworkBlock<T>,
    ) {
        let last = self.hidden();
        for k in 0..last {
            let layer = &self.layers[k];
            let cotangents = &mut block.cotangents[k][..points * layer.output_stride];
            let stride = layer.output_stride;
            arch().dispatch(Weigh { values: cotangents, weights, stride });
            let source =
                if k == 0 { input } else { self.hidden_values(k - 1, kept, &block.values) };
            let add = |b: &[T], columns: usize, b_stride: usize, c: &mut [T]| {
                Product {
                    rows: layer.output_stride,
                    inner: points,
                    columns,
                    a: cotangents,
                    b,
                    layout: Layout::Rows,
                    b_stride,
                    start: Start::Held,
                    finish: Finish::Store,
                    c,
                }
                .run();
            };
            add(source, layer.inputs, layer.input_stride, &mut sums.weights[k]);
            add(&sums.ones[..points], 1, 1, &mut sums.biases[k]);
        }
        let layer = self.last();
        for (w, (c, &weight)) in block
            .weighted
            .chunks_exact_mut(layer.outputs)
            .zip(cotangent.chunks_exact(layer.outputs).zip(weights))
            .take(points)
        {
            for ((w, &c), b) in w.iter_mut().zip(c).zip(&mut *sums.biases[last]) {
                *w = c * weight;
                *b += *w;
            }
        }
        let source =
            if last == 0 { input } else { self.hidden_values(last - 1, kept, &block.values) };
        // The last layer's sum is kept row by row: its outputs are few and would be mostly padding.
        Product {
            rows: layer.input_stride,
            inner: points,
            columns: layer.outputs,
            a: source,
            b: &block.weighted,
            layout: Layout::Rows,
            b_stride: layer.outputs,
            start: Start::Held,
            finish: Finish::Store,
            c: &mut sums.weights[last],
        }
        .run();
    }

    /// From tangents of the inputs, `[points, input_stride]`, to tangents of the outputs,
    /// `[points, output_stride]`, after [`forward_into`](Self::forward_into) without `kept`; weights and constants do
    /// not change. Uses up the cotangents in `block`.
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn push_forward(
        &self,
        points: usize,
        tangent: &[T],
        out: &mut [T],
        block: &mut NetworkBlock<T>,
    ) {
        let last = self.hidden();
        for (k, layer) in self.layers.iter().enumerate() {
            let len = points * layer.output_stride;
            let (done, rest) = block.cotangents.split_at_mut(k.min(last));
            let source = if k == 0 { tangent } else { &done[k - 1] };
            let target = if k == last { &mut out[..len] } else { &mut rest[0][..len] };
            Product {
                rows: layer.output_stride,
                inner: layer.inputs,
                columns: points,
                a: &layer.columns,
                b: source,
                layout: Layout::Columns,
                b_stride: layer.input_stride,
                start: Start::Zero,
                finish: if k < last {
                    self.slopes_of(k, &[], &block.values, &block.slopes)
                } else {
                    Finish::Store
                },
                c: target,
            }
            .run();
        }
    }
}

/// Each point times its weight.
struct Weigh<'a, T> {
    values: &'a mut [T],
    weights: &'a [T],
    stride: usize,
}

impl<T: Float> WithSimd for Weigh<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for (point, &w) in self.values.chunks_exact_mut(self.stride).zip(self.weights) {
            for v in point {
                *v *= w;
            }
        }
    }
}

/// `target[p, d] = start[d] + vectors[d] · source[p]`, for few vectors. Without a start from zero.
struct Dots<'a, T> {
    points: usize,
    vectors: &'a [T],
    source: &'a [T],
    stride: usize,
    start: &'a [T],
    target: &'a mut [T],
    out_stride: usize,
}

impl<T: Float> WithSimd for Dots<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (d, w) in self.vectors.chunks_exact(self.stride).enumerate() {
            let (w, _) = T::split::<S>(w);
            let start = self.start.get(d).copied().unwrap_or_default();
            let at = |point: usize| {
                let (x, _) = T::split::<S>(&self.source[point * self.stride..][..self.stride]);
                &x[..w.len()]
            };
            let mut point = 0;
            // Four points at a time: each addition waits for the one before it, but not for those of other points.
            while point + 4 <= self.points {
                let x = [at(point), at(point + 1), at(point + 2), at(point + 3)];
                let mut sums = [T::splat(simd, T::default()); 4];
                for (k, &w) in w.iter().enumerate() {
                    for (sum, x) in sums.iter_mut().zip(x) {
                        *sum = T::fused(simd, w, x[k], *sum);
                    }
                }
                for (n, sum) in sums.into_iter().enumerate() {
                    self.target[(point + n) * self.out_stride + d] = start + T::across(simd, sum);
                }
                point += 4;
            }
            for point in point..self.points {
                let mut sum = T::splat(simd, T::default());
                for (&w, &x) in w.iter().zip(at(point)) {
                    sum = T::fused(simd, w, x, sum);
                }
                self.target[point * self.out_stride + d] = start + T::across(simd, sum);
            }
        }
    }
}
