"""What a loop of sim.step() costs over sim.step(n), us a step. Usage: PYTHONPATH=build/release/python step_overhead.py
[SCENE]; the least of several rounds, as other work on the machine only adds."""
import os
import sys
import time

import quoin

scene = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(__file__), "../tests/cli/small_wall.toml")
N, ROUNDS = 500, 20


def one_by_one(sim):
    step = sim.step
    for _ in range(N):
        step()


def least(work):
    seconds = []
    sim = quoin.Simulation(scene, threads=1)
    start = sim.save()
    for _ in range(ROUNDS):
        sim.restore(start)
        before = time.perf_counter()
        work(sim)
        seconds.append(time.perf_counter() - before)
    return min(seconds) / N * 1e6


whole, single = least(lambda sim: sim.step(N)), least(one_by_one)
print(f"step(n): {whole:.2f} us a step; step(): {single:.2f} us; over it: {single - whole:.2f} us")
