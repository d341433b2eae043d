use pam_ablate::sweep::{Assignment, Sweep};
use std::path::Path;

fn parse(text: &str) -> Result<Sweep, String> {
    Sweep::parse(text, Path::new("here/s.toml")).map_err(|e| e.to_string())
}

#[test]
fn grids_run_through_all_values_with_every_seed() {
    let sweep = parse(
        "seeds = 2\n[[axis]]\nkey = \"a.b\"\nvalues = [1, 2, 3]\n[[axis]]\nname = \"how\"\n\
         [[axis.variant]]\nname = \"x\"\nset = { \"c\" = true }\n[[axis.variant]]\nname = \"y\"\n",
    )
    .unwrap();
    let cells = sweep.cells();
    assert_eq!(cells.len(), 3 * 2 * 2);
    assert_eq!(cells[0].seed, 1);
    assert_eq!(cells[1].seed, 2);
    let distinct: std::collections::BTreeSet<String> = cells
        .iter()
        .map(|c| format!("{:?} {}", c.choices.iter().map(|h| &h.label).collect::<Vec<_>>(), c.seed))
        .collect();
    assert_eq!(distinct.len(), 12);
    assert_eq!(sweep.name, "s");
}

#[test]
fn draws_stay_within_their_ranges_and_repeat() {
    let text = "seeds = [4, 9]\n[[axis]]\nkey = \"r\"\nlog_uniform = [1e-5, 1e-2]\n[[axis]]\nkey = \"n\"\n\
                integers = [2, 4]\n[search]\ndraws = 40\nseed = 3\n";
    let cells = parse(text).unwrap().cells();
    assert_eq!(cells.len(), 80);
    assert_eq!(cells, parse(text).unwrap().cells());
    let below = cells.iter().filter(|c| c.choices[0].number.unwrap() < 3e-4).count();
    assert!((20..60).contains(&below), "{below} of 80 below the geometric middle");
    for c in &cells {
        assert!((1e-5..1e-2).contains(&c.choices[0].number.unwrap()));
        assert!((2.0..=4.0).contains(&c.choices[1].number.unwrap()));
    }
    // Both seeds of a draw have the same values.
    assert_eq!(cells[0].choices, cells[1].choices);
}

#[test]
fn mistakes_are_told_with_their_line() {
    for (text, line, part) in [
        ("seeds = 0\n", 1, "seeds"),
        ("seeds = [1, 1]\n", 1, "different"),
        ("name = \"a\"\nsed = 1\n", 2, "sed"),
        ("[[axis]]\nkey = \"a\"\n", 1, "one of"),
        ("\n[[axis]]\nkey = \"a\"\nvalues = [1,\n 1]\n", 5, "twice"),
        ("[[axis]]\nkey = \"a\"\nuniform = [1.0, 2.0]\n", 1, "range"),
        ("[search]\ndraws = 0\n", 1, "draws"),
        ("[[axis]]\nkey = \"a\"\nlog_uniform = [0.0, 2.0]\n[search]\ndraws = 1\n", 1, "positive"),
    ] {
        let message = parse(text).unwrap_err();
        assert!(message.contains(&format!("s.toml:{line}:")), "{text}: {message}");
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn overrides_come_before_axes_and_not_against_them() {
    let mut sweep = parse("[[axis]]\nkey = \"a\"\nvalues = [1]\n").unwrap();
    sweep.override_with("b.c=x y").unwrap();
    assert_eq!(sweep.cells()[0].assignments[0], Assignment::new("b.c", "x y"));
    assert!(sweep.override_with("a=3").unwrap_err().to_string().contains("axis `a`"));
}
