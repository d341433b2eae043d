#!/usr/bin/env python3
"""Recordings of a made-up elbow driven by two pneumatic muscles, as a lab would log them.

The elbow shares no code, geometry, units or names with the rest of the repository. Its equations, in SI units:

    I q'' = tau - r (F_biceps - F_triceps) - d q' - friction
    F_i   = (P_i - P_atm) (b^2 - 3 L_i^2)/(-4 pi n^2)     Chou and Hannaford, IEEE Trans. Robot. Autom. 12 (1996)
    P_i V_i(L_i)^k = const,  V_i = L_i (b^2 - L_i^2)/(4 pi n^2) + dead volume

with L = L0 -/+ r q. Dry friction is set-valued: a step that would cross zero velocity ends at rest. Sensors: an encoder
of 8192 counts, 12-bit pressure transducers of 0 to 10 bar gauge, a torque transducer.

    python3 elbow.py OUT          writes train-*.csv and stiff-*.csv (with 6 N of dry friction at the tendon)
"""

import math
import os
import random
import sys

R = 0.025  # pulley, m
L0, R0, ALPHA = 0.250, 0.005, math.radians(24.0)  # muscles at q = 0: length, radius, braid angle
INERTIA = 4e-3  # kg m^2: 6.4 kg at the tendon
DAMPING = 0.08  # N m s
DEAD = 1e-6  # m^3
P_ATM = 101_325.0
POLYTROPIC = 1.0
STEP = 5e-5  # s
RATE = 200  # Hz

B = L0 / math.cos(ALPHA)
TURNS = B * math.sin(ALPHA) / (2 * math.pi * R0)
K = 4 * math.pi * TURNS**2


def volume(length):
    return length * (B * B - length * length) / K + DEAD


def contraction_force(pressure, length):
    return (pressure - P_ATM) * (3 * length * length - B * B) / K


def torque(seed, amplitude):
    """A sum of sines between 0.1 and 5 Hz, smooth."""
    rng = random.Random(seed)
    sines = [
        (rng.uniform(0.4, 1.0) * amplitude / (1 + f / 2.0), 2 * math.pi * f * rng.uniform(0.93, 1.07), rng.uniform(0, 6.28))
        for f in (0.1, 0.23, 0.5, 0.9, 1.7, 3.0, 5.0)
    ]
    return lambda t: min(1.0, t / 2.0) * sum(a * math.sin(w * t + p) for a, w, p in sines)


def record(path, bar, duration, seed, amplitude, friction_n=0.0):
    """One recording; `bar` are the sealed gauge pressures at q = 0."""
    rng = random.Random(1000 + seed)
    tau = torque(seed, amplitude)
    filled = [P_ATM + 1e5 * p for p in bar]
    v0 = [volume(L0)] * 2
    q, dq = 0.0, 0.0
    every = round(1 / RATE / STEP)
    rows = []

    def pressures(q):
        lengths = (L0 - R * q, L0 + R * q)
        return lengths, [p * (v / volume(l)) ** POLYTROPIC for p, v, l in zip(filled, v0, lengths)]

    # Rest before the recording: the joint settles under its sealed muscles.
    for k in range(-round(3 / STEP), round(duration / STEP)):
        t = k * STEP
        lengths, p = pressures(q)
        now = tau(t) if k >= 0 else 0.0
        if k >= 0 and k % every == 0:
            angle = round(math.degrees(q) * 8192 / 360) * 360 / 8192
            bars = [round((x - P_ATM) / 1e5 / 10 * 4096 + rng.gauss(0, 0.8)) * 10 / 4096 for x in p]
            rows.append((1000 * t, angle, bars[1], bars[0], now + rng.gauss(0, 0.004)))
        pull = R * (contraction_force(p[0], lengths[0]) - contraction_force(p[1], lengths[1]))
        # The biceps pulls towards positive angles, so the torque acts against the difference.
        free = dq + STEP / INERTIA * (now + pull - DAMPING * dq)
        stop = STEP / INERTIA * friction_n * R
        dq = math.copysign(max(0.0, abs(free) - stop), free)
        q += STEP * dq
    with open(path, "w", encoding="utf-8") as out:
        out.write("Zeit (ms);Winkel (deg);p_Trizeps (barg);p_Bizeps (barg);Drehmoment (Nm)\n")
        for row in rows:
            cells = [f"{row[0]:.0f}", f"{row[1]:.4f}", f"{row[2]:.4f}", f"{row[3]:.4f}", f"{row[4]:.4f}"]
            out.write(";".join(c.replace(".", ",") for c in cells) + "\n")


def main(folder):
    os.makedirs(folder, exist_ok=True)
    fills = [(1.5, 1.5), (3.0, 3.0), (2.0, 3.2), (3.2, 2.0), (2.4, 2.4), (2.6, 1.8)]
    for k, bar in enumerate(fills):
        record(f"{folder}/train-{k + 1}.csv", bar, 30, k, 0.6 * math.sqrt(sum(bar) / 2))
    for k, bar in enumerate([(2.2, 2.8), (2.8, 2.4)]):
        record(f"{folder}/stiff-{k + 1}.csv", bar, 30, 100 + k, 0.6 * math.sqrt(sum(bar) / 2), friction_n=6.0)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else ".")
