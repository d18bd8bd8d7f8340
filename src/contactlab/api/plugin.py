"""Imports for the entry-point module of a plugin: the hook marker and `Part`.

from contactlab.api.plugin import Part, hookimpl

@hookimpl
def contactlab_parts():
    return [Part("contact", "my-contact", "my_package.contact:MyContact", "one line")]
"""

from __future__ import annotations

import pluggy

from contactlab.api.part import Part

__all__ = ["Part", "hookimpl"]

hookimpl = pluggy.HookimplMarker("contactlab")
