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
    """A frame of the run. time, s; displacement of the gridpoints of all blocks, m; joints: a structured array by contact
    point, position, displacement, traction, opening, slip, damage_tension, damage_shear, crack, block_a, block_b, joint,
    gap. Where blocks of a joint of the start have parted in large motion, its points keep their last damage. gap (m) is
    then the vector from the place on block_a to that on block_b, and opening is its length."""

    def __init__(self, of_session):
        self.time, self.displacement = of_session["time"], of_session["displacement"]
        self.joints = table(of_session["joints"])

    def __repr__(self):
        return f"<frame at {self.time:.6g} s: {len(self.displacement)} gridpoints, {len(self.joints)} contact points>"


class Run(Pictures):
    """Results of a run. Pictures of the model need the folder `out`. history: a structured array with the names and
    numbers of history.csv; summary: contents of summary.json; frames, and their mesh; out: the folder of its files, or
    None."""

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
        """The history as a DataFrame of pandas, if that is installed."""
        try:
            import pandas
        except ImportError:
            raise ImportError("dataframe needs pandas, which is not installed for this Python: apt-get install python3-pandas") from None
        return pandas.DataFrame({name: self.history[name] for name in self.history.dtype.names})

    @property
    def peak(self):
        """Largest horizontal force, N, and its displacement, m; vertical ones if the last stage is driven vertically. Magnitudes:
        the history has the signs. None where no block is watched."""
        upright = self.summary["peak_vertical_force_N"]
        return self.summary["peak_horizontal_force_N"] if upright is None else upright, self.summary["displacement_at_peak_m"]

    def __repr__(self):
        force, displacement = self.peak
        peak = "no block watched" if force is None else f"peak {force / 1e3:.2f} kN at {displacement * 1e3:.3f} mm"
        return f"<run {self.summary['status']}: {len(self.history)} rows, {len(self.frames)} frames, {peak}>"


def run(scene, *, threads=0, progress=False, frames=True, out=None, report=False, isolate_law=False, law_seconds=None):
    """Runs a scene, or a scene file, to its end. progress: a line with the state (peak so far, damaged joints, energy) on
    stderr, or in the cell of a notebook. out: a folder for history.csv, summary.json and the files for ParaView, as of
    `quoin run --out`. report: also its page, as of `quoin report`. isolate_law, law_seconds: as of Simulation. Errors are
    raised, as is KeyboardInterrupt, with the results so far as attribute `run` of the exception."""
    if report and out is None:
        raise BadInput("report: the page is made from the files of a run; give the folder for them, out=...")
    simulation = Simulation(scene, threads=threads, frames=frames, out=out, isolate_law=isolate_law,
                            law_seconds=law_seconds)
    if report:
        simulation._session.require_report()  # at the start, not at the end of a long run
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
