"""The figure of a verification case: measured points over the curves of their reference, as SVG with the same bytes each time."""
import csv
import os

# Colours that differ in lightness too.
COLOURS = ["#1d3557", "#d1495b", "#2a9d8f", "#e09f3e"]
MARKS = ["o", "s", "^", "D"]
MOST_LONE_POINTS = 30  # of a curve; more of them are a line with marks


def read(path):
    """Labels of both axes, and the curves in the order of the file: (name, kind, x, y)."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    curves = []
    for name, kind, x, y in rows[1:]:
        if not curves or curves[-1][:2] != (name, kind):
            curves.append((name, kind, [], []))
        curves[-1][2].append(float(x))
        curves[-1][3].append(float(y))
    return rows[0][2], rows[0][3], curves


def version():
    """What is in the file beside the drawing; None where matplotlib is not here."""
    try:
        import matplotlib
    except ImportError:
        return None
    return f"Matplotlib v{matplotlib.__version__}"


def draw(data, picture, log=""):
    """data: as write_figure of tests/verification/support.h writes it. log: axes that are logarithmic, as "xy"."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot, ticker
    x_label, y_label, curves = read(data)
    with matplotlib.rc_context({"svg.hashsalt": os.path.basename(data), "svg.fonttype": "path", "font.size": 9,
                                "axes.spines.top": False, "axes.spines.right": False}):
        figure, axes = pyplot.subplots(figsize=(7.2, 3.0), constrained_layout=True)
        count = {"reference": 0, "measured": 0}
        paired = sum(kind == "reference" for _, kind, _, _ in curves) > 1
        for name, kind, x, y in curves:
            nth = count[kind]
            count[kind] += 1
            if kind == "reference":
                axes.plot(x, y, color=COLOURS[nth] if paired else "#8d99ae", linewidth=2.2, alpha=0.55, linestyle=["-", "--", "-.", ":"][nth],
                          label=name)
            else:
                axes.plot(x, y, color=COLOURS[nth], linewidth=0 if len(x) <= MOST_LONE_POINTS else 0.8, marker=MARKS[nth], markersize=4,
                          markerfacecolor="none", markevery=1 if len(x) <= MOST_LONE_POINTS else 0.045, label=name)
        for name, axis, scale, at in (("x", axes.xaxis, axes.set_xscale, 2), ("y", axes.yaxis, axes.set_yscale, 3)):
            if name not in log:
                continue
            scale("log")
            if max(max(c[at]) for c in curves) < 100 * min(min(c[at]) for c in curves):  # few powers of ten, if any
                axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
                axis.set_major_formatter(ticker.FormatStrFormatter("%g"))
                axis.set_minor_locator(ticker.NullLocator())
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
        axes.grid(linewidth=0.4, color="#dddddd")
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize=8)
        figure.canvas.draw()
        for text in (axes.xaxis.label, axes.yaxis.label, axes.get_legend()):
            box = text.get_window_extent()
            if box.x0 < 0 or box.y0 < 0 or box.x1 > figure.bbox.x1 or box.y1 > figure.bbox.y1:
                raise ValueError(f"{data}: a label or the legend is longer than the figure: shorten {x_label!r}, {y_label!r} or a name")
        figure.savefig(picture, format="svg", metadata={"Date": None})
        pyplot.close(figure)
