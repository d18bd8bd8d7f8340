"""Process that reports how a run died if the run could not do so itself; imports the standard library alone.

Its standard input is a pipe from the run: a byte, and all is well; an end without one, and the run is gone.
Arguments: the folder of the run, the scene's name as JSON (which any encoding can pass), and the file into which
`faulthandler` writes.
"""

from __future__ import annotations

import json
import signal
import sys
from pathlib import Path

KILLED = "the process ended without a message (killed, or left by os._exit)"


def main(folder: str, scene: str, trace: str) -> None:
    """Wait for the end of the run; leave `crash.txt` and `summary.json` if it came too early."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)  # at the terminal they are meant for the run
    if sys.stdin.buffer.read(1):
        return
    text = Path(trace).read_text(errors="replace")
    Path(trace).unlink()
    reason = described(text)
    print(f"contactlab: {printable(scene)}: failed: {reason}", file=sys.stderr)
    if not Path(folder).is_dir():
        return
    if text:
        Path(folder, "crash.txt").write_text(text)
    summary = Path(folder, "summary.json")
    if not summary.exists():
        told = {"format": 1, "scene": scene, "status": "failed", "reason": reason}
        written = summary.with_suffix(".json.new")
        written.write_text(json.dumps(told, indent=1) + "\n")
        written.replace(summary)


def printable(text: str) -> str:
    """The text without what commands a terminal."""
    return "".join(character for character in text if character.isprintable())


def described(text: str) -> str:
    """Say what happened and where, from what `faulthandler` wrote."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    if not lines:
        return KILLED
    fault = lines[0].removeprefix("Fatal Python error: ")
    begin = next((i for i, line in enumerate(lines) if line.startswith("Current thread")), 0)
    frame = next((line for line in lines[begin:] if line.startswith("File ")), "")
    place = f" in {frame.removeprefix('File ')}" if frame else ""
    return f"the interpreter crashed ({fault}){place}; crash.txt has the whole stack"


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]), sys.argv[3])
