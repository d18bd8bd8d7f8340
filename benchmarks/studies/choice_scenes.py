"""Scenes that `contactlab choose` is put to in `choices.py`: none but the first has an installed reference."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contactlab.parts.registry import default_registry
from contactlab.scene.scene import Scene, load_scene

Table = dict[str, Any]
HELD = {"on": "block.bottom", "ux": 0.0, "uy": 0.0}
DISC = {"use": "arc-block", "radius": 1.0, "half_width": 0.8, "top": 0.6, "cells": [24, 6]}
BLOCK = {"use": "rectangle", "x": [-0.9, 0.9], "y": [-0.3, 0.0], "cells": [36, 6]}
SOFT = {"use": "neo-hookean", "young": 7000.0, "poisson": 0.3, "density": 2.7e-9}
LESS_DEEP = {"name": "less-deep", "integrator": "newton", "supports.1.uy.to": -0.1}
METAL = SOFT | {"use": "linear-hardening", "young": 70000.0, "yield_stress": 300.0, "hardening": 700.0}
HOW_TO = Path(__file__).parents[2] / "docs" / "how-to"
STEEL = SOFT | {"young": 70000.0}


@dataclass(frozen=True)
class Asked:
    """A scene with the relative error that is asked for."""

    scene: Scene
    what: str
    error: float


def asked() -> list[Asked]:
    """All of them."""
    return [
        Asked(load_scene("disc-on-block"), "as bundled, with its reference", 0.01),
        Asked(
            load_scene("disc-on-block").with_(LESS_DEEP),
            "the same, less deep",
            0.01,
        ),
        _disc("deep", "one and a half times as deep", 0.01, depth=0.12),
        _disc("shallow", "three segments in the half-width", 0.05, depth=0.012),
        _disc("nearly-incompressible", "block of Poisson's ratio 0.49", 0.02, block=SOFT | {"poisson": 0.49}),
        _disc("rough", "friction, mu = 0.3", 0.02, friction={"use": "coulomb", "mu": 0.3}),
        _disc("quadratic", "declared with quadratic elements", 0.02, element="q2"),
        _disc("leaning", "pushed aside as well, mu = 0.2", 0.03, friction={"use": "coulomb", "mu": 0.2}, aside=0.01),
        _rigid("parabola", "rigid parabola", 0.02, [[x, 0.5 * x * x] for x in _even(-0.6, 0.6, 400)]),
        _rigid("rounded", "flat punch with rounded edges", 0.03, [[x, _rounded(x)] for x in _even(-0.7, 0.7, 400)]),
        _rigid("wave", "rigid wave", 0.03, [[x, 0.02 * (1 - math.cos(7 * x))] for x in _even(-1.2, 1.2, 800)], 0.02),
        _two_discs(),
        _pressed_layer(),
        _disc("plastic", "a block that flows", 0.03, block=METAL, element="q1-fbar", depth=0.04),
        Asked(load_scene(HOW_TO / "bearing.toml"), "a mesh from Gmsh, two contacts", 0.05),
        _four_contacts(),
        _two_rings(),
        _two_beams(),
        _punch(),
        _bouncing_block(),
    ]


def _made(name: str, **tables: Any) -> Scene:
    data = {"format": 1, "name": name, "integrator": {"use": "newton"}, "record": {"frames": 1}} | tables
    return Scene.from_data(data, registry=default_registry())


def _linear(material: Mapping[str, Any]) -> Table:
    return {**material, "use": "linear-elastic"}


def _even(first: float, last: float, count: int) -> list[float]:
    return [first + (last - first) * k / count for k in range(count + 1)]


def _rounded(x: float) -> float:
    """Flat over |x| < 0.25, then a parabola."""
    return 2.0 * max(0.0, abs(x) - 0.25) ** 2


def _contact(slave: str, master: str, friction: Table | None = None) -> list[Table]:
    return [{"slave": slave, "master": master, "algorithm": "mortar-p0"} | ({"friction": friction} if friction else {})]


def _ramp(to: float) -> Table:
    return {"ramp": "linear", "to": to}


def _disc(
    name: str, what: str, error: float, depth: float = 0.06, disc: Table = STEEL, block: Table = SOFT,
    element: str = "q1", radius: float = 1.0, friction: Table | None = None, aside: float = 0.0,
) -> Asked:  # fmt: skip
    mesh = DISC | {"radius": radius, "half_width": 0.8 * radius, "top": 0.6 * radius}
    scene = _made(
        name,
        materials={"upper": disc, "lower": block},
        bodies={
            "disc": {"element": element, "material": "upper", "mesh": mesh},
            "block": {"element": element, "material": "lower", "mesh": BLOCK},
        },
        contacts=_contact("disc.arc", "block.top", friction),
        supports=[HELD, {"on": "disc.top", "ux": _ramp(aside) if aside else 0.0, "uy": _ramp(-depth)}],
        **({} if aside else {"symmetry": "x"}),
    )
    return Asked(scene, what, error)


def _rigid(name: str, what: str, error: float, line: list[list[float]], depth: float = 0.04) -> Asked:
    scene = _made(
        name,
        materials={"soft": SOFT},
        bodies={"block": {"element": "q1", "material": "soft", "mesh": BLOCK}},
        rigid={"tool": {"line": line[::1], "uy": _ramp(-depth)}},
        contacts=_contact("block.top", "tool"),
        supports=[HELD],
        symmetry="x",
    )
    return Asked(scene, what, error)


def _two_discs() -> Asked:
    scene = _made(
        "two-discs",
        materials={"upper": STEEL, "lower": SOFT},
        bodies={
            "disc": {"element": "q1", "material": "upper", "mesh": DISC},
            "block": {"element": "q1", "material": "lower", "mesh": DISC | {"cells": [30, 6]}, "rotate": 180.0},
        },
        contacts=_contact("disc.arc", "block.arc"),
        supports=[{"on": "block.top", "ux": 0.0, "uy": 0.0}, {"on": "disc.top", "ux": 0.0, "uy": _ramp(-0.06)}],
        symmetry="x",
    )
    return Asked(scene, "two discs", 0.02)


def _pressed_layer() -> Asked:
    layer = {"use": "rectangle", "x": [-0.9, 0.9], "y": [0.0, 0.2], "cells": [36, 6]}
    wide = {"use": "rectangle", "x": [-0.9, 0.9], "y": [-0.6, 0.0], "cells": [30, 10]}
    scene = _made(
        "pressed-layer",
        materials={"stiff": _linear(STEEL), "soft": _linear(SOFT)},
        bodies={
            "layer": {"element": "q1", "material": "stiff", "mesh": layer},
            "block": {"element": "q1", "material": "soft", "mesh": wide},
        },
        contacts=_contact("layer.bottom", "block.top"),
        supports=[HELD, {"on": "layer.left", "ux": 0.0}, {"on": "layer.right", "ux": 0.0}],
        loads=[{
            "on": "layer.top", "pressure": _ramp(20.0), "follower": False,
            "profile": {"by": "x", "cosine": [1.0, 0.6, 1.8]},
        }],
        symmetry="x",
    )  # fmt: skip
    return Asked(scene, "a layer under a pressure that varies", 0.01)


def _body(mesh: Table, material: str = "soft", **rest: Any) -> Table:
    return {"element": "q1", "material": material, "mesh": mesh, **rest}


def _rectangle(x: list[float], y: list[float], cells: list[int]) -> Table:
    return {"use": "rectangle", "x": x, "y": y, "cells": cells}


def _four_contacts() -> Asked:
    pairs = [
        ("low.bottom", "floor"),
        ("roll.bottom", "low.top"),
        ("roll.top", "high.bottom"),
        ("cap.bottom", "high.top"),
    ]
    scene = _made(
        "four-contacts",
        materials={"soft": SOFT, "stiff": STEEL},
        bodies={
            "low": _body(_rectangle([-1.2, 1.2], [0.0, 0.5], [24, 5])),
            "roll": _body({"use": "disc", "radius": 0.8, "cells": [10, 5]}, "stiff", shift=[0.0, 1.3]),
            "high": _body(_rectangle([-1.2, 1.2], [2.1, 2.6], [30, 5])),
            "cap": _body(_rectangle([-0.6, 0.6], [2.6, 3.0], [10, 4]), "stiff"),
        },
        rigid={"floor": {"line": [[3.0, 0.0], [-3.0, 0.0]]}},
        contacts=[c for pair in pairs for c in _contact(*pair, {"use": "coulomb", "mu": 0.2})],
        supports=[
            {"on": "low.left", "ux": 0.0}, {"on": "high.left", "ux": 0.0},
            {"on": "cap.top", "ux": 0.0, "uy": _ramp(-0.06)},
        ],
        effects=[{"use": "spring", "on": "roll", "stiffness": [1.0, 0.0]}],
    )  # fmt: skip
    return Asked(scene, "a roll between two blocks, on a floor and under a cap", 0.03)


def _two_rings() -> Asked:
    def ring(radii: list[float], cells: list[int]) -> Table:
        return {"use": "ring", "radii": radii, "cells": cells, "angles": [0.0, 180.0]}

    scene = _made(
        "two-rings",
        materials={"soft": SOFT, "stiff": STEEL},
        bodies={
            "inner": _body(ring([4.0, 6.02], [40, 4]), "stiff"),
            "outer": _body(ring([6.0, 8.5], [32, 5])),
        },
        contacts=[_contact("inner.outer", "outer.inner")[0] | {"start": {"overlap": "ramp"}}],
        supports=[{"on": f"{body}.{end}", "uy": 0.0} for body in ("inner", "outer") for end in ("start", "end")],
        effects=[
            {"use": "spring", "on": on, "stiffness": [1e-2, 0.0]} for on in ("inner.inner", "outer.outer")
        ],
    )  # fmt: skip
    return Asked(scene, "a shrink fit of half rings", 0.02)


def _two_beams() -> Asked:
    scene = _made(
        "two-beams",
        materials={"stiff": STEEL},
        bodies={
            "lower": _body(_rectangle([0.0, 20.0], [0.0, 1.0], [24, 2]), "stiff"),
            "upper": _body(_rectangle([12.0, 32.0], [1.2, 2.4], [20, 2]), "stiff"),
        },
        contacts=_contact("upper.bottom", "lower.top", {"use": "coulomb", "mu": 0.1}),
        supports=[{"on": "lower.left", "ux": 0.0, "uy": 0.0}, {"on": "upper.right", "ux": 0.0, "uy": _ramp(-2.0)}],
    )
    return Asked(scene, "two cantilevers that press with their ends", 0.05)


def _punch() -> Asked:
    scene = _made(
        "punch",
        materials={"soft": SOFT, "stiff": STEEL},
        bodies={
            "punch": _body(_rectangle([-0.5, 0.5], [0.0, 0.8], [12, 8]), "stiff"),
            "block": _body(_rectangle([-1.5, 1.5], [-1.0, 0.0], [36, 12])),
        },
        contacts=_contact("punch.bottom", "block.top", {"use": "coulomb", "mu": 0.2}),
        supports=[HELD, {"on": "punch.top", "ux": 0.0, "uy": _ramp(-0.02)}],
        symmetry="x",
    )
    return Asked(scene, "a flat punch with sharp edges", 0.03)


def _bouncing_block() -> Asked:
    block = _rectangle([0.0, 8.0], [0.0, 6.0], [8, 6])
    scene = _made(
        "bouncing-block",
        time={"end": 4e-4},
        integrator={"use": "central-difference"},
        materials={"soft": SOFT | {"young": 50.0, "density": 1e-9}},
        bodies={"block": _body(block, velocity=[300.0, -4000.0], shift=[0.0, 0.3])},
        rigid={"floor": {"line": [[30.0, 0.0], [-10.0, 0.0]]}},
        contacts=_contact("block.bottom", "floor", {"use": "coulomb", "mu": 0.1}),
    )
    return Asked(scene, "a block that bounces off a floor", 0.05)
