"""How long a training step of the GRU takes in PyTorch and here, on the same machine, in turns.

    pip install torch numpy
    cargo build --release -p pam-baselines --example gru_speed
    python gru_speed.py --pam ../../target/release/examples/gru_speed

A step is value and gradient of the loss over a batch of windows (100 samples of warm-up, 100 predicted
recursively), clipping, and Adam, in float32. PyTorch's warm-up is one call of its fused GRU; the recursion is
a loop, because an output is the next input. `--compile` also times `torch.compile` of the loss.
"""

import argparse
import json
import statistics
import subprocess
import time

import torch

from gru_fixture import Gru, loss_of, predict


def windows(batch):
    t = torch.arange(200).reshape(1, 200, 1)
    w = torch.arange(batch).reshape(batch, 1, 1)
    c = torch.arange(5).reshape(1, 1, 5)
    return torch.sin(0.05 * t + 0.7 * w + 0.9 * c).float()


def torch_step_s(batch, steps, compiled):
    torch.manual_seed(1)
    model = Gru()
    adam = torch.optim.Adam(model.parameters(), lr=1e-3)
    data = windows(batch)

    def loss():
        return loss_of(predict(model, data, 100, 100), data[:, 100:, :4])

    value = torch.compile(loss) if compiled else loss
    seconds = []
    for _ in range(steps + 1):
        begun = time.perf_counter()
        adam.zero_grad()
        value().backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        adam.step()
        seconds.append(time.perf_counter() - begun)
    return statistics.median(seconds[1:])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--pam", required=True, help="the example gru_speed, built")
    parser.add_argument("--batches", type=int, nargs="+", default=[32, 64, 256, 1024])
    parser.add_argument("--steps", type=int, default=5)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--compile", action="store_true")
    parser.add_argument("--json")
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    rows = []
    for batch in args.batches:
        own, peer, compiled = [], [], []
        for _ in range(args.rounds):
            out = subprocess.run(
                [args.pam, str(batch), str(args.steps)],
                check=True,
                capture_output=True,
                text=True,
                env={"RAYON_NUM_THREADS": str(args.threads)},
            )
            own.append(json.loads(out.stdout)["step_s"])
            peer.append(torch_step_s(batch, args.steps, False))
            if args.compile:
                compiled.append(torch_step_s(batch, args.steps, True))
        row = {"batch": batch, "pam_s": statistics.median(own), "torch_s": statistics.median(peer)}
        row["ratio"] = row["torch_s"] / row["pam_s"]
        if compiled:
            row["compiled_s"] = statistics.median(compiled)
        rows.append(row)
        print(row, flush=True)
    if args.json:
        with open(args.json, "w") as file:
            json.dump({"torch": torch.__version__, "threads": args.threads, "rows": rows}, file, indent=1)


if __name__ == "__main__":
    main()
