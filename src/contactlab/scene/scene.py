"""Scenes: what is simulated, read from TOML and checked as far as that goes without a mesh."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from contactlab.arguments import NAME, arguments
from contactlab.errors import Location, PartError, SceneError, did_you_mean
from contactlab.parts.registry import Registry, default_registry
from contactlab.parts.scenes_and_commands import core_scenes
from contactlab.scene.checks import check_bodies, check_contacts, check_loads, check_rigid, check_supports, check_times
from contactlab.scene.fields import PartSpec, as_data, hidden, is_required, key, keys_of, kind_at, part
from contactlab.scene.keys import Body, Contact, Field, Load, Record, Rigid, Support, Time
from contactlab.scene.overrides import changed
from contactlab.scene.reading import read_table
from contactlab.scene.toml_text import read_toml, write_toml
from contactlab.views import view

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True, repr=False)
class Scene:
    """A checked scene. Its fields are the top of the file, `data` is all of it as plain tables.

    Parts are tables with `use` and every field of theirs; `Registry.make` turns one into an instance.
    """

    format: Literal[1] = key(1, says="version of the scene format")
    name: str = key("scene", says="names the results folder; not written: the name of the file")
    source: str = key("", says="where the scene was published")
    units: str = key("mm N s t", says="a label for tables and plots; any consistent set of units")
    level: int = key(1, least=1, says="multiplies all cell counts of the meshes")
    symmetry: Literal["x"] | None = key(
        None, says="x: mirror symmetric about the line x = 0, and the asymmetry of the result is reported"
    )
    threads: int = key(1, least=1, says="blocks of cells computed in parallel; results are the same to the last bit")
    time: Time = key(Time(), says="duration and steps")
    integrator: PartSpec = part(
        "integrator", says="how a step is made; auto: several are tried in order, the first that gets through is used"
    )
    materials: Mapping[str, PartSpec] = part("material", says="the material laws by name")
    bodies: Mapping[str, Body] = key(says="the bodies by name")
    contacts: tuple[Contact, ...] = key((), says="contact pairs")
    rigid: Mapping[str, Rigid] = key({}, says="rigid surfaces by name")
    supports: tuple[Support, ...] = key((), says="prescribed displacements")
    loads: tuple[Load, ...] = key((), says="forces spread over edge sets")
    fields: Mapping[str, Field] = key({}, says="numbers of place and time that materials and friction need, by name")
    effects: tuple[PartSpec, ...] = part("effect", (), says="gravity, springs, dampers: what else pushes on nodes")
    record: Record = key(Record(), says="what is kept of a run")

    origin: Location = hidden(Location())
    registry: Registry = dataclasses.field(
        default_factory=default_registry, repr=False, compare=False, metadata={"hidden": True}
    )

    @classmethod
    @arguments(data=Mapping, origin=Location, registry=Registry)
    def from_data(
        cls, data: Mapping[str, Any], origin: Location | None = None, registry: Registry | None = None
    ) -> Scene:
        """A scene from plain tables, as TOML gives them. Raises SceneError or PartError."""
        registry = registry or default_registry()
        origin = origin or Location()
        scene = read_table(cls, data, origin, registry.written_out, origin=origin, registry=registry)
        sides = scene.bodies, scene.rigid, origin
        check_bodies(scene.bodies, scene.materials, origin)
        check_rigid(scene.rigid, scene.bodies, scene.contacts, origin)
        check_contacts(scene.contacts, *sides)
        check_supports(scene.supports, *sides)
        check_loads(scene.loads, *sides)
        check_times(scene.time, scene.supports, scene.loads, scene.rigid, scene.contacts, origin)
        return scene

    @property
    def data(self) -> dict[str, Any]:
        """All keys as plain tables, defaults included; keys without a value are left out."""
        return as_data(self)

    def toml(self) -> str:
        """The scene as a file that reads back as exactly this scene."""
        return write_toml(self.data)

    def __repr__(self) -> str:
        return str(view("notebook.texts.scene_text")(self))

    def _repr_html_(self) -> str:
        return str(view("notebook.html.scene_html")(self))

    def plot(self, ax: Axes | None = None) -> Figure:
        """Draw the meshes before the run, with contact sides, supports and loads."""
        figure: Figure = view("notebook.scene_picture.scene_figure")(self, ax)
        return figure

    def where(self, key: str) -> Location:
        """The place of a dotted key, for errors."""
        return self.origin.at(key)

    @arguments(changes=Mapping)
    def with_(self, changes: Mapping[str, Any] | None = None, **keys: Any) -> Scene:
        """Give the scene other values at dotted keys and check it: `with_({"contacts.0.swap": True}, level=2)`.

        Keys need not be written yet: {"contacts.0.friction": {"use": "coulomb", "mu": 0.2}}. A contact
        or support with a name can be addressed by it: "contacts.tool.swap". If another part is named, the
        fields of the old part are dropped, except for those that both parts require.
        """
        return Scene._with(self.data, {**(changes or {}), **keys}, self.origin, self.registry)

    @staticmethod
    def _with(data: Mapping[str, Any], changes: Mapping[str, Any], origin: Location, registry: Registry) -> Scene:
        data, found = changed(data, changes, _is_part, partial(_switched, registry))
        origin = dataclasses.replace(origin, overrides=origin.overrides | set(found))
        return Scene.from_data(data, origin, registry)


def _is_part(path: str) -> bool:
    return kind_at(Scene, path.split(".")) is not None


def _switched(registry: Registry, path: str, old: Mapping[str, Any], name: str) -> dict[str, Any]:
    if old.get("use") == name:
        return dict(old)
    kind = kind_at(Scene, path.split("."))
    assert kind is not None
    required = partial(_required, registry, kind)
    kept = required(str(old.get("use"))) & required(name)
    return {"use": name, **{field: value for field, value in old.items() if field in kept}}


def _required(registry: Registry, kind: str, name: str) -> set[str]:
    if name not in registry.names(kind):
        return set()
    fields = keys_of(registry.part_class(kind, name))
    return {field for field in fields if is_required(fields[field])}


@arguments(name_or_path=NAME, registry=Registry, changes=Mapping)
def load_scene(
    name_or_path: str | Path, registry: Registry | None = None, changes: Mapping[str, Any] | None = None
) -> Scene:
    """A bundled scene by its name, or the scene in a TOML file. Raises SceneError or PartError.

    With `changes`, values at dotted keys as of `Scene.with_`: what they replace need not be installed.
    """
    registry = registry or default_registry()
    path, shown = find_scene(name_or_path, registry)
    data, lines = read_toml(path, shown)
    data.setdefault("name", path.stem)
    origin = Location(shown, lines=lines, folder=str(path.parent.resolve()))
    try:
        changes = dict(changes or {})
        try:
            scene = Scene.from_data(data, origin, registry)
        except PartError:  # which a change may put another part in the place of
            named = {key: changes.pop(key) for key in list(changes) if _is_part(key.removesuffix(".use"))}
            scene = Scene._with(data, named, origin, registry)
        return scene.with_(changes) if changes else scene
    except PartError as error:
        error.hint = _brought(path.parent / "summary.json", error.got) or error.hint
        raise


def _brought(summary: Path, name: object) -> str:
    """Distribution of a part in a stored run, as a hint, if its summary has the part; else empty."""
    if not summary.is_file():
        return ""
    try:
        parts = json.loads(summary.read_text(encoding="utf-8")).get("parts", {}).values()
    except (OSError, ValueError, AttributeError):
        return ""
    found = [part.partition(" (")[2].rstrip(")") for part in parts if part.partition(" (")[0] == name]
    return f"the run had it from {found[0]}: install that" if found else ""


def bundled_scenes(registry: Registry | None = None) -> dict[str, Path]:
    """Scenes that come with the core and with plugins, by name."""
    return {**(registry or default_registry()).scenes(), **core_scenes()}


def find_scene(name_or_path: str | Path, registry: Registry) -> tuple[Path, str]:
    """The file of a scene and what to call it. Raises SceneError with the nearest bundled name."""
    bundled = bundled_scenes(registry)
    if isinstance(name_or_path, str) and name_or_path in bundled:
        return bundled[name_or_path], f"bundled scene {name_or_path}"
    path = Path(name_or_path)
    try:
        there = path.exists()
    except (OSError, ValueError):  # no name that a file could have
        there = False
    if there:
        return path, str(name_or_path) or str(path)
    raise SceneError(
        "there is no such scene",
        where=str(name_or_path),
        got=str(name_or_path),
        allowed=f"the path of a TOML file, or a bundled scene: {', '.join(bundled)}",
        hint=registry.reason_against(f"scene {name_or_path}") or did_you_mean(path.stem, bundled),
    )
