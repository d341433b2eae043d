"""Pressures for a motion and a stiffness, carried out on the virtual rig."""

import numpy as np

import pam_ode as pam


def main() -> None:
    model = pam.load()
    plan = pam.plan(model, "sine:A=0.5,f=0.5", 150.0, rate_hz=1000)
    print(plan)
    rig = pam.Rig(pressures_kpa=plan.pressures_kpa[0], seed=1)
    samples = rig.run(np.zeros(len(plan)), servo_kpa=plan.pressures_kpa)
    error = samples.true_displacement_mm - plan.displacement_mm
    print(f"tracking error: {np.sqrt(np.mean(error**2)):.3f} mm (RMS)")


if __name__ == "__main__":
    main()
