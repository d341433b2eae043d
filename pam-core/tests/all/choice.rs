use pam_core::NamedChoice;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fruit {
    Apple,
    Pear,
}

impl NamedChoice for Fruit {
    const KIND: &'static str = "fruit";
    const ALL: &'static [(&'static str, Self, &'static str)] =
        &[("apple", Self::Apple, "round"), ("pear", Self::Pear, "longer")];
}

#[test]
fn names_are_read_and_written() {
    for (name, fruit, _) in Fruit::ALL {
        assert_eq!(Fruit::from_name(name), Ok(*fruit));
        assert_eq!(fruit.name(), *name);
    }
    let message = Fruit::from_name("plum").unwrap_err().to_string();
    assert_eq!(message, "unknown fruit `plum`; known: apple, pear");
}
