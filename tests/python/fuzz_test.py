"""Random calls with random arguments: each returns or raises, none ends the interpreter. usage: fuzz_test.py [CALLS]
[SEED]. Allowed exceptions include an arithmetic fault of a law, a simulation that has failed, and wrong types."""
import hashlib
import os
import random
import sys
import time

import numpy as np
import quoin
from support import SMALL_WALL, block_scene

ALLOWED = (TypeError, ValueError, KeyError, IndexError, AttributeError, RuntimeError, OverflowError, quoin.Error,
           quoin.Refused, ArithmeticError, OSError, BufferError)


class Odd:
    def __index__(self):
        raise ValueError("odd")

    __float__ = __index__


JOINTS, BLOCKS, VECTORS = ("mortar", "dry"), (0, 1, "cube", "base"), ([0.1, 0.0, None], [None, -1e3, 5.0])
METHODS = {"step": ((1, 2, 7),), "run": ((0.0,),), "set_velocity": (("top_beam", "base"), VECTORS),
           "set_force": (("cube", "top_beam"), VECTORS), "swap_law": (JOINTS, ("elastic", "coulomb_slip")),
           **{name: (JOINTS,) for name in ("sigma", "tau_s", "tau_t", "area", "position", "damage", "contacts")},
           "state": (JOINTS, ("xi_t", "slip_s")), **{name: (BLOCKS,) for name in ("displacement", "velocity")},
           "measure": (), "mesh": (), "save": (), "restore": ((b"",),)}
GENERATORS = {"wall": ("english", 2, 1.0, [0.2, 0.1, 0.1]), "two_leaf_wall": (3, 1.0, [0.2, 0.1, 0.09]),
              "curved_wall": (2.0, 0.3, 1.0, 2, 6), "rubble": ([1, 1, 1], [0.5, 0.5, 0.5]),
              "barrel_vault": (2.0, 0.3, 1.0, 5, 2), "cross_vault": (4.0, 0.4, 5, 30.0), "dome": (3.0, 0.4, 3, 8),
              "arch_bridge": (2, 3.0, 0.9, 0.3, 1.0, 7, 0.9, 1.0), "beam": ([0, 0, 0], [1.0, 0.2, 0.2]),
              "ring_beam": ([0, 0, 0], 2.0, 1.5, [0.2, 0.2])}


