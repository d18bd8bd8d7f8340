"""Every effect is absent from memory, imports, compilation and the step loop unless the scene declares it.

Each scene is explained, then run for some steps in a process of its own where every call of a part is
counted; what was explained must be what happened.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from tiers import some

from contactlab.explanation.explain import Explanation, explain
from contactlab.explanation.trial_run import run_trial
from contactlab.parts.loading import RESTRICT
from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene, bundled_scenes, load_scene

PROBE = Path(__file__).with_name("composition_probe.py")
CONTACT = r"contactlab\.(model\.contact|results\.contact_report)"
CONTACT_KERNELS = r"contactlab\.kernels\.contact"


@dataclass(frozen=True)
class Traces:
    """What an effect leaves behind where it is declared, and nowhere else: patterns of names."""

    modules: str = ""
    kernels: str = ""
    arrays: str = ""
    calls: str = ""

    def patterns(self) -> dict[str, str]:
        return {kind: pattern for kind, pattern in asdict(self).items() if pattern}


EFFECTS: dict[str, Traces] = {
    "contact": Traces(f"{CONTACT}|{CONTACT_KERNELS}", CONTACT_KERNELS, r"contact\.|state\.(mult|contact_f)", "contact"),
    "friction": Traces(
        r"contactlab_friction\.(?!plugin)", r".*\.(write_slips|tangential_work)", r"contact\.rows\.(slip|bound|tang)",
        "contact normals",
    ),
    "rigid surfaces": Traces(modules=r"contactlab\.model\.loading\.rigid"),
    "several bodies": Traces(arrays=r"(bodies|forces)\.1\."),
    "finite strain": Traces(
        r"contactlab_solids\.(neo_hookean|hypoelastic|j2)",
        r"contactlab_solids\.(kernels\.(?!linear_elastic)|hypoelastic_kernels|j2_kernels)",
    ),
    "quadratic shape functions": Traces(modules=r"contactlab_quads\.(q2|quadratic)"),
    "inertia": Traces(kernels=r"contactlab\.model\.motion", arrays=r"mass|state\.velocity"),
    "material history": Traces(arrays=r"state\.history"),
    "plasticity": Traces(modules=r"contactlab_solids\.j2"),
    "hourglass control": Traces(kernels=r".*\.stabilise", calls="element stabilisation"),
    "loads": Traces(modules=r"contactlab\.(model\.loading\.loads|kernels\.edge_loads)", kernels=r".*\.edge_forces"),
    "gravity": Traces(modules=r"contactlab_effects\.gravity"),
    "recording": Traces(
        r"h5py|contactlab\.results\.(vtkhdf|steps)", r".*step_scalars", r"run\.journal\.(sampler|recordings)"
    ),
}  # fmt: skip

# one body at rest, nothing declared that can be left out
BARE = {
    "time.end": 1e-5, "contacts": [], "supports": [], "record.recorders": [],
    "materials.steel.use": "linear-elastic", "materials.soft.use": "linear-elastic",
}  # fmt: skip
LOADED = {
    "record.recorders": ["vtkhdf"],
    "contacts.0.friction": {"use": "coulomb", "mu": 0.2},
    "effects": [{"use": "gravity", "acceleration": [0.0, -9810.0]}],
    "loads": [{"on": "block.left", "pressure": 1.0}],
    "bodies.disc.element": "q1-reduced",
    "materials.soft": {
        "use": "power-law", "young": 7000.0, "poisson": 0.3, "density": 2.7e-9, "strength": 300.0, "prestrain": 0.02,
        "exponent": 0.1,
    },
}  # fmt: skip
RATE = {"materials.soft.use": "hypoelastic", "bodies.block.element": "q2", "contacts.0.algorithm": "node-on-segment"}
STATIC = {"integrator": "newton", "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2]}


def composed_alike(scene: Scene) -> str:
    """What a scene is made of: scenes that differ in shapes and numbers alone have the same."""
    data = scene.data
    tables = [name for name in ("rigid", "supports", "loads") if data.get(name)]
    parts = [body["element"]["use"] for body in data["bodies"].values()]
    parts += [part["use"] for part in (*data.get("effects", ()), *data["materials"].values())]
    contacts = sorted({(str(c["algorithm"]), "friction" in c) for c in data["contacts"]})
    return str((sorted(set(parts)), contacts, tables))


def differently_composed() -> list[str]:
    """Bundled scenes, one of each composition."""
    return list({composed_alike(load_scene(name)): name for name in reversed(bundled_scenes())}.values())


CASES: dict[str, tuple[str, dict[str, Any]]] = {name: (name, {}) for name in differently_composed()} | {
    "bare": ("disc-on-block", BARE),
    "loaded": ("disc-on-block", LOADED),
    "rate and quadratic": ("disc-on-block", RATE),
    "static": ("disc-on-block", STATIC),
}
BRANCHES = {
    "contactlab.kernels.contact.corners.take_row",
    "contactlab.kernels.contact.corners.touches",
    "contactlab.kernels.contact.weights.own_nodes",
    "contactlab.kernels.contact.weights.solved",
    "contactlab.kernels.checks.deepest",
    "contactlab.kernels.contact.passing.passages",
}
"""Kernels that depend on how surfaces lie, or look at them now and then: a run may come to need them later than in
its first steps."""


def scene_of(name: str) -> Scene:
    """The scene of a case, with no frame in the middle of the steps that are watched."""
    scene, changes = CASES[name]
    found = load_scene(scene).with_({**changes, "record.frames": 1})
    # the probe stops a static run at its second step
    return found.with_({"integrator.steps": 4}) if found.integrator["use"] == "newton" else found


@cache
def happened(name: str, arrays: bool = True, plugins: str = "") -> dict[str, Any]:
    """What a run of some steps of a case did in a process of its own, with all plugins or some."""
    scene = scene_of(name)
    steps = 2 if scene.integrator["use"] == "newton" else 60
    wish = json.dumps({"scene": scene.data, "steps": steps, "arrays": arrays})
    command, environment = [sys.executable, str(PROBE)], {**os.environ, RESTRICT: plugins}
    done = subprocess.run(command, input=wish, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert found["status"] in ("interrupted", "finished"), found["reason"]
    return dict(found)


ALWAYS = {"loaded"}


@pytest.mark.full
@pytest.mark.parametrize("name", some(CASES, ALWAYS))
def test_what_happens_is_what_was_explained(name: str) -> None:
    scene = scene_of(name)
    said, run = explain(scene, default_registry(), run_trial(scene)), happened(name)
    check_calls(said, run)
    check_kernels(said, run)
    check_modules(said, run)
    check_arrays(said, run)
    for effect in EFFECTS:
        check_effect(effect, said, run, untold(scene))


def untold(scene: Scene) -> set[tuple[str, str]]:
    """Traces that effects do not leave in this scene."""
    chosen = scene.integrator
    consistent = chosen["use"] == "central-difference" and chosen.get("forces") != "frozen"
    return (DEAD_LOADS if dead(scene) else set()) | (CONSISTENT if consistent else set())


def check_calls(said: Explanation, run: dict[str, Any]) -> None:
    """Each call of a part as often in each step (or iteration) as explained, and no other call."""
    counted = {call: count for call, count in run["calls"].items() if count}
    for call in (call for call in said.calls if call.per == "step"):
        count = call.times * run["steps"]
        # a solve that gives up goes to the sweeps, and one that moves nodes far is made again with all conditions
        most = 3 * count if call.call == "contact enforcement" else count
        assert count <= counted.pop(call.call) <= most, call.call
    iterated = {call.call: call.times for call in said.calls if call.per == "iteration"}
    assert counted.keys() == iterated.keys()
    # bodies do all of their work equally often
    assert len({counted[call] / times for call, times in iterated.items() if not call.startswith("contact")}) <= 1


def check_kernels(said: Explanation, run: dict[str, Any]) -> None:
    """The same kernels, and each as often in a step as explained."""
    expected = {kernel.kernel: kernel.per_step for kernel in said.kernels}
    assert set(run["kernels"]) ^ set(expected) <= BRANCHES
    # near lists and solves made again come now and then, and not in both stretches of steps alike
    steady = {name for name, count in run["per_step"].items() if count.is_integer() and expected[name].is_integer()}
    assert {name: run["per_step"][name] for name in steady} == {name: expected[name] for name in steady}
    assert len(steady) >= 0.75 * len(run["per_step"])


def check_modules(said: Explanation, run: dict[str, Any]) -> None:
    """The same modules of the project and of plugins, the same libraries."""
    listed = {row.package for row in said.modules}
    listed |= {f"{row.package}.{module}" for row in said.modules for module in row.modules.split(", ") if module}
    # what a trial run needs to count arrays
    assert set(run["modules"]) | {"contactlab.model.held_arrays", "scipy"} == listed | {"scipy"}


def check_arrays(said: Explanation, run: dict[str, Any]) -> None:
    """NumPy's own count of what is allocated in the middle of a run against the list."""
    # not listed: tables of classes that all runs share; stored curves differ by a frame, about 5 kB each; and rows of
    # consistent forces find their room when surfaces meet, after the steps of a trial: some 20 kB for 20 multipliers
    assert abs(run["bytes"] - said.scene.array_bytes) <= 0.02 * said.scene.array_bytes + 30_000


