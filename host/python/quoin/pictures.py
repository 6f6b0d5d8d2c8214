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
    """Axes of the curve of a stage: (column, or its values, factor, label) of both; None where nothing is watched."""
    of = stage.get("curve") or {"kind": "push", "along": "x"}
    upright, whose = of["along"] == "y", f" of {of['of']}" if of.get("of") else ""
    way = {"y": "vertical", "z": "out-of-plane"}.get(of["along"], "horizontal")
    time, moved = ("time_s", 1.0, "time [s]"), "vertical_displacement_m" if upright else "displacement_m"
    displacement = (moved, 1e3, f"{way} displacement{whose} [mm]")
    if of["kind"] == "collapse" and "multiplier" in history.dtype.names:
        return ("largest_displacement_m", 1e3, "largest displacement [mm]"), ("multiplier", 1.0, "multiplier of the weight")
    if of.get("of", "") is None:
        return (time, ("largest_displacement_m", 1e3, "largest displacement of a block [mm]")) if (
            "largest_displacement_m" in history.dtype.names) else None
    if of["kind"] == "earthquake":
        direction = of.get("direction") or [float(axis == of["along"]) for axis in "xyz"]
        parts = [(d, f"monitor_relative_d{axis}_m") for d, axis in zip(direction, "xyz") if d]
        if parts[0][1] in history.dtype.names:
            relative = sum(d * history[name] for d, name in parts)
            return time, (relative, 1e3, f"relative displacement along {of['along']}{whose} [mm]")
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
            extents.setdefault(block, set()).update(corners)
        self.vertices = {block: np.array(sorted(corners)) for block, corners in extents.items()}
        self.still = {block for block, corners in self.vertices.items() if not np.any(self.moved[corners])}
        moving = [self.start[c] for block, c in self.vertices.items() if block not in self.still] or [self.start]
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
        """Faces towards the viewer, from back to front: (index, outline). Supports come first, as the depth of their middle
        does not sort what stands on them. In a plane view the faces of a block follow each other."""
        places = self.start + magnified * self.moved
        seen, nearest = [], {}
        for k, (corners, block) in enumerate(self.faces):
            p = places[corners]
            normal = np.cross(p[1] - p[0], p[2] - p[0])
            if normal @ self.towards > 0.05 * np.linalg.norm(normal):
                depth = p.mean(axis=0) @ self.towards
                nearest[block] = max(depth, nearest.get(block, -np.inf))
                seen.append((block not in self.still, depth, block, k, self.flat(p)))
        if self.plane:
            seen = [(moves, nearest[block], block, k, outline) for moves, _, block, k, outline in seen]
        return [(k, outline) for *_, k, outline in sorted(seen, key=lambda f: f[:4])]

    def magnify(self, places, blocks, magnified):
        """Current places on blocks, moved on with the nearest vertex of each: the mean of these."""
        if magnified == 1:
            return places
        now = self.start + self.moved
        shift = np.zeros_like(places)
        for of in (self.vertices[block] for block in blocks):
            nearest = [of[np.argmin(((now[of] - p) ** 2).sum(axis=1))] for p in places]
            shift += self.moved[nearest] / len(blocks)
        return places + (magnified - 1) * shift

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


def _joints_of(*columns):
    """Indices of contact points, joint by joint: those with equal values in these columns."""
    _, joint = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    order = np.argsort(joint.ravel(), kind="stable")
    return np.split(order, np.flatnonzero(np.diff(joint.ravel()[order])) + 1)


