"""Cases beyond the paper's figures: errors in numbers, the bar of Taylor, upsetting, a disc that comes to roll."""

from __future__ import annotations

import shutil
import tomllib
from itertools import product
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np
from common import ROOT, SHORT, Numbers, area, cross, deep_reference, difference, disc, percent, profile, reaction, run
from scipy.optimize import brentq

import contactlab
from contactlab.api import Record
from contactlab.results.results import Results
from contactlab.studies.measures import pressure_error
from contactlab.studies.profile import Profile
from contactlab.studies.reference import load_reference

ALGORITHMS = ("node-on-segment", "mortar-p0", "mortar-p1")
MORTARS = ALGORITHMS[1:]

TAYLOR = """
format = 1
name = "taylor-bar"
[time]
end = 80e-6
[integrator]
use = "central-difference"
[materials.copper]
use = "linear-hardening"
young = 117000.0
poisson = 0.35
density = 8.93e-9
yield_stress = 400.0
hardening = 100.0
[bodies.bar]
element = "q1-fbar"
material = "copper"
mesh = { use = "rectangle", x = [0.0, 3.2], y = [0.0, 32.4], cells = [6, 60] }
velocity = [0.0, -227000.0]
[rigid.wall]
line = [[20.0, 0.0], [-5.0, 0.0]]
[[contacts]]
slave = "bar.bottom"
master = "wall"
algorithm = "mortar-p0"
[[supports]]
on = "bar.left"
ux = 0.0
[record]
frames = 2
"""

UPSETTING = """
format = 1
name = "upsetting"
[time]
end = "auto"
ramp = 1e-3
damping = 1e4
[integrator]
use = "central-difference"
[materials.aluminium]
use = "power-law"
young = 70000.0
poisson = 0.3
density = 2.7e-9
strength = 348.0
prestrain = 0.02
exponent = 0.03
# a quarter of 20 x 30
[bodies.block]
element = "q1-fbar"
material = "aluminium"
mesh = { use = "rectangle", x = [0.0, 10.0], y = [0.0, 15.0], cells = [6, 9] }
[rigid.ram]
line = [[-5.0, 15.0], [40.0, 15.0]]
uy = { ramp = "smooth", to = -7.5 }
[[contacts]]
slave = ["block.right", "block.top"]
master = "ram"
algorithm = "mortar-p0"
[[supports]]
on = "block.left"
ux = 0.0
[[supports]]
on = "block.bottom"
uy = 0.0
[record]
frames = 20
"""

ROLLING = """
format = 1
name = "spun-disc"
[time]
end = 0.3
[integrator]
use = "central-difference"
[materials.rubber]
use = "neo-hookean"
young = 0.3
poisson = 0.3
density = 7.85e-9
[bodies.disc]
element = "q1"
material = "rubber"
mesh = { use = "disc", radius = 10.0, cells = [16, 5] }
spin = -100.0
[rigid.plane]
line = [[200.0, -10.0], [-50.0, -10.0]]
segment = 1.0
[[contacts]]
slave = "disc.arc"
master = "plane"
algorithm = "mortar-p0"
friction = { use = "coulomb", mu = 0.2 }
[[effects]]
use = "gravity"
acceleration = [0.0, -9810.0]
[[effects]]
use = "vibration-damping"
rate = 400.0
[record]
frames = 150
"""


def load(text: str, changes: dict[str, Any]) -> Any:
    """A scene from its text."""
    folder = Path(mkdtemp())
    name = tomllib.loads(text)["name"]
    (folder / f"{name}.toml").write_text(text)
    scene = contactlab.load_scene(folder / f"{name}.toml").with_(changes)
    shutil.rmtree(folder)
    return scene


def taylor() -> Numbers:
    """Width and length of the bar by two elements that do not lock, and by one that does."""
    meshes = {"q1": (12, 120), "q1-fbar": (12, 120), "q2-lagrange": (6, 60)}
    shapes: dict[tuple[str, str], tuple[float, float]] = {}
    numbers: Numbers = {"rows": []}
    plans = [(element, "mortar-p0") for element in meshes] + [("q1-fbar", "mortar-p1"), ("q1-fbar", "node-on-segment")]
    for element, algorithm in plans:
        changes = {"bodies.bar.element": element, "bodies.bar.mesh.cells": list(meshes[element])}
        results = run(load(TAYLOR, changes | {"contacts.0.algorithm": algorithm}))
        own = np.unique(results.cells["bar"])
        x = (results.nodes + results.displacement)[own]
        top = np.isclose(results.nodes[own, 1], 32.4)
        shapes[element, algorithm] = width, length = x[:, 0].max(), x[top, 1].mean() - x[:, 1].min()
        cells = results.cells["bar"]
        volume = area(results.nodes + results.displacement, cells) / area(results.nodes, cells) - 1.0
        numbers["rows"].append(
            f"| {element} | {SHORT[algorithm]} | {results.status} | {width:.3f} | {length:.3f} | "
            f"{percent(abs(volume))} | {results.summary['balance']['ledger_error']:.0e} |"
        )
    one, two = shapes["q1-fbar", "mortar-p0"], shapes["q2-lagrange", "mortar-p0"]
    numbers["width"], numbers["length"] = (percent(abs(a - b) / b) for a, b in zip(one, two, strict=True))
    return numbers


FACES = {"contacts.0.slave": "block.top"}
# so slow that inertia and drag change the pressure by less than the aim
SLOW = {"time.ramp": 4e-3, "time.damping": 3e3}


