"""What a scene answers without a run."""
import json

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


class Modes:
    """Natural frequencies. frequencies, Hz; effective_mass, kg, and participation: arrays by mode and direction; alpha
    (1/s) and beta (s) of Rayleigh's damping; shapes[mode][block]: displacement of its corners or gridpoints, largest 1;
    summary: as modes.json."""

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


def modes(scene, *, count=10, stage="", ratios=(0.05, 0.05), at=(0.0, 0.0)):
    """The lowest modes of a scene, or of the file of one, as it is at the start, as `quoin modes` finds them. stage: whose
    supports hold the blocks; else the first. ratios: of critical damping at the frequencies `at`, Hz; 0: those of the
    first and the last mode."""
    if not hasattr(_quoin, "modes"):
        raise BadInput("modes: this installation has no natural frequencies; build it with libopenblas-serial-dev")
    return Modes(*_quoin.modes(*scene_of(scene)._source(), whole("count", count, 1, 10000), str(stage),
                               pair("ratios", ratios), pair("at", at)))


def properties_of(**tests):
    """Properties of units and joints from what tests gave, by the rule of host/validate/README.md. tests: keys of a table
    [tests] in SI units, as unit="clay", unit_strength=20e6, cohesion=0.2e6, friction=0.6, block_height=0.065. Returns a
    dict: unit (a material), bed, head and inside (joints of fracture_energy), derivation (a line a number: name, value,
    unit, from, spread as a coefficient of variation)."""
    return _quoin.properties_of(tests)
