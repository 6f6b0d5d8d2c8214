"""A whole run."""
import json
import os

from . import _quoin
from .errors import BadInput, Error
from .pictures import Pictures
from .progress import run_and_tell
from .results import open_results
from .simulation import Simulation, table


class Frame:
    """A moment of the run. time, s; displacement of the gridpoints of all blocks, m; joints: a structured array by
    contact point, position, displacement, traction, opening, slip, damage_tension, damage_shear, crack, block_a, block_b,
    joint, gap: in large motion, where the blocks of a joint of the start have come apart, it stays with its last damage, and
    gap (m) leads from its place on block_a to that on block_b; opening is the length of it."""

    def __init__(self, of_session):
        self.time, self.displacement = of_session["time"], of_session["displacement"]
        self.joints = table(of_session["joints"])

    def __repr__(self):
        return f"<frame at {self.time:.6g} s: {len(self.displacement)} gridpoints, {len(self.joints)} contact points>"


class Run(Pictures):
    """What a run has found. Pictures of the model need the folder `out`. history: a structured array with the names and numbers of history.csv; summary: as
    summary.json; frames, and the mesh that they belong to; out: the folder of its files, or None."""

    def __init__(self, simulation, status="done", message="", out=None):
        session = simulation._session
        self.scene, self.out = simulation.scene, out
        self.history = simulation.history
        self.summary = json.loads(session.finish(status, message))
        self.frames = [Frame(f) for f in session.frames()]
        self.mesh = simulation.mesh()

    @property
    def title(self):
        return self.summary.get("title") or "run"

    def plot_cracks(self, *args, **named):
        return self._written("plot_cracks").plot_cracks(*args, **named)

    def plot_forces(self, *args, **named):
        return self._written("plot_forces").plot_forces(*args, **named)

    def plot_field(self, *args, **named):
        return self._written("plot_field").plot_field(*args, **named)

    def _written(self, what):
        if self.out is None:
            raise BadInput(f"{what}: draws the files of a run; run it with a folder for them, out=...")
        return open_results(self.out)

    @property
    def dataframe(self):
        """The history for pandas, where that is installed."""
        import pandas
        return pandas.DataFrame({name: self.history[name] for name in self.history.dtype.names})

    @property
    def peak(self):
        """Largest horizontal force, or vertical one where the last stage is driven upright, N, and the displacement there, m."""
        upright = self.summary["peak_vertical_force_N"]
        return self.summary["peak_horizontal_force_N"] if upright is None else upright, self.summary["displacement_at_peak_m"]

    def __repr__(self):
        return (f"<run {self.summary['status']}: {len(self.history)} rows, {len(self.frames)} frames, peak "
                f"{self.peak[0] / 1e3:.2f} kN at {self.peak[1] * 1e3:.3f} mm>")


def run(scene, *, threads=0, progress=False, frames=True, out=None, report=False, isolate_law=False, law_seconds=None):
    """Runs a scene, or the file of one, to its end. progress: a line of what it has come to (peak so far, damaged
    joints, energy) on stderr, or in the cell of a notebook. out: a folder for
    history.csv, summary.json and the files for ParaView, as `quoin run --out` writes them. report: its page too, as
    `quoin report` writes it. isolate_law, law_seconds: as of Simulation. What goes wrong is raised, and Ctrl-C too, with
    what was computed until then as attribute `run` of the exception."""
    if report and out is None:
        raise BadInput("report: the page is made from the files of a run; give the folder for them, out=...")
    simulation = Simulation(scene, threads=threads, frames=frames, out=out, isolate_law=isolate_law,
                            law_seconds=law_seconds)
    if report:
        simulation._session.require_report()  # now, and not after hours
    try:
        run_and_tell(simulation) if progress else simulation.run()
    except (Error, KeyboardInterrupt) as stopped:
        interrupted = isinstance(stopped, KeyboardInterrupt)
        stopped.run = Run(simulation, "interrupted" if interrupted else "failed", str(stopped), out)
        raise
    result = Run(simulation, out=out)
    simulation.close()
    if report:
        _quoin.report(os.fspath(out))
    return result
