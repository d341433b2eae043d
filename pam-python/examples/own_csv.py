"""Data of your own: a CSV file in other units, by NumPy or pandas."""

import io

import numpy as np

import pam_ode as pam

#: Degrees, bar gauge, newtons; milliseconds.
CSV = "t_ms,angle_deg,p_flexor_bar,p_extensor_bar,force_n\n" + "\n".join(
    f"{k},{8 * np.sin(k / 80):.5f},{3.1 - 0.2 * np.sin(k / 80):.5f},{3.1 + 0.2 * np.sin(k / 80):.5f},{60 * np.sin(k / 80):.4f}"
    for k in range(1000)
)


def main() -> None:
    table = np.genfromtxt(io.StringIO(CSV), delimiter=",", names=True)
    pulley_mm, atmosphere_kpa = 6.875, 101.325
    recording = pam.Recording(
        1e-3 * table["t_ms"],
        np.deg2rad(table["angle_deg"]) * pulley_mm,
        100 * table["p_flexor_bar"] + atmosphere_kpa,
        100 * table["p_extensor_bar"] + atmosphere_kpa,
        table["force_n"],
        name="mine",
    )
    print(recording)
    print(pam.load().evaluate(recording))


if __name__ == "__main__":
    main()
