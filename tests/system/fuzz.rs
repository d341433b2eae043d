//! Readers and settings files under mutated inputs: a few; `cargo run -p pam-tests --features studies --example fuzz` runs more.

use pam_tests::fuzz::run;
use pam_tests::fuzz::targets::TARGETS;

/// Every reader reads its seed, so that mutants reach its depths.
#[test]
fn the_corpus_is_sound() {
    for target in TARGETS {
        assert_eq!((target.read)(&target.seed()), Ok(()), "{}", target.name);
    }
}

#[test]
fn mutated_inputs_are_read_or_refused_with_the_name_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let each = 50;
    let cases = each * TARGETS.len() as u64;
    let counts = run(0..cases, folder.path(), |_| true);
    assert_eq!(counts.unsound, []);
    assert_eq!(counts.cases(), cases);
    // The mutators do not only destroy: each reader gets through with some of them.
    for (target, [read, refused]) in &counts.by_target {
        assert!(read + refused == each && *read > 0, "{target}: {read} read, {refused} refused");
    }
}