def fuzz(calls, seed):
    rng = random.Random(seed)
    values = [None, True, -1, 0, 1, 3, 2**63, -2**70, 1.5, float("nan"), float("inf"), 1e300, "", "mortar", "dry", "cube",
              "top_beam", "bottom_beam", "a" * 1000, "\0", b"", b"rubbish", [], [1], [1.0, 2.0, 3.0], [None] * 3,
              [float("nan")] * 3, ["x", "y", "z"], (), {}, {"a": 1}, np.zeros(3), np.zeros((2, 2)), np.zeros(0),
              np.array([np.nan] * 4), np.zeros(4, dtype=np.float32), np.zeros(8)[::-2], object(), Odd(), len, "elastic",
              "coulomb_slip", "fracture_energy", "precompression", "shear", np.int64(2), np.float64(0.1), slice(0, 3), ...]

    def value():
        return rng.choice(values)

    def fresh():
        kind = rng.randrange(3)
        if kind == 0:
            return quoin.Simulation(SMALL_WALL, threads=rng.choice([1, 2]))
        return quoin.Simulation(block_scene(stage=[quoin.Stage(duration=5.0, gravity=[0, -9.81, 0])]), threads=1)

    law = quoin.Law("fracture_energy", normal_stiffness=1e9, shear_stiffness=1e9, tensile_strength=1e5, cohesion=1e5,
                    friction_angle=30.0, fracture_energy_tension=10.0, fracture_energy_shear=100.0)
    sim, views, states = fresh(), [], []
    raised, told = 0, time.monotonic()
    for i in range(calls):
        if time.monotonic() - told > 30.0:  # under a sanitizer the test takes an hour
            told = time.monotonic()
            print(f"{i} of {calls} calls, {raised} raised", file=sys.stderr, flush=True)
        choice = rng.random()
        try:
            if choice < 0.5:
                name, right = rng.choice(list(METHODS.items()))
                arguments = [rng.choice(ones) for ones in right]
                if arguments and rng.random() < 0.5:
                    arguments[rng.randrange(len(arguments))] = value()
                elif rng.random() < 0.2:
                    arguments = [value() for _ in range(rng.choice([0, 1, 2, 3]))]
                if name in ("step", "run"):  # few steps
                    arguments = [rng.choice([1, 2, 7, -1, 0, 1.5, "x", [], Odd(), np.zeros(4), float("nan")])]
                result = getattr(sim, name)(*arguments)
                if isinstance(result, quoin.simulation.View):
                    views.append(result)
                if isinstance(result, bytes):
                    states.append(result)
            elif choice < 0.7 and views:
                view = rng.choice(views)
                use = rng.randrange(6)
                if use == 0:
                    view[value()]
                elif use == 1:
                    view[value()] = value()
                elif use == 2:
                    view + value()
                elif use == 3:
                    np.add(value(), view, out=value())
                elif use == 4:
                    repr(view), np.array(view), view.max()
                else:
                    getattr(np, rng.choice(["sum", "concatenate", "dot", "reshape", "sort", "linalg"]))(view, value())
            elif choice < 0.85:
                arrays = [value() for _ in range(4)]
                if rng.random() < 0.5:
                    n = rng.choice([0, 1, 5])
                    arrays = [np.zeros(n), [np.zeros(n)] * 2, [np.zeros(n) for _ in range(3)], law.initial_state(n)]
                    if rng.random() < 0.6:
                        arrays[rng.randrange(4)] = value()
                rng.choice([law.evaluate, law.prepare, law.drive, law.take_over])(*arrays)
            elif choice < 0.9:
                quoin.Law(value(), **{rng.choice(["normal_stiffness", "tensile_strength", "rust"]): value()})
            elif choice < 0.95:
                scene = block_scene()
                where = rng.choice([scene, scene.joints, scene.joints.dry, scene.block[0], scene.block, scene.stage[0],
                                    scene.materials.stone, scene.output])
                key = value() if rng.random() < 0.2 else rng.choice(["density", "law", "box", "duration", "title", "stage",
                                                                     "block", "vertices", "faces", "mesh", "tetrahedra",
                                                                     "rigid", "zone_edge"])
                where[key] = value()
                scene.check()
            elif choice < 0.96:
                # At most one argument is wrong; no size would take minutes.
                name, arguments = rng.choice(list(GENERATORS.items()))
                arguments = list(arguments)
                arguments[rng.randrange(len(arguments))] = value() if rng.random() < 0.7 else arguments[0]
                made = getattr(quoin.shapes, name)(*arguments, material="stone")
                if rng.random() < 0.2:
                    quoin.Simulation(block_scene(block=made), threads=1)
                rng.choice([quoin.shapes.cut, quoin.shapes.fill_load, quoin.shapes.opening])(made, value(), value())
            elif choice < 0.963:
                quoin.read_blocks(value(), material=value(), scale=value())
            elif choice < 0.965:
                quoin.Simulation(SMALL_WALL, threads=value(), isolate_law=rng.random() < 0.2,
                                 law_seconds=rng.choice([None, "x", -1, float("nan"), [], 60]))
            elif choice < 0.975 and states:
                state = bytearray(rng.choice(states))
                for _ in range(rng.choice([0, 1, 5])):
                    state[rng.randrange(len(state))] = rng.randrange(256)
                state = bytes(state[:rng.choice([len(state), len(state) // 2, 20])])
                if rng.random() < 0.7:  # with a valid checksum
                    state = hashlib.blake2b(state[64:]).digest() + state[64:]
                sim.restore(state)
            elif choice < 0.985:
                sim.close() if rng.random() < 0.5 else None
                sim, states = fresh(), []
                views = views[-2:]
        except ALLOWED:
            raised += 1
    print(f"{calls} calls, seed {seed}: {raised} raised")
    assert raised > 0.2 * calls


if __name__ == "__main__":
    fuzz(int(sys.argv[1]) if len(sys.argv) > 1 else 2000, int(sys.argv[2]) if len(sys.argv) > 2 else 1)
