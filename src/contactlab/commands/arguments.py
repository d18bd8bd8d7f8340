"""Commands of the core and what can be typed after each.

`contactlab new-scene` calls `contactlab.commands.new_scene.new_scene`, and so on; it is imported when it is called, so
that a command loads what it needs alone.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from contactlab import __version__
from contactlab.commands.command_line import CommandLine


def positive(text: str) -> int:
    """A whole number of at least 1."""
    number = _whole(text)
    if number is None or number < 1:
        raise argparse.ArgumentTypeError(f"got {text[:40]}, allowed: a whole number >= 1")
    return number


def _whole(text: str) -> int | None:
    """The whole number that is written; None for other text and for more than 18 digits."""
    digits = text.strip().removeprefix("+")
    return int(digits) if digits.isdecimal() and len(digits) <= 18 else None


def share(text: str) -> float:
    """An error below 1: a fraction, or a percentage such as 1%."""
    try:
        number = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        number = 0.0
    if not 0.0 < number < 1.0:
        raise argparse.ArgumentTypeError(f"got {text}, allowed: an error such as 1% or 0.01, below 1")
    return number


def seconds(text: str) -> float:
    """A time above 0; the unit s may be added."""
    try:
        number = float(text.removesuffix("s"))
    except ValueError:
        number = 0.0
    if not 0.0 < number < float("inf"):
        raise argparse.ArgumentTypeError(f"got {text}, allowed: seconds, above 0")
    return number


def step(text: str) -> int:
    """A whole number of at least 0."""
    number = _whole(text)
    if number is None:
        raise argparse.ArgumentTypeError(f"got {text[:40]}, allowed: a whole number >= 0")
    return number


Describe = Callable[[Any], object]
"""Adds its words and options to a command."""


class Command(NamedTuple):
    """Help text of a command, and its words and options."""

    text: str
    words: Sequence[Describe]


class _Program(CommandLine):
    """The parser of the whole program, whose help groups the commands."""

    def format_help(self) -> str:
        """Return the help, a line per command."""
        lines = [f"{self.format_usage()}\n{self.description}\n"]
        for title, commands in GROUPS.items():
            lines.append(f"\n{title}:\n")
            lines += [f"  {name:<14}{command.text}\n" for name, command in commands.items()]
        return f"{''.join(lines)}\n{self.epilog}\n"


def make_parser() -> CommandLine:
    """Make the parser of the program with all commands of the core."""
    parser = _Program(
        prog="contactlab",
        description="Compare finite-element contact algorithms in 2D: accuracy, cost, failures.",
        epilog="SCENE is a bundled name or a TOML file. Options of a command: contactlab COMMAND --help.\n"
        "Plugins may add commands: contactlab parts. Exit status: 0 finished, 1 the\n"
        "simulation failed, 2 wrong request, 130 interrupted.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"contactlab {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True, parser_class=CommandLine)
    for name, (text, words) in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".", allow_abbrev=False)
        command.set_defaults(command=name)
        for describe in words:
            describe(command)
    return parser


def _word(*names: str, **more: Any) -> Describe:
    return lambda command: command.add_argument(*names, **more)


def _flag(*names: str, text: str) -> Describe:
    return _word(*names, action="store_true", help=text)


def _list(name: str, dest: str | None = None, **more: Any) -> Describe:
    """An option that may be given several times."""
    return _word(name, action="append", default=[], **({"dest": dest} if dest else {}), **more)


def _amount(command: Any) -> None:
    """Add the options on how much is printed."""
    group = command.add_mutually_exclusive_group()
    group.add_argument("-q", "--quiet", action="store_true", help="print failures and warnings only")
    group.add_argument("-v", "--verbose", action="store_true", help="print every number of the result")
    command.add_argument("--profile", action="store_true", help="print times by phase")


FILES = _list("--with", dest="files", metavar="FILE.py", help="also use the parts in this file")
JSON = _flag("--json", text="print JSON instead of tables")
OUT = _word("--out", metavar="DIR", help="folder for the results (default: a new one under runs/)")
SET = _list(
    "--set", dest="settings", metavar="KEY=VALUE",
    help="change a key of the scene: contacts.0.algorithm=mortar-p1, level=2",
)  # fmt: skip
SCENE = (_word("scene", metavar="SCENE", help="name of a bundled scene, or TOML file"), SET, FILES)
MANY = (
    OUT,
    _flag(
        "--resume",
        text="resume in DIR: finished runs are kept, interrupted ones continued, damaged records made again",
    ),
    _word(
        "--time-limit", type=seconds, metavar="S",
        help="wall time of one run without compilation; a longer one is `timed-out`",
    ),
    _word("--jobs", type=positive, metavar="N", help="runs at a time (default: one per core)"),
    _word(
        "--scheduler", default="local", metavar="WHERE",
        help="local; dask: a cluster on this machine; tcp://HOST:PORT: a running dask scheduler",
    ),
)  # fmt: skip
"""Options of all commands that make many runs, with one meaning."""

EVERYDAY = {
    "run": Command(
        "run one scene",
        (*SCENE, OUT, _flag("--resume", text="resume the interrupted run in DIR"), JSON, _amount),
    ),
    "compare": Command(
        "run every combination of values: accuracy against cost", (
            _word("scene", metavar="SCENE-or-STUDY", help="bundled name, or TOML file of a scene or study"),
            _list("--vary", metavar="KEY=[V1, V2]", help="values to combine; replaces a study's own"),
            _flag("--effects", text="leave out each effect in turn: its cost and its influence"),
            SET, FILES, *MANY,
            _flag("--quick", text="study of cases: a few of them, in three CPU minutes"),
            _word(
                "--reference", metavar="NAME",
                help="compare pressures with this: a name, a JSON or CSV file, or finest",
            ),
            _word("--repeat", type=positive, metavar="N", help="runs of each combination; costs are medians"),
            _word(
                "--keep", choices=("all", "failed", "none"), default="all",
                help="runs whose results.vtkhdf and recordings are kept (default: all)",
            ),
            JSON, _amount,
        ),
    ),
    "plot": Command(
        "draw force curves, pressures, stresses or an animation", (
            _word("path", metavar="DIR", help="folder of a run or a comparison"),
            _word(
                "what", choices=("force", "pressure", "stress", "animation"),
                help="force against displacement, pressure along the slave, a field on the bodies, or its animation",
            ),
            _word("--out", metavar="FILE", help=".png, .svg, .pdf; .gif, .mp4 (default: in DIR)"),
            _word("--on", metavar="NAME", help="force: a support or contact; pressure: a contact"),
            _word("--component", choices=("x", "y", "magnitude"), help="of the force (default: along the motion)"),
            _word("--field", default="von_mises", metavar="NAME", help="field to draw (default: von_mises)"),
            _word("--frame", type=step, metavar="N", help="stored frame of stress (default: the last one)"),
            _word(
                "--stride", type=positive, default=1, metavar="N", help="animation: every Nth frame (default: 1)"
            ),
            _flag("--flat", text="one colour per cell instead of nodal averages"),
            _word("--runs", nargs="+", metavar="NAME", default=[], help="runs of a comparison (default: all)"),
        ),
    ),
    "view": Command(
        "open the timeline in the viewer, or save a picture", (
            _word("path", metavar="DIR-or-RRD", help="folder of a run or a comparison, or a recording"),
            _word("--png", metavar="FILE", help="write a picture; needs no display"),
            _word("--panel", default="", metavar="NAME", help="show one panel only: part of its name"),
            _word(
                "--runs", nargs="+", metavar="NAME", default=[],
                help="runs of a comparison to show (default: all up to 12, else the first of each algorithm)",
            ),
            _word("--step", type=step, metavar="N", help="the step of the picture (default: the last one)"),
            _word("--iteration", type=step, metavar="N", help="the Newton iteration of the picture, counted from 1"),
        ),
    ),
    "scenes": Command(
        "list the bundled scenes, or print one", (
            _word("scene", nargs="?", metavar="NAME", help="print this one (default: list all)"),
            _flag("--schema", text="print the JSON schema of scenes, for editors"), JSON, FILES,
        ),
    ),
    "new-scene": Command(
        "write a scene of your own, starting from another", (
            _word("name", metavar="NAME", help="name of the new scene; NAME.toml is written"),
            _word(
                "--from", required=True, dest="source", metavar="SCENE",
                help="scene to start from: bundled name or TOML file",
            ),
            FILES,
        ),
    ),
    "runs": Command(
        "list result folders, or remove some", (
            _word("folders", nargs="*", metavar="DIR", help="folders to look through (default: runs)"),
            _word(
                "--remove", nargs="+", metavar="NAME", default=[],
                help="remove these folders: names or patterns such as 'disc-*', or failed",
            ),
            _flag("--yes", text="remove without asking"), JSON,
        ),
    ),
    "cite": Command(
        "print what to cite for a run or a scene", (
            _word("path", metavar="RUN-or-SCENE", help="folder of a run or a comparison; a scene's name or TOML file"),
            _flag("--bibtex", text="print BibTeX entries for program, scene and parts"), FILES, JSON,
        ),
    ),
}  # fmt: skip
AUTHORS = {
    "new-plugin": Command(
        "write a package with a working part, its tests and its metadata", (
            _word(
                "kind", metavar="KIND", help="kind of part: contact, material, integrator ... (contactlab parts)"
            ),
            _word("name", metavar="NAME", help="name of part and package: my-contact; a folder is written"),
            _word(
                "--from", dest="start", default="", metavar="WAY",
                help="way to write a contact: mortar (default), node-on-segment or points, energy, by formulas; rows, "
                "potential, in NumPy",
            ),
            _flag("--with-ci", text="add a workflow that runs the checks at every push"),
        ),
    ),
    "check": Command(
        "validate a plugin: unit tests, benchmarks, timing", (
            _word(
                "target", metavar="NAME-or-FILE", help="name of a part, Python file, folder, or installed distribution"
            ),
            _word("--kind", default="", metavar="KIND", help="only parts of this kind"),
            _list(
                "--set", dest="settings", metavar="FIELD=VALUE",
                help="value of a field of the part; fields without a default get usual values",
            ),
            _list("--only", metavar="CHECK", help="run this check only; may be repeated"),
            FILES, JSON,
            _word("--card", metavar="DIR", help="write the results as card.json and card.md"),
            _flag("--python", text="run formulas as plain Python in the unit checks, and count their lines"),
        ),
    ),
    "parts": Command(
        "list the parts of all plugins and broken ones, or describe one",
        (_word("name", nargs="?", metavar="NAME", help="describe this part (default: list all)"), JSON, FILES),
    ),
}  # fmt: skip
LABORATORY = {
    "matrix": Command(
        "judge contact algorithms on benchmark cases with known solutions", (
            _word("cases", nargs="*", metavar="CASE", help="names of cases (default: all; contactlab parts)"),
            _list(
                "--contact", dest="contacts", metavar="NAME",
                help="judge this method (default: all): ALGORITHM [FIELD=VALUE] [+ ENFORCEMENT]",
            ),
            _flag("--full", text="all variants of each case, either slave, all its elements and integrators"),
            _list(
                "--level", dest="levels", type=positive, metavar="N",
                help="mesh level, several times for orders of convergence (default: 1)",
            ),
            _flag("--margins", text="how far each case can be driven before it fails a criterion"),
            _word("--against", metavar="FILE", help="an earlier matrix.csv: exit status 1 if a cell is worse"),
            FILES, *MANY, JSON,
        ),
    ),
    "choose": Command(
        "find the cheapest configuration that meets an error", (
            *SCENE,
            _word("--error", type=share, default=0.01, metavar="E", help="target error (default: 1%%)"),
            _word("--budget", type=seconds, default=60.0, metavar="S", help="CPU time of a run (default: 60s)"),
            _word("--search", type=seconds, default=120.0, metavar="S", help="CPU time of trials (default: 120s)"),
            _flag("--run", text="run the chosen configuration"), *MANY, JSON,
        ),
    ),
    "error-budget": Command(
        "split the error of a run: mesh, step, ramp, damping, tolerance", (*SCENE, *MANY, JSON)
    ),
    "explain": Command(
        "print what a scene uses and its cost estimate", (
            *SCENE,
            _word(
                "--all", action="store_true", dest="everything",
                help="every effect, part, call, kernel, array and module",
            ),
            _flag("--effects", text="also try the scene without each effect, and print the cost of each"), JSON,
        ),
    ),
    "archive": Command(
        "list, merge or export archived runs", (
            _word("action", choices=("list", "merge", "export"), help="merge A B copies all of B into A"),
            _word("paths", nargs="*", metavar="ARCHIVE", help="archive.sqlite or its folder (default: here)"),
        ),
    ),
}  # fmt: skip
SHELLS = ("bash", "zsh", "fish", "powershell")
INSTALLATION = {
    "doctor": Command("check the installation by a contact step", (JSON,)),
    "completion": Command(
        "print the shell code that completes commands and keys",
        (_word("shell", choices=SHELLS, help="the shell you type in"),),
    ),
}  # fmt: skip
GROUPS: dict[str, dict[str, Command]] = {
    "everyday": EVERYDAY, "for authors of plugins": AUTHORS, "laboratory": LABORATORY, "this installation": INSTALLATION
}  # fmt: skip
"""Commands of the core as the help groups them."""

COMMANDS: dict[str, Command] = {name: command for group in GROUPS.values() for name, command in group.items()}