def upsetting() -> Numbers:
    """Smooth dies against the rigid-plastic limit; rough ones to 60 %, where sides fold onto them."""
    numbers: Numbers = {"rows": []}
    forces: dict[str, list[float]] = {name: [] for name in ALGORITHMS}
    for mu, way in ((0.0, 7.5), (0.5, 9.0)):
        for algorithm in ALGORITHMS:
            changes: dict[str, Any] = {"contacts.0.algorithm": algorithm, "rigid.ram.uy.to": -way}
            changes |= {"contacts.0.friction": {"use": "coulomb", "mu": mu}} if mu else SLOW
            for slaves, more in (("faces and sides", {}), ("faces", FACES)):
                results = run(load(UPSETTING, changes | more))
                numbers["rows"].append(f"| {mu} | {SHORT[algorithm]} | {slaves} | {_upset(results, mu, 15.0 - way)} |")
                if not mu:
                    break
                if not more:
                    forces[algorithm].append(reaction(results, "ram"))
    static = {"integrator": {"use": "newton", "steps": 60}, "contacts.0.friction": {"use": "coulomb", "mu": 0.5}}
    for algorithm in ALGORITHMS:
        results = run(load(UPSETTING, static | {"contacts.0.algorithm": algorithm, "rigid.ram.uy.to": -9.0}))
        numbers["rows"].append(f"| 0.5 | {SHORT[algorithm]} | faces and sides, static | {_upset(results, 0.5, 6.0)} |")
        forces[algorithm].append(reaction(results, "ram"))
    numbers["static"] = percent(max(abs(static / explicit - 1.0) for explicit, static in forces.values()))
    return numbers


def _upset(results: Record, mu: float, height: float) -> str:
    if results.status != "finished":
        share = results.history["time"][-1] / results.summary["resolved"]["ramp"]
        return f"{results.status} at {percent(1.0 - max(0.0, 1.0 - share) ** 2)} of the way | | | "
    x = results.nodes + results.displacement
    own = np.isin(np.arange(len(x)), np.unique(results.cells["block"]))
    side = own & np.isclose(results.nodes[:, 0], 10.0) & (results.nodes[:, 1] < 15.0 - 1e-9)
    folded = np.count_nonzero(side & (x[:, 1] > height - 0.05))
    deepest = max(float(x[own, 1].max()) - height, 0.0) / (10.0 / 6.0)
    width = area(x, results.cells["block"]) / height  # the mean one
    force = abs(results.summary["reactions"]["ram"][1])
    size = f"{force / width:.2f} MPa" if not mu else f"{force:.0f} N/mm"
    return f"finished | {size} | {folded} | {percent(deepest)}"


# contact is half as wide, and so are segments
STIFFER = {"bodies.disc.mesh.cells": [32, 10], "rigid.plane.segment": 0.5, "materials.rubber.young": 1.2}


def rolling() -> Numbers:
    """Spun and thrown: time of slipping, way, and final speed against a rigid disc."""
    slips, speed = 100.0 * 10.0 / (3 * 0.2 * 9810.0), 1000.0 / 3.0
    numbers: Numbers = {"rows": [], "slips": f"{slips:.5f}", "speed": f"{speed:.2f}"}
    for kind, segments, algorithm in product(("spun", "thrown"), (64, 128), ALGORITHMS):
        changes: dict[str, Any] = {"contacts.0.algorithm": algorithm} | (STIFFER if segments == 128 else {})
        if kind == "thrown":
            # so fast that it slips as long: v0/(3 mu g), and rolls at 2 v0/3
            changes |= {"bodies.disc.spin": 0.0, "bodies.disc.velocity": [1000.0, 0.0]}
        wanted = speed if kind == "spun" else 2000.0 / 3.0
        label = f"{kind} | {segments}"
        numbers["rows"].append(_rolled(load(ROLLING, changes), label, algorithm, slips, wanted))
    return numbers


def motion(results: Results) -> dict[str, Any]:
    """Time, speed and way along x of the disc's mass at every frame."""
    cells = results.cells["disc"]
    weights = np.zeros(len(results.nodes))
    a, b, c, d = (results.nodes[cells[:, i]] for i in range(4))
    np.add.at(weights, cells, 0.125 * cross(c - a, d - b)[:, None])
    weights /= weights.sum()
    found = [(f.time, weights @ f.velocity[:, 0], weights @ f.displacement[:, 0]) for f in results.frames]
    return dict(zip(("time", "speed", "way"), np.array(found).T, strict=True))


def _rolled(scene: Any, kind: str, algorithm: str, slips: float, wanted: float) -> str:
    results = run(scene, motion)
    if results.status != "finished":
        return f"| {kind} | {SHORT[algorithm]} | {results.status}: {results.reason.split(';')[0]} | | |"
    times, speeds, ways = (results.watched["motion"][name] for name in ("time", "speed", "way"))
    final = float(speeds[times > 1.3 * slips].mean())
    # where the straight line of slipping meets the final speed
    middle = (times > 0.2 * slips) & (times < 0.8 * slips)
    slope, start = np.polyfit(times[middle], speeds[middle], 1)
    until = float(brentq(lambda t: start + slope * t - final, 0.0, 1.0))
    return (
        f"| {kind} | {SHORT[algorithm]} | {until:.4f} ({percent(until / slips - 1.0)}) | "
        f"{final:.1f} ({percent(final / wanted - 1.0)}) | {ways[-1]:.2f} |"
    )


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


FIGURES = {"peers": peers, "disc": disc_on_block, "taylor": taylor, "upsetting": upsetting, "rolling": rolling}
