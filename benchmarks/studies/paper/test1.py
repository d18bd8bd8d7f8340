"""Test 1 of the paper, disc on block: figures 7 to 12, and what they leave open."""

from __future__ import annotations

from typing import Any

import numpy as np
from common import (
    COLOURS,
    DEEP,
    GREY,
    ROOT,
    SHORT,
    STATE_COLOURS,
    Numbers,
    curve,
    deep_reference,
    difference,
    disc,
    draw,
    percent,
    picture,
    profile,
    reaction,
    run,
)  # fmt: skip
from matplotlib.figure import Figure

import contactlab
from contactlab.api import Record
from contactlab.parts.registry import Registry
from contactlab.studies.measures import excess_turning_points, pressure_error
from contactlab.studies.profile import Profile
from contactlab.studies.reference import load_reference

MORTARS = ("mortar-p0", "mortar-p1")
SLAVES = {False: "disc is slave", True: "block is slave"}
STORED = ("curves", "times")
PRESSURE, SHEAR = "pressure [MPa]", "shear [MPa]"


def _label(axes: Any, title: str, y: str = PRESSURE) -> None:
    axes.set(title=title, xlabel="x, deformed [mm]", ylabel=y, xlim=(-0.65, 0.65))
    axes.legend(fontsize=8)


def _reference(axes: Any) -> Profile:
    shape = deep_reference().profile
    axes.plot(shape.x, shape.value, color=GREY, linewidth=2.2, label="reference", zorder=1)
    return shape


def second_code(swap: bool, depth: float) -> tuple[Profile, float, Profile, float]:
    """Nodes on segments by CalculiX, from its file, and ours with its law: pressure and reaction of each."""
    slave = "block" if swap else "disc"
    path = ROOT / "benchmarks" / "references" / f"calculix-disc-on-block-{slave}-level-2-depth-{depth:g}.csv"
    force = float(path.read_text().split("reaction")[1].split()[0])
    registry = Registry(files=[ROOT / "benchmarks" / "peers" / "calculix_law.py"])
    changes: dict[str, Any] = {
        "level": 2, "contacts.0.algorithm": "node-on-segment", "contacts.0.swap": swap, "supports.1.uy.to": -depth,
        "integrator": {"use": "newton", "steps": 10}, "record.frames": 1,
    }  # fmt: skip
    for material, young in (("steel", 70000.0), ("soft", 7000.0)):
        law = {"use": "calculix-neo-hooke", "young": young, "poisson": 0.3, "density": 2.7e-9}
        changes[f"materials.{material}"] = law
    own = run(contactlab.load_scene("disc-on-block", registry).with_(changes))
    return Profile.of_nodes(*np.loadtxt(path, delimiter=",", unpack=True)), force, profile(own), reaction(own)


