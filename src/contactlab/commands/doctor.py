"""`contactlab doctor`: does this installation compute a contact step, and with what."""

from __future__ import annotations

import argparse
import os
import platform
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from time import perf_counter
from typing import TYPE_CHECKING

from contactlab.commands.common import add_row, console, number, table
from contactlab.errors import ContactlabError, one_line
from contactlab.parts.registry import Registry, default_registry
from contactlab.scene.scene import load_scene

if TYPE_CHECKING:
    from contactlab.results.results import Results

LIBRARIES = ("contactlab", "numpy", "scipy", "numba", "pluggy", "rich", "matplotlib")
THREADS = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

# the bundled scene on a mesh so coarse that only compilation takes time; long enough for a wave to cross it
PROBE = {
    "level": 1,
    "bodies.disc.mesh.cells": [8, 2],
    "bodies.block.mesh.cells": [12, 2],
    "supports.1.uy.to": -0.001,
    "time.end": 1e-6,
}


def doctor(options: argparse.Namespace) -> int:
    """Print facts and the outcome of a contact step; status 1 when it fails."""
    del options
    registry = default_registry()
    shown = table("fact", "value")
    for label, value in (*_machine(), *_versions(), *_plugins(registry)):
        add_row(shown, label, value)
    healthy, outcome = contact_step(registry)
    add_row(shown, "contact step", outcome)
    console().print(shown)
    return 0 if healthy else 1


def contact_step(registry: Registry) -> tuple[bool, str]:
    """Whether a disc pressed on a block for some steps meets resistance, and how long that takes."""
    try:
        began = perf_counter()
        _probe(registry)
        ready = perf_counter() - began
        results = _probe(registry)
        seconds = perf_counter() - began - ready
    except Exception as error:  # whatever is wrong with an installation, the facts around it are worth printing
        return False, f"not possible: {error if isinstance(error, ContactlabError) else one_line(error)}"
    if results.status != "finished":
        return False, f"{results.status}: {results.reason}"
    force = results.summary["contacts"]["contacts.0"]["resultant"][1]
    if not force > 0.0:
        return False, f"the contact carries no force ({number(force)})"
    steps = results.summary["steps"]
    return True, f"works: {steps} steps in {seconds:.2f} s after {ready:.1f} s to compile kernels or find them compiled"


def _probe(registry: Registry) -> Results:
    from contactlab.run.simulation import simulate

    return simulate(load_scene("disc-on-block", registry).with_(PROBE), registry=registry)


def _machine() -> Iterator[tuple[str, str]]:
    yield "system", f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    yield "cores", f"{usable} usable of {os.cpu_count()}"
    limits = [f"{name}={os.environ[name]}" for name in THREADS if name in os.environ]
    said = ", ".join(limits) or "no limit set in the environment"
    yield "threads", f"one per run, or as many as the scene's key `threads` says; {said}"


def _versions() -> Iterator[tuple[str, str]]:
    for name in LIBRARIES:
        try:
            yield name, version(name)
        except PackageNotFoundError:
            yield name, "not installed"


def _plugins(registry: Registry) -> Iterator[tuple[str, str]]:
    offers = registry.parts()
    origins = sorted({str(offer.origin) for offer in offers})
    yield "plugins", f"{len(offers)} parts from {', '.join(origins)}"
    for item in (*registry.broken(), *registry.incomplete()):
        yield "broken plugin", f"{item.origin} {item.item}: {item.reason}"
