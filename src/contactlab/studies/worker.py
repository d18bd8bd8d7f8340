"""The process at the other end of `pool.Worker`; imports the standard library alone.

Reads pickled messages from standard input: the module path, then calls (the function and its arguments, pickled
apart), or `STOP`. Writes pickled messages to standard output: ("report", object) as often as the function likes, then
("done", result) or ("raised", text, traceback). It never imports the caller's script, so that a script without a
`__main__` guard may compare too.

A thread reads, so that a call under way can be told to stop. Being told comes to the call as Ctrl-C does, whatever this
process was told about signals when it was started: one in the background ignores Ctrl-C, for one.
"""

from __future__ import annotations

import atexit
import gc
import os
import pickle
import queue
import signal
import sys
import threading
import time
import traceback
from typing import IO, Any

STOP = "stop"
BEGUN = "begun"  # a report of a call that what its process had to do once is done: its time begins
WORN = "worn"  # a report of a call that was interrupted anywhere: its process serves no other
PATIENCE = 30.0  # s that a call may take to stop in order when the caller is gone


def main() -> None:
    """Serve calls until standard input ends."""
    atexit.register(gc.freeze)  # nobody looks for garbage in a process that ends
    requests, answers = _take_pipes()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    calls: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
    serving = threading.Event()
    try:
        sys.path[:] = receive(requests)
        threading.Thread(target=_listen, args=(requests, calls, serving), daemon=True).start()
        while (call := calls.get()) is not None:
            answer = _answer(call, answers)
            serving.clear()
            send(answers, answer)
    except (EOFError, KeyboardInterrupt, BrokenPipeError):
        return


def send(stream: IO[bytes], message: Any) -> None:
    """Write one pickled object to standard output, its length first."""
    data = pickle.dumps(message)
    stream.write(len(data).to_bytes(8, "little") + data)
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """The next object. Raises EOFError when the other side is gone."""
    return pickle.loads(_exactly(stream, int.from_bytes(_exactly(stream, 8), "little")))


def _exactly(stream: IO[bytes], size: int) -> bytes:
    data = stream.read(size)
    if len(data) < size:
        raise EOFError
    return data


def _take_pipes() -> tuple[IO[bytes], IO[bytes]]:
    """Keep the pipes for messages alone: whatever a part prints goes to standard error."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    return sys.stdin.buffer, answers


def _listen(requests: IO[bytes], calls: queue.SimpleQueue[bytes | None], serving: threading.Event) -> None:
    """Hand calls on, and stop what runs when that is said or when nobody is there any more to say it."""
    try:
        while True:
            message = receive(requests)
            if message == STOP:
                _interrupt(serving)
            else:
                serving.set()
                calls.put(message)
    except EOFError:
        calls.put(None)
        deadline = threading.Timer(PATIENCE, os._exit, args=(1,))
        deadline.daemon = True
        deadline.start()
        _interrupt(serving)


def _interrupt(serving: threading.Event) -> None:
    """Ctrl-C for the thread that serves a call, also where it sleeps.

    Before a run has its own way to stop, compilers may swallow it: it is repeated until it is heard.
    """
    while serving.is_set():
        heard = signal.getsignal(signal.SIGINT) is not signal.default_int_handler
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        if heard:
            return
        time.sleep(1.0)


def _answer(call: bytes, answers: IO[bytes]) -> tuple[Any, ...]:
    try:
        function, arguments = pickle.loads(call)
        return "done", function(*arguments, lambda message: send(answers, ("report", message)))
    except (KeyboardInterrupt, BrokenPipeError):
        raise
    except BaseException as error:
        return "raised", f"{type(error).__name__}: {error}", traceback.format_exc()


if __name__ == "__main__":
    main()