def figure_7() -> Numbers:
    """Nodes on segments, explicit: both slaves at the same depth, and at the full one where it is reached."""
    runs = {swap: disc("node-on-segment", swap=swap, explicit=True, frames=100) for swap in SLAVES}
    curves, times = ({swap: getattr(found, name)["contacts.0"] for swap, found in runs.items()} for name in STORED)
    finite = [
        number for number, found in enumerate(curves[False])
        if np.isfinite(np.asarray(found.pressure)).all() and np.max(found.pressure) < 1e5
    ]  # fmt: skip
    last = finite[-1]
    time = times[False][last]
    other = int(np.argmin(np.abs(times[True] - time)))
    same = {False: Profile.of_curve(curves[False][last]), True: Profile.of_curve(curves[True][other])}
    ramp = runs[False].summary["resolved"]["ramp"]
    share = 1.0 - max(0.0, 1.0 - time / ramp) ** 2
    full = profile(runs[True])
    reference = deep_reference().profile
    peers = {(swap, depth): second_code(swap, depth) for swap, depth in ((False, 0.01), (True, 0.01), (True, DEEP))}

    def fill(figure: Figure, axes: Any) -> None:
        one, two, three = axes[0]
        for swap, colour in ((False, COLOURS["node-on-segment"]), (True, "#0072B2")):
            theirs, _, ours, _ = peers[swap, 0.01]
            draw(three, ours, colour, SLAVES[swap], marker="s" if swap else "o")
            three.plot(theirs.x, theirs.value, "x", color="#000000", markersize=4.5, label="" if swap else "CalculiX")
        _label(three, "depth 0.01 mm, law of CalculiX")
        three.set_xlim(-0.16, 0.16)
        draw(one, same[False], COLOURS["node-on-segment"], SLAVES[False])
        draw(one, same[True], "#0072B2", SLAVES[True], marker="s")
        _label(one, f"{100 * share:.0f} % of the depth, both slaves")
        _reference(two)
        draw(two, full, "#0072B2", SLAVES[True], marker="s")
        _label(two, "full depth")

    picture("figure-07", 1, 3, fill, (12.6, 3.4))
    rows = [
        f"| {depth} | {SLAVES[swap]} | {theirs_force:.2f} | {ours_force:.2f} | "
        f"{percent(abs(ours_force / theirs_force - 1.0))} | {percent(pressure_error(ours, theirs))} |"
        for (swap, depth), (theirs, theirs_force, ours, ours_force) in peers.items()
    ]
    return {
        "peer_rows": rows,
        "peer_apart": percent(difference(peers[False, 0.01][0], peers[True, 0.01][0])),
        "own_apart": percent(difference(peers[False, 0.01][2], peers[True, 0.01][2])),
        "asymmetry": percent(difference(same[False], same[True])),
        "share": percent(share), "end": _end(runs[False], share * DEEP),
        "turns": excess_turning_points(same[False], same[True]),
        "error": percent(pressure_error(full, reference)),
        "reaction": f"{reaction(runs[True]):.1f}",
    }  # fmt: skip


def _end(record: Record, reached: float) -> str:
    """How the run with the disc as slave ended, as a sentence."""
    if record.finished:
        return "The explicit run reaches the full depth."
    return f'The explicit run ends at {reached:.4f} mm: {record.status}, "{record.reason.split(";")[0]}".'


def figure_8() -> Numbers:
    """Mortar P0 with either slave."""
    shapes = {swap: profile(disc("mortar-p0", swap=swap)) for swap in SLAVES}

    def fill(figure: Figure, axes: Any) -> None:
        _reference(axes[0][0])
        for swap, colour in ((False, COLOURS["mortar-p0"]), (True, "#D55E00")):
            draw(axes[0][0], shapes[swap], colour, SLAVES[swap], marker="s" if swap else "o")
        _label(axes[0][0], "mortar P0, full depth")

    picture("figure-08", 1, 1, fill, (5.4, 3.4))
    asymmetry = {
        (algorithm, level): difference(*(profile(disc(algorithm, swap=swap, level=level)) for swap in SLAVES))
        for algorithm in MORTARS for level in (2, 4)
    }  # fmt: skip
    reference = deep_reference().profile
    errors = {swap: percent(pressure_error(shapes[swap], reference)) for swap in SLAVES}
    forces = [reaction(disc("mortar-p0", swap=swap)) for swap in SLAVES]
    return {
        "asymmetry": percent(asymmetry["mortar-p0", 2]), "asymmetry_4": percent(asymmetry["mortar-p0", 4]),
        "asymmetry_p1": percent(asymmetry["mortar-p1", 2]), "asymmetry_p1_4": percent(asymmetry["mortar-p1", 4]),
        "error_disc": errors[False], "error_block": errors[True],
        "forces": percent(abs(forces[0] - forces[1]) / forces[0]),
    }  # fmt: skip


def figure_9() -> Numbers:
    """P0 against P1, disc as slave."""
    shapes = {algorithm: profile(disc(algorithm)) for algorithm in MORTARS}

    def fill(figure: Figure, axes: Any) -> None:
        _reference(axes[0][0])
        for algorithm, shape in shapes.items():
            draw(axes[0][0], shape, COLOURS[algorithm], SHORT[algorithm])
        _label(axes[0][0], "P0 and P1, disc is slave")

    picture("figure-09", 1, 1, fill, (5.4, 3.4))
    forces = [reaction(disc(algorithm)) for algorithm in MORTARS]
    return {
        "difference": percent(difference(*shapes.values())),
        "forces": percent(abs(forces[0] - forces[1]) / forces[0]),
        "error_p0": percent(pressure_error(shapes["mortar-p0"], deep_reference().profile)),
        "error_p1": percent(pressure_error(shapes["mortar-p1"], deep_reference().profile)),
    }


