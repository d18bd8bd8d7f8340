"""The cost of a call of a part, compared with other parts of its kind."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from contactlab.api import BLOCK_CELLS, ExplicitEnforcement, ExplicitIntegrator, GapAlgorithm, NormalLaw
from contactlab.errors import RequestError
from contactlab.testing.assertions import NotApplicable
from contactlab.testing.cells import distorted_cells
from contactlab.testing.effect import Scenery, added
from contactlab.testing.gap_rows import coupled_normals, rows_from
from contactlab.testing.oscillator import Oscillator
from contactlab.testing.points import gradients, no_history
from contactlab.testing.subject import Subject
from contactlab.testing.surfaces import flat, pair_of

SHORTEST = 0.01  # s of CPU time, for one measurement
TIMES = 3  # of which the least counts: others on the machine only add

Call = Callable[[], object]


@dataclass(frozen=True)
class Cost:
    """CPU time of one call [us] of a part; `of` names the call."""

    name: str
    microseconds: float
    of: str


def costs(subject: Subject) -> list[Cost]:
    """Costs of the part, then of every other part of its kind with the same call; empty if none is known."""
    call_of = partial(_contact, edges=_edges(subject)) if subject.kind == "contact" else _CALLS.get(subject.kind)
    if call_of is None:
        return []
    found = []
    others = [name for name in subject.registry.names(subject.kind) if name != subject.name]
    for name in (subject.name, *others):
        this = subject if name == subject.name else Subject(subject.registry, subject.kind, name)
        try:
            of, call = call_of(this)
            found.append(Cost(name, 1e6 * seconds(call), of))
        except (NotApplicable, RequestError, AssertionError):
            continue  # what cannot be called has failed its checks already
    same = [cost for cost in found if cost.of == found[0].of]
    return same if same and same[0].name == subject.name else []


def seconds(call: Call) -> float:
    """CPU seconds of one call, compiled before."""
    call()
    repeat, spent = 1, 0.0
    while True:
        began = time.process_time()
        for _ in range(repeat):
            call()
        spent = time.process_time() - began
        if spent > SHORTEST:
            break
        repeat *= 2
    best = spent
    for _ in range(TIMES - 1):
        began = time.process_time()
        for _ in range(repeat):
            call()
        best = min(best, time.process_time() - began)
    return best / repeat


def _material(subject: Subject) -> tuple[str, Call]:
    law, points = subject.make(), 4 * BLOCK_CELLS
    gradient, history = gradients(law, points, 1e-4), no_history(law, points)
    stress, new = np.empty((4, points)), np.empty_like(history)
    return f"stresses of {points} points", lambda: law.stress(gradient, history, 1e-6, stress, new)


def _edges(subject: Subject) -> tuple[int, int]:
    """Slave's and master's segments: fewer for finished gap conditions, which are often in plain NumPy."""
    return (40, 30) if issubclass(subject.part_class, GapAlgorithm) else (200, 150)


def _contact(subject: Subject, edges: tuple[int, int]) -> tuple[str, Call]:
    at = flat(edges=edges)
    pair, memory = pair_of(subject.make(), at)
    if pair.by_energy:
        raise NotApplicable("potentials set no conditions")
    n = len(at.slave.segments)
    return f"pieces and rows of {n} segments", lambda: pair.update(at.nodes, memory)


def _element(subject: Subject) -> tuple[str, Call]:
    cells = distorted_cells(subject.make(), BLOCK_CELLS, kinematics="finite")
    kernels, a = cells.kernels, len(cells.element.nodes)
    out, force = np.empty((4, cells.points)), np.zeros_like(cells.nodes)
    scratch, stress = np.zeros((6 * a + 6, BLOCK_CELLS)), np.ones((4, cells.points))

    def call() -> None:
        kernels.gradient(cells.nodes, cells.nodes, cells.connectivity, out, scratch)
        kernels.force(cells.nodes, cells.connectivity, stress, force, scratch)

    return f"gradients and forces of {BLOCK_CELLS} cells", call


def _enforcement(subject: Subject) -> tuple[str, Call]:
    from contactlab.testing.enforcement_implicit import some_conditions

    enforcement = subject.make()
    if isinstance(enforcement, ExplicitEnforcement):
        normal = coupled_normals(50, 1)
        rows = rows_from(normal, np.random.default_rng(1).uniform(-1.0, 1.0, 50))
        compliance, force = np.ones((53, 2)), np.zeros((53, 2))
        return "solution of 50 rows", lambda: enforcement.solve(rows, compliance, np.zeros((1, 50)), force)
    if isinstance(enforcement, NormalLaw):
        gap, ones, (pressure, slope, *more) = np.linspace(-0.1, 0.1, 1000), np.ones(1000), np.zeros((4, 1000))
        from contactlab.testing.normal_law import named_of

        arrays = (gap, ones, ones, pressure, slope, *(more if "traction" in enforcement.needs else ()))
        named = named_of(enforcement, 1000)
        return "pressure of 1000 gaps", lambda: enforcement.pressure(*arrays, **named)
    conditions, out = some_conditions(1000, friction=True)
    return "response of 1000 conditions", lambda: enforcement.respond(conditions, out)


def _integrator(subject: Subject) -> tuple[str, Call]:
    integrator, n = subject.make(), 200
    model = Oscillator(integrator, np.ones(n), np.ones(n), velocity=np.ones((n, 2)))
    kind = "explicit" if isinstance(integrator, ExplicitIntegrator) else "implicit"
    return f"{kind} step of {n} masses", lambda: model.advance(0.01)


def _effect(subject: Subject) -> tuple[str, Call]:
    view = Scenery.moving(1).view
    add, force = added(subject.make(), view), np.zeros_like(view.reference)
    return f"forces on {len(force)} nodes", lambda: add(0.3, force)


_CALLS: dict[str, Callable[[Subject], tuple[str, Call]]] = {
    "material": _material,
    "element": _element,
    "enforcement": _enforcement,
    "integrator": _integrator,
    "effect": _effect,
}
