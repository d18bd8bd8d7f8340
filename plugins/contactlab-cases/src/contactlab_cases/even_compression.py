"""The even pressure between two layers, exact: a reference of comparisons, and what cases of such layers measure by."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from contactlab.api import ReferenceSolution, Scalar, Solution

DAMPING = ("contact", "damping", "vibration-damping")
"""Effects that leave the final state as it is."""


@dataclass(frozen=True)
class EvenCompression(ReferenceSolution):
    """Two rectangles of one width, one upon the other, pressed together evenly.

    Each is linear elastic and strained along y alone: with Poisson's ratio 0, or held sideways. The top of the upper
    one is displaced or loaded. With the moduli M = E (1 - nu)/((1 + nu)(1 - 2 nu)) and the heights H, the approach w of
    both far sides, and what they overlapped by at the start, give p = w/(H1/M1 + H2/M2).
    """

    title: ClassVar[str] = "two layers pressed evenly"
    origin: ClassVar[str] = "equilibrium and Hooke's law in one dimension, p = w/(H1/M1 + H2/M2), or p of the load"

    def mismatch(self, scene: Mapping[str, Any]) -> str:
        """The first thing that gives the scene another solution. Never raises."""
        try:
            return next(_mismatches(scene), "")
        except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
            return f"it is not a scene of two layers: {type(error).__name__} {error}"

    def solution(self, scene: Mapping[str, Any]) -> Solution:
        """Return a uniform pressure over the common width."""
        layers = _Layers(scene)
        left, right = layers.mesh("upper")["x"]
        pressure = layers.pressure()
        force = Scalar(pressure * (right - left), 0.0, "vertical reaction")
        x = np.array([left, right], float) + layers.shift("upper")[0]
        return Solution(x, np.full(2, pressure), 0.0, "exact", scalars={"reaction": force})


def _mismatches(scene: Mapping[str, Any]) -> Iterator[str]:
    """Yield reasons why a scene does not match two layers."""
    if len(scene["contacts"]) != 1 or len(scene["bodies"]) != 2 or scene.get("rigid"):
        yield "the scene does not have two bodies and one contact"
    layers = _Layers(scene)
    for role, name in layers.names.items():
        yield from _mismatches_of_a_body(layers, role, name)
    upper, lower = ((np.array(layers.mesh(role)["x"]) + layers.shift(role)[0]) for role in ("upper", "lower"))
    if not np.allclose(upper, lower, rtol=0.0, atol=1e-12 * float(np.ptp(upper))):
        yield "the bodies are not equally wide"
    start = scene["contacts"][0].get("start", {})
    if start.get("gap", 0.0) or (layers.overlap() > 0.0 and start.get("overlap") != "ramp"):
        yield "the mesh is adjusted at the start"
    for effect in scene.get("effects", ()):
        if effect["use"] not in DAMPING:
            yield f"the effect {effect['use']} acts"
    if layers.pressure() <= 0.0:
        yield "nothing is pressed"


def _mismatches_of_a_body(layers: _Layers, role: str, name: str) -> Iterator[str]:
    """Yield reasons why a body does not have a uniform strain along y."""
    if layers.mesh(role)["use"] != "rectangle" or len(layers.mesh(role)["x"]) != 2 or len(layers.mesh(role)["y"]) != 2:
        yield f"body {name} is not a rectangle"
    if layers.bodies[name].get("rotate", 0.0):
        yield f"body {name} is rotated"
    if layers.law(role)["use"] != "linear-elastic":
        yield f"the law of body {name} is not linear-elastic"
    if layers.law(role)["poisson"] and not layers.held_sideways(name):
        yield f"body {name} bulges: its Poisson's ratio is not 0, and its sides are not held"
    for support in layers.scene["supports"]:
        body, _, side = support["on"].partition(".")
        if body != name:
            continue
        if _value(support.get("ux")):
            yield f"support on {support['on']} moves sideways"
        if "uy" in support and side != ("top" if role == "upper" else "bottom"):
            yield f"support on {support['on']} holds the body along y"
    for load in layers.scene.get("loads", ()):
        if load["on"] != f"{layers.names['upper']}.top" or not set(load) <= {"on", "pressure", "follower"}:
            yield f"the load on {load['on']} is not an even pressure on the upper side"


class _Layers:
    """The upper and the lower body of a scene, and what presses them."""

    def __init__(self, scene: Mapping[str, Any]) -> None:
        self.scene, self.bodies = scene, scene["bodies"]
        sides = (scene["contacts"][0][key].partition(".") for key in ("slave", "master"))
        found = {{"bottom": "upper", "top": "lower"}[side]: body for body, _, side in sides}
        self.names = {role: found[role] for role in ("upper", "lower")}

    def mesh(self, role: str) -> Mapping[str, Any]:
        found: Mapping[str, Any] = self.bodies[self.names[role]]["mesh"]
        return found

    def law(self, role: str) -> Mapping[str, Any]:
        found: Mapping[str, Any] = self.scene["materials"][self.bodies[self.names[role]]["material"]]
        return found

    def shift(self, role: str) -> tuple[float, float]:
        x, y = self.bodies[self.names[role]].get("shift", (0.0, 0.0))
        return float(x), float(y)

    def held_sideways(self, name: str) -> bool:
        held = {support["on"] for support in self.scene["supports"] if "ux" in support}
        return name in held or {f"{name}.left", f"{name}.right"} <= held

    def overlap(self) -> float:
        """Height of the lower body's top above the upper body's bottom at the start [mm]."""
        return float(
            self.mesh("lower")["y"][1] + self.shift("lower")[1] - self.mesh("upper")["y"][0] - self.shift("upper")[1]
        )

    def compliance(self, role: str) -> float:
        """H/M [mm/MPa]."""
        bottom, top = self.mesh(role)["y"]
        young, poisson = (float(self.law(role)[key]) for key in ("young", "poisson"))
        return float(top - bottom) * (1.0 + poisson) * (1.0 - 2.0 * poisson) / (1.0 - poisson) / young

    def pressure(self) -> float:
        """Pressure of the loads if there are any, else from the approach [MPa]."""
        if loads := self.scene.get("loads", ()):
            return sum(_value(load["pressure"]) for load in loads)
        moved = {s["on"]: _value(s.get("uy")) for s in self.scene["supports"] if "uy" in s}
        approach = moved[f"{self.names['lower']}.bottom"] - moved[f"{self.names['upper']}.top"]
        return (approach + self.overlap()) / (self.compliance("upper") + self.compliance("lower"))


def _value(given: Any) -> float:
    """The final value of a quantity that a scene gives as a number or as a ramp."""
    return float(given["to"] if isinstance(given, Mapping) else given or 0.0)
