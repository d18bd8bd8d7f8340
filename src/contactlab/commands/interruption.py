"""What a command says and returns when Ctrl-C or SIGTERM ends it."""

from __future__ import annotations

import sys
from pathlib import Path

INTERRUPTED = 130
"""Exit status."""


def interrupted(folder: Path) -> int:
    """Tell how to go on with what `folder` keeps; gives the exit status."""
    line = f"interrupted; what is done is kept; add --out {folder} --resume to the same command to go on"
    print(line, file=sys.stderr)
    return INTERRUPTED
