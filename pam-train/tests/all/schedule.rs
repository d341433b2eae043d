use pam_train::{EarlyStop, Rate, Schedule};

/// Rates of `losses.len()` epochs with a base of 8, state written and read back before each.
fn rates(schedule: Schedule, losses: &[f64]) -> Vec<f64> {
    let mut rate = Rate::new(schedule);
    losses
        .iter()
        .enumerate()
        .map(|(epoch, &loss)| {
            rate = serde_json::from_str(&serde_json::to_string(&rate).unwrap()).unwrap();
            rate.next(8.0, epoch, losses.len(), loss)
        })
        .collect()
}

fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() < 1e-12, "{found:?}, expected {expected:?}");
    }
}

const NO_LOSS: [f64; 6] = [f64::NAN; 6];

#[test]
fn rates_that_know_no_loss() {
    assert_close(&rates(Schedule::default(), &NO_LOSS), &[8.0; 6]);
    let warm = Schedule::Constant { warm_up_epochs: 3 };
    assert_close(&rates(warm, &NO_LOSS), &[2.0, 4.0, 6.0, 8.0, 8.0, 8.0]);
    let falling = Schedule::Exponential { per_epoch: 0.5, warm_up_epochs: 1 };
    assert_close(&rates(falling, &NO_LOSS), &[4.0, 8.0, 4.0, 2.0, 1.0, 0.5]);
}

/// cos(0, 60°, 120°) = 1, ½, −½: shares 1, ¾, ¼; with a final share of ½: 1, 7/8, 5/8.
#[test]
fn cosine_ends_at_its_share_after_the_last_epoch() {
    let cosine = Schedule::Cosine { final_share: 0.0, warm_up_epochs: 0 };
    assert_close(&rates(cosine, &NO_LOSS[..3]), &[8.0, 6.0, 2.0]);
    let cosine = Schedule::Cosine { final_share: 0.5, warm_up_epochs: 3 };
    assert_close(&rates(cosine, &NO_LOSS), &[2.0, 4.0, 6.0, 8.0, 7.0, 5.0]);
    assert_eq!(Rate::new(cosine).next(8.0, 6, 6, f64::NAN), 4.0);
    assert_eq!(Rate::new(cosine).next(8.0, 9, 6, f64::NAN), 4.0);
}

fn plateau(patience: usize, smallest_share: f64, warm_up_epochs: usize) -> Schedule {
    Schedule::Plateau { factor: 0.5, patience, smallest_share, warm_up_epochs }
}

#[test]
fn a_plateau_halves_the_rate() {
    // The best loss is that of epoch 1; epochs 2 and 3 are not better, nor are 4 and 5.
    let losses = [2.0, 1.0, 1.0, 1.5, 1.2, 1.0, 0.5, 0.4];
    let expected = [8.0, 8.0, 8.0, 4.0, 4.0, 2.0, 2.0, 2.0];
    assert_close(&rates(plateau(2, 0.0, 0), &losses), &expected);
    // An improvement between them starts the count anew.
    let losses = [2.0, 2.0, 1.0, 1.0, 0.9, 0.9, 0.9];
    assert_close(&rates(plateau(2, 0.0, 0), &losses), &[8.0, 8.0, 8.0, 8.0, 8.0, 8.0, 4.0]);
    // Of 1, 0.99995 is not 10⁻⁴ lower and 0.9998 is.
    assert_close(&rates(plateau(1, 0.0, 0), &[1.0, 0.99995]), &[8.0, 4.0]);
    assert_close(&rates(plateau(1, 0.0, 0), &[1.0, 0.9998]), &[8.0, 8.0]);
}

#[test]
fn a_plateau_has_a_floor_and_takes_failures_for_no_improvement() {
    assert_close(&rates(plateau(1, 0.3, 0), &[1.0; 5]), &[8.0, 4.0, 2.4, 2.4, 2.4]);
    let losses = [f64::NAN, f64::INFINITY, 1.0, f64::NAN, f64::NAN];
    assert_close(&rates(plateau(2, 0.0, 0), &losses), &[8.0, 8.0, 8.0, 8.0, 4.0]);
    // Three epochs of warm-up do not count: 1 better, then two that are not.
    let losses = [1.0, 2.0, 2.0, 2.0, 2.0, 2.0];
    assert_close(&rates(plateau(2, 0.0, 3), &losses), &[2.0, 4.0, 6.0, 8.0, 4.0, 4.0]);
}

#[test]
fn early_stop_waits_for_its_patience() {
    let stops = |losses: &[f64]| {
        let mut stop = EarlyStop::new(2);
        losses
            .iter()
            .map(|&loss| {
                stop = serde_json::from_str(&serde_json::to_string(&stop).unwrap()).unwrap();
                stop.stops(loss)
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(stops(&[3.0, 2.0, 2.0, 1.9, 2.0, 1.9]), [false, false, false, false, false, true]);
    assert_eq!(stops(&[1.0, f64::NAN, f64::INFINITY]), [false, false, true]);
    // The least improvement is one.
    assert_eq!(stops(&[1.0, 1.1, 1.0 - 1e-9, 1.1]), [false; 4]);
    let mut stop = EarlyStop::new(5);
    for loss in [3.0, 1.0, 2.0, 2.0] {
        assert!(!stop.stops(loss));
    }
    assert_eq!((stop.best(), stop.waited()), (Some(1.0), 2));
}

#[test]
fn schedules_are_read_by_name() {
    let read = |json: &str| serde_json::from_str::<Schedule>(json);
    assert_eq!(read(r#"{"kind":"constant"}"#).unwrap(), Schedule::default());
    assert_eq!(
        read(r#"{"kind":"cosine","final_share":0.1,"warm_up_epochs":5}"#).unwrap(),
        Schedule::Cosine { final_share: 0.1, warm_up_epochs: 5 }
    );
    let default =
        Schedule::Plateau { factor: 0.5, patience: 10, smallest_share: 1e-3, warm_up_epochs: 0 };
    assert_eq!(read(r#"{"kind":"plateau"}"#).unwrap(), default);
    default.check().unwrap();
    assert!(read(r#"{"kind":"exponential"}"#).is_err(), "it has no default");
    assert!(read(r#"{"kind":"constant","factor":1.0}"#).is_err());
    assert!(read(r#"{"kind":"exponential","per_epoch":1.5}"#).unwrap().check().is_err());
    assert!(read(r#"{"kind":"plateau","factor":0.0}"#).unwrap().check().is_err());
    assert!(read(r#"{"kind":"cosine","final_share":2.0}"#).unwrap().check().is_err());
}
