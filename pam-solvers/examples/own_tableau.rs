//! A Runge–Kutta method of one's own: Kutta's 3/8 rule of 1901 (Hairer, Nørsett and Wanner, *Solving
//! Ordinary Differential Equations I*, 1993, table II.1.2).
//!
//! To give it a name, put the constructor into `pam-solvers/src/tableau/three_eighths.rs` and add two lines to
//! `mod.rs` there: `mod three_eighths;` and `"rk38" => three_eighths::three_eighths,`.

use pam_core::FieldFn;
use pam_solvers::{ConstantStep, Integrator, NoInput, SaveAt, Tableau, Term};

/// Kutta's 3/8 rule, of order 4.
pub fn three_eighths() -> Tableau {
    let third = 1.0 / 3.0;
    Tableau::custom(
        "rk38",
        4,
        &[0.0, third, 2.0 * third, 1.0],
        &[&[], &[third], &[-third, 1.0], &[1.0, -1.0, 1.0]],
        &[1.0 / 8.0, 3.0 / 8.0, 3.0 / 8.0, 1.0 / 8.0],
    )
    .expect("four stages, explicit, consistent")
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // ẍ = −x from (1, 0) has the solution cos t.
    let field = FieldFn::new(2, 0, |_t: f64, y: &[f64], _u: &[f64], dy: &mut [f64]| {
        dy[0] = y[1];
        dy[1] = -y[0];
    });
    let term = Term::new(field, NoInput);
    let error = |step_s: f64| -> Result<f64, Box<dyn std::error::Error>> {
        let integrator = Integrator::new(three_eighths(), ConstantStep::new(step_s));
        let solution = integrator.solve(&term, 0.0, 4.0, &[1.0, 0.0], SaveAt::End)?;
        Ok((solution.state(0)[0] - 4.0_f64.cos()).abs())
    };
    let (coarse, fine) = (error(0.05)?, error(0.025)?);
    let order = (coarse / fine).log2();
    println!("errors {coarse:.2e} and {fine:.2e}: order {order:.2}");
    assert!((order - 4.0).abs() < 0.2);

    // A tableau that does not add up is refused with the reason.
    let wrong = Tableau::custom("wrong", 2, &[0.0, 1.0], &[&[], &[0.9]], &[0.5, 0.5]);
    println!("{}", wrong.expect_err("row 1 sums to 0.9, its node is 1"));
    Ok(())
}
