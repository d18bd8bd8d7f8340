"""Commands of the core and what can be typed after each.

The functions behind them are named here and imported when they are called, so that a command loads what it needs alone.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

from contactlab import __version__
from contactlab.commands.command_line import CommandLine
from contactlab.commands.typed_values import positive, seconds, share, step


class _Program(CommandLine):
    """The parser of the whole program, whose help groups the commands."""

    def format_help(self) -> str:
        """One line per command."""
        lines = [f"{self.format_usage()}\n{self.description}\n"]
        for title, commands in GROUPS.items():
            lines.append(f"\n{title}:\n")
            lines += [f"  {name:<14}{text}\n" for name, (_, text, _) in commands.items()]
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
    for name, (describe, text, handler) in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".", allow_abbrev=False)
        command.set_defaults(handler=handler)
        describe(command)
    return parser


def _describe_run(command: argparse.ArgumentParser) -> None:
    _add_scene(command)
    _add_out(command)
    command.add_argument("--resume", action="store_true", help="resume the interrupted run in DIR")
    _add_json(command)
    _add_amount(command)


def _describe_compare(command: argparse.ArgumentParser) -> None:
    command.add_argument("scene", metavar="SCENE-or-STUDY", help="bundled name, or TOML file of a scene or study")
    command.add_argument(
        "--vary", action="append", default=[], metavar="KEY=[V1, V2]", help="values to combine; replaces a study's own"
    )
    command.add_argument(
        "--effects", action="store_true", help="leave out each effect in turn: its cost and its influence"
    )
    _add_changes(command)
    _add_many(command)
    command.add_argument("--quick", action="store_true", help="study of cases: a few of them, in three CPU minutes")
    command.add_argument(
        "--reference",
        metavar="NAME",
        help="compare pressures with this: a name, a JSON or CSV file, or finest",
    )
    command.add_argument("--repeat", type=positive, metavar="N", help="runs of each combination; costs are medians")
    command.add_argument(
        "--keep", choices=("all", "failed", "none"), default="all",
        help="runs whose results.vtkhdf and recordings are kept (default: all)",
    )  # fmt: skip
    _add_json(command)
    _add_amount(command)


def _describe_choose(command: argparse.ArgumentParser) -> None:
    _add_scene(command)
    command.add_argument("--error", type=share, default=0.01, metavar="E", help="error to meet (default: 1%%)")
    command.add_argument("--budget", type=seconds, default=60.0, metavar="S", help="CPU time of a run (default: 60s)")
    command.add_argument(
        "--search", type=seconds, default=120.0, metavar="S", help="CPU time of trials (default: 120s)"
    )
    command.add_argument("--run", action="store_true", help="run what was chosen")
    _add_many(command)
    _add_json(command)


def _describe_error_budget(command: argparse.ArgumentParser) -> None:
    _add_scene(command)
    _add_many(command)
    _add_json(command)


def _describe_matrix(command: argparse.ArgumentParser) -> None:
    command.add_argument("cases", nargs="*", metavar="CASE", help="names of cases (default: all; contactlab parts)")
    command.add_argument(
        "--contact", action="append", default=[], dest="contacts", metavar="NAME",
        help="judge this algorithm (default: all)",
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
        help="how far each case can be driven before it fails a criterion",
    )
    command.add_argument("--against", metavar="FILE", help="an earlier matrix.csv: exit status 1 where a cell is worse")
    _add_files(command)
    _add_many(command)
    _add_json(command)


def _add_many(command: argparse.ArgumentParser) -> None:
    """Options of all commands that make many runs, with one meaning."""
    _add_out(command)
    command.add_argument(
        "--resume", action="store_true",
        help="resume in DIR: finished runs are kept, interrupted ones continued, damaged records made again",
    )  # fmt: skip
    command.add_argument(
        "--time-limit", type=seconds, metavar="S",
        help="wall time of one run without compilation; a longer one is `timed-out`",
    )  # fmt: skip
    command.add_argument("--jobs", type=positive, metavar="N", help="runs at a time (default: one per core)")
    command.add_argument(
        "--scheduler", default="local", metavar="WHERE",
        help="local; dask: a cluster on this machine; tcp://HOST:PORT: a dask scheduler that is there",
    )  # fmt: skip


def _describe_archive(command: argparse.ArgumentParser) -> None:
    command.add_argument("action", choices=("list", "merge", "export"), help="merge A B copies all of B into A")
    command.add_argument("paths", nargs="*", metavar="ARCHIVE", help="archive.sqlite or its folder (default: here)")


def _describe_view(command: argparse.ArgumentParser) -> None:
    command.add_argument("path", metavar="DIR-or-RRD", help="folder of a run or a comparison, or a recording")
    command.add_argument("--png", metavar="FILE", help="write a picture; needs no display")
    command.add_argument("--panel", default="", metavar="NAME", help="show one panel only: part of its name")
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


def _describe_plot(command: argparse.ArgumentParser) -> None:
    command.add_argument("path", metavar="DIR", help="folder of a run or a comparison")
    command.add_argument(
        "what", choices=("force", "pressure", "stress", "animation"),
        help="force against displacement, pressure along the slave, a field on the bodies, or its animation",
    )  # fmt: skip
    command.add_argument("--out", metavar="FILE", help=".png, .svg, .pdf; .gif, .mp4 (default: in DIR)")
    command.add_argument("--on", metavar="NAME", help="force: a support or contact; pressure: a contact")
    command.add_argument(
        "--component", choices=("x", "y", "magnitude"), help="of the force (default: along the motion)"
    )
    command.add_argument("--field", default="von_mises", metavar="NAME", help="field to draw (default: von_mises)")
    command.add_argument("--frame", type=step, metavar="N", help="stored frame of stress (default: the last one)")
    command.add_argument(
        "--stride", type=positive, default=1, metavar="N", help="animation: every Nth frame (default: 1)"
    )
    command.add_argument("--flat", action="store_true", help="one colour per cell instead of nodal averages")
    command.add_argument("--runs", nargs="+", metavar="NAME", default=[], help="runs of a comparison (default: all)")


def _describe_explain(command: argparse.ArgumentParser) -> None:
    _add_scene(command)
    command.add_argument(
        "--all", action="store_true", dest="everything", help="every effect, part, call, kernel, array and module"
    )
    command.add_argument(
        "--effects", action="store_true", help="try the scene without each effect, too, and print what each costs"
    )
    _add_json(command)


def _describe_scenes(command: argparse.ArgumentParser) -> None:
    command.add_argument("scene", nargs="?", metavar="NAME", help="print this one (default: list all)")
    command.add_argument("--schema", action="store_true", help="print the JSON schema of scenes, for editors")
    _add_json(command)
    _add_files(command)


def _describe_new_scene(command: argparse.ArgumentParser) -> None:
    command.add_argument("name", metavar="NAME", help="name of the new scene; NAME.toml is written")
    command.add_argument(
        "--from", required=True, dest="source", metavar="SCENE", help="scene to start from: bundled name or TOML file"
    )
    _add_files(command)


def _describe_new_plugin(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "kind", metavar="KIND", help="kind of part: contact, material, integrator ... (contactlab parts)"
    )
    command.add_argument("name", metavar="NAME", help="name of part and package: my-contact; a folder is written")
    command.add_argument(
        "--from", dest="start", default="", metavar="WAY",
        help="way to write a contact: mortar or points, by formulas, or rows in NumPy (default)",
    )  # fmt: skip
    command.add_argument("--with-ci", action="store_true", help="add a workflow that runs the checks at every push")


def _describe_cite(command: argparse.ArgumentParser) -> None:
    command.add_argument("path", metavar="RUN", help="folder of a run or a comparison")
    _add_files(command)
    _add_json(command)


def _describe_runs(command: argparse.ArgumentParser) -> None:
    command.add_argument("folders", nargs="*", metavar="DIR", help="folders to look through (default: runs)")
    command.add_argument(
        "--remove", nargs="+", metavar="NAME", default=[],
        help="remove these folders: names or patterns such as 'disc-*', or failed",
    )  # fmt: skip
    command.add_argument("--yes", action="store_true", help="remove without asking")
    _add_json(command)


def _describe_parts(command: argparse.ArgumentParser) -> None:
    command.add_argument("name", nargs="?", metavar="NAME", help="describe this part (default: list all)")
    _add_json(command)
    _add_files(command)


def _describe_completion(command: argparse.ArgumentParser) -> None:
    command.add_argument("shell", choices=("bash", "zsh", "fish", "powershell"), help="the shell you type in")


def _describe_doctor(command: argparse.ArgumentParser) -> None:
    _add_json(command)


def _add_amount(command: argparse.ArgumentParser) -> None:
    group = command.add_mutually_exclusive_group()
    group.add_argument("-q", "--quiet", action="store_true", help="print failures and warnings only")
    group.add_argument("-v", "--verbose", action="store_true", help="print every number of the result")
    command.add_argument("--profile", action="store_true", help="print where the time went")


def _add_json(command: argparse.ArgumentParser) -> None:
    command.add_argument("--json", action="store_true", help="print JSON instead of tables")


def _describe_check(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "target", metavar="NAME-or-FILE", help="name of a part, Python file, folder, or installed distribution"
    )
    command.add_argument("--kind", default="", metavar="KIND", help="only parts of this kind")
    command.add_argument(
        "--set", action="append", default=[], dest="settings", metavar="FIELD=VALUE",
        help="value of a field of the part; fields without a default get usual values",
    )  # fmt: skip
    command.add_argument(
        "--only",
        action="append",
        default=[],
        metavar="CHECK",
        help="run this check only; may be repeated",
    )
    _add_files(command)
    _add_json(command)
    command.add_argument("--card", metavar="DIR", help="write the outcome as card.json and card.md")
    command.add_argument(
        "--python", action="store_true", help="run formulas as plain Python in the unit checks, and count their lines"
    )


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
        "--with", action="append", default=[], dest="files", metavar="FILE.py", help="also use the parts in this file"
    )


def _add_out(command: argparse.ArgumentParser) -> None:
    command.add_argument("--out", metavar="DIR", help="folder for the results (default: a new one under runs/)")


_Describe = Callable[[argparse.ArgumentParser], None]

Commands = dict[str, tuple[_Describe, str, str]]

GROUPS: dict[str, Commands] = {
    "everyday": {
        "run": (_describe_run, "run one scene", "contactlab.commands.run:run"),
        "compare": (
            _describe_compare,
            "run every combination of values: accuracy against cost",
            "contactlab.commands.compare:compare",
        ),
        "plot": (
            _describe_plot,
            "draw force curves, pressures, stresses or an animation",
            "contactlab.commands.plot:plot",
        ),
        "view": (
            _describe_view,
            "open the timeline in the viewer, or save a picture",
            "contactlab.commands.view:view",
        ),
        "scenes": (_describe_scenes, "list the bundled scenes, or print one", "contactlab.commands.scenes:scenes"),
        "new-scene": (
            _describe_new_scene,
            "write a scene of your own, starting from another",
            "contactlab.commands.scenes:new_scene",
        ),
        "runs": (_describe_runs, "list result folders, or remove some", "contactlab.commands.runs:runs"),
        "cite": (_describe_cite, "print what to cite for a run", "contactlab.commands.cite:cite"),
    },
    "for authors of plugins": {
        "new-plugin": (
            _describe_new_plugin,
            "write a package with a working part, its tests and its metadata",
            "contactlab.commands.new_plugin:new_plugin",
        ),
        "check": (
            _describe_check,
            "validate a plugin: unit tests, benchmarks, timing",
            "contactlab.commands.check:check",
        ),
        "parts": (
            _describe_parts,
            "list the parts of all plugins and broken ones, or describe one",
            "contactlab.commands.parts:parts",
        ),
    },
    "laboratory": {
        "matrix": (
            _describe_matrix,
            "judge contact algorithms on benchmark cases with known solutions",
            "contactlab.commands.matrix:matrix",
        ),
        "choose": (
            _describe_choose,
            "find the cheapest configuration that meets an error",
            "contactlab.commands.choose:choose_for",
        ),
        "error-budget": (
            _describe_error_budget,
            "split the error of a run: mesh, step, ramp, damping, tolerance",
            "contactlab.commands.error_budget:budget",
        ),
        "explain": (
            _describe_explain,
            "print what a scene uses and its cost estimate",
            "contactlab.commands.explain:explain",
        ),
        "archive": (
            _describe_archive,
            "list, merge or export archived runs",
            "contactlab.commands.archive:archive",
        ),
    },
    "this installation": {
        "doctor": (_describe_doctor, "check the installation by a contact step", "contactlab.commands.doctor:doctor"),
        "completion": (
            _describe_completion,
            "print the shell code that completes commands and keys",
            "contactlab.commands.completion:completion",
        ),
    },
}
"""Commands of the core as the help groups them: what can be typed after each, what it does, and its function."""

COMMANDS: Commands = {name: command for group in GROUPS.values() for name, command in group.items()}
