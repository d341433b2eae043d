use pam_trajectory::AnyLoss;

/// One line and the table of a configuration file that says the same.
#[test]
fn lines_say_what_tables_say() {
    for (line, json) in [
        ("published", r#"{"kind":"published"}"#),
        ("squared:weights=100/1e2/1/0.5", r#"{"kind":"squared","weights":[100,100,1,0.5]}"#),
        ("normalised", r#"{"kind":"normalised"}"#),
        (
            "huber:form=huber,thresholds=0.5/5/2/2,weights=1/1/1/1",
            r#"{"kind":"huber","form":"huber","thresholds":[0.5,5,2,2],"weights":[1,1,1,1]}"#,
        ),
        (
            "masked:every=4,intervals_s=0..10/20..30.5,of=masked:intervals_s=1..2,of=paper",
            r#"{"kind":"masked","every":4,"intervals_s":[[0,10],[20,30.5]],
                "of":{"kind":"masked","intervals_s":[[1,2]],"of":{"kind":"paper"}}}"#,
        ),
    ] {
        assert_eq!(line.parse::<AnyLoss>().unwrap(), serde_json::from_str(json).unwrap(), "{line}");
    }
}

#[test]
fn wrong_lines_are_refused() {
    for (line, why) in [
        // Further losses stand between these.
        ("hinge", "known: paper, published, "),
        ("hinge", "squared, normalised, huber, masked"),
        ("squared", "missing field `weights`"),
        ("squared:weights=1/1/1", "length 4"),
        ("squared:weights=1/1/1/x", "`x` is not a number"),
        ("squared:weights=1/1/1/-1", "not negative"),
        ("squared:weights=1/1/1/1,weights=1/1/1/1", "given twice"),
        ("paper:weights=1/1/1/1", "unknown field"),
        ("normalised:2", "`2` is not KEY=VALUE"),
        ("masked:every=2", "missing field `of`"),
        ("masked:intervals_s=2..1,of=paper", "end after it begins"),
        ("masked:of=hinge", "unknown variant `hinge`"),
    ] {
        let message = line.parse::<AnyLoss>().unwrap_err().to_string();
        assert!(message.contains(why) && message.contains(line), "{line}: {message}");
    }
}