def _front_lines(joints, magnified):
    """Cracks of joints on the lattice, from the front: (kind, places of both ends). Each contact point colours the line
    half-way to its neighbours. Of points behind each other the worst one counts."""
    start, crack = joints["position"].astype(float), joints["crack"]
    places = start + magnified * joints["displacement_m"].astype(float)
    axis = np.abs(joints["normal"]).argmax(axis=1)
    lines = []
    for points in _joints_of(joints["block_a"], joints["block_b"], axis):
        if axis[points[0]] == 2 or not crack[points].any():  # in the plane of the picture, or intact
            continue
        points = points[np.argsort(start[points, 1 if axis[points[0]] == 0 else 0], kind="stable")]
        along = start[points, 1 if axis[points[0]] == 0 else 0]
        columns = np.split(points, np.flatnonzero(np.diff(along) > 1e-3 * np.ptp(along)) + 1)  # behind each other
        kinds = [crack[column].max() for column in columns]
        fronts = [places[column[start[column, 2].argmax()]] for column in columns]
        for (kind_a, a), (kind_b, b) in zip(zip(kinds, fronts), zip(kinds[1:], fronts[1:])):
            lines += [(kind_a, np.array([a, (a + b) / 2])), (kind_b, np.array([(a + b) / 2, b]))]
    return lines


def _cracked_sides(joints):
    """Sides of joints that are not intact: (kind, blocks, current places). The worst contact point gives the kind. A joint
    has one side for both blocks, or one for each where these have parted."""
    at = joints["position"].astype(float) + joints["displacement_m"]
    gap = joints["gap_m"].astype(float) if "gap_m" in joints else np.zeros_like(at)
    a, b = joints["block_a"], joints["block_b"]
    sides = []
    for points in _joints_of(np.minimum(a, b), np.maximum(a, b)):
        kind = joints["crack"][points].max()
        if kind == 0:
            continue
        low, high = sorted((int(a[points[0]]), int(b[points[0]])))
        if not gap[points].any():
            sides.append((kind, (low, high), at[points]))
            continue
        on_a, on_b = at[points], at[points] + gap[points]
        in_order = (a[points] == low)[:, None]
        sides += [(kind, (low,), np.where(in_order, on_a, on_b)), (kind, (high,), np.where(in_order, on_b, on_a))]
    return sides


def _side_lines(sides, paper, magnified):
    """Cracks of blocks in a plane view: the line between the two places of a side that are furthest apart."""
    lines = []
    for kind, blocks, places in sides:
        flat, depth = paper.flat(places), places @ paper.towards
        apart = np.linalg.norm(flat[:, None] - flat[None, :], axis=2)
        apart += 1e-6 * (depth[:, None] + depth[None, :])  # of equal ones that on the viewer's side
        ends = np.unravel_index(apart.argmax(), apart.shape)
        lines.append((kind, paper.magnify(places[list(ends)], blocks, magnified)))
    return lines


def _edge_lines(sides, paper, magnified):
    """Cracks of other views, by face: what joints cover of its edges. As the faces, nearer faces hide them."""
    now, drawn = paper.start + paper.moved, paper.start + magnified * paper.moved
    of_block = {}
    for kind, blocks, places in sides:
        for block in blocks:
            of_block.setdefault(block, []).append((kind, places))
    lines = {}
    for k, (corners, block) in enumerate(paper.faces):
        for p, q in zip(corners, corners[1:] + corners[:1]):
            edge = now[q] - now[p]
            length = np.linalg.norm(edge) or 1.0
            for kind, places in of_block.get(block, ()):
                along = (places - now[p]) @ edge / length**2
                away = np.linalg.norm(places - now[p] - along[:, None] * edge, axis=1)
                # The tolerance is above the overlap of blocks under compression.
                on = np.clip(along[(along > -0.02) & (along < 1.02) & (away <= 0.02 * length)], 0.0, 1.0)
                if len(on) and np.ptp(on) > 0.02:
                    ends = np.array([on.min(), on.max()])[:, None]
                    lines.setdefault(k, []).append((kind, drawn[p] + ends * (drawn[q] - drawn[p])))
    return lines


