"""Pictures of a run by matplotlib, if it is installed. Colours are those of cracks.png and of the page."""
import re

import numpy as np

from . import _quoin
from .errors import Error
from .forces import pressed, thrust_lines

ENERGIES = {"kinetic_energy_J": "kinetic", "strain_energy_J": "strain", "contact_energy_J": "joints",
            "dissipated_tension_J": "tension", "dissipated_cohesion_J": "cohesion", "dissipated_friction_J": "friction",
            "dissipated_crushing_J": "crushing", "damping_work_J": "damping", "external_work_J": "external work"}
DASHES = ("-", "--", ":", "-.")  # lines also differ in grey
SEEN_FROM = np.array([0.55, 0.45, 1.0])  # direction to the viewer of assemblies that are not plane
WIDEST = 7.5  # inches of a picture


def _pyplot():
    try:
        from matplotlib import pyplot
    except ImportError:
        raise Error("pictures need matplotlib, which is not installed for this Python: apt-get install python3-matplotlib, or pip "
                    "install matplotlib. history, summary and frames can be read without it") from None
    return pyplot


def _finished(figure, file):
    if file is not None:
        figure.savefig(file, dpi=150)
    return figure


def _curve(stage, history):
    """Axes of the curve of a stage: (column, factor, label) of both."""
    of = stage.get("curve") or {"kind": "push", "along": "x"}
    upright, whose = of["along"] == "y", f" of {of['of']}" if of.get("of") else ""
    way = {"y": "vertical", "z": "out-of-plane"}.get(of["along"], "horizontal")
    time, moved = ("time_s", 1.0, "time [s]"), "vertical_displacement_m" if upright else "displacement_m"
    displacement = (moved, 1e3, f"{way} displacement{whose} [mm]")
    if of["kind"] == "collapse" and "multiplier" in history.dtype.names:
        return ("largest_displacement_m", 1e3, "largest displacement [mm]"), ("multiplier", 1.0, "multiplier of the horizontal load")
    if of["kind"] == "earthquake":
        relative = f"monitor_relative_d{of['along']}_m"
        if relative in history.dtype.names:
            return time, (relative, 1e3, f"displacement along {of['along']}{whose}, relative to the ground [mm]")
        return time, displacement
    if of["kind"] == "rest":
        return time, ("vertical_displacement_m", 1e3, f"vertical displacement{whose} [mm]")
    return displacement, ("vertical_force_N" if upright else "horizontal_force_N", 1e-3, f"{way} force [kN]")


def _round_down(x):
    """Largest of 1, 2 or 5 times a power of ten that is not above x."""
    power = 10.0 ** np.floor(np.log10(x))
    return next(d * power for d in (5, 2, 1) if d * power <= x * (1 + 1e-9))


