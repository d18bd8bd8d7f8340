"""Location of compiled machine code on disk, so that it is reused and never stale.

numba checks only the file of the cached function, not the files of the functions that it inlines: after an inlined
helper was edited or upgraded, the old machine code would still run. The name of the folder therefore contains a hash
of every source that a kernel can inline (the core's kernels, the decorators, the whole package that defines the
kernel) and of the versions of numba and Python.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import sys
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
KERNELS, TEMPLATES = PACKAGE / "kernels", PACKAGE / "formulas"


def cache_root() -> Path:
    """Return `CONTACTLAB_CACHE`, or a folder in the user's cache directory."""
    chosen = os.environ.get("CONTACTLAB_CACHE")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "contactlab"


@cache
def source_hash(folder: Path) -> str:
    """Return a hash of all Python sources below `folder` and of the core's kernels, in a fixed order."""
    digest = hashlib.sha256()
    digest.update(f"{sys.version} numba {importlib.metadata.version('numba')}".encode())
    api = Path(__file__).resolve().parents[1]
    core = [*KERNELS.rglob("*.py"), *TEMPLATES.rglob("*.py"), *(api / "compiled").glob("*.py"), api / "tensors.py"]
    for file in sorted({*core, *folder.rglob("*.py")}):
        digest.update(file.name.encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder(source: str) -> str:
    """Return the cache folder for kernels defined in the file `source`."""
    file = Path(source).resolve()
    folder = KERNELS if PACKAGE in file.parents else file.parent
    return str(cache_root() / "kernels" / source_hash(folder))
