"""Analyses of a scene without a run."""
import json
import os

import numpy as np

from . import _quoin
from .errors import BadInput
from .scene import scene_of
from .simulation import whole


def pair(name, values):
    try:
        values = [float(v) for v in values]
    except (TypeError, ValueError):
        raise TypeError(f"{name}: two numbers are needed") from None
    if len(values) != 2:
        raise ValueError(f"{name}: two numbers are needed, not {len(values)}")
    return values


class Limit:
    """Limit loads. multiplier: that of associated flow. multiplier_without_dilation: None: not found. gap: upper less
    lower bound over max(1, |multiplier|). stands, margin: of given loads. friction_scale and
    friction_scale_without_dilation: the smallest scale of friction that carries the given loads (None: no scale does).
    velocity: rows of blocks, x y z and spin. point_blocks, point, force: by contact point its blocks a and b, place in m,
    and force on block a along n, s, t in N, tension positive. Empty where no mechanism was found. summary: contents of
    limit.json."""

    def __init__(self, text, velocity, blocks, point, force):
        self.summary = json.loads(text)
        self.multiplier = self.summary["multiplier"]
        self.multiplier_without_dilation = self.summary["multiplier_without_dilation"]
        self.gap = self.summary["gap"]
        self.stands = self.summary["stands"]
        self.margin = self.summary["margin"]
        self.friction_scale = self.summary["smallest_friction_scale"]
        self.friction_scale_without_dilation = self.summary["smallest_friction_scale_without_dilation"]
        self.velocity = np.array(velocity).reshape(-1, 6)
        self.point_blocks = np.array(blocks, dtype=int).reshape(-1, 2)
        self.point = np.array(point).reshape(-1, 3)
        self.force = np.array(force).reshape(-1, 3)

    def __repr__(self):
        answer = "does not stand" if not self.stands else f"margin {self.margin}"
        return f"<limit: {answer}, multiplier {self.multiplier}>"


def limit(scene, *, direction=None, given=0.0, facets=0, associated=False, moving=False, multiply="weight", stage="",
          seconds=300.0):
    """Limit analysis of a scene, or of a scene file, as by `quoin limit`. direction: x, y, z of the variable load, a
    share of the weight; default: that of the first collapse stage. given: multiple of this load that acts with the
    weight. multiply: "weight", or "forces", "pressures" or "loads" (both, and forces on bodies) of a stage, or
    "motion", a force of 1 N along its motion. stage: the stage whose gravity and loads count; default: the first that
    collapses or has what is multiplied. facets: number of facets of pyramids within the friction cones; 0: exact cones.
    associated: no search for solutions without dilation. moving: the variable load is the moving load of the first
    stage with one, at each of its positions; summary["moving"] has the results. seconds: time of the associated
    analysis, and of each search without dilation. summary["moving_joints"] has the joints of the mechanism. A scene
    that does not stand is a result, not an error."""
    if not hasattr(_quoin, "limit"):
        raise BadInput("limit: this installation has no limit analysis; build it with coinor-libclp-dev")
    way = [] if direction is None else [float(v) for v in direction]
    if len(way) not in (0, 3):
        raise ValueError(f"direction: three numbers are needed, not {len(way)}")
    return Limit(*_quoin.limit(*scene_of(scene)._source(), way, float(given), whole("facets", facets, 0, 1000),
                               bool(associated), bool(moving), str(multiply), str(stage), float(seconds)))


class Modes:
    """Natural frequencies. frequencies, Hz; effective_mass, kg, and participation: arrays by mode and direction; alpha
    (1/s) and beta (s) of Rayleigh damping; shapes[mode][block]: displacement of its corners or gridpoints, largest 1;
    summary: contents of modes.json."""

    def __init__(self, text, shapes):
        self.summary = json.loads(text)
        self.frequencies = np.array(self.summary["frequencies_Hz"])
        self.effective_mass = np.array(self.summary["effective_mass_kg"])
        self.participation = np.array(self.summary["participation"])
        self.alpha = self.summary["rayleigh"]["alpha_per_s"]
        self.beta = self.summary["rayleigh"]["beta_s"]
        self.shapes = [[np.array(block) for block in mode] for mode in shapes]

    def __repr__(self):
        return f"<{len(self.frequencies)} modes from {self.frequencies[0]:.4g} to {self.frequencies[-1]:.4g} Hz>"


def modes(scene, *, count=10, stage="", state="undamaged", ratios=(0.05, 0.05), at=(0.0, 0.0)):
    """The lowest natural modes of a scene, or of a scene file, as by `quoin modes`. stage: the stage whose supports hold
    the blocks; default: the first. state: "undamaged", the state at the start; "weight": at rest under the loads of the
    stage; or the folder of a run of this scene from Python with output.end_state = true, in whose end state open joints
    are open. ratios: damping ratios at the frequencies `at`, Hz; 0: those of the first and the last mode."""
    if not hasattr(_quoin, "modes"):
        raise BadInput("modes: this installation has no natural frequencies; build it with libopenblas-serial-dev")
    return Modes(*_quoin.modes(*scene_of(scene)._source(), whole("count", count, 1, 10000), str(stage),
                               os.fspath(state), pair("ratios", ratios), pair("at", at)))


def properties_of(**tests):
    """Properties of units and joints from tests, by the rule of host/validate/README.md. tests: keys of a table [tests]
    in SI units, as unit="clay", unit_strength=20e6, cohesion=0.2e6, friction=0.6, block_height=0.065. Returns a dict:
    unit (a material), bed, head and inside (joints of fracture_energy), derivation (a line per number: name, value, unit,
    from, spread as a coefficient of variation)."""
    return _quoin.properties_of(tests)
