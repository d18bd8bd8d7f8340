"""`contactlab doctor`: does this installation compute a contact step, and with what."""

from __future__ import annotations

import argparse
import os
import platform
import re
from collections.abc import Iterator, Sequence
from ctypes.util import find_library
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from contactlab.commands.common import console, number, print_json
from contactlab.errors import ContactlabError, one_line
from contactlab.parts.machine import blas_kernels, processor, usable_cores
from contactlab.parts.registry import Registry, default_registry
from contactlab.reports.sheet import Column, Sheet
from contactlab.results.results import Results
from contactlab.scene.scene import load_scene

OPTIONAL = {
    "ipykernel": ("notebooks", "notebook"),
    "ipython": ("pictures and progress inside notebooks", "notebook"),
    "pandas": ("results as data frames", "notebook"),
    "pyvista": ("meshes in three-dimensional views", "notebook"),
    "rerun-notebook": ("viewer inside notebooks", "notebook"),
    "xarray": ("results as labelled arrays", "notebook"),
    "distributed": ("comparisons on several machines", "dask"),
}
"""Packages that come with extras: what they are for, and the extra that brings them."""
DRIVER_FOLDERS = ("/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d", "/usr/local/share/vulkan/icd.d",
                  "~/.local/share/vulkan/icd.d")  # fmt: skip
INSTALL_DRIVER = (
    "a software driver is enough: apt-get install mesa-vulkan-drivers libvulkan1 (Debian, Ubuntu) or "
    "dnf install mesa-vulkan-drivers vulkan-loader (Fedora)"
)
THREADS = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")

# the bundled scene on a mesh so coarse that only compilation takes time; long enough for a wave to cross it
PROBE = {
    "level": 1,
    "bodies.disc.mesh.cells": [8, 2],
    "bodies.block.mesh.cells": [12, 2],
    "supports.1.uy.to": -0.001,
    "time.end": 1e-6,
}


class Fact(NamedTuple):
    """A line: what it is about, what was found, and what to do about it (nothing where all is well)."""

    fact: str
    value: str
    todo: str = ""


def doctor(options: argparse.Namespace) -> int:
    """Print facts, what to install, and the outcome of a contact step; status 1 when the step fails."""
    registry = default_registry()
    facts = [*_machine(), *_packages(registry), *optional_packages(), *_plugins(registry), vulkan_driver()]
    healthy, outcome = contact_step(registry)
    facts.append(Fact("contact step", outcome))
    if options.json:
        print_json({"format": 1, "healthy": healthy, "facts": [fact._asdict() for fact in facts]})
        return 0 if healthy else 1
    out = console()
    out.print(Sheet((Column("fact", whole=True), "value"), ([fact.fact, fact.value] for fact in facts)))
    for fact in (fact for fact in facts if fact.todo):
        out.say(f"{fact.fact}: {fact.todo}")
    return 0 if healthy else 1


def contact_step(registry: Registry) -> tuple[bool, str]:
    """Press a disc on a block for some steps; return whether contact carries a force, and the times in words."""
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
    return True, f"works: {steps} steps in {seconds:.2f} s after {ready:.1f} s to compile or load kernels"


def _probe(registry: Registry) -> Results:
    from contactlab.run.simulation import simulate

    return simulate(load_scene("disc-on-block", registry).with_(PROBE), registry=registry)


def _machine() -> Iterator[Fact]:
    yield Fact("system", f"{platform.system()} {platform.machine()}, Python {platform.python_version()}")
    yield Fact("cores", f"{usable_cores()} usable of {os.cpu_count()}")
    yield Fact("processor", processor())
    yield Fact("BLAS", blas_kernels())
    limits = [f"{name}={os.environ[name]}" for name in THREADS if name in os.environ]
    said = ", ".join(limits) or "no limit set in the environment"
    yield Fact("threads", f"one per run, or as many as the scene's key `threads` says; {said}")


def _packages(registry: Registry) -> Iterator[Fact]:
    """Every package that has to be there, by what the core and the plugins require, with its version."""
    own = dict.fromkeys(["contactlab", *(offer.origin.distribution for offer in registry.parts())])
    needed = {name for package in own for name in _required_by(package)}
    for name in (*own, *sorted(needed - set(own))):
        found = _version(name)
        yield Fact(name, found or "not installed", "" if found else f"pip install {name}")


def _required_by(package: str) -> Iterator[str]:
    """Names of what a package requires always."""
    try:
        required = requires(package) or []
    except PackageNotFoundError:
        return
    for line in required:
        if "extra ==" not in line:
            yield re.split(r"[\s<>=!~;\[(]", line, maxsplit=1)[0]


def optional_packages() -> Iterator[Fact]:
    """Packages that some things need, and for what."""
    for name, (use, extra) in OPTIONAL.items():
        found = _version(name)
        todo = f'for {use}, pip install {name}, or pip install "contactlab[{extra}]"'
        yield Fact(name, found or f"not installed: no {use}", "" if found else todo)


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def _plugins(registry: Registry) -> Iterator[Fact]:
    offers = registry.parts()
    origins = {str(offer.origin) for offer in offers}
    yield Fact("plugins", f"{len(offers)} parts from {len(origins)} packages")
    for item in (*registry.broken(), *registry.incomplete()):
        yield Fact("broken plugin", f"{item.origin} {item.item}: {item.reason}", f"fix or update {item.origin}")
    for item in registry.burdens():
        yield Fact("plugin", f"{item.origin}: {item.reason}", f"ask the authors of {item.origin}")


def vulkan_driver(folders: Sequence[str] = DRIVER_FOLDERS) -> Fact:
    """The drivers that pictures of the timeline can be drawn with; only Linux may be without one."""
    if platform.system() != "Linux":
        return Fact("Vulkan driver", "not needed: this system has its own graphics")
    named = [os.environ.get(variable, "") for variable in ("VK_DRIVER_FILES", "VK_ICD_FILENAMES")]
    files = [Path(path) for text in named for path in text.split(os.pathsep) if path]
    files = files or [path for folder in folders for path in sorted(Path(folder).expanduser().glob("*.json"))]
    drivers = list(dict.fromkeys(path.name.removesuffix(".json").split("_icd")[0] for path in files if path.is_file()))
    if not drivers:
        return Fact("Vulkan driver", "none: no pictures of a timeline (contactlab view)", INSTALL_DRIVER)
    if find_library("vulkan") is None:
        return Fact("Vulkan driver", f"{', '.join(drivers)}, but the loader libvulkan is missing", INSTALL_DRIVER)
    software = " (software)" if drivers == ["lvp"] else ""
    return Fact("Vulkan driver", f"{', '.join(drivers)}{software}")
