"""Consistency checks of a scene that need no mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from contactlab.errors import Location, SceneError, did_you_mean
from contactlab.scene.keys import Contact, Load, Ramp, Rigid, Support, Turn

if TYPE_CHECKING:
    from contactlab.scene.scene import Scene


def check(scene: Scene) -> None:
    """Raise SceneError for the first tables of the scene that contradict each other."""
    _check_bodies(scene)
    _check_rigid(scene)
    _check_contacts(scene)
    _check_supports(scene)
    _check_names(scene, "loads", scene.loads)
    for number, load in enumerate(scene.loads):
        _check_target(scene, load.on, scene.where(f"loads.{number}.on"), needs_edges=True)
    # a fixed step beyond the end is a slip of units
    end, step = scene.time.end, scene.time.step
    if step is not None and not isinstance(end, str) and step > end:
        raise SceneError(
            "the step is longer than the run", where=scene.where("time.step"), got=step, allowed=f"at most {end:g} [s]"
        )
    _check_begins(scene)


def split_target(target: str) -> tuple[str, str]:
    """Body and edge set of "body.edge_set"; the edge set of "body" is ""."""
    body, _, edge_set = target.partition(".")
    return body, edge_set


def _check_bodies(scene: Scene) -> None:
    if not scene.bodies:
        raise SceneError(
            "the scene has no body", where=scene.where("bodies"), got="none", allowed="at least one [bodies.NAME]"
        )
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
                hint="remove the table, or set the key material of a body to its name",
            )


def _check_rigid(scene: Scene) -> None:
    touched = {target for contact in scene.contacts for side in contact.targets for target in side}
    for name in scene.rigid:
        where = scene.where(f"rigid.{name}")
        if name in scene.bodies:
            raise SceneError("a body has the same name", where=where, got=name, allowed="an unused name")
        if name not in touched:
            raise SceneError(
                "no contact names this rigid surface",
                where=where,
                got=name,
                allowed=f"surfaces that a contact names: {', '.join(sorted(touched)) or 'none'}",
                hint=f'remove the table, or write master = "{name}" at a contact',
            )


def _check_contacts(scene: Scene) -> None:
    _check_names(scene, "contacts", scene.contacts)
    pairs: dict[frozenset[str], int] = {}
    for number, contact in enumerate(scene.contacts):
        where = scene.where(f"contacts.{number}")
        sides = [_check_side(scene, contact, side, where.child(side)) for side in ("slave", "master")]
        common = set(sides[0]) & set(sides[1])
        if common:
            raise SceneError(
                "slave and master are the same edge set",
                where=where.child("master"),
                got=sorted(common)[0],
                allowed="two different edge sets",
            )
        for pair in (frozenset((s, m)) for s in sides[0] for m in sides[1]):
            if pair in pairs:
                raise SceneError(
                    f"contacts.{pairs[pair]} already joins these edge sets",
                    where=where,
                    got=sorted(pair),
                    allowed="each pair of edge sets once",
                )
            pairs[pair] = number


def _check_side(scene: Scene, contact: Contact, side: str, where: Location) -> tuple[str, ...]:
    """The edge sets of `slave` or `master` as written. A rigid surface carries no multipliers."""
    written = getattr(contact, side)
    targets = (written,) if isinstance(written, str) else tuple(written)
    acts_as_slave = (side == "slave") != contact.swap
    if not targets or len(set(targets)) < len(targets):
        raise SceneError(
            "edge sets are needed here, each once", where=where, got=list(targets), allowed="BODY.EDGE_SET, or a list"
        )
    for target in targets:
        if target not in scene.rigid:
            _check_target(scene, target, where, needs_edges=True)
        elif acts_as_slave:
            raise SceneError(
                "a rigid surface cannot be the slave: its nodes cannot move under a multiplier",
                where=where,
                got=target,
                allowed="edge sets of bodies",
                hint="make it the master" + (", swap = false" if contact.swap else ""),
            )
    return targets


def _check_supports(scene: Scene) -> None:
    _check_names(scene, "supports", scene.supports)
    taken: dict[tuple[str, str], int] = {}
    for number, support in enumerate(scene.supports):
        where = scene.where(f"supports.{number}")
        _check_target(scene, support.on, where.child("on"), needs_edges=False)
        given = ["ux", "uy"] if support.turn else [c for c in ("ux", "uy") if getattr(support, c) is not None]
        if not given:
            raise SceneError(
                "this support has no effect",
                where=where,
                got="none of its keys",
                allowed="ux, uy, turn",
                hint="add ux = 0.0 or uy = 0.0",
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
    if target in scene.rigid:
        raise SceneError(
            "a rigid surface is moved by its own table",
            where=where,
            got=target,
            allowed="an edge set of a body",
            hint=f"write ux, uy or turn under [rigid.{target}]",
        )
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


def _check_names(scene: Scene, table: str, entries: Sequence[Contact | Support | Load]) -> None:
    """Check that names are unique and do not look like numbers or paths."""
    seen: dict[str, int] = {}
    for number, entry in enumerate(entries):
        if entry.name is None:
            continue
        where = scene.where(f"{table}.{number}.name")
        if not entry.name.isprintable() or not entry.name or entry.name.isdecimal() or "." in entry.name:
            allowed = "a word without dots, line breaks and control characters"
            raise SceneError("not a usable name", where=where, got=entry.name, allowed=allowed)
        if seen.setdefault(entry.name, number) != number:
            raise SceneError(
                f"{table}.{seen[entry.name]} already has this name",
                where=where,
                got=entry.name,
                allowed="an unused name",
            )


def _check_begins(scene: Scene) -> None:
    """Raise SceneError for values that begin after the end of a run of given length, or are not finished by then."""
    end = scene.time.end
    if isinstance(end, str):
        return
    tables: dict[str, Support | Load | Rigid] = {
        f"supports.{number}": support for number, support in enumerate(scene.supports)
    }
    tables.update({f"loads.{number}": load for number, load in enumerate(scene.loads)})
    tables.update({f"rigid.{name}": rigid for name, rigid in scene.rigid.items()})
    for table, entry in tables.items():
        for name, value in vars(entry).items():
            if isinstance(value, Ramp | Turn):
                _check_begin(scene, f"{table}.{name}", value, end)
    for number, contact in enumerate(scene.contacts):
        duration = contact.start.duration if contact.start is not None else None
        if duration is not None and duration > end:
            raise SceneError(
                "the overlap is not pushed out before the end of the run",
                where=scene.where(f"contacts.{number}.start.duration"),
                got=duration,
                allowed=f"at most {end:g} [s], the end of the run",
                hint="omit it: overlaps are then pushed out by the end",
            )


def _check_begin(scene: Scene, key: str, value: Ramp | Turn, end: float) -> None:
    points = value.points if isinstance(value, Ramp) else ()
    begin = value.begin + (points[0][0] if points and points[0][1] == 0.0 else 0.0)
    if begin >= end:
        raise SceneError(
            "this begins after the end of the run",
            where=scene.where(f"{key}.begin" if value.begin > 0.0 else key),
            got=begin,
            allowed=f"a time before {end:g} [s], the end of the run",
            hint="give the run a later time.end, or remove this",
        )