class Pictures:
    """Pictures of runs with history, summary, frames and title. Each method returns a figure, and writes it to `file` if
    that is given: .png, .svg or .pdf."""

    def _stages(self):
        return (self.summary.get("settings") or {}).get("stages") or [{}]

    def _moment_text(self, moment):
        stages = self._stages()
        stage = stages[min(moment.stage, len(stages)) - 1]
        axes = _curve(stage, self.history)
        (name, factor, _) = axes[0] if axes else ("time_s", 1.0, "")
        value = 0.0 if moment.row is None else self.history[name][moment.row] * factor
        come = "" if name == "time_s" else f", {0.0 if abs(value) < 1e-6 else value:.4g} mm"
        return f"stage {moment.stage} {stage.get('name', '')}{come}, {moment.time:.3g} s"

    def plot(self, stage=-1, file=None):
        """The curve of a stage (the last one): force over displacement, multiplier, or displacement over time."""
        figure, axes = _pyplot().subplots(figsize=(WIDEST, 4.6), constrained_layout=True)
        history, settings = self.history, self._stages()[stage]
        alike = [k + 1 for k, s in enumerate(self._stages()) if s.get("curve") == settings.get("curve")]
        rows = np.isin(history["stage"], alike)
        axes_of = _curve(settings, history)
        if axes_of is None:
            raise Error(f"{self.title}: no block is watched in stage {settings.get('name', '')}, so there is no curve: give a monitor")
        (x, x_factor, x_label), (y, y_factor, y_label) = axes_of
        xs, ys = history[x][rows] * x_factor, (history[y] if isinstance(y, str) else y)[rows] * y_factor
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
        """The model at a frame, with its cracks as in cracks.png."""
        from matplotlib.collections import LineCollection
        moment = self.frames[frame]
        paper = _Paper(moment)
        magnified = paper.magnification(self.summary) if magnified is None else magnified
        figure, axes = self._sheet(paper, moment, magnified)
        joints, styles = moment.joints, _quoin.colours()["cracks"]
        widths = [2.0 + 0.3 * kind for kind in range(len(styles))]  # worse cracks are wider, also in grey
        on_faces, lines = {}, []
        if paper.plane and "gap_m" not in joints:  # the lattice
            lines = _front_lines(joints, magnified)
        elif paper.plane:
            lines = _side_lines(_cracked_sides(joints), paper, magnified)
        else:
            on_faces = {k: [(paper.flat(ends), styles[kind][1], widths[kind]) for kind, ends in of_face]
                        for k, of_face in _edge_lines(_cracked_sides(joints), paper, magnified).items()}
        self._draw_faces(axes, paper, magnified, [_quoin.colours()["face"]] * len(paper.faces), on_faces)
        handles = []
        for kind, (label, colour) in list(enumerate(styles))[1:]:
            axes.add_collection(LineCollection([paper.flat(ends) for of, ends in lines if of == kind], colors=colour,
                                               linewidths=widths[kind], zorder=2 + kind, label=label))
            handles.append(axes.plot([], [], color=colour, linewidth=widths[kind] + 1.5, label=label)[0])
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
    def _draw_faces(axes, paper, magnified, colours, lines_on=None):
        """Draws faces from back to front, so that nearer ones hide farther ones with their edges. lines_on: by face, lines to
        draw with it: (ends, colour, width)."""
        from matplotlib.collections import PolyCollection
        outline, width = _quoin.colours()["edge"], 0.5
        seen = paper.visible(magnified)
        # A plane view has edges of blocks, not of their zones: after the last face of each.
        of_block = {}
        if paper.plane:
            places = paper.flat(paper.start + magnified * paper.moved)
            block_of = {int(v): block for block, vertices in paper.vertices.items() for v in vertices}
            for edge in paper.sharp({k for k, _ in seen}):
                of_block.setdefault(block_of[edge[0]], []).append(places[list(edge)])
        items = []  # (outline, fill, colour of the outline, width)
        for i, (k, face) in enumerate(seen):
            block = paper.faces[k][1]
            items.append((face, colours[k], colours[k] if paper.plane else outline, 0.4))
            if i + 1 == len(seen) or paper.faces[seen[i + 1][0]][1] != block:
                items += [(ends, "none", outline, width) for ends in of_block.pop(block, ())]
            items += [(ends, "none", colour, wide) for ends, colour, wide in (lines_on or {}).get(k, ())]
        if items:
            faces, fills, edges, widths = zip(*items)
            axes.add_collection(PolyCollection(faces, facecolors=fills, edgecolors=edges, linewidths=widths, zorder=1))

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