def dead(scene: Scene) -> bool:
    """Whether no load of the scene follows its edges."""
    return all(not {"pressure", "shear"} & load.keys() for load in scene.data.get("loads", ()))


def check_effect(effect: str, said: Explanation, run: dict[str, Any], absent: set[tuple[str, str]]) -> None:
    """An effect leaves its traces where it is declared, and nowhere else."""
    declared = {row.effect: row.called_for for row in said.effects}[effect]
    implicit = any(call.per == "iteration" for call in said.calls)
    names = {
        "modules": run["modules"],
        "kernels": run["kernels"],
        "arrays": [array.name for array in said.arrays],
        "calls": [call for call, count in run["calls"].items() if count],
    }
    for kind, pattern in EFFECTS[effect].patterns().items():
        found = [name for name in names[kind] if re.match(pattern, name)]
        if not declared:
            assert not found, f"{effect} is not declared, and yet there are {kind} of it"
        elif (effect, kind) not in absent and not (implicit and (effect, kind) in EXPLICIT_ONLY):
            assert found, f"{effect} is declared, and there are no {kind} of it: the pattern tells nothing"


EXPLICIT_ONLY = {("contact", "arrays"), ("friction", "arrays"), ("recording", "kernels")}
"""Traces that implicit runs have under other names."""


