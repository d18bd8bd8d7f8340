"""Commands of the core and what can be typed after each.

The functions behind them are named here and imported when they are called, so that a command loads what it needs alone.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

from contactlab import __version__
from contactlab.commands.command_line import CommandLine
from contactlab.commands.typed_values import positive, seconds, share, step


def make_parser() -> CommandLine:
    """Make the parser of the program with all commands of the core."""
    parser = CommandLine(
        prog="contactlab",
        description="A bench for finite-element contact algorithms.",
        epilog="SCENE is the name of a bundled scene or a TOML file. Plugins may add commands: contactlab parts.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"contactlab {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name, (describe, text, handler) in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".", allow_abbrev=False)
        command.set_defaults(handler=handler)
        describe(command)
    return parser


def _describe_run(command: argparse.ArgumentParser) -> None:
    _add_scene(command)
    _add_out(command)
    command.add_argument("--resume", action="store_true", help="go on with the interrupted run in DIR")
    _add_json(command)


def _describe_compare(command: argparse.ArgumentParser) -> None:
    command.add_argument("scene", metavar="SCENE-or-STUDY", help="bundled name, or TOML file of a scene or study")
    command.add_argument(
        "--vary", action="append", default=[], metavar="KEY=[V1, V2]", help="values to combine; replaces a study's own"
    )
    command.add_argument(
        "--effects", action="store_true", help="take out each effect of the scene in turn: what it costs and changes"
    )
    _add_changes(command)
    _add_out(command)
    command.add_argument("--resume", action="store_true", help="go on with the comparison in DIR; what is over stays")
    command.add_argument(
        "--time-limit", type=seconds, metavar="S", help="wall time for one run; one over it is a row `timed-out`"
    )
    _add_jobs(command, "runs")
    command.add_argument("--quick", action="store_true", help="of a study of cases: a few of them in three CPU minutes")
    command.add_argument(
        "--reference",
        metavar="NAME",
        help="measure pressures against this one: a name, a JSON or CSV file, finest",
    )
    command.add_argument("--repeat", type=positive, metavar="N", help="runs of each combination; costs are medians")
    command.add_argument(
        "--keep", choices=("all", "failed", "none"), default="all",
        help="whose results.vtkhdf and recordings stay (default: all)",
    )  # fmt: skip
    _add_json(command)
    _add_scheduler(command)


def _describe_choose(command: argparse.ArgumentParser) -> None:
    _add_scene(command)
    command.add_argument("--error", type=share, default=0.01, metavar="E", help="that it must meet (default: 1%%)")
    command.add_argument("--budget", type=seconds, default=60.0, metavar="S", help="CPU time of a run (default: 60s)")
    command.add_argument("--search", type=seconds, default=120.0, metavar="S", help="of all trials (default: 120s)")
    command.add_argument("--run", action="store_true", help="run what was chosen")
    _add_jobs(command, "trials")
    _add_out(command)
    command.add_argument("--resume", action="store_true", help="use what was tried in DIR")
    _add_json(command)


def _describe_error_budget(command: argparse.ArgumentParser) -> None:
    _add_scene(command)
    _add_jobs(command, "runs")
    command.add_argument("--time-limit", type=seconds, metavar="S", help="wall time of a run")
    _add_out(command)
    command.add_argument("--resume", action="store_true", help="use what was run in DIR")
    _add_json(command)


def _describe_matrix(command: argparse.ArgumentParser) -> None:
    command.add_argument("cases", nargs="*", metavar="CASE", help="names of cases (default: all; contactlab parts)")
    command.add_argument(
        "--contact", action="append", default=[], dest="contacts", metavar="NAME",
        help="put this algorithm to them (default: all)",
    )  # fmt: skip
    command.add_argument(
        "--full", action="store_true", help="all variants of each case, either slave, all its elements and integrators"
    )
    command.add_argument(
        "--level", action="append", default=[], dest="levels", type=positive, metavar="N",
        help="mesh level, several times for orders of convergence (default: 1)",
    )  # fmt: skip
    command.add_argument(
        "--margins",
        action="store_true",
        help="how far each case can be driven until it misses a criterion",
    )
    command.add_argument("--against", metavar="FILE", help="an earlier matrix.csv: exit status 1 where a cell is worse")
    _add_files(command)
    _add_out(command)
    command.add_argument("--resume", action="store_true", help="go on with the matrix in DIR; what is done stays")
    _add_jobs(command, "cells")
    _add_json(command)
    _add_scheduler(command)


def _add_jobs(command: argparse.ArgumentParser, what: str) -> None:
    command.add_argument("--jobs", type=positive, metavar="N", help=f"{what} at a time (default: one per core)")


def _add_scheduler(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--scheduler", default="local", metavar="WHERE",
        help="local; dask: a cluster on this machine; tcp://HOST:PORT: a dask scheduler that is there",
    )  # fmt: skip


def _describe_archive(command: argparse.ArgumentParser) -> None:
    command.add_argument("action", choices=("list", "merge", "export"), help="merge A B: all of B comes into A")
    command.add_argument("paths", nargs="*", metavar="ARCHIVE", help="archive.sqlite or its folder (default: here)")


def _describe_view(command: argparse.ArgumentParser) -> None:
    command.add_argument("path", metavar="DIR-or-RRD", help="folder of a run or a comparison, or a recording")
    command.add_argument("--png", metavar="FILE", help="write a picture instead; needs no display")
    command.add_argument("--panel", default="", metavar="NAME", help="show one panel alone: part of its name")
    command.add_argument(
        "--runs", nargs="+", metavar="NAME", default=[],
        help="runs of a comparison to show (default: all up to 12, else the first of each algorithm)",
    )  # fmt: skip
    command.add_argument("--step", type=step, metavar="N", help="the step of the picture (default: the last one)")
    command.add_argument(
        "--iteration",
        type=step,
        metavar="N",
        help="the Newton iteration of the picture, counted from 1",
    )


def _describe_explain(command: argparse.ArgumentParser) -> None:
    _add_scene(command)
    command.add_argument(
        "--all", action="store_true", dest="everything", help="every effect, part, call, kernel, array and module"
    )
    _add_json(command)


def _describe_calibrate(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "scenes", nargs="*", metavar="SCENE",
        help="make trials of these and of their variants: bundled names, TOML files, or all (that are bundled); prices "
        "that are there stay as they are",
    )  # fmt: skip
    command.add_argument(
        "--rounds", type=positive, default=2, metavar="N", help="times that each sample is run (default: 2)"
    )
    _add_changes(command)
    _add_json(command)


def _describe_scenes(command: argparse.ArgumentParser) -> None:
    command.add_argument("scene", nargs="?", metavar="NAME", help="print this one (default: list all)")
    command.add_argument("--schema", action="store_true", help="print the JSON schema of scenes, for editors")
    _add_json(command)
    _add_files(command)


def _describe_new_scene(command: argparse.ArgumentParser) -> None:
    command.add_argument("name", metavar="NAME", help="of the new scene; NAME.toml is written")
    command.add_argument(
        "--from", required=True, dest="source", metavar="SCENE", help="scene to begin with: bundled name, or TOML file"
    )
    _add_files(command)


def _describe_new_plugin(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "kind", metavar="KIND", help="of the part: contact, material, integrator ... (contactlab parts)"
    )
    command.add_argument("name", metavar="NAME", help="of part and package, such as my-contact; a folder is written")
    command.add_argument("--with-ci", action="store_true", help="with a workflow that runs its checks at every push")


def _describe_parts(command: argparse.ArgumentParser) -> None:
    command.add_argument("name", nargs="?", metavar="NAME", help="tell all about this one (default: list all)")
    _add_json(command)
    _add_files(command)


def _describe_completion(command: argparse.ArgumentParser) -> None:
    command.add_argument("shell", choices=("bash", "zsh", "fish", "powershell"), help="the shell you type in")


def _describe_doctor(command: argparse.ArgumentParser) -> None:
    _add_json(command)


def _add_json(command: argparse.ArgumentParser) -> None:
    command.add_argument("--json", action="store_true", help="print JSON for programs in place of tables")


def _describe_check(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "target", metavar="NAME-or-FILE", help="name of a part, Python file, folder, or installed distribution"
    )
    command.add_argument("--kind", default="", metavar="KIND", help="only parts of this kind")
    command.add_argument(
        "--set", action="append", default=[], dest="settings", metavar="FIELD=VALUE",
        help="value of a field of the part; usual ones stand in for fields without a default",
    )  # fmt: skip
    command.add_argument(
        "--only",
        action="append",
        default=[],
        metavar="CHECK",
        help="make this check alone; may be repeated",
    )
    _add_files(command)
    _add_json(command)
    command.add_argument("--card", metavar="DIR", help="write card.json and card.md, to show what came out")


def _add_scene(command: argparse.ArgumentParser) -> None:
    command.add_argument("scene", metavar="SCENE", help="name of a bundled scene, or TOML file")
    _add_changes(command)


def _add_changes(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--set", action="append", default=[], dest="settings", metavar="KEY=VALUE",
        help="change a key of the scene: contacts.0.algorithm=mortar-p1, level=2",
    )  # fmt: skip
    _add_files(command)


def _add_files(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--with", action="append", default=[], dest="files", metavar="FILE.py", help="use the parts in this file, too"
    )


def _add_out(command: argparse.ArgumentParser) -> None:
    command.add_argument("--out", metavar="DIR", help="folder for the results (default: a fresh one under runs/)")


_Describe = Callable[[argparse.ArgumentParser], None]

COMMANDS: dict[str, tuple[_Describe, str, str]] = {
    "run": (_describe_run, "run one scene", "contactlab.commands.run:run"),
    "compare": (
        _describe_compare,
        "run every combination, accuracy against cost",
        "contactlab.commands.compare:compare",
    ),
    "choose": (
        _describe_choose,
        "find the cheapest algorithm, slave, element, integrator and level for a scene and an error",
        "contactlab.commands.choose:choose_for",
    ),
    "error-budget": (
        _describe_error_budget,
        "say where the error of a run sits: mesh, time step, ramp, damping, tolerance",
        "contactlab.commands.error_budget:budget",
    ),
    "matrix": (
        _describe_matrix,
        "put cases with known answers to contact algorithms: a verdict with a reason for each",
        "contactlab.commands.matrix:matrix",
    ),
    "archive": (
        _describe_archive,
        "list, merge or export what was run for a matrix",
        "contactlab.commands.archive:archive",
    ),
    "view": (
        _describe_view,
        "look at the timeline of a run or a comparison, or take a picture of it",
        "contactlab.commands.view:view",
    ),
    "explain": (
        _describe_explain,
        "say what a scene calls for and what it will cost, without running it",
        "contactlab.commands.explain:explain",
    ),
    "calibrate": (
        _describe_calibrate,
        "measure the prices of this machine, from which explain foresees what runs will cost",
        "contactlab.commands.calibrate:calibrate",
    ),
    "scenes": (_describe_scenes, "list the bundled scenes, or print one", "contactlab.commands.scenes:scenes"),
    "new-scene": (
        _describe_new_scene,
        "write a scene of your own, begun from another",
        "contactlab.commands.scenes:new_scene",
    ),
    "new-plugin": (
        _describe_new_plugin,
        "write a package with a working part of a kind, its tests and what a release needs",
        "contactlab.commands.new_plugin:new_plugin",
    ),
    "parts": (
        _describe_parts,
        "list the parts of all plugins, and plugins that are broken; or tell all about one part",
        "contactlab.commands.parts:parts",
    ),
    "check": (
        _describe_check,
        "prove a part: unit checks, cases with known answers, cost of a call",
        "contactlab.commands.check:check",
    ),
    "doctor": (
        _describe_doctor,
        "check the installation by a contact step",
        "contactlab.commands.doctor:doctor",
    ),
    "completion": (
        _describe_completion,
        "print what makes a shell complete commands, scenes, parts and keys",
        "contactlab.commands.completion:completion",
    ),
}
"""Of the core, by name: what can be typed after it, what it does, and the function behind it."""
