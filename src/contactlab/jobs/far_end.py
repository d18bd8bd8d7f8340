"""Worker process: serves calls one after another; imports the standard library alone.

A pipe in addition to the library's own queues carries reports to the caller, and the request to stop from it. Stopping
reaches the call as Ctrl-C does, whatever signals the process ignores: in the background it ignores Ctrl-C.
"""

from __future__ import annotations

import _thread
import atexit
import gc
import os
import pickle
import signal
import threading
import time
import traceback
from multiprocessing.connection import Connection
from typing import Any

STOP = "stop"
BEGUN = "begun"
"""Report of a call: the preparations of its process (imports, compilation) are done, and its time begins."""
WORN = "worn"
"""Report of a call that was interrupted at any point: its process serves no other."""
PROCESS, ENDED = "process", "ended"
PATIENCE = 30.0
"""Seconds that a call may take to stop in order if the caller is gone."""

_sending = threading.Lock()
_serving = threading.Event()
_stopped = threading.Event()
_pipe: Connection


def begin(pipe: Connection, errors: str) -> None:
    """Prepare the process: a session of its own, output into the file `errors`, and a thread that listens."""
    global _pipe
    _pipe = pipe
    if hasattr(os, "setsid"):
        os.setsid()  # Ctrl-C at the terminal reaches the caller alone
    output = os.open(errors, os.O_WRONLY | os.O_APPEND)
    os.dup2(output, 1)
    os.dup2(output, 2)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    atexit.register(gc.freeze)  # no search for garbage in a process that ends
    tell((PROCESS, os.getpid()))
    threading.Thread(target=_listen, daemon=True).start()


def tell(message: Any) -> None:
    """Send a message to the caller."""
    with _sending:
        _pipe.send(message)


def serve(call: bytes) -> tuple[Any, ...]:
    """Run a pickled call; returns ("done", result), ("raised", text, traceback) or ("stopped",)."""
    _serving.set()
    try:
        if _stopped.is_set():
            return ("stopped",)
        function, arguments = pickle.loads(call)
        return "done", function(*arguments, lambda message: tell(("report", message)))
    except KeyboardInterrupt:
        return ("stopped",)
    except BaseException as error:
        return "raised", f"{type(error).__name__}: {error}", traceback.format_exc()
    finally:
        _serving.clear()
        tell((ENDED, None))


def _listen() -> None:
    """Wait for the word to stop, or for the end of the caller."""
    try:
        while _pipe.recv() != STOP:
            pass
        _interrupt()
        _pipe.recv()
    except (EOFError, OSError):
        deadline = threading.Timer(PATIENCE, os._exit, args=(1,))
        deadline.daemon = True
        deadline.start()
        _interrupt()
        os._exit(0)


def _interrupt() -> None:
    """Raise Ctrl-C in the thread that serves a call, also if it sleeps; returns when the call has ended.

    Before a run has installed its own way to stop, compilers may swallow the signal, so it is repeated.
    """
    _stopped.set()
    heard = False
    while _serving.is_set():
        if not heard:
            heard = signal.getsignal(signal.SIGINT) is not signal.default_int_handler
            if hasattr(signal, "pthread_kill"):
                signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
            else:
                _thread.interrupt_main()
        for _ in range(10):
            if not _serving.is_set():
                return
            time.sleep(0.1)
