"""A run whose interpreter may crash in a part: another process reports the crash then."""

from __future__ import annotations

import contextlib
import faulthandler
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from contactlab.run import crash_watch


@contextmanager
def told_if_it_crashes(folder: Path, scene: str) -> Iterator[None]:
    """While this lasts, a crash of the interpreter leaves `crash.txt`, a summary, and a line on standard error."""
    # not taken away by itself: it must outlive a crash
    trace = tempfile.NamedTemporaryFile("w", prefix="contactlab-", suffix=".txt", delete=False)  # noqa: SIM115
    before = faulthandler.is_enabled()
    faulthandler.enable(trace)
    words = [sys.executable, "-I", "-S", crash_watch.__file__, str(folder.absolute()), json.dumps(scene), trace.name]
    watch = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
    try:
        yield
    finally:
        faulthandler.disable()
        if before and sys.__stderr__ is not None:
            faulthandler.enable(sys.__stderr__)
        with contextlib.suppress(BrokenPipeError):
            watch.communicate(b".")
        trace.close()
        Path(trace.name).unlink()
