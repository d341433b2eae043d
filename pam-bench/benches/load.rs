//! Loading and preprocessing a raw log of the published length.

use criterion::{Criterion, criterion_group, criterion_main};
use pam_bench::raw_log_text;
use pam_data::{LoadOptions, open_recordings};

fn load(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("nn_4545");
    std::fs::write(&path, raw_log_text()).expect("the log is written");
    let options = LoadOptions::default();
    let mut group = criterion.benchmark_group("load");
    group.sample_size(20);
    group.bench_function("raw log, 73 s", |b| {
        b.iter(|| open_recordings(&path, &options).expect("the log is read"));
    });
    group.finish();
}

criterion_group!(benches, load);
criterion_main!(benches);
