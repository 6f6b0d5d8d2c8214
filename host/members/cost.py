"""What the floors of the Pavia building cost: /usr/bin/python3 host/members/cost.py out/cost

Runs pavia_floors.toml with its floors and without, in turn, on one thread, and prints processor time a step of both, their
ratio, and the share of members that `time:` of the run gives.
"""
import json
import os
import re
import resource
import subprocess
import sys

import pavia_floors

SETTINGS = ["--threads", "1", "--set", "output.frames=0", "--set", "output.plots=false", "--set", "stage.shake.duration=0.2"]
ROUNDS = 4


def step_cost(scene, out):
    """Processor time of a step, s, and the share of members."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([pavia_floors.PROGRAM, "run", scene, "--out", out, *SETTINGS], capture_output=True, text=True, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(os.path.join(out, "summary.json")) as file:
        steps = json.load(file)["steps"]
    share = re.search(r"members (\d+) %", done.stdout + done.stderr)
    return (after.ru_utime - before.ru_utime) / steps, int(share.group(1)) if share else 0


def main(folder):
    os.makedirs(folder, exist_ok=True)
    with open(pavia_floors.SCENE) as file:
        text = file.read()
    costs = {}
    for _ in range(ROUNDS):
        for floor in ("none", "boards"):
            scene = os.path.join(folder, floor + ".toml")
            with open(scene, "w") as file:
                file.write(pavia_floors.scene_of(text, floor, "shake z"))
            costs.setdefault(floor, []).append(step_cost(scene, os.path.join(folder, floor)))
    without, with_floors = (min(cost for cost, _ in costs[floor]) for floor in ("none", "boards"))
    for floor, found in costs.items():
        print(floor, "; ".join(f"{1e6 * cost:.0f} us a step, members {share} %" for cost, share in found))
    print(f"least of {ROUNDS} rounds: {with_floors / without:.3f} times a step without floors")


if __name__ == "__main__":
    main(sys.argv[1])
