"""Measures the extra cost of a loop of sim.step() over sim.step(n), us for each step. Usage:
PYTHONPATH=build/release/python step_overhead.py [SCENE]. Both alternate for many rounds; the result is the shortest
round, since other programs only add time."""
import os
import sys
import time

import quoin

scene = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(__file__), "../tests/cli/small_wall.toml")
N, ROUNDS = 200, 300  # a round takes a millisecond, so that some rounds are not disturbed


def one_by_one(sim):
    step = sim.step
    for _ in range(N):
        step()


def seconds_of(work):
    sim.restore(start)
    before = time.perf_counter()
    work(sim)
    return time.perf_counter() - before


sim = quoin.Simulation(scene, threads=1)
start = sim.save()
rounds = [(seconds_of(lambda s: s.step(N)), seconds_of(one_by_one)) for _ in range(ROUNDS)]
whole, single = (min(column) / N * 1e6 for column in zip(*rounds))
print(f"step(n): {whole:.2f} us a step; step(): {single:.2f} us; over it: {single - whole:.2f} us, {single / whole - 1:.0%}; "
      f"load of the machine {os.getloadavg()[0]:.1f}")
