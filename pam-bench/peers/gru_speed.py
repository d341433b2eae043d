"""How long a training step of the GRU takes in PyTorch and here, on the same machine, in turns.

    pip install torch numpy
    cargo build --release -p pam-baselines --example gru_speed
    python gru_speed.py --pam ../../target/release/examples/gru_speed

A step is value and gradient of the loss over a batch of windows (100 samples of warm-up, 100 predicted
recursively), clipping, and Adam, in float32. PyTorch's warm-up is one call of its fused GRU; the recursion is
a loop, because an output is the next input. `--compile` also times `torch.compile` of the loss.

The programs take turns, round by round. `ratio` is that of the medians of wall-clock times over all rounds,
`ratio_low` and `ratio_high` are the extremes of single rounds. `cpu_ratio` compares CPU times instead,
which other work on the machine hardly changes.
"""

import argparse
import json
import os
import resource
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
    seconds, cpu = [], []
    for _ in range(steps + 1):
        begun, begun_cpu = time.perf_counter(), time.process_time()
        adam.zero_grad()
        value().backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        adam.step()
        seconds.append(time.perf_counter() - begun)
        cpu.append(time.process_time() - begun_cpu)
    return statistics.median(seconds[1:]), statistics.mean(cpu[1:])


def children_cpu_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def pam_step_s(program, batch, steps, threads):
    begun = children_cpu_s()
    out = subprocess.run(
        [program, str(batch), str(steps)],
        check=True,
        capture_output=True,
        text=True,
        env={**os.environ, "RAYON_NUM_THREADS": str(threads)},
    )
    # One more step than those that are timed, and the start of the program.
    return json.loads(out.stdout)["step_s"], (children_cpu_s() - begun) / (steps + 1)


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
            own.append(pam_step_s(args.pam, batch, args.steps, args.threads))
            peer.append(torch_step_s(batch, args.steps, False))
            if args.compile:
                compiled.append(torch_step_s(batch, args.steps, True))
        wall = [statistics.median(s for s, _ in times) for times in (own, peer)]
        cpu = [statistics.median(c for _, c in times) for times in (own, peer)]
        ratios = [p / o for (o, _), (p, _) in zip(own, peer)]
        row = {
            "batch": batch,
            "pam_s": wall[0],
            "torch_s": wall[1],
            "ratio": wall[1] / wall[0],
            "ratio_low": min(ratios),
            "ratio_high": max(ratios),
            "pam_cpu_s": cpu[0],
            "torch_cpu_s": cpu[1],
            "cpu_ratio": cpu[1] / cpu[0],
        }
        if compiled:
            row["compiled_s"] = statistics.median(s for s, _ in compiled)
        rows.append(row)
        print(row, flush=True)
    if args.json:
        with open(args.json, "w") as file:
            json.dump({"torch": torch.__version__, "threads": args.threads, "rows": rows}, file, indent=1)


if __name__ == "__main__":
    main()
