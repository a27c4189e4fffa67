#!/usr/bin/env python3
"""How the error of a T-spline falls with its control points: a table and a plot of what bench_convergence prints.

    build/release/bench/bench_convergence > log.jsonl
    bench/convergence.py log.jsonl --plot docs/images/convergence.png > table.md

The plot needs matplotlib.
"""
import argparse
import json
import math

SHAPES = {"torus": "torus of radii 2 and 1", "sphere": "unit sphere: eight vertices of valence 3"}
WAYS = {"uniform": "uniform", "by direction": "adaptive, by direction", "in four": "adaptive, in four"}


def slope(rows, key):
    """The exponent of the error in the number of control points, over the finer half of the rows."""
    rows = sorted(rows, key=lambda r: r["points"])[-(len(rows) + 1) // 2:]
    x = [math.log(r["points"]) for r in rows]
    y = [math.log(r[key]) for r in rows]
    n, mx, my = len(x), sum(x) / len(x), sum(y) / len(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x) if n > 1 else math.nan


def of(rows, shape, way):
    return sorted((r for r in rows if r["shape"] == shape and r["way"] == way), key=lambda r: r["points"])


def print_table(rows):
    print("| shape | quads | control points | T-junctions | largest error | rms | largest, 20 degrees away |")
    print("|---|---|---:|---:|---:|---:|---:|")
    for shape in SHAPES:
        for way in WAYS:
            for r in of(rows, shape, way):
                away = f"{r['away_max']:.2g}" if shape == "sphere" else "-"
                print(f"| {shape} | {WAYS[way]} | {r['points']:,} | {r['junctions']} | {r['max']:.2g} | {r['rms']:.2g} | {away} |")
    print()
    for shape in SHAPES:
        for way in WAYS:
            found = of(rows, shape, way)
            if not found:
                continue
            text = f"{shape}, {WAYS[way]}: largest error ~ N^{slope(found, 'max'):.2f}, rms ~ N^{slope(found, 'rms'):.2f}"
            if shape == "sphere" and way == "uniform":
                text += f", largest away from the vertices ~ N^{slope(found, 'away_max'):.2f}"
            print(f"* {text}")


def plot(rows, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.4), sharey=True)
    for axis, (shape, title) in zip(axes, SHAPES.items()):
        series = [(WAYS[way], of(rows, shape, way), "max", style)
                  for way, style in (("uniform", "o-C0"), ("by direction", "s-C1"), ("in four", "^-C3"))]
        if shape == "sphere":
            series.insert(1, ("uniform, 20 degrees away from them", of(rows, shape, "uniform"), "away_max", "o:C0"))
        for label, found, key, style in series:
            if found:
                axis.loglog([r["points"] for r in found], [r[key] for r in found], style, label=label, ms=5)
        start = of(rows, shape, "uniform")[0]
        x = [40, 9000]
        y = 0.35 * start["max"] * start["points"] ** 2
        axis.loglog(x, [y / n ** 2 for n in x], "--", color="0.5", label="order 4: 1/N²")
        if shape == "sphere":
            last = of(rows, shape, "uniform")[-1]
            axis.loglog(x, [2.5 * last["max"] * last["points"] / n for n in x], ":", color="0.5", label="order 2: 1/N")
        axis.set_title(title)
        axis.set_xlabel("control points N")
        axis.grid(True, which="major", alpha=0.4)
        axis.grid(True, which="minor", alpha=0.12)
        axis.legend(fontsize=8, loc="lower left")
    axes[0].set_ylabel("largest distance to the shape")
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log")
    parser.add_argument("--plot")
    options = parser.parse_args()
    with open(options.log, encoding="utf-8") as log:
        rows = [json.loads(line) for line in log]
    print_table(rows)
    if options.plot:
        plot(rows, options.plot)


if __name__ == "__main__":
    main()