def figure_10() -> Numbers:
    """Friction 0.05 and 0.2, P0 and P1."""
    runs = {(mu, algorithm): disc(algorithm, mu=mu, steps=40) for mu in (0.05, 0.2) for algorithm in MORTARS}
    numbers: Numbers = {}

    def fill(figure: Figure, axes: Any) -> None:
        for row, column, y in ((0, "pressure", PRESSURE), (1, "shear", SHEAR)):
            for place, mu in enumerate((0.05, 0.2)):
                for algorithm in MORTARS:
                    shape = profile(runs[mu, algorithm], column)
                    draw(axes[row][place], shape, COLOURS[algorithm], SHORT[algorithm])
                if column == "shear":
                    bound = profile(runs[mu, "mortar-p1"])
                    for sign in (-1, 1):
                        axes[row][place].plot(
                            bound.x, sign * mu * bound.value, color=GREY, linewidth=0.8, linestyle="--", zorder=1
                        )
                _label(axes[row][place], f"mu = {mu}", y)

    picture("figure-10", 2, 2, fill, (9.0, 6.0))
    for mu, name in ((0.05, "005"), (0.2, "02")):
        for column in ("pressure", "shear"):
            shapes = [profile(runs[mu, algorithm], column) for algorithm in MORTARS]
            numbers[f"{column}_{name}"] = percent(difference(*shapes))
        forces = [reaction(runs[mu, algorithm]) for algorithm in MORTARS]
        numbers[f"forces_{name}"] = percent(abs(forces[0] - forces[1]) / forces[0])
        numbers[f"reaction_{name}"] = f"{forces[0]:.1f}"
    return numbers


def figure_11() -> Numbers:
    """Q1 against Q2 with as many nodes, without friction."""
    shapes = {"Q1": profile(disc("mortar-p0")), "Q2": profile(disc("mortar-p0", element="q2", level=1))}

    def fill(figure: Figure, axes: Any) -> None:
        _reference(axes[0][0])
        for (name, shape), colour in zip(shapes.items(), ("#0072B2", "#D55E00"), strict=True):
            draw(axes[0][0], shape, colour, name, marker="o" if name == "Q1" else "s")
        _label(axes[0][0], "Q1 and Q2 with the same nodes, P0")

    picture("figure-11", 1, 1, fill, (5.4, 3.4))
    forces = [reaction(disc("mortar-p0")), reaction(disc("mortar-p0", element="q2", level=1))]
    reference = deep_reference().profile
    return {
        "error_q1": percent(pressure_error(shapes["Q1"], reference)),
        "error_q2": percent(pressure_error(shapes["Q2"], reference)),
        "forces": percent(abs(forces[0] - forces[1]) / forces[0]),
        "reaction_q1": f"{forces[0]:.2f}", "reaction_q2": f"{forces[1]:.2f}",
        "saw": percent(saw_tooth(disc("mortar-p0", element="q2", level=1))),
        "saw_p1": percent(saw_tooth(disc("mortar-p1", element="q2", level=1))),
        "saw_raw": percent(saw_tooth(disc("mortar-p0", element="q2", level=1), "nodal_pressure")),
    }  # fmt: skip


def saw_tooth(results: Record, column: str = "pressure") -> float:
    """How far mid nodes stand off the parabola-free trend of corner nodes, over the largest pressure.

    Mean of p(mid) - (its two corners' cubic mean), alternating with the node kind, over the inner contact: a smooth
    pressure has none.
    """
    found = curve(results)
    p = np.abs(np.nan_to_num(np.asarray(getattr(found, column), float)))
    inner = np.flatnonzero(p > 0.25 * p.max())
    inner = inner[(inner >= 3) & (inner < len(p) - 3)]
    # fourth differences keep what alternates from node to node (16 times) and drop cubics
    ripple = (p[inner - 2] - 4 * p[inner - 1] + 6 * p[inner] - 4 * p[inner + 1] + p[inner + 2]) / 16.0
    return float(np.abs(np.mean(ripple * (-1.0) ** inner)) / p.max())


