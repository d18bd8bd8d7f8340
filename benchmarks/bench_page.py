"""The page of the benchmarks: tables in Markdown, and three plots."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from machine import described
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactlab.api.drawing.colours import styles
from contactlab.reports.figures import INK, MUTED, house_style
from contactlab.reports.sheet import Sheet

Rows = Sequence[Mapping[str, Any]]
PHASES = {"elements": "#0072B2", "contact": "#D55E00", "rest": "#999999"}


def write_page(found: Mapping[str, Any], lost: Mapping[str, float], against: str, folder: Path) -> None:
    """`benchmarks.md` and its plots in the folder. `against`: what `lost` is relative to, or why nothing is."""
    for name, draw in (("updates", _updates), ("phases", _phases), ("contact", _contact)):
        with house_style():
            figure = Figure(figsize=(7.2, 4.2), layout="constrained")
            draw(figure.subplots(), found)
            figure.savefig(folder / f"benchmarks-{name}.png", dpi=110)
    (folder / "benchmarks.md").write_text("\n".join(_text(found, lost, against)) + "\n", encoding="utf-8")


# --- plots -------------------------------------------------------------------------------------------


def _updates(axes: Axes, found: Mapping[str, Any]) -> None:
    rows = [row for row in found["elements"] if row["element"] == "q1"]
    laws = list(dict.fromkeys(row["law"] for row in rows))
    for number, law in enumerate(laws):
        own = [row for row in rows if row["law"] == law]
        cells, speed = [row["cells"] for row in own], [row["millions_per_s"] for row in own]
        axes.plot(cells, speed, marker="o", color=f"C{number}", label=law)
    axes.set(xscale="log", xlabel="cells", ylabel="million updates per CPU second", ylim=(0.0, None))
    axes.set_title("explicit steps, bilinear quadrilateral, 2x2 points", fontsize=10)
    axes.legend()


def _phases(axes: Axes, found: Mapping[str, Any]) -> None:
    rows = found["phases"]
    below, at = np.zeros(len(rows)), np.arange(len(rows))
    for name, colour in PHASES.items():
        share = np.array([100.0 * row[name] / sum(row[phase] for phase in PHASES) for row in rows])
        axes.bar(at, share, bottom=below, color=colour, label=name, width=0.7)
        below += share
    axes.set_xticks(at, [f"{row['cells']:.0f} cells\n{row['whole']:.0f} µs" for row in rows])
    axes.set(ylabel="share of a step [%]", ylim=(0.0, 100.0))
    axes.set_title("two pressed blocks, mortar-p0, every slave node active", fontsize=10)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15), ncols=3)


def _contact(axes: Axes, found: Mapping[str, Any]) -> None:
    for name, style in styles(dict.fromkeys(row["algorithm"] for row in found["contact"])).items():
        own = [row for row in found["contact"] if row["algorithm"] == name]
        nodes, cost = [row["nodes"] for row in own], [row["contact"] for row in own]
        slope = found["exponents"][name]
        axes.plot(nodes, cost, marker="o", color=style.colour, label=f"{name}: exponent {slope:.2f}")
    ends = np.array([min(row["nodes"] for row in found["contact"]), max(row["nodes"] for row in found["contact"])])
    axes.plot(ends, 0.5 * ends, color=MUTED, linestyle="--", linewidth=1.0)
    axes.annotate("proportional", (ends[0], 0.5 * ends[0]), (4, -12), color=INK, fontsize=9, textcoords="offset points")
    axes.set_ylim(bottom=0.25 * ends[0])
    axes.set(xscale="log", yscale="log", xlabel="active slave nodes", ylabel="contact in a step [µs]")
    axes.legend()


# --- text --------------------------------------------------------------------------------------------


def _text(found: Mapping[str, Any], lost: Mapping[str, float], against: str) -> Iterable[str]:
    yield "# Benchmarks"
    yield ""
    yield (
        "Written by `make bench`. CPU time of one thread, medians of rounds, in brackets the best and the worst. "
        "Seconds depend on the machine and its load. Ratios are between measurements that take turns in one process; "
        "they belong to the machine as well, as the share of memory in them differs."
    )
    yield ""
    yield described(found["machine"])
    yield from _element_section(found["elements"])
    yield from _peer_section(found["peers"])
    yield from _step_section(found)
    yield from _start_section(found)
    yield from ["", "## Against the baseline", "", against[:1].upper() + against[1:] + "."]
    if "no baseline" not in against:
        yield ""
        yield from [f"- {name}: {share:.0%} lost" for name, share in lost.items()] or ["Nothing lost a fifth or more."]


def _element_section(rows: Rows) -> Iterable[str]:
    yield from ["", "## Element updates", "", "![updates per second](benchmarks-updates.png)", ""]
    yield (
        "Node update and Python overhead included. *Bound* is the time that the STREAM triad on this machine needs "
        "for the bytes that no scheme can avoid."
    )
    yield ""
    head = ("element", "law", "cells", "ns", "M/s", "share of the bound")
    cells = (
        (r["element"], r["law"], r["cells"], f"{r['ns']:.1f} {_spread(r['spread'])}", f"{r['millions_per_s']:.1f}",
         f"{r['share_of_bound']:.0%}")
        for r in rows
    )  # fmt: skip
    yield Sheet(head, cells).markdown()


def _peer_section(rows: Rows) -> Iterable[str]:
    yield from ["", "## Other codes", ""]
    yield "Linear elastic bilinear quadrilaterals, with the same mesh and motion (`benchmarks/peers`)."
    yield ""
    known = [r for r in rows if "ratio" in r]
    head = ("code", "cells", "ns", "our updates in the same CPU time")
    body = (
        (f"{r['peer']} {r['version']}", r["cells"], f"{r['ns']:.0f} {_spread(r['spread'])}", f"{r['ratio']:.0f} times")
        for r in known
    )
    yield Sheet(head, body).markdown()
    yield from ("\nLeft out: " + f"{r['peer']}: {r['skipped']}" for r in rows if "skipped" in r)


def _step_section(found: Mapping[str, Any]) -> Iterable[str]:
    yield from [
        "",
        "## A step by phase",
        "",
        "![phases](benchmarks-phases.png)",
        "",
        "![contact](benchmarks-contact.png)",
    ]
    yield ""
    head = ("cells", "step, µs", "elements", "contact", "rest", "contact over elements", "sweeps")
    body = (
        (f"{r['cells']:.0f}", f"{r['whole']:.1f} {_spread((r['least'], r['largest']))}",
         *(f"{r[k]:.1f}" for k in ("elements", "contact", "rest")),
         f"{r['contact'] / r['elements']:.2f}", f"{r['sweeps']:.1f}")
        for r in found["phases"]
    )  # fmt: skip
    yield Sheet(head, body).markdown()
    yield ""
    slopes = ", ".join(f"{name} {value:.2f}" for name, value in found["exponents"].items())
    yield f"Exponents of cost against size: {slopes}."
    yield ""
    head = ("element", "law", "bytes per cell", "bytes per slave node")
    rows = found["memory"]
    memory = ((r["element"], r["law"], f"{r['bytes_per_cell']:.0f}", f"{r['bytes_per_slave_node']:.0f}") for r in rows)
    yield Sheet(head, memory).markdown()


def _start_section(found: Mapping[str, Any]) -> Iterable[str]:
    start, compiled, overhead, law = (found[k] for k in ("start_up", "compilation", "overhead", "numpy law"))
    yield from ["", "## Start and overhead", ""]
    rows = [
        ("`import contactlab`, s", f"{start['contactlab']:.2f}"),
        ("cached scene to its first step, s", f"{start['first_step']:.2f}"),
        ("everything compiled, s", f"{compiled['everything_s']:.1f}"),
        *((f"also compiled: {name}, s", f"{seconds:.1f}") for name, seconds in compiled["combinations_s"].items()),
        ("step of four cells with contact, µs", f"{overhead['step_us']:.0f}"),
        ("the same without contact, µs", f"{overhead['without_contact_us']:.0f}"),
        ("NumPy law by components over the compiled law: whole step", f"{law['by components']:.1f}"),
        ("the law alone", f"{law['alone']:.1f}"),
        ("NumPy law by stacked matrices over the compiled law: whole step", f"{law['by matrices']:.1f}"),
    ]
    yield Sheet(("what", "CPU"), rows).markdown()


def _spread(ends: Sequence[float]) -> str:
    """Best and worst round."""
    return f"({ends[0]:.1f} to {ends[1]:.1f})"
