"""Environment steps per second of Factotum and robosuite at a door, in turn on one processor.

    cargo bench -p factotum-worlds --bench contact --no-run      # prints the path of the benchmark
    python env_steps.py PATH_OF_BENCHMARK PATH_OF_DOOR_XML [ROUNDS] > env_steps.jsonl

robosuite: its Door environment, Panda, OSC_POSE with variable stiffness (13 actions), 20 Hz, 25 physics steps of 2 ms an
environment step, no cameras, no latch. Factotum: the same scene as MJCF (`robosuite`) and the door of assets/tasks
(`own`); `overhead` is what a step in that scene takes longer than its physics alone in the same states, as a share,
measured step by step by the benchmark itself. Actions are random and small, gripper open; every hundredth step
begins anew, which is not measured. A round is 50 steps of each. One line a round: steps per second of wall time, and
per second that the process was on the processor.
"""

import json
import os
import subprocess
import sys
import time

CPU = max(os.sched_getaffinity(0))
os.sched_setaffinity(0, {CPU})
for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[name] = "1"

import mujoco
import numpy as np
import robosuite

N_STEPS = 50


def peer():
    """robosuite's Door, as the experiments with composable interaction primitives use it."""
    config = robosuite.load_composite_controller_config(controller="BASIC", robot="Panda")
    parts = config["body_parts"]
    arm = parts["right"] if "right" in parts else parts["arms"]["right"]
    arm["impedance_mode"] = "variable_kp"
    return robosuite.make(
        "Door",
        robots="Panda",
        controller_configs=config,
        has_renderer=False,
        has_offscreen_renderer=False,
        use_camera_obs=False,
        use_latch=False,
        reward_shaping=True,
        control_freq=20,
        ignore_done=True,
        hard_reset=False,
    )


def main():
    program, scene = sys.argv[1:3]
    n_rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 20
    ours = subprocess.Popen([program, "paced", scene], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def busy_secs():
        with open(f"/proc/{ours.pid}/schedstat") as file:
            return int(file.read().split()[0]) * 1e-9

    def ask(kind):
        ours.stdin.write(kind + "\n")
        ours.stdin.flush()
        return ours.stdout.readline()

    def of_ours(kind):
        busy = busy_secs()
        n, secs = ask(kind).split()
        # Beginning anew is in the processor's time: a few tenths of a per cent.
        return {"per_wall_sec": int(n) / float(secs), "per_cpu_sec": int(n) / (busy_secs() - busy)}

    env = peer()
    draw = np.random.default_rng(1)
    low, high = env.action_spec
    low, high = low.copy(), high.copy()
    low[6:12] *= 0.2
    high[6:12] *= 0.2
    low[12] = high[12] = -1.0

    def of_peer(index):
        if index % 2 == 0:
            env.reset()
        actions = draw.uniform(low, high, (N_STEPS, len(low)))
        wall, busy = time.perf_counter(), time.process_time()
        for action in actions:
            env.step(action)
        return {
            "per_wall_sec": N_STEPS / (time.perf_counter() - wall),
            "per_cpu_sec": N_STEPS / (time.process_time() - busy),
        }

    for index in range(n_rounds + 2):
        line = {kind: of_ours(kind) for kind in ("robosuite", "own")}
        line["overhead"] = float(ask("overhead"))
        line["peer"] = of_peer(index)
        if index >= 2:  # the first compile and warm the caches
            print(json.dumps(line), flush=True)
    ours.stdin.close()
    ours.wait()
    print(f"robosuite {robosuite.__version__}, mujoco {mujoco.__version__}", file=sys.stderr)


main()