def figure_12() -> Numbers:
    """Q2 with friction 0.05: P0 and P1."""
    runs = {algorithm: disc(algorithm, element="q2", level=1, mu=0.05, steps=40) for algorithm in MORTARS}
    stuck = {
        (algorithm, multipliers): disc(
            {"use": algorithm, "multipliers": multipliers}, swap=True, element="q2", level=1, mu=0.2, steps=40
        )
        for algorithm in MORTARS for multipliers in ("nodes", "vertices")
    }  # fmt: skip
    nine = {
        algorithm: disc(algorithm, swap=True, element="q2-lagrange", level=1, mu=0.2, steps=40) for algorithm in MORTARS
    }

    def fill(figure: Figure, axes: Any) -> None:
        for place, (column, y) in enumerate((("pressure", PRESSURE), ("shear", SHEAR))):
            for algorithm in MORTARS:
                draw(axes[0][place], profile(runs[algorithm], column), COLOURS[algorithm], SHORT[algorithm])
            _label(axes[0][place], "Q2, mu = 0.05", y)
        last = axes[0][2]
        for multipliers, colour, label in (
            ("nodes", GREY, "at all nodes"), ("vertices", COLOURS["mortar-p1"], "at ends of edges")
        ):  # fmt: skip
            draw(last, profile(stuck["mortar-p1", multipliers], "shear"), colour, label)
        _label(last, "Q2, mu = 0.2, P1, block is slave", SHEAR)

    picture("figure-12", 1, 3, fill, (12.6, 3.4))
    numbers = {
        column: percent(difference(*(profile(run, column) for run in runs.values())))
        for column in ("pressure", "shear")
    }
    forces = [reaction(run) for run in runs.values()]
    q1 = reaction(disc("mortar-p0", mu=0.05, steps=40))
    numbers["saw"] = percent(max(saw_tooth(run) for run in runs.values()))
    for multipliers in ("nodes", "vertices"):
        found = {algorithm: stuck[algorithm, multipliers] for algorithm in MORTARS}
        numbers[f"stuck_{multipliers}"] = percent(max(saw_tooth(run, "shear") for run in found.values()))
        numbers[f"nine_{multipliers}"] = percent(
            max(difference(profile(run, "shear"), profile(nine[name], "shear")) for name, run in found.items())
        )
    return numbers | {
        "forces": percent(abs(forces[0] - forces[1]) / forces[0]),
        "q1": percent(abs(forces[0] - q1) / q1),
    }


def friction_paths() -> Numbers:
    """What the figures leave open: explicit against static with friction; how the shear turns round with depth."""
    numbers: Numbers = {"rows": []}
    worst = 0.0
    for algorithm in MORTARS:
        for swap in SLAVES:
            static = reaction(disc(algorithm, swap=swap, mu=0.2, steps=40))
            in_time = disc(algorithm, swap=swap, mu=0.2, explicit=True)
            explicit = reaction(in_time)
            worst = max(worst, abs(static - explicit) / static)
            numbers["rows"].append(
                f"| {SHORT[algorithm]} | {SLAVES[swap]} | {static:.2f} | {explicit:.2f} | "
                f"{percent(abs(static - explicit) / static)} |"
            )
    depths = (0.01, 0.04, 0.08, DEEP)
    runs = {depth: disc("mortar-p1", mu=0.2, level=4, depth=depth, steps=40) for depth in depths}

    def fill(figure: Figure, axes: Any) -> None:
        for place, depth in zip(axes.flat, depths, strict=True):
            shape, state = profile(runs[depth], "shear"), np.asarray(curve(runs[depth]).state)
            x = np.asarray(curve(runs[depth]).x)
            draw(place, shape, GREY, "shear", marker="")
            for kind, name in ((1, "sticks"), (2, "slips")):
                on = state == kind
                place.plot(
                    x[on], np.asarray(curve(runs[depth]).shear)[on], linestyle="", marker="o", markersize=3.0,
                    color=STATE_COLOURS[kind], label=name,
                )  # fmt: skip
            pressed = x[state > 0]
            _label(place, f"depth {depth} mm", SHEAR)
            place.set_xlim(1.15 * pressed.min(), 1.15 * pressed.max())

    picture("friction-with-depth", 2, 2, fill, (9.0, 6.0))
    numbers["worst"], numbers["steps_in_time"] = percent(worst), in_time.summary["steps"]
    for depth, name in ((0.01, "shallow"), (DEEP, "deep")):
        shape = profile(runs[depth], "shear")
        right = shape.x > 0.0
        mean = float(np.trapezoid(shape.value[right], shape.x[right]))
        numbers[f"half_{name}"] = f"{mean:+.2f}"
        state = np.asarray(curve(runs[depth]).state)
        numbers[f"stick_{name}"] = percent(np.count_nonzero(state == 1) / max(1, np.count_nonzero(state > 0)))
    halves = [
        float(np.trapezoid(np.maximum(shape.x, 0) * 0 + np.where(shape.x > 0, shape.value, 0), shape.x))
        for shape in (profile(disc("mortar-p1", mu=0.2, level=2, steps=steps), "shear") for steps in (10, 40, 80))
    ]
    numbers["steps"] = ", ".join(f"{value:+.2f}" for value in halves)
    return numbers


