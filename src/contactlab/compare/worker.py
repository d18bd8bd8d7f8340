"""The process at the other end of `pool.Worker`; imports the standard library alone.

Reads pickled (function, arguments) from standard input and writes pickled messages to standard
output: ("report", object) as often as the function likes, then ("done", result) or
("raised", text, traceback). It never imports the caller's script, so that a script without a
`__main__` guard may compare too.
"""

from __future__ import annotations

import os
import pickle
import sys
import traceback
from typing import IO, Any


def main() -> None:
    """Serve calls until standard input ends."""
    requests, answers = _take_pipes()
    try:
        sys.path[:] = receive(requests)
        while True:
            _serve_one(requests, answers)
    except (EOFError, KeyboardInterrupt, BrokenPipeError):
        return


def send(stream: IO[bytes], message: Any) -> None:
    """One pickled object, its length first."""
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


def _serve_one(requests: IO[bytes], answers: IO[bytes]) -> None:
    request = receive(requests)
    try:
        function, arguments = pickle.loads(request)
        result = function(*arguments, lambda message: send(answers, ("report", message)))
        answer: tuple[Any, ...] = ("done", result)
    except (KeyboardInterrupt, BrokenPipeError):
        raise
    except BaseException as error:
        answer = ("raised", f"{type(error).__name__}: {error}", traceback.format_exc())
    send(answers, answer)


if __name__ == "__main__":
    main()
