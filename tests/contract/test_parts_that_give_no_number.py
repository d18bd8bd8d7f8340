"""What a part gives that is no number is found, and told with the part, its method and the step."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from typing import Any

import pytest

from contactlab.errors import PartError
from contactlab.parts.registry import Registry
from contactlab.run.simulation import simulate
from contactlab.scene.scene import Scene, load_scene

KICKED = {"contacts.0.algorithm": "node-on-segment", "integrator.forces": "frozen"}
"""Of corners that meet head on: their contact makes energy."""

PARTS = '''
"""Parts that are right for a while; STEP of them is the first that goes wrong."""

from dataclasses import dataclass, replace

import numpy as np

from contactlab.api import GapAlgorithm, GapConditions
from contactlab.api.plugin import Part, hookimpl
from contactlab_dynamics.forward_increment import ForwardIncrement
from contactlab_effects.gravity import Gravity
from contactlab_mortar.mortar import MortarP0
from contactlab_quads.q1 import Q1
from contactlab_solids.neo_hookean import NeoHookean

calls, mortar = {}, MortarP0()  # whose kernels are there: those of a class derived from its own would be compiled


def late(what, step):
    """Whether a call is the one that makes the given step, or a later one."""
    calls[what] = calls.get(what, 0) + 1
    return calls[what] >= step


@dataclass(frozen=True)
class BadLaw(NeoHookean):
    after: int = 0

    def stress(self, gradient, history, dt, stress, new_history):
        super().stress(gradient, history, dt, stress, new_history)
        if late("law", self.after):
            stress[1, 0] = np.nan


@dataclass(frozen=True)
class BadMortar(MortarP0):
    what: str = ""
    after: int = 0

    def pieces(self, view, out):
        count = mortar.pieces(view, out)
        if late("mortar", self.after) and count:
            if self.what == "zero T":
                out.T[:count] = 0.0
            elif self.what == "none":
                return None
            elif self.what == "normal":
                out.normal[out.multiplier[0]] = np.nan
            else:
                getattr(out, self.what)[count // 2] = np.nan
        return count

    def derivatives(self, *arguments):
        return mortar.derivatives(*arguments)

    def gradients(self, *arguments):
        return mortar.gradients(*arguments)


@dataclass(frozen=True)
class Points(GapAlgorithm):
    """Slave nodes against a flat master."""

    what: str = "nan"
    after: int = 0
    passes_patch_test = False

    def conditions(self, view, *, tangent):
        if late("points", self.after) and self.what == "none":
            return None
        slave, master, at = view.slave, view.master, view.at
        m = len(slave.nodes)
        along = at.master[-1] - at.master[0]
        normal = np.array([-along[1], along[0]]) / np.hypot(*along)
        normal = normal if normal[1] > 0 else -normal
        share = (at.slave - at.master[0]) @ along / (along @ along)
        foot = np.clip(share * (len(at.master) - 1), 0, len(at.master) - 1 - 1e-9).astype(int)
        local = share * (len(at.master) - 1) - foot
        node = np.stack([slave.nodes, master.nodes[foot], master.nodes[foot + 1]], axis=1)
        weight = np.stack([np.ones(m), local - 1.0, -local], axis=1)[:, :, None] * normal
        gap = (at.slave - at.master[0]) @ normal
        if late("points nan", self.after) and self.what == "nan":
            gap[m // 2] = np.nan
        return GapConditions(
            np.arange(0, 3 * m + 1, 3, dtype=np.int32), node.ravel().astype(np.int32), weight.reshape(-1, 2),
            np.zeros((0, 2)), gap, np.full(m, 0.1), np.arange(m, dtype=np.int32),
        )


@dataclass(frozen=True)
class BadSolve(ForwardIncrement):
    after: int = 0

    def solve_factored(self, rows, compliance, multipliers, force):
        done = super().solve_factored(rows, compliance, multipliers, force)
        if late("solve", self.after):
            force[rows.node[0]] = np.nan
        return done


@dataclass(frozen=True)
class BadGravity(Gravity):
    after: float = 0.0

    def bind(self, view):
        pull = super().bind(view)

        def bad(time, out):
            pull(time, out)
            if time > self.after:
                out[3] = np.nan

        return bad


@hookimpl
def contactlab_parts():
    return [
        Part("material", "bad-law", "numberless_parts:BadLaw", "for tests"),
        Part("contact", "bad-mortar", "numberless_parts:BadMortar", "for tests"),
        Part("contact", "points", "numberless_parts:Points", "for tests"),
        Part("enforcement", "bad-solve", "numberless_parts:BadSolve", "for tests"),
        Part("effect", "bad-gravity", "numberless_parts:BadGravity", "for tests"),
    ]
'''


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Registry]:
    file = tmp_path_factory.mktemp("numberless") / "numberless_parts.py"
    file.write_text(PARTS)
    yield Registry(files=[file])
    sys.modules.pop("numberless_parts", None)


ELASTIC = {"young": 1000.0, "poisson": 0.25, "density": 1e-6}
SMALL = {
    "bodies.disc.mesh.cells": [8, 2],
    "bodies.block.mesh.cells": [12, 2],
    "time.end": 3e-6,
    "record.frames": 2,
    "record.recorders": [],
}


def blocks(**more: Any) -> dict[str, Any]:
    """A block pressed on another."""

    def block(x: tuple[float, float], y: tuple[float, float], cells: tuple[int, int]) -> dict[str, Any]:
        mesh = {"use": "rectangle", "x": list(x), "y": list(y), "cells": list(cells)}
        return {"element": "q1", "material": "m", "mesh": mesh}

    return {
        "name": "numberless",
        "time": {"end": 5e-4},
        "integrator": "central-difference",
        "materials": {"m": {"use": "neo-hookean", **ELASTIC}},
        "bodies": {"upper": block((0.5, 1.5), (0.0, 1.0), (4, 3)), "lower": block((0.0, 2.0), (-1.0, 0.0), (5, 3))},
        "contacts": [{"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p0"}],
        "supports": [
            {"on": "lower.bottom", "ux": 0.0, "uy": 0.0},
            {"on": "upper.top", "ux": 0.0, "uy": {"ramp": "parabola", "to": -0.05}},
        ],
        "record": {"frames": 2, "recorders": []},
        **more,
    }


def reason_of(scene: Scene, registry: Registry) -> str:
    calls = sys.modules["numberless_parts"].calls if "numberless_parts" in sys.modules else {}
    calls.clear()
    results = simulate(scene, registry=registry)
    assert results.status == "failed", (results.status, results.reason)
    return results.reason


def mortar(what: str, after: int = 60) -> dict[str, Any]:
    contact = {"slave": "upper.bottom", "master": "lower.top"}
    return blocks(contacts=[contact | {"algorithm": {"use": "bad-mortar", "what": what, "after": after}}])


LAW = {"m": {"use": "bad-law", **ELASTIC, "after": 62}}  # one call of each body builds the model
EXPLICIT = {
    "stress": (blocks(materials=LAW), r"step \d+: BadLaw: stress gave a stress that is not finite in cell 0 of body"),
    "zero T": (mortar("zero T"), r"step \d+: BadMortar: pieces gave \d+ pieces in contacts.0 whose T sums up to 0"),
    "T": (mortar("T"), r"step \d+: BadMortar: pieces gave an entry of T that is not finite in contacts.0"),
    "D": (mortar("D"), r"step \d+: BadMortar: pieces gave an entry of D that is not finite"),
    "M": (mortar("M"), r"step \d+: BadMortar: pieces gave an entry of M that is not finite"),
    "normal": (mortar("normal"), r"step \d+: BadMortar: pieces gave a normal that is not finite"),
    "none": (mortar("none"), r"step \d+: BadMortar: pieces gave None, needed: how many"),
    "gap": (
        blocks(
            contacts=[
                {"slave": "upper.bottom", "master": "lower.top", "algorithm": {"use": "points", "after": 60}},
            ]
        ),
        r"step \d+: Points: a gap condition is not as allowed: gap, .* finite numbers",
    ),
    "no conditions": (
        blocks(
            contacts=[
                {"slave": "upper.bottom", "master": "lower.top",
                 "algorithm": {"use": "points", "what": "none", "after": 60}}
            ]
        ),
        r"step \d+: Points: conditions gave NoneType, needed: GapConditions",
    ),
    "effect": (
        blocks(effects=[{"use": "bad-gravity", "acceleration": [0.0, -1.0], "after": 2.5e-4}]),
        r"step \d+: effects.0 gave a force that is not finite",
    ),
    "enforcement": (
        blocks(
            contacts=[
                {"slave": "upper.bottom", "master": "lower.top", "algorithm": "mortar-p0",
                 "enforcement": {"use": "bad-solve", "forces": "frozen", "after": 60}}
            ]
        ),
        r"step \d+: BadSolve: solve gave a force that is not finite",
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", EXPLICIT)
def test_explicit_runs_name_part_method_and_step(fault: str, parts: Registry) -> None:
    data, words = EXPLICIT[fault]
    reason = reason_of(Scene.from_data(data, registry=parts), parts)
    assert re.match(words, reason), reason


IMPLICIT = {"integrator": {"use": "newton", "steps": 6}, "time": {"end": 1.0}}


@pytest.mark.parametrize(
    ("fault", "data"),
    [
        ("stress", blocks(**IMPLICIT, materials={"m": {"use": "bad-law", **ELASTIC, "after": 20}})),
        ("zero T", mortar("zero T", 12) | IMPLICIT),
        ("T", mortar("T", 12) | IMPLICIT),
        ("M", mortar("M", 12) | IMPLICIT),
    ],
)
def test_load_steps_name_them_too(fault: str, data: dict[str, Any], parts: Registry) -> None:
    reason = reason_of(Scene.from_data(data, registry=parts), parts)
    assert re.match(EXPLICIT[fault][1], reason), reason


def test_an_effect_that_is_wrong_wherever_the_load_path_looks_is_told_before_the_run(parts: Registry) -> None:
    data = blocks(**IMPLICIT, effects=[{"use": "bad-gravity", "acceleration": [0.0, -1.0], "after": 0.4}])
    with pytest.raises(PartError, match=r"effects\.0 gave a force that is not finite"):
        simulate(Scene.from_data(data, registry=parts), registry=parts)


def test_the_step_is_the_first_one_at_fault(parts: Registry) -> None:
    """A law that goes wrong by time gives the number that can be counted: the effect's step 1 + time / dt."""
    data = blocks(effects=[{"use": "bad-gravity", "acceleration": [0.0, -1.0], "after": 1e-4}])
    data["time"] = {"end": 5e-4, "step": 1e-6}
    reason = reason_of(Scene.from_data(data, registry=parts), parts)
    assert reason.startswith("step 102: effects.0"), reason  # the first that begins after 1e-4


def test_a_run_that_diverges_by_itself_blames_nobody(parts: Registry) -> None:
    results = simulate(load_scene("vertex-to-vertex").with_(KICKED))
    assert results.status == "diverged"
    assert "not finite" not in results.reason


def test_a_repeated_state_is_the_same_to_the_last_bit() -> None:
    """What is kept brings the very steps back: 40 steps twice from one state."""
    from contactlab.model.build import build
    from contactlab.parts.registry import default_registry
    from contactlab.run.kept_states import KeptState

    model = build(load_scene("disc-on-block").with_(SMALL), default_registry())
    advance = model.bound_integrator().step
    kept, dt = KeptState(), 0.9 * model.stable_step()

    def forty() -> bytes:
        for _ in range(40):
            advance(dt)
        return model.state["velocity"].tobytes()

    forty()
    kept.take(model, dt)
    first = forty()
    kept.bring_back(model)
    assert forty() == first
