"""Every hook that a plugin can implement.

A plugin is a distribution with an entry point in the group `contactlab`. The entry names a light
module: it is imported to list what is on offer, so it imports nothing but `contactlab.api.plugin`.

    from contactlab.api.plugin import Part, hookimpl

    @hookimpl
    def contactlab_parts():
        return [Part("contact", "my-contact", "my_package.contact:MyContact", "one line")]

No hook is called inside the step loop.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pluggy

from contactlab.api.part import Part

PROJECT = "contactlab"
"""Name of the hook markers and of the entry-point group."""

hookspec = pluggy.HookspecMarker(PROJECT)


@hookspec
def contactlab_parts() -> Sequence[Part]:  # type: ignore[empty-body]
    """The parts on offer. Called once, when plugins are loaded; targets are imported when a scene uses them."""


@hookspec
def contactlab_scenes() -> Mapping[str, Path]:  # type: ignore[empty-body]
    """Bundled scenes: kebab-case name and the absolute path of its TOML file.

    A name that the core or another plugin uses is refused, and so is a path where there is no file.
    """


@hookspec
def contactlab_commands() -> Mapping[str, str]:  # type: ignore[empty-body]
    """Return further commands: kebab-case name and "package.module:function".

    The function takes the list of the remaining command-line words and returns the exit status.
    It is imported when the command is typed. A name that the core or another plugin uses is refused.
    """


@hookspec
def contactlab_run_finished(summary: Mapping[str, Any], folder: Path | None) -> None:
    """Called after a run, also a failed one, with a copy of the content of `summary.json` and the run's folder.

    What it raises is shown as a warning and changes neither the results nor the exit status.
    """
