"""Training in JAX through the framework's gradient, with optax."""

import jax
import numpy as np
import optax

import pam_ode as pam
import pam_ode.jax


def main(steps: int = 30) -> None:
    time_s = np.arange(1000) * 2e-3
    plant = pam.load("spring-damper")
    recordings = [
        plant.predict(pam.Recording.at_rest(time_s, kpa, 60 * np.sin(9 * time_s))).to_recording(f"{kpa:.0f} kPa")
        for kpa in (300.0, 412.0, 520.0)
    ]
    model = pam.load()
    loss = pam_ode.jax.loss(model, recordings)
    weights = pam_ode.jax.parameters(model)
    optimiser = optax.chain(optax.clip_by_global_norm(1.0), optax.adam(1e-3))
    state = optimiser.init(weights)

    @jax.jit
    def step(weights, state):  # type: ignore[no-untyped-def]
        value, gradient = jax.value_and_grad(loss)(weights)
        change, state = optimiser.update(gradient, state)
        return optax.apply_updates(weights, change), state, value

    for k in range(steps):
        weights, state, value = step(weights, state)
        if k % 10 == 0:
            print(f"step {k}: loss {float(value):.4f}")
    trained = model.with_parameters(weights)
    print(f"R² of x: {trained.predict(recordings[0]).r2[0]:.4f}")


if __name__ == "__main__":
    main()
