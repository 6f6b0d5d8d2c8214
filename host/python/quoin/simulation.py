"""Step-by-step simulation from Python."""
import hashlib
import math
import numbers
import os

import numpy as np

from . import _quoin
from .errors import BadInput, Gone
from .scene import LISTS, TABLES, scene_of
from .view import View

MOST_STEPS = 2**62


def whole(name, value, lower, upper):
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (numbers.Integral, np.integer)):
        raise TypeError(f"{name}: an integer is needed, not {type(value).__name__}")
    if not lower <= value <= upper:
        raise ValueError(f"{name} = {value}: allowed: {lower} to {upper}")
    return int(value)


def plain_number(block):
    """Integers of NumPy, as block_a of contacts has them, as those of Python."""
    return int(block) if isinstance(block, np.integer) else block


def word(name, value):
    if not isinstance(value, str):
        raise TypeError(f"{name}: a name is needed, not {type(value).__name__}")
    return value


def vector(name, value):
    """Three numbers. None stands for no change and becomes NaN."""
    try:
        values = [math.nan if v is None else float(v) for v in value]
    except (TypeError, ValueError):
        raise TypeError(f"{name}: three numbers are needed, for x, y, z; None for what stays as it is") from None
    if len(values) != 3:
        raise ValueError(f"{name}: three numbers are needed, for x, y, z, not {len(values)}")
    for given, v in zip(value, values):
        if given is not None and not math.isfinite(v):
            raise ValueError(f"{name}: {v} is not finite; None for what stays as it is")
    return values


def table(columns):
    """Columns of equal length as one structured array."""
    columns = {name: np.asarray(c) for name, c in columns.items()}
    count = len(next(iter(columns.values())))
    kinds = [(name, c.dtype if c.size else c.dtype if c.dtype.kind != "U" else "U1", c.shape[1:])
             for name, c in columns.items()]
    array = np.empty(count, dtype=kinds)
    for name, c in columns.items():
        array[name] = c
    return array


