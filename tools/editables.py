"""An editable wheel of each package of this repository: `python tools/editables.py FOLDER`.

`pip install -e` starts three processes for a package, one package after the other; the hook it calls in them
(PEP 660) makes all of them in one process here. Needs setuptools. Nothing may be installed meanwhile: setuptools
imports what it finds in the environment, and a package that is half unpacked stops it.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from setuptools import build_meta

ROOT = Path(__file__).resolve().parents[1]


def make(folder: Path) -> None:
    """Fill `folder` with the wheels and nothing else."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for project in [ROOT, *sorted(file.parent for file in ROOT.glob("plugins/*/pyproject.toml"))]:
        os.chdir(project)  # where PEP 517 has its hooks called
        build_meta.build_editable(str(folder))


if __name__ == "__main__":
    make(Path(sys.argv[1]).resolve())