class _Paper:
    """Projection of space onto the picture: from the front where all moving blocks share their middle plane, else
    oblique."""

    def __init__(self, moment):
        blocks = moment.blocks
        self.start, self.moved = blocks["position"].astype(float), blocks["displacement_m"].astype(float)
        self.faces = moment.faces()
        extents = {}
        for corners, block in self.faces:
            extents.setdefault(block, []).extend(corners)
        moving = [self.start[c] for c in extents.values() if np.any(self.moved[c])] or [self.start]
        middles = [(c[:, 2].min() + c[:, 2].max()) / 2 for c in moving]
        self.plane = max(middles) - min(middles) < 0.25 * max(np.ptp(c[:, 2]) for c in moving)
        towards = np.array([0.0, 0.0, 1.0]) if self.plane else SEEN_FROM / np.linalg.norm(SEEN_FROM)
        right = np.cross([0.0, 1.0, 0.0], towards)
        self.right, self.towards = right / np.linalg.norm(right), towards
        self.up = np.cross(towards, self.right)
        self.size = max(np.ptp(np.vstack(moving), axis=0))
        low, high = np.min(np.vstack(moving), axis=0), np.max(np.vstack(moving), axis=0)
        self.corners = np.array([low, high])

    def magnification(self, summary):
        """Magnification of displacements that makes them visible; 1 in large motion."""
        largest = np.linalg.norm(self.moved, axis=1).max()
        if largest == 0.0 or (summary.get("motion") or {}).get("small_displacements") is False:
            return 1.0
        return max(1.0, _round_down(0.05 * self.size / largest))

    def flat(self, places):
        return np.column_stack([places @ self.right, places @ self.up])

    def visible(self, magnified):
        """Faces towards the viewer, from back to front: (index, outline)."""
        places = self.start + magnified * self.moved
        seen = []
        for k, (corners, _) in enumerate(self.faces):
            p = places[corners]
            normal = np.cross(p[1] - p[0], p[2] - p[0])
            if normal @ self.towards > 0.05 * np.linalg.norm(normal):
                seen.append((p.mean(axis=0) @ self.towards, k, self.flat(p)))
        return [(k, outline) for _, k, outline in sorted(seen, key=lambda f: f[0])]


    def sharp(self, wanted):
        """Edges of some faces at which a block has a corner."""
        normals = {}
        for k, (corners, _) in enumerate(self.faces):
            p = self.start[corners[:3]]
            normal = np.cross(p[1] - p[0], p[2] - p[0])
            normal = normal / (np.linalg.norm(normal) or 1.0)
            for a, b in zip(corners, corners[1:] + corners[:1]):
                normals.setdefault((min(a, b), max(a, b)), []).append((normal, k in wanted))
        return [edge for edge, sides in normals.items() if any(seen for _, seen in sides) and
                (len(sides) != 2 or abs(sides[0][0] @ sides[1][0]) < 0.94)]


