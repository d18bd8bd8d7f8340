"""What the tables of a scene must say together, as far as no mesh is needed to tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from contactlab.errors import Location, SceneError, did_you_mean
from contactlab.scene_keys import Contact, Support

if TYPE_CHECKING:
    from contactlab.scene import Scene


def check(scene: Scene) -> None:
    """Raise SceneError for the first contradiction."""
    _check_bodies(scene)
    _check_contacts(scene)
    _check_supports(scene)
    _check_duration(scene)


def split_target(target: str) -> tuple[str, str]:
    """Body and edge set of "body.edge_set"; the edge set of "body" is ""."""
    body, _, edge_set = target.partition(".")
    return body, edge_set


def _check_bodies(scene: Scene) -> None:
    if not scene.bodies:
        raise SceneError("the scene has no body", where=scene.where("bodies"), allowed="at least one [bodies.NAME]")
    used = set()
    for name, body in scene.bodies.items():
        if body.material not in scene.materials:
            raise SceneError(
                "no material of this name is declared",
                where=scene.where(f"bodies.{name}.material"),
                got=body.material,
                allowed=", ".join(scene.materials) or "declare one as [materials.NAME]",
                hint=did_you_mean(body.material, scene.materials),
            )
        used.add(body.material)
    for name in scene.materials:
        if name not in used:
            raise SceneError(
                "no body is made of this material",
                where=scene.where(f"materials.{name}"),
                got=name,
                allowed=f"materials that a body names: {', '.join(sorted(used))}",
                hint="take the table out, or write its name at a body's key material",
            )


def _check_contacts(scene: Scene) -> None:
    _check_names(scene, "contacts", scene.contacts)
    pairs: dict[frozenset[str], int] = {}
    for number, contact in enumerate(scene.contacts):
        where = scene.where(f"contacts.{number}")
        for side in ("slave", "master"):
            _check_target(scene, getattr(contact, side), where.child(side), needs_edges=True)
        if contact.slave == contact.master:
            raise SceneError(
                "slave and master are the same edge set",
                where=where.child("master"),
                got=contact.master,
                allowed="two different edge sets",
            )
        pair = frozenset((contact.slave, contact.master))
        if pair in pairs:
            raise SceneError(
                f"contacts.{pairs[pair]} already joins these edge sets",
                where=where,
                got=[contact.slave, contact.master],
                allowed="each pair of edge sets once",
            )
        pairs[pair] = number


def _check_supports(scene: Scene) -> None:
    _check_names(scene, "supports", scene.supports)
    taken: dict[tuple[str, str], int] = {}
    for number, support in enumerate(scene.supports):
        where = scene.where(f"supports.{number}")
        _check_target(scene, support.on, where.child("on"), needs_edges=False)
        given = [component for component in ("ux", "uy") if getattr(support, component) is not None]
        if not given:
            raise SceneError(
                "this support holds nothing", where=where, allowed="ux, uy or both", hint="add ux = 0.0 or uy = 0.0"
            )
        for component in given:
            first = taken.setdefault((support.on, component), number)
            if first != number:
                raise SceneError(
                    f"supports.{first} already gives {component} of {support.on}",
                    where=where.child(component),
                    got=support.on,
                    allowed="each displacement once",
                )


def _check_target(scene: Scene, target: str, where: Location, needs_edges: bool) -> None:
    body, edge_set = split_target(target)
    if body not in scene.bodies:
        raise SceneError(
            "no body of this name is declared",
            where=where,
            got=target,
            allowed=", ".join(scene.bodies),
            hint=did_you_mean(body, scene.bodies),
        )
    if needs_edges and not edge_set:
        raise SceneError(
            "an edge set of the body is needed here",
            where=where,
            got=target,
            allowed='"body.edge_set"',
            hint=f'"{body}.top", for instance',
        )


def _check_names(scene: Scene, table: str, entries: Sequence[Contact | Support]) -> None:
    """Names must tell entries apart and not look like their numbers or like paths."""
    seen: dict[str, int] = {}
    for number, entry in enumerate(entries):
        if entry.name is None:
            continue
        where = scene.where(f"{table}.{number}.name")
        if not entry.name or entry.name.isdecimal() or "." in entry.name:
            raise SceneError("not a usable name", where=where, got=entry.name, allowed="a word without dots")
        if seen.setdefault(entry.name, number) != number:
            raise SceneError(
                f"{table}.{seen[entry.name]} already has this name",
                where=where,
                got=entry.name,
                allowed="a name that is not taken",
            )


def _check_duration(scene: Scene) -> None:
    """A fixed step beyond the end is a slip of units."""
    end, step = scene.time.end, scene.time.step
    if step is not None and not isinstance(end, str) and step > end:
        raise SceneError(
            "the step is longer than the run", where=scene.where("time.step"), got=step, allowed=f"at most {end:g} [s]"
        )
