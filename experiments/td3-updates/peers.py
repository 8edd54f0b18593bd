"""TD3 updates per second of Factotum, Stable-Baselines3 and SBX, in turn on one processor.

    cargo bench -p factotum-learning --bench td3 --no-run      # prints the path of the benchmark
    python peers.py PATH_OF_BENCHMARK [ROUNDS] > results.jsonl

Observation 50, action 13, two hidden layers of 64, batch 256, learning rate 1e-4, 5,000 random transitions. A round is
one call of each learner: 250 updates of Factotum, 250 of SBX in one call (its fastest way), 25 of Stable-Baselines3.
One line a round: updates per second of wall time, and per second that the process was on the processor.
"""

import json
import os
import subprocess
import sys
import time

CPU = max(os.sched_getaffinity(0))
os.sched_setaffinity(0, {CPU})
for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
os.environ["CUDA_VISIBLE_DEVICES"] = ""
os.environ["JAX_PLATFORMS"] = "cpu"

import gymnasium
import numpy as np
import sbx
import stable_baselines3
import torch

torch.set_num_threads(1)

N_OBSERVATION, N_ACTION, BATCH, N_STORED = 50, 13, 256, 5000


class Spaces(gymnasium.Env):
    """Nothing but the sizes."""

    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (N_OBSERVATION,), np.float32)
    action_space = gymnasium.spaces.Box(-1.0, 1.0, (N_ACTION,), np.float32)

    def reset(self, *, seed=None, options=None):
        return np.zeros(N_OBSERVATION, np.float32), {}

    def step(self, action):
        return np.zeros(N_OBSERVATION, np.float32), 0.0, False, False, {}


def peer(module):
    """A learner with random transitions."""
    model = module.TD3(
        "MlpPolicy",
        Spaces(),
        learning_rate=1e-4,
        buffer_size=N_STORED,
        batch_size=BATCH,
        policy_kwargs={"net_arch": [64, 64]},
        device="cpu",
        seed=1,
    )
    model._setup_learn(1)
    draw = np.random.default_rng(1)
    for _ in range(N_STORED):
        before, after = draw.uniform(-1, 1, (2, 1, N_OBSERVATION)).astype(np.float32)
        action = draw.uniform(-1, 1, (1, N_ACTION)).astype(np.float32)
        model.replay_buffer.add(before, after, action, np.array([0.05]), np.array([False]), [{}])
    return model


def measured(n, act, on_processor):
    wall, busy = time.perf_counter(), on_processor()
    act()
    return {
        "per_wall_sec": n / (time.perf_counter() - wall),
        "per_cpu_sec": n / (on_processor() - busy),
    }


def main():
    ours = subprocess.Popen([sys.argv[1], "paced"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ours_act():
        ours.stdin.write("\n")
        ours.stdin.flush()
        assert ours.stdout.readline().strip() == "250"

    def ours_busy():
        with open(f"/proc/{ours.pid}/schedstat") as file:
            return int(file.read().split()[0]) * 1e-9

    sb3, jax = peer(stable_baselines3), peer(sbx)
    learners = {
        "factotum": (250, ours_act, ours_busy),
        "sbx": (250, lambda: jax.train(gradient_steps=250, batch_size=BATCH), time.process_time),
        "sb3": (25, lambda: sb3.train(gradient_steps=25, batch_size=BATCH), time.process_time),
    }
    n_rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 40
    rounds = []
    for index in range(n_rounds + 2):
        line = {name: measured(*learner) for name, learner in learners.items()}
        if index >= 2:  # the first compile and warm the caches
            rounds.append(line)
            print(json.dumps(line), flush=True)
    ours.stdin.close()
    ours.wait()
    versions = f"stable-baselines3 {stable_baselines3.__version__}, sbx-rl {sbx.__version__}, torch {torch.__version__}"
    print(versions, file=sys.stderr)
    for time_of in ("per_wall_sec", "per_cpu_sec"):
        for name in learners:
            rates = sorted(line[name][time_of] for line in rounds)
            ratios = sorted(line["factotum"][time_of] / line[name][time_of] for line in rounds)
            at = lambda values, share: values[min(int(share * len(values)), len(values) - 1)]
            print(
                f"{time_of} {name}: median {at(rates, 0.5):.0f}, most {rates[-1]:.0f};"
                f" factotum / {name}: median {at(ratios, 0.5):.2f}, quartiles {at(ratios, 0.25):.2f} to {at(ratios, 0.75):.2f}",
                file=sys.stderr,
            )


main()
