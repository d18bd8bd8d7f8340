"""Kills at random moments, full disks and damaged files: what is stored must be whole, or said not to be.

    python tests/abuse/faults.py [--kills N] [--early N] [--disks N] [--full N] [--comparisons N] [--damages N]

early  signals to the program in its first seconds; disks limits of the size of a file; full disks that are full, and
limits, with the default recorders

Prints the seed and a table; exit status 1 where a number came back that was not stored, or a traceback.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "timeline")]

from damages import damage, everything, outcome, same  # noqa: E402
from test_kill import ForkServer  # noqa: E402
from test_resume import COULOMB, IMPLICIT, PLASTIC, STATICS  # noqa: E402

import contactlab  # noqa: E402

FRAMES = 20
COMPARED = ["mortar-p0", "mortar-p1", "node-on-segment"]
TRIES = 10  # at a moment within the run: a machine that is busy may end it sooner than it was meant to live
SMALL = {
    "bodies.disc.mesh.cells": [8, 2], "bodies.block.mesh.cells": [12, 2], "time.end": 8e-6, "record.frames": FRAMES,
    "record.recorders": ["vtkhdf"],
}  # fmt: skip
VARIANTS: dict[str, dict[str, Any]] = {
    "mortar-p0": {},
    "mortar-p1, friction": {"contacts.0.algorithm": "mortar-p1", **COULOMB},
    "node-on-segment, plasticity": {"contacts.0.algorithm": "node-on-segment", **PLASTIC},
    "quadratic": {"bodies.disc.element": "q2", "bodies.block.element": "q2-lagrange"},
    "newton": STATICS,
    "newton, friction": {**STATICS, **COULOMB},
    "implicit-dynamics, plasticity": {**IMPLICIT, **PLASTIC},
}
TABLES = ("history.csv", "contact.csv", "iterations.csv")
GOOD = (
    "same",
    "killed too early or too late",
    "as before",
    "told",
    "told, some salvaged",
    "full, then same",
    "refused",
)
SIGNALS = (signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
FIRST = 2.0  # s
HANG = 300.0  # s of a machine that may be busy
WHOLE_RUN = {key: value for key, value in SMALL.items() if key != "record.recorders"}
"""With the default recorders."""


def kill(fork_server: ForkServer, scene: Any, whole: Path, cpu: float, folder: Path, chance: random.Random) -> str:
    """Kill a run once or twice, take it up again, and compare everything."""
    for _ in range(TRIES):
        hit = False
        for attempt in range(chance.choice((1, 1, 2))):
            ended = fork_server.run(scene, folder, resume=attempt > 0, lives=chance.uniform(0.1, 0.9) * cpu)
            hit = hit or ended.status < 0
        if hit:
            break
        shutil.rmtree(folder)
    if fork_server.run(scene, folder, resume=True).status != 0:
        return "not taken up"
    return _compared(whole, folder, "same" if hit else "killed too early or too late")


def kill_comparison(scene: Path, whole: Path, folder: Path, chance: random.Random) -> str:
    """Kill a comparison and its workers when so many frames are stored, take it up again, and compare all runs."""
    command = [sys.executable, "-m", "contactlab", "compare", str(scene), "--out", str(folder), "--jobs", "1"]
    command += ["--vary", f"contacts.0.algorithm={json.dumps(COMPARED)}"]
    wanted = chance.randrange(1, len(COMPARED) * FRAMES) if whole != folder else sys.maxsize
    process = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and _stored(folder) < wanted:
        time.sleep(0.005)
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        good = "same"
        again = subprocess.run([*command, "--resume"], capture_output=True, text=True, check=False)
        if again.returncode:
            return f"not taken up: {again.stderr[-300:]}"
    else:
        good = "killed too early or too late"
    places = sorted(place.parent.relative_to(whole) for place in whole.glob("runs/*/results.vtkhdf"))
    came = {_compared(whole / place, folder / place, good) for place in places}
    return good if came == {good} and len(places) == len(COMPARED) else f"runs of it: {came}"


def _stored(folder: Path) -> int:
    """Frames of all runs of a comparison so far."""
    return sum(max(0, path.read_text().count("\n") - 1) for path in folder.rglob("history.csv"))


def fill_disk(fork_server: ForkServer, scene: Any, whole: Path, folder: Path, chance: random.Random) -> str:
    """Let no file become larger than a share of what the run needs, then take the run up again."""
    size = (whole / "results.vtkhdf").stat().st_size
    fork_server.run(scene, folder, largest=int(chance.uniform(0.02, 1.0) * size))
    if fork_server.run(scene, folder, resume=True).status != 0:
        return "not taken up"
    return _compared(whole, folder, "full, then same")


def program(whole: Path, folder: Path, *more: str) -> list[str]:
    """The words that run the scene beside `whole` into `folder`."""
    scene = str(whole.with_name("scene.toml"))
    return [sys.executable, "-P", "-m", "contactlab", "run", scene, "--out", str(folder), "--quiet", *more]


def stop_early(whole: Path, folder: Path, chance: random.Random) -> str:
    """Send a signal to the program within its first seconds, run it again, and compare everything."""
    sent, shell = chance.choice(SIGNALS), {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    process = subprocess.Popen(program(whole, folder), text=True, **shell)  # type: ignore[call-overload]
    time.sleep(chance.uniform(0.0, FIRST))
    over = process.poll() is not None
    process.send_signal(sent)
    told, _ = process.communicate(timeout=HANG)
    ended = process.returncode
    if "Traceback" in told or "Exception ignored" in told:
        return f"{sent.name}: {told[-500:]}"
    if over:
        return "killed too early or too late"
    # the interpreter itself does not listen in its first tenth of a second
    if sent != signal.SIGKILL and ended not in (130, -sent) and not (ended == 1 and sent == signal.SIGINT):
        return f"{sent.name} swallowed: status {ended}"
    time.sleep(0.5)  # for the process that tells of a death
    anew = [] if not (folder / "results.vtkhdf").exists() and chance.random() < 0.5 else ["--resume"]
    again = subprocess.run(program(whole, folder, *anew), capture_output=True, text=True, check=False, timeout=HANG)
    if again.returncode:
        return f"{sent.name} {ended}: not taken up {anew}: {again.stderr[-300:]}"
    return _compared(whole, folder, "same")


def fill_whole_disk(whole: Path, folder: Path, chance: random.Random) -> str:
    """Run on a disk that is too small, or with a limit of file size, with the default recorders; then with room."""
    size = sum(path.stat().st_size for path in whole.iterdir())
    largest = max(path.stat().st_size for path in whole.iterdir())
    share, mounted = chance.uniform(0.05, 1.0), hasattr(os, "geteuid") and os.geteuid() == 0 and chance.random() < 0.5
    limit: Any = None
    folder.mkdir()
    if mounted:
        words = ["mount", "-t", "tmpfs", "-o", f"size={int(share * size)}", "tmpfs", str(folder)]
        mounted = subprocess.run(words, check=False, capture_output=True).returncode == 0
    if not mounted:
        most = int(share * largest)
        limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))  # noqa: E731
    try:
        out = folder / "run"
        words = program(whole, out)
        first = subprocess.run(words, capture_output=True, text=True, check=False, timeout=HANG, preexec_fn=limit)
        told = first.stdout + first.stderr
        if "Traceback" in told or first.returncode not in (0, 1, 2):
            return f"{'disk' if mounted else 'limit'} of {share:.2f}: status {first.returncode}: {told[-600:]}"
        if mounted:
            subprocess.run(["mount", "-o", f"remount,size={4 * size}", str(folder)], check=True)
        if first.returncode != 2 or out.exists():
            again = subprocess.run([*words, "--resume"], capture_output=True, text=True, check=False, timeout=HANG)
            if again.returncode:
                return f"{'disk' if mounted else 'limit'} of {share:.2f}: not taken up: {again.stderr[-400:]}"
            return _compared(whole, out, "full, then same")
        return "refused"
    except subprocess.TimeoutExpired:
        return f"{'disk' if mounted else 'limit'} of {share:.2f}: hangs"
    finally:
        if mounted:
            subprocess.run(["umount", str(folder)], check=True)


def of_program(number: int, root: Path, tried: Any, chance: random.Random, say: Any) -> Counter[str]:
    """What comes of so many tries of the program, with the default recorders."""
    counts: Counter[str] = Counter()
    if number:
        whole = root / "program"
        (root / "scene.toml").write_text(contactlab.load_scene("disc-on-block").with_(WHOLE_RUN).toml())
        if not whole.exists():
            subprocess.run(program(whole, whole), check=True)
    for count in range(number):
        came = tried(whole, root / "try", chance)
        counts[came if came in GOOD else "wrong"] += 1
        if came not in GOOD:
            say(f"{tried.__name__} {count}: {came}")
        shutil.rmtree(root / "try", ignore_errors=True)
    return counts


def _compared(whole: Path, folder: Path, good: str) -> str:
    if not same(everything(folder), everything(whole)):
        return "other numbers"
    for name in TABLES:
        if (whole / name).is_file() and (whole / name).read_bytes() != (folder / name).read_bytes():
            return f"{name} differs"
    return good


def comparisons(number: int, root: Path, chance: random.Random) -> Counter[str]:
    """Kill so many comparisons of one scene; what came of them."""
    counts: Counter[str] = Counter()
    if number:
        scene, whole = root / "small.toml", root / "comparison"
        scene.write_text(contactlab.load_scene("disc-on-block").with_(SMALL).toml())
        kill_comparison(scene, whole, whole, chance)
    for _ in range(number):
        counts[kill_comparison(scene, whole, root / "try", chance)] += 1
        shutil.rmtree(root / "try")
    return counts


def main() -> int:
    """Do it, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    for name, number in (
        ("kills", 80),
        ("early", 20),
        ("comparisons", 10),
        ("disks", 20),
        ("full", 20),
        ("damages", 400),
        ("seed", 1),
    ):
        parser.add_argument(f"--{name}", type=int, default=number)
    asked = parser.parse_args()
    print(f"seed {asked.seed}", flush=True)
    chance, counts = random.Random(asked.seed), {"kills": Counter(), "disks": Counter(), "damages": Counter()}
    root, fork_server = Path(tempfile.mkdtemp()), ForkServer()
    whole: dict[str, tuple[Any, Path, float]] = {}
    for name, changes in VARIANTS.items():
        if len(whole) == max(asked.kills, asked.disks, asked.damages):
            break  # fewer tries than kinds of runs
        scene = contactlab.load_scene("disc-on-block").with_({**SMALL, **changes})
        done = fork_server.run(scene, root / name)
        assert done.status == 0, f"{name} does not run by itself"
        whole[name] = scene, root / name, done.cpu
    for kind, number in (("kills", asked.kills), ("disks", asked.disks), ("damages", asked.damages)):
        for count in range(number):
            name = list(whole)[count % len(whole)]
            scene, place, cpu = whole[name]
            folder = root / "try"
            if kind == "kills":
                came = kill(fork_server, scene, place, cpu, folder, chance)
            elif kind == "disks":
                came = fill_disk(fork_server, scene, place, folder, chance)
            else:
                folder.mkdir()
                shutil.copy(place / "results.vtkhdf", folder)
                damage(folder / "results.vtkhdf", chance)
                came = outcome(folder, everything(place))
            counts[kind][came] += 1
            if not (count + 1) % 50:
                print(kind, dict(counts[kind]), flush=True)
            if came not in GOOD:
                print(f"{kind} {count}, {name}: {came}", flush=True)
            shutil.rmtree(folder)
        print(kind, dict(counts[kind]), flush=True)
    fork_server.close()
    for kind, number, tried in (("early", asked.early, stop_early), ("full", asked.full, fill_whole_disk)):
        counts[kind] = of_program(number, root, tried, chance, print)
        print(kind, dict(counts[kind]), flush=True)
    counts["comparisons"] = comparisons(asked.comparisons, root, chance)
    print("comparisons", dict(counts["comparisons"]), flush=True)
    shutil.rmtree(root)
    return int(any(came not in GOOD for counter in counts.values() for came in counter))


if __name__ == "__main__":
    sys.exit(main())
