"""Movement primitives and policy search of Factotum beside those of others. `cargo x bench peers bootstrap` runs it:

    python peers.py PATH_OF_BENCHMARK PATH_OF_VIA_POINT [ROUNDS [FILE]]

Seven joints, 32 kernels, one second at steps of 0.01 s, from one demonstration, in turn on one processor with
movement_primitives. A round is one turn of each; FILE gets one line a round: calls per second of wall time, and per
second on the processor. Then PI2-CMA on the via-point problem, beside the figures measured with dmpbbo. Prints JSON.
"""

import json
import os
import statistics
import subprocess
import sys
import time

CPU = max(os.sched_getaffinity(0))
os.sched_setaffinity(0, {CPU})
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np
from movement_primitives.dmp import DMP

N_JOINTS, N_KERNELS = 7, 32


def demonstration(n_samples):
    """As in benches/primitives.rs."""
    t = np.linspace(0, 1, n_samples)
    size = np.arange(1, N_JOINTS + 1)[:, None]
    way = t**3 * (10 - 15 * t + 6 * t**2)
    return t, (0.2 * size * way + 0.1 * np.sin(np.pi * t) ** 3 * np.cos(size * t)).T


def learned(n_samples):
    dmp = DMP(N_JOINTS, execution_time=1.0, dt=0.01, n_weights_per_dim=N_KERNELS)
    dmp.imitate(*demonstration(n_samples))
    return dmp


def measured(n, act, on_processor):
    wall, busy = time.perf_counter(), on_processor()
    act()
    return {
        "per_wall_sec": n / (time.perf_counter() - wall),
        "per_cpu_sec": n / (on_processor() - busy),
    }


def main():
    ours = subprocess.Popen([sys.argv[1], "paced"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(line):
        ours.stdin.write(line + "\n")
        ours.stdin.flush()
        return ours.stdout.readline().strip()

    def ours_busy():
        with open(f"/proc/{ours.pid}/schedstat") as file:
            return int(file.read().split()[0]) * 1e-9

    dmp = learned(101)
    by_step = {
        name: lambda name=name: dmp.open_loop(step_function=name) for name in ("rk4-cython", "euler-cython")
    }

    def repeat(n, act):
        return lambda: [act() for _ in range(n)]

    turns = {
        "factotum rollout": (200, lambda: ask("rollout"), ours_busy),
        "movement_primitives rk4-cython rollout": (10, repeat(10, by_step["rk4-cython"]), time.process_time),
        "movement_primitives euler-cython rollout": (10, repeat(10, by_step["euler-cython"]), time.process_time),
    }
    for n_samples in (101, 1001):
        turns[f"factotum learn {n_samples}"] = (200, lambda n=n_samples: ask(f"learn {n}"), ours_busy)
        turns[f"movement_primitives learn {n_samples}"] = (
            10,
            repeat(10, lambda n=n_samples: learned(n)),
            time.process_time,
        )

    errors = {"factotum": [float(x) for x in ask("errors").split()]}
    _, shown = demonstration(101)
    for name, act in by_step.items():
        off = np.abs(act()[1] - shown).max(axis=1)
        errors[f"movement_primitives {name}"] = [float(off[-1]), float(off.max())]

    n_rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 20
    rounds = []
    for index in range(n_rounds + 1):
        line = {name: measured(*turn) for name, turn in turns.items()}
        if index >= 1:  # the first warms the caches
            rounds.append(line)
    ours.stdin.close()
    ours.wait()

    if len(sys.argv) > 4:
        with open(sys.argv[4], "w") as file:
            file.writelines(json.dumps(line) + "\n" for line in rounds)

    at = lambda values, share: sorted(values)[min(int(share * len(values)), len(values) - 1)]
    summary = {"n_rounds": n_rounds, "error_at_end_and_worst_rad": errors, "rates": {}, "ratios": {}}
    for clock in ("per_wall_sec", "per_cpu_sec"):
        for name in turns:
            summary["rates"][f"{name}, {clock}"] = at([line[name][clock] for line in rounds], 0.5)
        for name in turns:
            if name.startswith("factotum"):
                continue
            mine = "factotum rollout" if "rollout" in name else f"factotum learn {name.split()[-1]}"
            ratios = [line[mine][clock] / line[name][clock] for line in rounds]
            summary["ratios"][f"factotum / {name}, {clock}"] = [at(ratios, share) for share in (0.25, 0.5, 0.75)]
    print(json.dumps({"primitives": summary, "via_point": via_point()}, indent=1))


# Mean and spread of the cost after 40 updates of 10 rollouts over 10 seeds, measured with dmpbbo's demonstration.
DMPBBO = {"1 cma": [0.110, 0.045], "1 decay": [0.074, 0.009], "2 cma": [0.112, 0.016], "2 decay": [0.065, 0.014]}


def via_point():
    found = {}
    for text in subprocess.run([sys.argv[2]], stdout=subprocess.PIPE, check=True, text=True).stdout.splitlines():
        line = json.loads(text)
        found.setdefault(f"{line['n_dims']} {line['search']}", []).append(line["costs"])
    return {
        name: {
            "cost_before": runs[0][0],
            "cost_after_mean": statistics.mean(costs[-1] for costs in runs),
            "cost_after_std": statistics.stdev(costs[-1] for costs in runs),
            "n_seeds": len(runs),
            "dmpbbo_cost_after_mean_and_spread": DMPBBO.get(name),
        }
        for name, runs in found.items()
    }


main()
