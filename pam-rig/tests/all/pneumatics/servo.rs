use pam_rig::pneumatics::{Opening, Servo, ServoParameters};

#[test]
fn pulses_and_pauses_have_the_published_lengths() {
    let mut servo = Servo::new(ServoParameters::default());
    let up: Vec<Opening> = (0..60).map(|_| servo.decide(30.0, 10.0, 1.0)).collect();
    let open = |o: &[Opening]| o.iter().take_while(|o| **o != Opening::Shut).count();
    let shut = |o: &[Opening]| o.iter().take_while(|o| **o == Opening::Shut).count();
    assert_eq!((open(&up), shut(&up[10..]), open(&up[30..])), (10, 20, 10));
    let mut servo = Servo::new(ServoParameters::default());
    let down: Vec<Opening> = (0..60).map(|_| servo.decide(10.0, 30.0, 1.0)).collect();
    assert_eq!((open(&down), shut(&down[15..])), (15, 20));
    assert_eq!(down[0], Opening::Exhaust);
}

#[test]
fn inside_the_deadband_nothing_happens() {
    let mut servo = Servo::new(ServoParameters::default());
    assert!((0..100).all(|_| servo.decide(30.0, 30.4, 1.0) == Opening::Shut));
}
