"""What a benchmark ran on: processor, caches, memory bandwidth, and the versions that made its machine code."""

from __future__ import annotations

import os
import platform
import re
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from statistics import median
from typing import Any

CACHES = Path("/sys/devices/system/cpu/cpu0/cache")
PACKAGES = ("contactlab", "numpy", "scipy", "numba", "llvmlite")


def machine(entries: int = 20_000_000, rounds: int = 7) -> dict[str, Any]:
    """The machine and its software; bandwidth by a triad over three arrays of so many `entries`.

    processor  name, as the system tells it; with `caches` and `cores` the kind of the machine
    bandwidth  GB/s of one thread: median, least and largest of the rounds
    software   compiler of Python's kernels (LLVM) and of Python itself, packages, and the system
    """
    # `stages` needs `kind` alone, where no package is installed
    import elements
    import llvmlite.binding
    import numpy as np

    arrays = tuple(np.ones(entries) for _ in range(3))
    elements.triad(*arrays)
    speeds = [24e-9 * entries / elements.seconds(lambda: elements.triad(*arrays), 1) for _ in range(rounds)]
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "caches": caches(),
        "bandwidth": {"median": median(speeds), "least": min(speeds), "largest": max(speeds)},
        "software": {
            "LLVM": ".".join(str(part) for part in llvmlite.binding.llvm_version_info),
            "Python": platform.python_version(),
            "Python's compiler": platform.python_compiler(),
            "system": f"{platform.system()} {platform.machine()}",
            **{name: version(name) for name in PACKAGES},
        },
    }


def kind(found: Mapping[str, Any]) -> str:
    """Processor, caches and cores: machines alike in these have comparable ratios."""
    held = ", ".join(f"{name} {size}" for name, size in found["caches"].items())
    return f"{found['processor']} ({found['cores']} cores, {held or 'caches not told'})"


def described(found: dict[str, Any]) -> str:
    """All of it in a sentence or two."""
    speed, software = found["bandwidth"], found["software"]
    return (
        f"{kind(found)}; memory {speed['median']:.1f} GB/s for one thread ({speed['least']:.1f} to "
        f"{speed['largest']:.1f}, triad). " + ", ".join(f"{name} {value}" for name, value in software.items()) + "."
    )


def processor() -> str:
    """Its name; family and model as well, since a virtual machine may give no more than a make."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or platform.machine()
    told = dict(re.findall(r"^(model name|cpu family|model)\s*:\s*(.*)$", text.split("\n\n")[0], re.MULTILINE))
    numbers = [f"{name.removeprefix('cpu ')} {told[name]}" for name in ("cpu family", "model") if name in told]
    return ", ".join([told.get("model name", platform.machine()), *numbers])


def caches() -> dict[str, str]:
    """Sizes of the caches that hold data, by level; empty where the system does not tell."""
    found = {}
    for folder in sorted(CACHES.glob("index*")):
        level, held, size = ((folder / name).read_text().strip() for name in ("level", "type", "size"))
        if held != "Instruction":
            found[f"L{level}"] = size
    return found
