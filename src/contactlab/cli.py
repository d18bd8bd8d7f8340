"""The `contactlab` program: a command is found, called, and its exit status returned.

Exit status: 0 finished, 1 the simulation failed, 2 the request is wrong, 130 interrupted.
"""

from __future__ import annotations

import sys

from contactlab.run.interruption import interrupt_on_signals, unanswered

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program with these words (by default of the command line); returns the exit status."""
    if arguments is None:
        interrupt_on_signals()  # before all else is imported
    try:
        from contactlab.commands.program import run_program

        status = run_program(arguments)
    except KeyboardInterrupt:
        unanswered()
        return interrupted()
    return interrupted() if arguments is None and unanswered() else status


def interrupted() -> int:
    """Say it; gives the exit status."""
    print("contactlab: interrupted", file=sys.stderr)
    return 130


if __name__ == "__main__":
    sys.exit(main())