def disc_on_block() -> Numbers:
    """Errors and asymmetries at level 4, both depths; forces of P0, P1, Q1 and Q2 for three coefficients."""
    shallow = load_reference("disc-on-block-shallow-other-code").profile
    numbers: Numbers = {"rows": [], "forces": []}
    for depth, reference in ((0.01, shallow), (0.1581, deep_reference().profile)):
        for algorithm in MORTARS:
            shapes = [profile(disc(algorithm, swap=swap, level=4, depth=depth)) for swap in (False, True)]
            errors = [percent(pressure_error(shape, reference)) for shape in shapes]
            numbers["rows"].append(
                f"| {depth} | {SHORT[algorithm]} | {errors[0]} | {errors[1]} | {percent(difference(*shapes))} |"
            )
        runs = [disc("node-on-segment", swap=swap, depth=depth, explicit=True) for swap in (False, True)]
        cells = [
            percent(pressure_error(profile(run), reference)) if run.status == "finished" else run.status for run in runs
        ]
        apart = percent(difference(*map(profile, runs))) if all(run.status == "finished" for run in runs) else ""
        numbers["rows"].append(f"| {depth} | node on segment, level 2 | {cells[0]} | {cells[1]} | {apart} |")
    for mu in (0.0, 0.05, 0.2):
        steps = 40 if mu else 10
        base = reaction(disc("mortar-p0", mu=mu, steps=steps))
        linear = reaction(disc("mortar-p1", mu=mu, steps=steps))
        quadratic = reaction(disc("mortar-p0", mu=mu, steps=steps, element="q2", level=1))
        numbers["forces"].append(
            f"| {mu} | {base:.2f} | {percent(abs(linear / base - 1.0))} | {percent(abs(quadratic / base - 1.0))} |"
        )
    return numbers


def peers() -> Numbers:
    """Reactions and pressures of GetFEM on the same meshes, from its files, beside ours."""
    numbers: Numbers = {"rows": []}
    reference = deep_reference()
    for level in (2, 4):
        for swap, slave in ((False, "disc"), (True, "block")):
            path = ROOT / "benchmarks" / "references" / f"getfem-disc-on-block-{slave}-level-{level}-depth-0.1581.csv"
            force = float(path.read_text().split("reaction")[1].split()[0])
            shape = Profile.of_nodes(*np.loadtxt(path, delimiter=",", unpack=True))
            own = disc("mortar-p1", swap=swap, level=level)
            numbers["rows"].append(
                f"| {level} | {slave} | {force:.2f} | {reaction(own):.2f} | "
                f"{percent(abs(reaction(own) / force - 1.0))} | "
                f"{percent(pressure_error(shape, reference.profile))} | "
                f"{percent(pressure_error(profile(own), reference.profile))} |"
            )
    return numbers


FIGURES = {
    "f07": figure_7, "f08": figure_8, "f09": figure_9, "f10": figure_10, "f11": figure_11, "f12": figure_12,
    "paths": friction_paths, "disc": disc_on_block, "peers": peers,
}  # fmt: skip
