"""A first prediction: a model, a recording, scores, a gradient."""

import numpy as np

import pam_ode as pam


def main() -> None:
    model = pam.load()
    time_s = np.arange(5000) * 1e-3
    force_n = 60 * np.sin(2 * np.pi * 0.5 * time_s)

    # A run that was never measured: at rest under 412 kPa (absolute) in both muscles, then driven.
    command = pam.Recording.at_rest(time_s, 412.0, force_n, name="sine")
    prediction = model.predict(command)
    print(f"largest displacement: {np.abs(prediction.displacement_mm).max():.3f} mm")
    print(f"stiffness at rest: {float(model.stiffness(0.0, pressures_kpa=412.0)):.1f} N/mm")

    # What a joint with other parameters would show, and the gradient of the loss there.
    measured = pam.load("spring-damper").predict(command).to_recording("measured")
    found = pam.value_and_gradient(model, measured)
    print(f"loss: {found.value:.4g}, norm of the gradient: {found.norm():.4g}")


if __name__ == "__main__":
    main()
