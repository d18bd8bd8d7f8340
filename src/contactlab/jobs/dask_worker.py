"""Worker side of a dask cluster: each call goes to a process of its own, as on one machine.

A call that crashes or hangs then costs neither the worker nor the other calls. If the worker does not see the folder
that the call is to write, or has to write elsewhere (`CONTACTLAB_SCRATCH`), the files come back with the answer.
"""

from __future__ import annotations

import io
import os
import pickle
import tarfile
from collections.abc import Callable
from multiprocessing import current_process
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from typing import Any

from contactlab.jobs.processes import Call, Process, ProcessDiedError, RaisedError, StoppedError, TimedOutError

SCRATCH = "CONTACTLAB_SCRATCH"

_lock = Lock()
_idle: list[Process] = []
_busy: dict[str, list[Process]] = {}
_stopped: set[str] = set()

Answer = tuple[str, Any, bytes]
"""End of a call ("done", "raised", "died", "timed-out", "stopped"), what it gave, and its files."""


def call(pool: str, content: bytes, limit: float | None, folder: Path | None, token: Path | None) -> Answer:
    """Serve one call of `pool`: `content` is the pickled pair of function and arguments.

    folder  written by the call, one of its arguments; `token` is a file that whoever shares the caller's disk sees.
    """
    function, arguments = pickle.loads(content)
    if folder is None or (SCRATCH not in os.environ and token is not None and token.exists()):
        return (*_serve(pool, function, arguments, limit), b"")
    with TemporaryDirectory(dir=os.environ.get(SCRATCH)) as scratch:
        here = Path(scratch) / folder.name
        kind, result = _serve(pool, function, tuple(here if a == folder else a for a in arguments), limit)
        # the files that the call left, as one archive
        file = io.BytesIO()
        with tarfile.open(fileobj=file, mode="w:gz", compresslevel=1) as packed:
            for path in sorted(here.rglob("*")) if here.is_dir() else ():
                if path.is_file():
                    packed.add(path, path.relative_to(here).as_posix())
        return kind, result, file.getvalue()


def _serve(pool: str, function: Callable[..., Any], arguments: tuple[Any, ...], limit: float | None) -> tuple[str, Any]:
    from distributed import get_worker

    topic, there = topic_of(pool), get_worker()
    key = there.get_current_task()
    with _lock:
        if pool in _stopped:
            return "stopped", None
        process = _idle.pop() if _idle else _started()
        _busy.setdefault(pool, []).append(process)
    there.log_event(topic, (key, None))
    wanted = Call(function, arguments, lambda message: there.log_event(topic, (key, message)), limit)
    try:
        return "done", process.call(wanted)
    except RaisedError as error:
        return "raised", (str(error), error.details)
    except TimedOutError as error:
        return "timed-out", (limit, error.result)
    except StoppedError:
        return "stopped", None
    except ProcessDiedError as error:
        return "died", str(error)
    finally:
        with _lock:
            _busy[pool].remove(process)
            if process.used_up:
                process.close()
            else:
                _idle.append(process)


def _started() -> Process:
    """A process of this worker, which under a nanny is a daemon and may start none unless the flag is changed."""
    current_process()._config["daemon"] = False  # type: ignore[attr-defined]
    return Process()


def topic_of(pool: str) -> str:
    """Topic on which the calls of a pool report: that they have begun (None), and their own messages."""
    return f"contactlab-{pool}"


def stop(pool: str) -> None:
    """Begin no further call of this pool, and stop running calls in order."""
    with _lock:
        _stopped.add(pool)
        for worker in _busy.get(pool, ()):
            worker.stop()


def kill(pool: str) -> None:
    """Begin no further call of this pool, and kill running calls."""
    with _lock:
        _stopped.add(pool)
        for worker in _busy.get(pool, ()):
            worker.kill()


def close() -> None:
    """End the processes that serve no call."""
    with _lock:
        while _idle:
            _idle.pop().close()


def unpack(files: bytes, folder: Path) -> None:
    """Write the files that came back into `folder`; none can land outside it."""
    if not files:
        return
    folder.mkdir(parents=True, exist_ok=True)
    with tarfile.open(fileobj=io.BytesIO(files), mode="r:gz") as packed:
        packed.extractall(folder, filter="data")