CONSISTENT = {("friction", "calls")}
"""Slips of consistent forces need no normals of the start of the step."""


DEAD_LOADS = {("loads", "kernels")}
"""Forces of dead loads are computed once."""


def test_every_effect_is_seen_declared_and_not() -> None:
    """Or the test above says nothing about it. The last cases, which are made up for it, show nearly all."""
    missing = {(effect, declared) for effect in EFFECTS for declared in (True, False)}
    for name in reversed(CASES):
        if missing:
            missing -= {(row.effect, row.called_for) for row in explain(scene_of(name), default_registry()).effects}
    assert not missing


@pytest.mark.full
@pytest.mark.parametrize("name", some(["disc-on-block", "loaded"], ["loaded"]))
def test_more_plugins_change_nothing(name: str) -> None:
    """The same numbers to the last bit, the same calls and kernels, with the needed plugins alone and with all."""
    scene = scene_of(name)
    parts = {part.package.partition(" ")[0] for part in explain(scene, default_registry()).parts}
    needed = ",".join(sorted(parts - {"contactlab"}))
    everything, alone = happened(name), happened(name, arrays=False, plugins=needed)
    for key in ("digest", "calls", "kernels", "per_step", "steps"):
        assert everything[key] == alone[key], key
    spared = set(everything["modules"]) - set(alone["modules"])
    assert spared, "no plugin was left out: the test tells nothing"
    assert not set(alone["modules"]) - set(everything["modules"])


LEFT_OUT = (
    "midplane", "half_pass", "points_pair", "nitsche", "traction", "barrier", "ipctk", "smooth", "pressure_",
    "contactlab_friction.pressure", "potential_pair",
)  # fmt: skip
"""In names of modules of methods that a scene does not use."""


def test_a_scene_imports_nothing_of_methods_that_it_does_not_use() -> None:
    """Neither methods nor their systems, pairs and kernels, and so it allocates and calls nothing of them."""
    program = f"""
import sys
from contactlab import load_scene, simulate
scene = load_scene("disc-on-block").with_({{"supports.1.uy.to": -0.001, "record.recorders": []}})
simulate(scene.with_({{"integrator": {{"use": "newton", "steps": 1}}, "contacts.0.algorithm": "gauss-point"}}))
simulate(scene.with_({{"time.end": 1e-7, "contacts.0.algorithm": "mortar-dual"}}))
print([name for name in sys.modules if any(word in name for word in {LEFT_OUT})])
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
