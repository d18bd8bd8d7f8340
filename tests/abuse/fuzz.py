"""Scenes, files, words, calls and stored runs that are wrong or strange: each must work, or be refused in words.

    python tests/abuse/fuzz.py [--cases N] [--seed S] [--seconds S]

Prints the seed, what was wrong, and counts; exit status 1 where there was a traceback, a hang over 10 s, memory beyond
the estimate, other numbers in silence, or a refusal without key, what was got and what is allowed.
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import json
import random
import resource
import shutil
import signal
import statistics
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

sys.path[:0] = [str(Path(__file__).parent)]

from damages import damage, everything, outcome  # noqa: E402
from strange_calls import call, program  # noqa: E402
from strange_scenes import BRIEF, Scenes  # noqa: E402

from contactlab.api.compiled.compiler import COMPILATION  # noqa: E402
from contactlab.errors import RequestError  # noqa: E402
from contactlab.meshing import room  # noqa: E402
from contactlab.model import sizes  # noqa: E402
from contactlab.model.model_size import MODEL  # noqa: E402
from contactlab.results.peak_memory import peak_memory_mib, reset_peak  # noqa: E402
from contactlab.run.simulation import simulate  # noqa: E402
from contactlab.scene.scene import Scene, load_scene  # noqa: E402

HANG = 10.0  # s of processor time, without compilation
STEPS = 20  # a run that has made so many has shown that its scene works
WORK = 25  # steps and iterations after which a run is stopped
MACHINE = 16.0 * 2**20  # bytes of the machine that scenes are told: larger ones must be refused by their estimate
LARGER_MACHINE = 64.0 * 2**20
ROOM = 2**30  # bytes that the process may take beside what it has: more ends in a MemoryError, which is seen
OVERHEAD = MODEL / 2.0**20  # MiB that any case may take, one that is refused while it is read, too
LARGE_WORK = 4  # of large scenes: they have taken their memory by then
SHARES = {
    "large scene": 0.01, "mild scene": 0.08, "keys": 0.25, "text": 0.25, "words": 0.13, "file beside": 0.1,
    "program": 0.06,
    "call": 0.09, "stored run": 0.03,
}  # fmt: skip
RAN = {"ran", "past 20 steps"}
GOOD = RAN | {"refused", "as before", "told", "told, some salvaged"}
BEYOND = "beyond the estimate"
MEASURED = sys.platform == "linux"  # elsewhere a peak is that of the process since it began


class Hung(BaseException):
    """A case took too long."""


class Fuzz:
    """What is tried, by kind, and what came of it. `chance` decides all."""

    def __init__(self, seed: int, folder: Path, few: bool, machine: float) -> None:
        self.chance, self.folder, self.scenes = random.Random(seed), folder, Scenes(few)
        self.machine, self.estimate = machine, 0.0
        self.counts: dict[str, Counter[str]] = {kind: Counter() for kind in SHARES}
        self.bad: list[str] = []
        self.used: dict[str, list[float]] = {kind: [] for kind in SHARES}  # peak of memory over its estimate
        warnings.simplefilter("ignore")
        simulate(
            self.scenes.bases["explicit"].with_({"record.recorders": ["vtkhdf"], "record.frames": 4}), folder / "run"
        )
        self.whole = everything(folder / "run")

    def one(self) -> None:
        """One case of a random kind."""
        kind = self.chance.choices(list(SHARES), list(SHARES.values()))[0]
        case = self.folder / "case"
        case.mkdir()
        came, words = self._timed(kind, case)
        shutil.rmtree(case)
        self.counts[kind][came] += 1
        if came not in GOOD:
            self.bad.append(f"{kind}: {came}: {words}")

    def _timed(self, kind: str, case: Path) -> tuple[str, str]:
        began, compiled = time.process_time(), COMPILATION.seconds

        def over(number: int, frame: Any) -> None:
            spent = time.process_time() - began - (COMPILATION.seconds - compiled)
            if spent > HANG:
                raise Hung
            signal.setitimer(signal.ITIMER_PROF, HANG - spent + 0.1)

        before = signal.signal(signal.SIGPROF, over)
        signal.setitimer(signal.ITIMER_PROF, HANG)
        try:
            if kind in ("stored run", "program"):
                return self._stored(case) if kind == "stored run" else self._told(lambda: program(case, self.chance))
            return self._called(case) if kind == "call" else self._scene(kind, case)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
            signal.signal(signal.SIGPROF, before)

    def _scene(self, kind: str, case: Path) -> tuple[str, str]:
        name, changes = "", {}
        if kind == "text":
            path = self.scenes.text(case, self.chance)

            def make() -> Scene:
                return load_scene(path).with_(BRIEF)

        else:

            def make() -> Scene:
                return self.scenes.bases[name].with_(changes)

            if kind == "words":
                try:
                    name, changes = self.scenes.words(self.chance)
                except RequestError as error:
                    return refusal(error)
            elif kind == "file beside":
                name, changes = self.scenes.beside(case, self.chance)
            elif kind == "large scene":
                name, changes = self.scenes.large(self.chance, self.machine)
            else:
                name, changes = (self.scenes.mild if kind == "mild scene" else self.scenes.keys)(self.chance)
        work = LARGE_WORK if kind == "large scene" else WORK
        came, words = self._measured(kind, make, work)
        if came == BEYOND:  # what libraries and kernels take at their first use is there by now
            came, words = self._measured(kind, make, work)
        if came in GOOD:
            return came, ""
        kept = " ".join(path.read_text(errors="replace")[:3000] for path in case.iterdir() if path.is_file())
        return came, f"{name} {str(changes)[:1000]}\n    {words[:400]}" + (f"\n    {kept}" if kept else "")

    def _called(self, case: Path) -> tuple[str, str]:
        made, words = call(self.scenes.bases["explicit"], case, self.chance)

        def called() -> tuple[str, str]:
            made()
            return "ran", ""

        came, told = self._told(called)
        return came, f"{words}\n    {told[:400]}"

    def _told(self, tried: Callable[[], tuple[str, str]]) -> tuple[str, str]:
        """What came of it, or how it was refused."""
        try:
            return tried()
        except RequestError as error:
            return refusal(error)
        except Hung:
            return "over 10 s", ""
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            return "traceback", f"{type(error).__name__}: {str(error)[:300]} ({Path(last.filename).name}:{last.lineno})"

    def _measured(self, kind: str, make: Callable[[], Scene], work: int) -> tuple[str, str]:
        """What comes of a scene, and whether it takes more memory than was estimated, refused ones included."""
        gc.collect()  # what an earlier case left would make this one look smaller
        reset_peak()
        before, self.estimate = resident_mib(), 0.0
        came, words = self._told(lambda: self._run(make, work))
        took = peak_memory_mib() - before
        if not MEASURED or came not in GOOD:
            return came, words
        # what does not fit is not begun
        allowed = max(OVERHEAD, self.estimate if self.estimate < self.machine / 2.0**20 else 0.0)
        if took > allowed:
            return BEYOND, f"{took:.1f} MiB, estimate {self.estimate:.1f} MiB; {came}: {words}"
        if came in RAN:
            self.used[kind].append(took / allowed)
        return came, words

    def _run(self, make: Callable[[], Scene], work: int) -> tuple[str, str]:
        scene = make()
        self.estimate = sizes.estimated_bytes(scene, scene.registry) / 2.0**20
        results = simulate(scene, work=work)
        cells = {body.name: len(body.cells) for body in results.layout.bodies}  # a mesh file does not say them before
        self.estimate = sizes.estimated_bytes(scene, scene.registry, cells) / 2.0**20
        return ("past 20 steps" if int(results.summary["steps"]) >= STEPS else "ran"), results.status

    def _stored(self, case: Path) -> tuple[str, str]:
        shutil.copytree(self.folder / "run", case / "run")
        file = self.chance.choice(sorted(path for path in (case / "run").rglob("*") if path.is_file()))
        way = f"{file.name}, {damage(file, self.chance)}" if file.stat().st_size else f"{file.name}, untouched"
        try:
            return outcome(case / "run", self.whole), way
        except Hung:
            return "over 10 s", way


def refusal(error: RequestError) -> tuple[str, str]:
    """Whether a refusal says where, what was got and what is allowed."""
    told = str(error)
    whole = str(error.where) and "  got " in told and "  allowed " in told
    return ("refused" if whole else "refused without key, got or allowed"), told


def resident_mib() -> float:
    """MiB of this process in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize() / 2.0**20 if MEASURED else 0.0