class Simulation:
    """A simulation of a scene. step and run advance it through its stages. Between two calls all its state can be read,
    and bodies can be moved and loaded. threads 0: all of the machine; the bits do not depend on it. out: a folder for
    history.csv, summary.json and the files for ParaView, complete at the end of the last stage, or when it is closed.

    isolate_law: laws are evaluated in processes of their own. A law that crashes, exits or takes more than law_seconds
    (60) for a batch raises NumericalFailure. Without it, a law that does not return within law_seconds ends the program
    with a message and exit code 5, as on the command line (None: no limit), because a law cannot be removed from a
    running process."""

    def __init__(self, scene, *, threads=0, frames=False, out=None, isolate_law=False, law_seconds=None):
        scene = scene_of(scene)
        self._session = None
        threads = whole("threads", threads, 0, 4096)
        if law_seconds is None:
            law_seconds = 60.0 if isolate_law else 0.0
        elif isinstance(law_seconds, bool) or not isinstance(law_seconds, (numbers.Real, np.floating)):
            raise TypeError(f"law_seconds: a number of seconds is needed, not {type(law_seconds).__name__}")
        elif not 0 <= law_seconds <= 1e9:
            raise ValueError(f"law_seconds = {law_seconds}: allowed: 0 (any time) to 1e9")
        source = scene._source()
        self.scene = scene.copy()
        self._session = _quoin.Session(*source, threads, bool(frames), "" if out is None else os.fspath(out),
                                       bool(isolate_law), float(law_seconds))

    # --- time -----------------------------------------------------------------------------------------------------

    def step(self, n=1):
        """Computes n steps, or fewer if the last stage ends. Returns whether more steps remain."""
        if n.__class__ is not int or not 1 <= n <= MOST_STEPS:
            n = whole("n", n, 1, MOST_STEPS)
        session = self._session
        if session is None:
            raise Gone("step: the simulation is closed")
        return session.step(n, False)

    def run(self, until=None, *, every=None):
        """Runs to the end of the last stage (until None), to a time in s, to the end of the stage of that name, or until
        until(simulation) is true, which is called after every `every` steps, 100 by default. Runs no step if that is
        reached already. Returns whether more steps remain."""
        session = self._session_of("run")
        if every is not None and not callable(until):
            raise TypeError(f"every = {every}: only where until is a function")
        if until is None:
            return session.step(MOST_STEPS, False)
        names = session.stage_names
        more = session.stages_ended < len(names)
        if callable(until):
            every = 100 if every is None else whole("every", every, 1, MOST_STEPS)
            while more and not until(self):
                more = self.step(every)
            return more
        if isinstance(until, str):
            if until not in names:
                raise BadInput(f"until = {until!r}: there is no such stage; there are {', '.join(names)}")
            while session.stages_ended <= names.index(until):
                more = session.step(MOST_STEPS, True)
            return more
        if isinstance(until, (bool, np.bool_)) or not isinstance(until, (numbers.Real, np.floating)):
            raise TypeError(f"until: a time in s, the name of a stage or a function is needed, not {type(until).__name__}")
        if not math.isfinite(until):
            raise ValueError(f"until = {until}: allowed: a finite time in s")
        while more and self.time < until - 1e-9 * self.time_step:
            more = self.step(max(1, min(MOST_STEPS, math.ceil((until - self.time) / self.time_step - 1e-9))))
        return more

    steps = property(lambda self: self._session_of("steps").steps, doc="since the start")
    time = property(lambda self: self._session_of("time").time, doc="s since the start")
    time_step = property(lambda self: self._session_of("time_step").time_step, doc="s")

    @property
    def stage(self):
        """Name of the current stage, or of the last one; None before the first step."""
        session = self._session_of("stage")
        return session.stage_names[session.stage] if session.stage >= 0 else None

    # --- what it is and has recorded --------------------------------------------------------------------------------

    blocks = property(lambda self: self._session_of("blocks").blocks, doc="their number")
    zones = property(lambda self: self._session_of("zones").zones, doc="their number")
    points = property(lambda self: self._session_of("points").points, doc="number of contact points")
    joints = property(lambda self: self._session_of("joints").joints, doc="names of the joint families")
    threads = property(lambda self: self._session_of("threads").threads)
    large_motion = property(lambda self: self._session_of("large_motion").large_motion,
                            doc="whether blocks may move by any amount, from now on")
    collapse_multiplier = property(lambda self: self._session_of("collapse_multiplier").collapse_multiplier)
    collapse_lag = property(lambda self: self._session_of("collapse_lag").collapse_lag)
    hash = property(lambda self: self._session_of("hash").hash, doc="of everything that moves: equal hashes, equal bits")

    @property
    def history(self):
        """Rows so far, with the names and numbers of history.csv."""
        return table(self._session_of("history").history())

    def measure(self):
        """The current row of the history, as a dictionary."""
        return self._session_of("measure").measure()

    def mesh(self):
        """points (gridpoints at the start, m), block (of each), zones (tetrahedra) and faces (of whole blocks)."""
        return self._session_of("mesh").mesh()

    # --- arrays -----------------------------------------------------------------------------------------------------

    def _view(self, what, fetch, writeable=False):
        fetch(self._session_of(what))  # raises errors at once
        return View(self, what, fetch, writeable)

    def displacement(self, block):
        """Displacement of the gridpoints of a block, m; of a rigid block on the lattice, of its centre. A copy in large
        motion."""
        block = plain_number(block)
        return self._view("displacement", lambda s: s.displacement(block))

    def velocity(self, block):
        """Velocity of the gridpoints of a block, m/s, half a step ago; of a rigid block, of its centre. It can be
        written."""
        block = plain_number(block)
        return self._view("velocity", lambda s: s.velocity(block), True)

    def sigma(self, joint):
        """Normal stress at the contact points of a joint family, Pa, tension positive."""
        return self._view("sigma", lambda s: s.sigma(word("joint", joint)))

    def tau_s(self, joint):
        return self._view("tau_s", lambda s: s.tau_s(word("joint", joint)))

    def tau_t(self, joint):
        return self._view("tau_t", lambda s: s.tau_t(word("joint", joint)))

    def area(self, joint):
        """Areas of the contact points of a joint family, m2."""
        return self._view("area", lambda s: s.area(word("joint", joint)))

    def position(self, joint):
        """Places of the contact points of a joint family, m; in small displacements those at the start. A copy in large
        motion."""
        return self._view("position", lambda s: s.position(word("joint", joint)))

    def state(self, joint, id):
        """A state variable of the law by its name in `quoin models`."""
        return self._view("state", lambda s: s.state(word("joint", joint), word("id", id)))

    def damage(self, joint):
        """Lost shares of tensile strength, cohesion and compressive strength: three arrays, computed by the law; NaN if
        the law has none."""
        return self._session_of("damage").damage(word("joint", joint))

    def contacts(self, joint):
        """Contact points of a joint family as a structured array: position, normal, s, t, area, jump (along n, s, t;
        in large motion along n alone, the slip is a state of the law), block_a, block_b, condition. A copy."""
        return table(self._session_of("contacts").contacts(word("joint", joint)))

    # --- steering ---------------------------------------------------------------------------------------------------

    def set_velocity(self, body, velocity):
        """Sets the velocity of bodies that the stage holds or moves, m/s, from now to the end of the stage. None: no
        change. Fixed blocks that follow a record stay the ground, whose motion is then what was set."""
        self._session_of("set_velocity").set_velocity(word("body", body), vector("velocity", velocity))

    def set_force(self, body, force):
        """Sets the force on free bodies, N, from now to the end of the stage. Along its components it replaces forces
        and pressures of the stage on each of these bodies, with their moments. Gravity and the pull of a whiffletree
        stay. None: no change. With half_thickness it acts on the half, and rows have twice as much."""
        self._session_of("set_force").set_force(word("body", body), vector("force", force))

    def swap_law(self, joint, law):
        """Replaces the law of a joint family; tractions stay. Returns numbers of points, and the change of
        elastic energy."""
        return self._session_of("swap_law").swap_law(word("joint", joint), word("law", law))

    # --- checkpoints ------------------------------------------------------------------------------------------------

    def save(self):
        """The complete state with the history so far, as bytes. After restore of these, in this simulation or in another
        one of the same scene, all further bits are the same."""
        state = self._session_of("save").save(self._scene_hashes())
        return hashlib.blake2b(state).digest() + state

    def restore(self, state):
        """Goes back, or on, to what save gave. States of another scene are refused, whatever differs."""
        session = self._session_of("restore")
        if not isinstance(state, bytes):
            raise TypeError(f"state: bytes of save() are needed, not {type(state).__name__}")
        size = hashlib.blake2b().digest_size
        if hashlib.blake2b(state[size:]).digest() != state[:size]:
            raise BadInput("state: not what save() gave, or a checkpoint that is damaged")
        session.restore(state[size:], self._scene_hashes())

    def _scene_hashes(self):
        """Hash of each key of the scene, by which messages name the first that differs. None stands for one without it."""
        document = self.scene._document()
        return {key: hashlib.sha256(_quoin.text({key: document[key]}).encode()).hexdigest() if key in document else "none"
                for key in {*LISTS, *TABLES, *document}}

    def checkpoint(self, path):
        """Writes the state and the history so far to a file."""
        self._session_of("checkpoint").checkpoint(os.fspath(path), self._scene_hashes())

    @classmethod
    def resume(cls, scene, path, **options):
        """A simulation of the scene that continues from a file of checkpoint."""
        simulation = cls(scene, **options)
        simulation._session.resume(os.fspath(path), simulation._scene_hashes())
        return simulation

    # --- its end ----------------------------------------------------------------------------------------------------

    def _session_of(self, what):
        if self._session is None:
            raise Gone(f"{what}: the simulation is closed")
        return self._session

    closed = property(lambda self: self._session is None)

    def close(self):
        """Completes the files of `out`, and frees its memory. Views of it then raise quoin.Gone."""
        self._close("")

    def _close(self, failure):
        if self._session is not None:
            self._session.close(failure)  # raises an error while another thread steps it
        self._session = None

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        self._close("" if error is None else str(error))

    def __repr__(self):
        if self.closed:
            return "<simulation, closed>"
        return f"<simulation: {self.blocks} blocks, {self.points} contact points, step {self.steps}, {self.time:.6g} s>"
