"""A command of the `contactlab` program is found, called, and its exit status returned."""

from __future__ import annotations

import argparse
import atexit
import contextlib
import errno
import gc
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from importlib import import_module

from contactlab.commands.arguments import COMMANDS, make_parser
from contactlab.errors import ContactlabError, ContactlabWarning, RequestError, did_you_mean


def run_program(arguments: Sequence[str] | None) -> int:
    """Run the program with these words (by default of the command line); returns the exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if arguments is None and "_ARGCOMPLETE" in os.environ:
        from contactlab.commands.completion import complete

        complete(make_parser())
    if arguments is None:
        # the collector walks through what libraries make when they are imported, in vain: not before a start is
        # over, which makes 250 000 objects, and not once more when the interpreter ends, a seventh of a short run
        gc.set_threshold(500_000, 20, 20)
        atexit.register(gc.freeze)
        warnings.formatwarning = _worded
        # what the program starts looks for modules where this one does, and not in the folder it is called in
        os.environ["PYTHONSAFEPATH"] = "1"
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(AttributeError):  # a stream that was closed or replaced
                stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
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


_formatted = warnings.formatwarning


def _worded(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, line: str | None = None
) -> str:
    """A warning as the program prints it: ours name what they are about, others the line of code."""
    if issubclass(category, ContactlabWarning):
        return f"contactlab: warning: {message}\n"
    return _formatted(message, category, filename, lineno, line)


def _run(words: list[str]) -> int:
    if not words:
        make_parser().print_help(sys.stderr)
        return RequestError.exit_status
    if not words[0].startswith("-") and words[0] not in COMMANDS:
        return _plugin_command(words[0], words[1:])
    options = make_parser().read(words)
    module, _, function = options.handler.partition(":")
    handler: Callable[[argparse.Namespace], int] = getattr(import_module(module), function)
    return handler(options)


def _plugin_command(name: str, words: list[str]) -> int:
    from contactlab.commands.common import plugin_command
    from contactlab.parts.registry import default_registry

    registry = default_registry()
    commands = registry.commands()
    if name in commands:
        return plugin_command(name, *commands[name])(words)
    known = [*COMMANDS, *commands]
    hint = registry.reason_against(f"command {name}") or did_you_mean(name, known)
    raise RequestError("unknown command", got=name, allowed=", ".join(known), hint=hint)
