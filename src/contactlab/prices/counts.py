"""The work of a run, counted by units such as "element NAME: cell": what prices are multiplied by.

A unit that begins with the kind and name of a part belongs to that part; the others belong to the core. A law is
counted beside the one that prices are measured with: its price is what a point takes more than with that one.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from contactlab.model.model import Model
    from contactlab.scene.scene import Scene

FACTOR = 1.5  # the power of unknowns that a factorisation of a plane mesh goes with (George 1973)

CONJUGATE_FRICTION = "conjugate forces with friction"
"""What the two cost more together than each by itself."""

Counts = defaultdict[str, float]


class Length(NamedTuple):
    """How long a run is: steps, Newton iterations of all of them (0 in explicit runs) and stored frames."""

    steps: float
    iterations: float
    frames: float


def counts_of(scene: Scene, model: Model, length: Length, touching: float = 1.0) -> dict[str, float]:
    """Work of a run by units; `touching` is the mean share of slave nodes that do not lie far from their masters.

    Load steps that begin in balance take no iteration, but stiffness and forces are found all the same.
    """
    counts: Counts = defaultdict(float)
    each = length.steps if model.explicit else max(length.iterations, length.steps)
    of = "" if model.explicit else "iteration's "
    integrator = f"integrator {scene.integrator['use']}"
    counts[f"{integrator}: run"] += 1
    counts[f"{integrator}: step"] += length.steps
    counts[f"{integrator}: node"] += each * len(model.reference)
    if not model.explicit:
        counts[f"{integrator}: iteration"] += length.iterations
        counts[f"{integrator}: factor"] += length.iterations * float(len(model.reference)) ** FACTOR
    _add_bodies(counts, scene, model, each, of)
    _add_contacts(counts, scene, model, each * touching, each, of)
    for spec in scene.effects:
        counts[f"effect {spec['use']}: {of}call"] += each
        counts[f"effect {spec['use']}: {of}node"] += each * len(model.reference)
    if scene.loads:
        counts["loads"] += each * len(scene.loads)
    _add_records(counts, scene, model, length)
    return {unit: float(count) for unit, count in counts.items() if count}


def _add_bodies(counts: Counts, scene: Scene, model: Model, each: float, of: str) -> None:
    for body in model.bodies:
        spec = scene.bodies[body.name]
        points = len(body.cells) * body.points
        counts[f"{of}body"] += each
        counts[f"element {spec.element['use']}: {of}cell"] += each * len(body.cells)
        counts[f"material {scene.materials[spec.material]['use']}: {of}point"] += each * points


def _add_contacts(counts: Counts, scene: Scene, model: Model, near: float, each: float, of: str) -> None:
    if model.contact is None:
        return
    counts[f"{of}contact"] += each
    conjugate = model.explicit and getattr(model.contact, "consistent", False)
    for pair, spec in zip(model.contact.pairs, scene.contacts, strict=True):
        nodes = len(pair.slave.nodes)
        parts = [f"contact {spec.algorithm['use']}"]
        parts += [f"friction {spec.friction['use']}"] if spec.friction else []
        parts += [f"enforcement {spec.enforcement['use']}"] if spec.enforcement else []
        parts += ["conjugate forces"] if conjugate else []
        parts += [CONJUGATE_FRICTION] if conjugate and spec.friction else []
        for part in parts:
            counts[f"{part}: {of}pair"] += each
            counts[f"{part}: {of}node"] += near * nodes


def _add_records(counts: Counts, scene: Scene, model: Model, length: Length) -> None:
    pairs = model.contact.pairs if model.contact is not None else ()
    slaves = sum(len(pair.slave.nodes) for pair in pairs)
    kind = "frame" if model.explicit else "load step's frame"
    sizes = {"body": len(model.bodies), "node": len(model.reference), "pair": len(pairs), "slave node": slaves}
    counts[kind] += length.frames
    for what, number in sizes.items():
        counts[f"{kind}: {what}"] += length.frames * number
    recorded = length.steps / _every(scene, model, length.steps) if pairs else 0.0
    for name in recorders_in(scene):
        counts[f"recorder {name}: run"] += 1
        counts[f"recorder {name}: {kind}"] += length.frames
        for what, number in sizes.items():
            counts[f"recorder {name}: {kind}'s {what}"] += length.frames * number
        counts[f"recorder {name}: step"] += length.steps
        counts[f"recorder {name}: contact step"] += recorded
        counts[f"recorder {name}: contact step's pair"] += recorded * len(pairs)
        counts[f"recorder {name}: contact step's node"] += recorded * slaves


def _every(scene: Scene, model: Model, steps: float) -> float:
    """Steps from one row of the contact record to the next."""
    recorded = model.contact is not None and scene.record.budget != 0.0
    return (scene.record.every or 1) if recorded else math.inf


def recorders_in(scene: Scene) -> list[str]:
    """Names of the recorders of a run with a folder."""
    from contactlab.run.recorders import default_recorders

    if scene.record.recorders is None:
        return default_recorders(scene.registry)
    return [spec["use"] for spec in scene.record.recorders]


def part_of(unit: str) -> str:
    """Kind and name of the part that a unit belongs to; empty for one of the core."""
    from contactlab.api.part import KINDS

    owner, colon, _ = unit.partition(":")
    return owner if colon and owner.partition(" ")[0] in KINDS else ""


def total(counts: Mapping[str, float], prices: Mapping[str, float]) -> float:
    """CPU time [s] of counted work; units without a price cost nothing here."""
    return sum(count * prices.get(unit, 0.0) for unit, count in counts.items())


def unpriced(counts: Mapping[str, float], prices: Mapping[str, Any]) -> list[str]:
    """Parts that are at work and have no price."""
    return list(dict.fromkeys(part_of(unit) or unit for unit in counts if unit not in prices))
