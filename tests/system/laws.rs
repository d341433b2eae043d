//! The search for laws on the joint: what hides a law shares no code with what finds it.

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use pam_data::load_model;
    use pam_diagnose::{
        DiagnoseOptions, DiagnosisSettings, RecordingSets, Verdict, diagnose, remainder,
    };
    use pam_effects::ExtendedModel;
    use pam_tests::diagnose::plant_runs;
    use pam_tests::laws::{
        LENGTH_S, LawOutcome, eighth_outside, eleventh_outside, run_law, seventh_outside,
    };
    use pam_tests::magnitudes::at_strength;
    use pam_tests::plant::{Excitation, Sensors};
    use pam_tests::published_weights;

    fn numbers(outcome: &LawOutcome, name: &str) -> [f64; 3] {
        let of = |(n, _): &&(String, [f64; 3])| n.starts_with(name);
        outcome.parameters.iter().find(of).expect("a number of the law").1
    }

    /// A motor that warms up looks like a spring factor and an added inertia, which leave nothing but noise. One law does the same
    /// with less.
    #[test]
    #[ignore = "long"]
    fn several_causes_do_not_explain_what_one_law_does() {
        let law = eighth_outside().into_iter().find(|l| l.id == "motor_heating").expect("a law");
        let outcome = run_law(&law, 1101, LENGTH_S, &DiagnosisSettings::default());
        println!("{outcome:?}");
        assert_eq!(outcome.diagnosis, "explained");
        assert!(outcome.named_before.len() >= 2, "{:?}", outcome.named_before);
        assert!(outcome.is_found() && outcome.verdict != "explained");
        assert!(outcome.named.is_empty(), "{:?}", outcome.named);
        // Hidden with 8 s.
        let [tau_s, low, high] = numbers(&outcome, "tau1");
        assert!((tau_s / 8.0 - 1.0).abs() < 0.1 && low < 8.0 && high > 8.0, "{tau_s} s");
    }

    /// A film that forms over four seconds is remembered from one piece of the recordings to the next: without that, the time would
    /// have to stand in the law.
    #[test]
    #[ignore = "long"]
    fn a_slow_memory_is_found_on_pieces_of_the_recordings() {
        let law = seventh_outside().into_iter().find(|l| l.id == "seal_warmup").expect("a law");
        let outcome = run_law(&law, 1001, LENGTH_S, &DiagnosisSettings::default());
        println!("{outcome:?}");
        assert!(outcome.is_found(), "{:?}", outcome.law);
        assert_eq!(
            (outcome.variables.as_slice(), outcome.remembers),
            (&["v".to_owned()][..], true)
        );
        let [tau_s, ..] = numbers(&outcome, "tau1");
        assert!((tau_s / 4.0 - 1.0).abs() < 0.15, "{tau_s} s");
    }

    /// A stop that the test recording touches a few times only is confirmed all the same, a leak that moves the pressure less than the
    /// sealed reading is uncertain by as well.
    #[test]
    #[ignore = "long"]
    fn what_acts_now_and_then_is_confirmed() {
        let cases =
            [("soft_stop", &[("c1", -14.0), ("w1", 0.5)][..]), ("bladder_crack", &[("c1", -1e-6)])];
        for (id, values) in cases {
            let law = eleventh_outside().into_iter().find(|l| l.id == id).expect("a law");
            let outcome = run_law(&law, 1401, LENGTH_S, &DiagnosisSettings::default());
            println!("{outcome:?}");
            assert!(outcome.is_found(), "{id}: {:?}", outcome.law);
            for (name, value) in values {
                let [found, ..] = numbers(&outcome, name);
                assert!((found / value - 1.0).abs() < 0.02, "{id}, {name}: {found}");
            }
        }
    }

    /// Each piece of a recording has an offset of its own, which hides a reading that drifts over all of them; the whole recordings show it.
    #[test]
    #[ignore = "long"]
    fn a_drift_that_no_piece_shows_is_found() {
        let law = eleventh_outside().into_iter().find(|l| l.id == "sensor_warmup").expect("a law");
        let outcome = run_law(&law, 1401, LENGTH_S, &DiagnosisSettings::default());
        println!("{outcome:?}");
        assert_eq!(outcome.diagnosis, "nothing_found");
        assert!(outcome.is_found() && outcome.verdict == "unexplained", "{:?}", outcome.law);
    }

    /// Air that flows into a volume behind a narrow passage and back: the memory begins at the pressure of the muscle.
    #[test]
    #[ignore = "long"]
    fn a_memory_of_the_pressure_is_found() {
        let law = eleventh_outside().into_iter().find(|l| l.id == "side_volume").expect("a law");
        let outcome = run_law(&law, 1401, LENGTH_S, &DiagnosisSettings::default());
        println!("{outcome:?}");
        assert!(outcome.is_found(), "{:?}", outcome.law);
        // Hidden with 0.8 s.
        let [tau_s, ..] = numbers(&outcome, "tau1");
        assert!((tau_s / 0.8 - 1.0).abs() < 0.1, "{tau_s} s");
    }

    /// In one recording the search for a law ends after the work that the settings allow, and says so; with more it goes on. Several
    /// recordings have no limit.
    #[test]
    #[ignore = "long"]
    fn the_search_in_one_recording_ends_after_its_work() {
        let saved = load_model(published_weights()).unwrap();
        let conditions = [[45.0, 45.0], [30.0, 60.0], [70.0, 60.0]];
        let excitation = Excitation::published(0.2);
        let effects = [at_strength("viscous_damping", 3.0)];
        let data = plant_runs(&saved, &conditions, &excitation, &effects, &Sensors::default(), 7);
        let model = ExtendedModel::from_saved(saved).unwrap();
        let learned = |count: usize, most_simulations: f64| {
            let mut options = DiagnoseOptions::default();
            // The damping is not in this list.
            options.candidates.retain(|e| e.info().id == "cogging");
            options.settings.remainder.most_simulations = most_simulations;
            let sets = RecordingSets { data: &data[..count], ..RecordingSets::default() };
            let d = diagnose(&model, &sets, &options, &|_, _| {}).unwrap();
            d.remainder.expect("it was asked for")
        };
        let ended = |r: &remainder::Remainder| r.sentence.contains("remainder.most_simulations");
        let none = learned(1, 0.0);
        assert_eq!(none.outcome, remainder::RemainderOutcome::NotLearned);
        assert!(ended(&none) && none.ranking.is_empty(), "{}", none.sentence);
        for all in [learned(1, 1e9), learned(3, 0.0)] {
            assert_eq!(all.outcome, remainder::RemainderOutcome::Law, "{}", all.sentence);
            assert!(!ended(&all), "{}", all.sentence);
        }
    }

    /// No law takes the place of two causes that are there.
    #[test]
    #[ignore = "long"]
    fn two_causes_that_are_there_stay() {
        let saved = load_model(published_weights()).unwrap();
        let effects = [at_strength("viscous_damping", 1.0), at_strength("constant_load", 1.0)];
        let conditions = [[45.0, 45.0], [30.0, 60.0], [70.0, 60.0]];
        let excitation = Excitation::published(0.2);
        let data = plant_runs(&saved, &conditions, &excitation, &effects, &Sensors::default(), 7);
        let model = ExtendedModel::from_saved(saved).unwrap();
        let sets = RecordingSets { data: &data, ..RecordingSets::default() };
        let d = diagnose(&model, &sets, &DiagnoseOptions::default(), &|_, _| {}).unwrap();
        let mut named = d.named();
        named.sort_unstable();
        assert_eq!(named, ["constant_load", "viscous_damping"], "{} {:?}", d.verdict, d.reasons);
        assert_eq!(d.verdict, Verdict::Explained, "{:?}", d.reasons);
        let outcome = d.remainder.as_ref().map(|r| r.outcome);
        assert_ne!(outcome, Some(remainder::RemainderOutcome::Law));
    }
}