class Pictures:
    """Pictures of runs with history, summary, frames and title. Each method returns a figure, and writes it to `file` if
    that is given: .png, .svg or .pdf."""

    def _stages(self):
        return (self.summary.get("settings") or {}).get("stages") or [{}]

    def _stage_of(self, row):
        stages = self._stages()
        return stages[min(int(self.history["stage"][row]) - 1, len(stages) - 1)]

    def _moment_text(self, moment):
        stage = self._stage_of(moment.row)
        (name, factor, label), _ = _curve(stage, self.history)
        value = self.history[name][moment.row] * factor
        come = "" if name == "time_s" else f", {0.0 if abs(value) < 1e-6 else value:.4g} mm"
        return f"stage {moment.stage} {stage.get('name', '')}{come}, {moment.time:.3g} s"

    def plot(self, stage=-1, file=None):
        """The curve of a stage (the last one): force over displacement, multiplier, or displacement over time."""
        figure, axes = _pyplot().subplots(figsize=(WIDEST, 4.6), constrained_layout=True)
        history, settings = self.history, self._stages()[stage]
        alike = [k + 1 for k, s in enumerate(self._stages()) if s.get("curve") == settings.get("curve")]
        rows = np.isin(history["stage"], alike)
        (x, x_factor, x_label), (y, y_factor, y_label) = _curve(settings, history)
        xs, ys = history[x][rows] * x_factor, history[y][rows] * y_factor
        axes.plot(xs, ys, color=_quoin.colours()["pens"][0], linewidth=1.6)
        axes.set(xlabel=x_label, ylabel=y_label, title=self.title)
        axes.grid(True, color="#dddddd", linewidth=0.6)
        axes.axhline(0.0, color="#888888", linewidth=0.8)
        axes.margins(x=0.02, y=0.14)
        if len(ys) and np.isfinite(ys).any():
            k = int(np.nanargmax(np.abs(ys)))
            left = xs[k] > np.mean(axes.get_xlim())
            axes.plot(xs[k], ys[k], "o", color=_quoin.colours()["pens"][0])
            x_unit, y_unit = (re.sub(r"^[^[]*\[?|\]", " ", label).rstrip() for label in (x_label, y_label))
            axes.annotate(f"{ys[k]:.4g}{y_unit} at {xs[k]:.4g}{x_unit}", (xs[k], ys[k]), xytext=(-8 if left else 8, 7 if ys[k] >= 0 else -7),
                          textcoords="offset points", ha="right" if left else "left", va="bottom" if ys[k] >= 0 else "top")
        return _finished(figure, file)

    def plot_cracks(self, frame=-1, magnified=None, file=None):
        """The model at a frame, with its cracks in the colours of cracks.png."""
        from matplotlib.collections import LineCollection
        moment = self.frames[frame]
        paper = _Paper(moment)
        magnified = paper.magnification(self.summary) if magnified is None else magnified
        figure, axes = self._sheet(paper, moment, magnified)
        self._draw_faces(axes, paper, magnified, [_quoin.colours()["face"]] * len(paper.faces))
        joints, styles = moment.joints, _quoin.colours()["cracks"]
        crack, places = joints["crack"], joints["position"] + magnified * joints["displacement_m"].astype(float)
        handles = []
        for kind, (label, colour) in list(enumerate(styles))[1:]:
            width = 2.0 + 0.3 * kind  # worse cracks are wider, also in grey
            if len(joints["connectivity"]) > len(joints["position"]):  # quads of the lattice
                lines = [paper.flat(places[list(ends)]) for ends in self._rim(joints["connectivity"])
                         if min(crack[list(ends)]) > 0 and max(crack[list(ends)]) == kind]
                axes.add_collection(LineCollection(lines, colors=colour, linewidths=width, zorder=2 + kind))
            else:
                at = self._on_blocks(joints, crack == kind, paper, magnified)
                axes.scatter(*paper.flat(at).T, s=4.0 * width, color=colour, zorder=2 + kind, linewidths=0)
            handles.append(axes.plot([], [], color=colour, linewidth=width + 1.5, label=label)[0])
        figure.legend(handles=handles, loc="lower center", ncol=3, frameon=False)
        return _finished(figure, file)

    def plot_field(self, quantity="displacement", frame=-1, magnified=None, limits=None, file=None):
        """The model at a frame, coloured by "displacement" (mm) or "stress" (the smallest principal stress of zones,
        MPa). limits: of the colour scale; by default a range with 98 % of the faces."""
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import LinearSegmentedColormap, Normalize
        if quantity not in ("displacement", "stress"):
            raise ValueError(f"quantity = {quantity!r}: displacement or stress")
        moment = self.frames[frame]
        paper = _Paper(moment)
        magnified = paper.magnification(self.summary) if magnified is None else magnified
        values = self._values(quantity, moment, paper)
        low, high = limits or (min(0.0, np.percentile(values, 1)), max(0.0, np.percentile(values, 99)))
        colours = _quoin.colours()
        most = max(-low, high) or 1.0
        steps = np.linspace(low, high, 64) / most if high > low else np.zeros(2)
        parts = [colours["cold"], colours["middle"], colours["warm"]]
        whole = LinearSegmentedColormap.from_list("quoin", parts)
        shown = LinearSegmentedColormap.from_list("shown", [whole(0.5 + 0.5 * s) for s in steps])
        scale = ScalarMappable(Normalize(low, high if high > low else low + 1.0), shown)
        figure, axes = self._sheet(paper, moment, magnified)
        self._draw_faces(axes, paper, magnified, scale.to_rgba(values))
        label = "displacement [mm]" if quantity == "displacement" else "smallest principal stress [MPa]"
        figure.colorbar(scale, ax=axes, shrink=0.8, label=label,
                        extend={(False, False): "neither", (True, False): "min", (False, True): "max",
                                (True, True): "both"}[values.min() < low, values.max() > high])
        return _finished(figure, file)

    def plot_forces(self, kind="joints", frame=-1, file=None):
        """The model in its place at a frame, without magnification. "joints": the resultant of each joint in compression,
        with a width in proportion. "thrust": the line of thrust of arches, walls and buttresses."""
        from matplotlib.collections import LineCollection
        if kind not in ("joints", "thrust"):
            raise ValueError(f"kind = {kind!r}: joints or thrust")
        moment = self.frames[frame]
        paper = _Paper(moment)
        figure, axes = self._sheet(paper, moment, 1.0)
        self._draw_faces(axes, paper, 1.0, [_quoin.colours()["face"]] * len(paper.faces))
        pens = _quoin.colours()["pens"]
        if kind == "thrust":
            lines = [paper.flat(np.array(piece)) for piece in thrust_lines(moment)]
            axes.add_collection(LineCollection(lines, colors=pens[0], linewidths=2.0, zorder=5))
            handle = axes.plot([], [], color=pens[0], linewidth=2.0, label="line of thrust")[0]
        else:
            joints = pressed(moment)
            force, place = joints["force_N"].astype(float), joints["position"].astype(float)
            size = np.linalg.norm(force, axis=1)
            most = size.max(initial=0.0) or 1.0
            half = 0.02 * paper.size * force / np.where(size > 0, size, 1.0)[:, None]
            lines = [paper.flat(np.array([p - h, p + h])) for p, h in zip(place, half)]
            axes.add_collection(LineCollection(lines, colors=pens[1], linewidths=6.0 * size / most, zorder=5))
            whole = (self.summary.get("symmetry_factor") or 1.0) * most / 1e3
            handle = axes.plot([], [], color=pens[1], linewidth=6.0, label=f"force in a joint: {whole:.3g} kN")[0]
        figure.legend(handles=[handle], loc="lower center", frameon=False)
        return _finished(figure, file)

    def plot_histories(self, columns=None, file=None):
        """Columns of the history over time; by default displacements, forces, the multiplier and energies."""
        history = self.history
        if columns is None:
            panels = [([c for c in names if c in history.dtype.names], factor, label) for names, factor, label in (
                (("displacement_m", "vertical_displacement_m"), 1e3, "displacement [mm]"),
                (("horizontal_force_N", "vertical_force_N"), 1e-3, "force [kN]"), (("multiplier",), 1.0, "multiplier"),
                (tuple(ENERGIES), 1.0, "energy [J]"))]
        else:
            panels = [([c], 1.0, c) for c in columns]
        panels = [p for p in panels if p[0]]
        figure, all_axes = _pyplot().subplots(len(panels), 1, sharex=True, squeeze=False, constrained_layout=True,
                                              figsize=(WIDEST, 1.0 + 2.1 * len(panels)))
        time, pens = history["time_s"], _quoin.colours()["pens"]
        for axes, (names, factor, label) in zip(all_axes[:, 0], panels):
            for k, name in enumerate(names):
                words = ENERGIES.get(name) or name.rsplit("_", 1)[0].replace("_", " ")
                axes.plot(time, history[name] * factor, DASHES[k // 3 % 4], color=pens[k % len(pens)], linewidth=1.4,
                          label=words if len(names) > 1 else None)
            for begin in np.flatnonzero(np.diff(history["stage"])) + 1:
                axes.axvline(time[begin], color="#888888", linewidth=0.8)
            axes.set_ylabel(label)
            axes.grid(True, color="#dddddd", linewidth=0.6)
            if len(names) > 1:
                axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False, fontsize="small")
        all_axes[-1, 0].set_xlabel("time [s]")
        names = [s.get("name", "") for s in self._stages()]
        all_axes[0, 0].set_title(f"{self.title}\nstages {', '.join(n for n in names if n)}; lines where the next begins")
        return _finished(figure, file)

    # --- parts of a picture -----------------------------------------------------------------------------------------

    def _sheet(self, paper, moment, magnified):
        extent = paper.flat(np.array([[paper.corners[i, 0], paper.corners[j, 1], paper.corners[k, 2]]
                                      for i in (0, 1) for j in (0, 1) for k in (0, 1)]))
        wide, tall = np.ptp(extent, axis=0)
        width = WIDEST
        height = float(np.clip(width * 0.8 * tall / max(wide, 1e-9), 2.5, 7.5)) + 1.6
        figure, axes = _pyplot().subplots(figsize=(width, height))
        figure.subplots_adjust(left=0.11, right=0.97, top=1 - 0.6 / height, bottom=1.15 / height)  # legend below, title above
        scale = "true to scale" if magnified == 1 else f"drawn {magnified:g} times larger"
        axes.set_title(f"{self.title}\n{self._moment_text(moment)}; displacements {scale}", fontsize="medium", wrap=True)
        axes.set_aspect("equal")
        room = 0.12 * max(wide, tall)
        axes.set_xlim(extent[:, 0].min() - room, extent[:, 0].max() + room)
        axes.set_ylim(extent[:, 1].min() - room, extent[:, 1].max() + room)
        if paper.plane:
            axes.set(xlabel="x [m]", ylabel="y [m]")
        else:
            axes.set_axis_off()
            length = _round_down(0.3 * wide)
            x, y = axes.get_xlim()[0], axes.get_ylim()[0]
            axes.plot([x, x + length], [y, y], color="#222222", linewidth=2, clip_on=False)
            axes.text(x + length, y, f" {length:g} m", va="center")
        return figure, axes

    @staticmethod
    def _draw_faces(axes, paper, magnified, colours):
        from matplotlib.collections import LineCollection, PolyCollection
        seen = paper.visible(magnified)
        # A plane view has edges of blocks, not of their zones. In other views nearer faces hide farther edges.
        outline = _quoin.colours()["edge"]
        edges = "face" if paper.plane else outline
        axes.add_collection(PolyCollection([face for _, face in seen], facecolors=[colours[k] for k, _ in seen],
                                           edgecolors=edges, linewidths=0.4, zorder=1))
        if paper.plane:
            places = paper.flat(paper.start + magnified * paper.moved)
            axes.add_collection(LineCollection([places[list(e)] for e in paper.sharp({k for k, _ in seen})], colors=outline,
                                               linewidths=0.5, zorder=1.5))

    @staticmethod
    def _rim(corners):
        """Edges of only one quad, where joints meet the surface."""
        quads = corners.reshape(-1, 4)
        ends = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
        edges, count = np.unique(ends, axis=0, return_counts=True)
        return edges[count == 1]

    @staticmethod
    def _on_blocks(joints, wanted, paper, magnified):
        """Places of joints' points in the picture: on their blocks, and on both blocks where these have parted."""
        at = joints["position"][wanted].astype(float)
        if "gap_m" in joints:
            apart = at + joints["gap_m"][wanted]
            at = np.vstack([at, apart[np.any(joints["gap_m"][wanted] != 0, axis=1)]])
        if magnified != 1 and len(at):  # current places: moved with the nearest vertex
            now = paper.start + paper.moved
            nearest = [int(np.argmin(((now - p) ** 2).sum(axis=1))) for p in at]
            at = at + (magnified - 1) * paper.moved[nearest]
        return at

    @staticmethod
    def _values(quantity, moment, paper):
        """Values by face of the surface."""
        if quantity == "displacement":
            size = 1e3 * np.linalg.norm(paper.moved, axis=1)
            return np.array([size[corners].mean() for corners, _ in paper.faces])
        xx, yy, zz, xy, yz, zx = moment.blocks["stress_Pa"].astype(float).T
        least = np.linalg.eigvalsh(np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]).transpose(2, 0, 1))[:, 0] / 1e6
        blocks = moment.blocks
        total, count = np.zeros((2, len(paper.start)))
        cells = np.repeat(np.arange(len(least)), np.diff(blocks["offsets"], prepend=0))
        np.add.at(total, blocks["connectivity"], least[cells])
        np.add.at(count, blocks["connectivity"], 1.0)
        at_points = total / np.maximum(count, 1.0)
        return np.array([at_points[corners].mean() for corners, _ in paper.faces])
