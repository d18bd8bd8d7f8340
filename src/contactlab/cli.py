"""The `contactlab` program: `contactlab NAME` calls the function NAME of `contactlab/commands/NAME.py`.

Exit status: 0 finished, 1 the simulation failed, 2 the request is wrong, 130 interrupted.
"""

from __future__ import annotations

import sys

from contactlab.run.interruption import interrupt_on_signals, unanswered

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program with these words (by default of the command line); returns the exit status."""
    if arguments is None:
        interrupt_on_signals()  # before all else is imported
    try:
        if arguments is None:
            _prepare_process()
        status = _answered(list(sys.argv[1:] if arguments is None else arguments))
    except KeyboardInterrupt:
        unanswered()
        return interrupted()
    return interrupted() if arguments is None and unanswered() else status


def interrupted() -> int:
    """Say it; gives the exit status."""
    print("contactlab: interrupted", file=sys.stderr)
    return 130


def _prepare_process() -> None:
    """Set up a process that is the program's own."""
    import atexit
    import contextlib
    import gc
    import os
    import warnings

    if "_ARGCOMPLETE" in os.environ:
        from contactlab.commands.arguments import make_parser
        from contactlab.commands.completion import complete

        complete(make_parser())
    # the collector walks through what libraries make when they are imported, in vain: not before a start is
    # over, which makes 250 000 objects, and not once more when the interpreter ends, a seventh of a short run
    gc.set_threshold(500_000, 20, 20)
    atexit.register(gc.freeze)
    warnings.formatwarning = _worded(warnings.formatwarning)
    # what the program starts looks for modules where this one does, and not in the folder it is called in
    os.environ["PYTHONSAFEPATH"] = "1"
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError):  # a stream that was closed or replaced
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]


def _worded(formatted: Callable[..., str]) -> Callable[..., str]:
    """Return a function that words warnings: ours name what they are about, others (`formatted`) the line of code."""
    from contactlab.errors import ContactlabWarning

    def worded(message: Warning | str, category: type[Warning], *place: object) -> str:
        if issubclass(category, ContactlabWarning):
            return f"contactlab: warning: {message}\n"
        return formatted(message, category, *place)

    return worded


def _answered(words: list[str]) -> int:
    """Run the command; errors that a user can mend become messages."""
    import errno
    import os

    from contactlab.errors import ContactlabError, RequestError

    try:
        status = _run(words)
        sys.stdout.flush()
    except ContactlabError as error:
        print(f"contactlab: {error}", file=sys.stderr)
        return error.exit_status
    except BrokenPipeError:
        # the reader of our output has gone; nobody is left to read a message
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        if error.errno != errno.ENAMETOOLONG:
            raise
        told = RequestError("no file can have this name", where=words[0], got=error.filename, allowed="up to 255 bytes")
        print(f"contactlab: {told}", file=sys.stderr)
        return told.exit_status
    return status


def _run(words: list[str]) -> int:
    from importlib import import_module

    from contactlab.commands.arguments import COMMANDS, make_parser
    from contactlab.errors import RequestError

    if not words:
        make_parser().print_help(sys.stderr)
        return RequestError.exit_status
    if not words[0].startswith("-") and words[0] not in COMMANDS:
        return _plugin_command(words[0], words[1:])
    options = make_parser().read(words)
    name = options.command.replace("-", "_")
    status: int = getattr(import_module(f"contactlab.commands.{name}"), name)(options)
    return status


def _plugin_command(name: str, words: list[str]) -> int:
    from contactlab.commands.arguments import COMMANDS
    from contactlab.commands.common import plugin_command
    from contactlab.errors import RequestError, did_you_mean
    from contactlab.parts.registry import default_registry

    registry = default_registry()
    commands = registry.commands()
    if name in commands:
        return plugin_command(name, *commands[name])(words)
    known = [*COMMANDS, *commands]
    hint = registry.reason_against(f"command {name}") or did_you_mean(name, known)
    raise RequestError("unknown command", got=name, allowed=", ".join(known), hint=hint)


if __name__ == "__main__":
    sys.exit(main())
