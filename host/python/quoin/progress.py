"""Progress of a run: on a terminal, and in a notebook as one line that is updated."""
import sys
import time

import numpy as np

PERIOD = 0.5  # s between two lines
FIRST = 50    # steps before the first line


def _in_notebook():
    """Function that shows and updates HTML, if IPython runs the kernel of a notebook; else None."""
    kernel = sys.modules.get("IPython") and sys.modules["IPython"].get_ipython()
    if kernel is None or not hasattr(kernel, "kernel"):
        return None
    from IPython.display import HTML, display
    handle = display(HTML(""), display_id=True)
    return lambda text: handle.update(HTML(f"<code>{text}</code>"))


def _on_terminal(text):
    print(f"\r{text:<100}", end="", file=sys.stderr, flush=True)


def state_of(simulation, stage, stages, name, fraction):
    """Stage, displacement and force, peak so far, kinetic energy, and the share of contact points that are damaged."""
    history = simulation.history
    told = f"stage {stage + 1} of {stages} {name}: {100 * fraction:.0f} %"
    if len(history) and np.isfinite(history["displacement_m"][-1]):
        upright = np.ptp(history["vertical_displacement_m"]) > np.ptp(history["displacement_m"])
        force = history["vertical_force_N" if upright else "horizontal_force_N"]
        moved = history["vertical_displacement_m" if upright else "displacement_m"]
        k = int(np.nanargmax(np.abs(force))) if np.isfinite(force).any() else 0
        told += (f"; {1e3 * moved[-1]:.3g} mm, {force[-1] / 1e3:.3g} kN, peak so far {abs(force[k]) / 1e3:.3g} kN at "
                 f"{1e3 * moved[k]:.3g} mm; kinetic energy {history['kinetic_energy_J'][-1]:.3g} J")
    damaged = points = 0
    for joint in simulation.joints:
        worst = np.max([np.nan_to_num(d) for d in simulation.damage(joint)], axis=0)
        damaged, points = damaged + np.count_nonzero(worst > 0), points + len(worst)
    return told + (f"; {100 * damaged / points:.3g} % of contact points damaged" if points else "")


def run_and_tell(simulation):
    """Runs to the end, with a line every half second. The steps are those of a run without progress."""
    come = [0, len(simulation.scene.stage), "", 0.0]
    session, show = simulation._session, _in_notebook() or _on_terminal
    session.set_progress(lambda *now: come.__setitem__(slice(None), now))
    steps, more = FIRST, True
    try:
        while more:
            began = time.monotonic()
            more = session.step(steps, False)
            steps = max(1, min(10 * steps, int(steps * PERIOD / max(time.monotonic() - began, 1e-6))))
            if not more:  # the progress function is called only from time to time
                come = [come[1] - 1, come[1], session.stage_names[-1], 1.0]
            show(state_of(simulation, *come))
    finally:
        session.set_progress(None)
        if show is _on_terminal:
            print(file=sys.stderr)