@contextmanager
def freed_is_given_back() -> Iterator[None]:
    """While it is entered, the C library keeps no freed memory (it may keep 64 MiB): what is measured is in use."""
    library = ctypes.CDLL(None)
    if not MEASURED or not hasattr(library, "mallopt"):
        yield
        return
    trim_threshold, mmap_threshold = -1, -3  # of malloc.h; any value ends their growth, so the largest stand for it
    for size in (trim_threshold, mmap_threshold):
        library.mallopt(size, 128 * 1024)
    try:
        yield
    finally:
        library.mallopt(trim_threshold, 64 * 2**20)
        library.mallopt(mmap_threshold, 32 * 2**20)


def limit_memory() -> None:
    """Let this process have no more than `ROOM` bytes beside what it has now."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + ROOM, resource.RLIM_INFINITY))


def fuzz(cases: int, seed: int, seconds: float, say: Any, few: bool, machine: float) -> Fuzz:
    """Try so many cases, or for so many seconds of processor time without compilation."""
    began = time.process_time() - COMPILATION.seconds
    gc.freeze()  # each run looks for garbage: not among what is here already
    with tempfile.TemporaryDirectory() as folder, freed_is_given_back():
        tried = Fuzz(seed, Path(folder), few, machine)
        for number in range(1, cases + 1):
            told = len(tried.bad)
            tried.one()
            for words in tried.bad[told:]:
                say(f"case {number}, {words}")
            spent = time.process_time() - COMPILATION.seconds - began
            if not number % 250:
                say(f"{number} cases, {spent:.0f} s")
            if spent > seconds:
                break
    gc.unfreeze()
    return tried


def main() -> int:
    """Do it, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=15_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=3600.0, help="of processor time")
    parser.add_argument("--quick", action="store_true", help="of one scene alone")
    parser.add_argument("--json", action="store_true", help="print what came of it for programs, as the last line")
    asked = parser.parse_args()
    print(f"seed {asked.seed}", flush=True)
    machine = MACHINE if asked.quick else LARGER_MACHINE
    for base in Scenes(asked.quick).bases.values():
        simulate(base, work=2)  # libraries and kernels take room, too
    sizes.machine_memory = room.machine_memory = lambda: machine
    if sys.platform == "linux":
        limit_memory()
    tried = fuzz(asked.cases, asked.seed, asked.seconds, partial(print, flush=True), asked.quick, machine)
    for kind, counts in tried.counts.items():
        print(f"{kind}: {dict(counts)}")
    for kind, used in tried.used.items():
        if used:
            of = f"{statistics.median(used):.2f} (median), {max(used):.2f} (most)"
            print(f"{kind}: peak of memory over its estimate {of}")
    if asked.json:
        print(json.dumps({"bad": tried.bad, "counts": tried.counts, "used": tried.used}))
    return int(bool(tried.bad))


if __name__ == "__main__":
    sys.exit(main())
