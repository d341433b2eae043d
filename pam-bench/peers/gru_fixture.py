"""Makes the numbers that the tests of the GRU and of the Koopman model are held to, with PyTorch and NumPy.

    pip install torch numpy
    python gru_fixture.py --out ../../pam-baselines/tests/fixtures/published_peers.json

The history and the forces are formulas, so that the file holds results only:

    u[t, c] = 0.6 sin(0.05 t + 0.9 c) + 0.2 cos(0.013 t (c + 1))      c = 0..4, t = 0..199

The first 100 samples are fed from hidden states of zero; then the network predicts recursively under u[t, 4].
`gradient_norm` holds, array by array, the Euclidean norm of the gradient of

    mean over 3 windows and 100 samples of 100 e_x^2 + 100 e_v^2 + e_pf^2 + e_pe^2

with the windows u[t + 7 w, c], w = 0, 1, 2, differentiated through warm-up and recursion in float32.
"""

import argparse
import json
import math
from pathlib import Path

import numpy as np
import torch


class Gru(torch.nn.Module):
    def __init__(self, hidden=96, layers=2):
        super().__init__()
        self.gru = torch.nn.GRU(5, hidden, layers, batch_first=True)
        self.head = torch.nn.Sequential(
            torch.nn.Linear(hidden, hidden), torch.nn.Tanh(), torch.nn.Linear(hidden, 4)
        )


def sample(t, c):
    return 0.6 * math.sin(0.05 * t + 0.9 * c) + 0.2 * math.cos(0.013 * t * (c + 1))


def predict(model, window, warm_up, horizon):
    """Scaled states of the samples after the warm-up, [windows, horizon, 4]."""
    out, hidden = model.gru(window[:, :warm_up])
    y = model.head(out[:, -1])
    outputs = [y]
    for k in range(warm_up, warm_up + horizon - 1):
        step = torch.cat([y, window[:, k, 4:]], dim=1).unsqueeze(1)
        out, hidden = model.gru(step, hidden)
        y = model.head(out[:, -1])
        outputs.append(y)
    return torch.stack(outputs, dim=1)


def loss_of(predicted, measured):
    weights = torch.tensor([100.0, 100.0, 1.0, 1.0])
    return ((predicted - measured) ** 2 * weights).sum(-1).mean()


def gru(published):
    saved = np.load(published)
    model = Gru()
    model.load_state_dict({n: torch.from_numpy(saved[n]) for n, _ in model.named_parameters()})
    window = torch.tensor(
        [[[sample(t + 7 * w, c) for c in range(5)] for t in range(200)] for w in range(3)],
        dtype=torch.float32,
    )
    predicted = predict(model, window, 100, 100)
    loss = loss_of(predicted, window[:, 100:, :4])
    loss.backward()
    return {
        "outputs": [[float(v) for v in row] for row in predicted[0].detach().numpy()[::9]],
        "every": 9,
        "loss": loss.item(),
        "gradient_norm": {n: float(p.grad.double().norm()) for n, p in model.named_parameters()},
        "input_scaler_min": [float(v) for v in saved["scaler_min"]],
        "input_scaler_max": [float(v) for v in saved["scaler_max"]],
    }


def koopman(published):
    m = np.load(published / "koopman_model.npz")
    states, forces, following = [], [], []
    for k in range(6):
        x = m["X_mean"] + m["X_std"] * np.array([math.sin(k + i) for i in range(4)])
        force = 1e5 * math.cos(1.7 * k)
        u = (force - m["U_mean"]) / m["U_std"]
        lifted = np.concatenate([[1.0], (x - m["X_mean"]) / m["X_std"], u])
        states.append(x.tolist())
        forces.append(force)
        following.append((m["K"] @ lifted * m["X_std"] + m["X_mean"]).tolist())
    return {"states": states, "forces_mn": forces, "next": following}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--published", type=Path, default=Path("../../data/published"))
    parser.add_argument("--out", type=Path, required=True)
    args = parser.parse_args()
    torch.manual_seed(0)
    made = {
        "made_by": "pam-bench/peers/gru_fixture.py",
        "torch": torch.__version__,
        "numpy": np.__version__,
        "gru": gru(args.published / "gru_model.npz"),
        "koopman": koopman(args.published),
    }
    args.out.write_text(json.dumps(made, indent=1) + "\n")


if __name__ == "__main__":
    main()
