"""Consistency checks of a scene that need no mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from contactlab.errors import Location, SceneError, did_you_mean
from contactlab.scene.keys import Body, Contact, Load, Ramp, Rigid, Support, Time, Turn


def split_target(target: str) -> tuple[str, str]:
    """Body and edge set of "body.edge_set"; the edge set of "body" is ""."""
    body, _, edge_set = target.partition(".")
    return body, edge_set


def check_bodies(bodies: Mapping[str, Body], materials: Mapping[str, Any], origin: Location) -> None:
    """Raise SceneError if there is no body, or for a material that no table declares or no body is made of."""
    if not bodies:
        raise SceneError(
            "the scene has no body", where=origin.at("bodies"), got="none", allowed="at least one [bodies.NAME]"
        )
    used = set()
    for name, body in bodies.items():
        if body.material not in materials:
            raise SceneError(
                "no material of this name is declared",
                where=origin.at(f"bodies.{name}.material"),
                got=body.material,
                allowed=", ".join(materials) or "declare one as [materials.NAME]",
                hint=did_you_mean(body.material, materials),
            )
        used.add(body.material)
    for name in materials:
        if name not in used:
            raise SceneError(
                "no body is made of this material",
                where=origin.at(f"materials.{name}"),
                got=name,
                allowed=f"materials that a body names: {', '.join(sorted(used))}",
                hint="remove the table, or set the key material of a body to its name",
            )


def check_rigid(
    rigid: Mapping[str, Rigid], bodies: Mapping[str, Body], contacts: Sequence[Contact], origin: Location
) -> None:
    """Raise SceneError for a rigid surface with the name of a body, or that no contact names."""
    touched = {target for contact in contacts for side in contact.targets for target in side}
    for name in rigid:
        where = origin.at(f"rigid.{name}")
        if name in bodies:
            raise SceneError("a body has the same name", where=where, got=name, allowed="an unused name")
        if name not in touched:
            raise SceneError(
                "no contact names this rigid surface",
                where=where,
                got=name,
                allowed=f"surfaces that a contact names: {', '.join(sorted(touched)) or 'none'}",
                hint=f'remove the table, or write master = "{name}" at a contact',
            )


def check_contacts(
    contacts: Sequence[Contact], bodies: Mapping[str, Body], rigid: Mapping[str, Rigid], origin: Location
) -> None:
    """Raise SceneError for contacts whose sides do not exist, cannot touch, or touch in another contact."""
    _check_names("contacts", contacts, origin)
    pairs: dict[frozenset[str], int] = {}
    for number, contact in enumerate(contacts):
        where = origin.at(f"contacts.{number}")
        sides = [_check_side(contact, side, bodies, rigid, where.child(side)) for side in ("slave", "master")]
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


def _check_side(
    contact: Contact, side: str, bodies: Mapping[str, Body], rigid: Mapping[str, Rigid], where: Location
) -> tuple[str, ...]:
    """The edge sets of `slave` or `master` as written. A rigid surface carries no multipliers."""
    written = getattr(contact, side)
    targets = (written,) if isinstance(written, str) else tuple(written)
    acts_as_slave = (side == "slave") != contact.swap
    if not targets or len(set(targets)) < len(targets):
        raise SceneError(
            "edge sets are needed here, each once", where=where, got=list(targets), allowed="BODY.EDGE_SET, or a list"
        )
    for target in targets:
        if target not in rigid:
            _check_target(target, bodies, rigid, where, needs_edges=True)
        elif acts_as_slave:
            raise SceneError(
                "a rigid surface cannot be the slave: its nodes cannot move under a multiplier",
                where=where,
                got=target,
                allowed="edge sets of bodies",
                hint="make it the master" + (", swap = false" if contact.swap else ""),
            )
    return targets


def check_supports(
    supports: Sequence[Support], bodies: Mapping[str, Body], rigid: Mapping[str, Rigid], origin: Location
) -> None:
    """Raise SceneError for a support of nothing, without effect, or of what another support holds."""
    _check_names("supports", supports, origin)
    taken: dict[tuple[str, str], int] = {}
    for number, support in enumerate(supports):
        where = origin.at(f"supports.{number}")
        _check_target(support.on, bodies, rigid, where.child("on"), needs_edges=False)
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


def check_loads(
    loads: Sequence[Load], bodies: Mapping[str, Body], rigid: Mapping[str, Rigid], origin: Location
) -> None:
    """Raise SceneError for a load on something else than an edge set of a body."""
    _check_names("loads", loads, origin)
    for number, load in enumerate(loads):
        _check_target(load.on, bodies, rigid, origin.at(f"loads.{number}.on"), needs_edges=True)


def _check_target(
    target: str, bodies: Mapping[str, Body], rigid: Mapping[str, Rigid], where: Location, needs_edges: bool
) -> None:
    body, edge_set = split_target(target)
    if target in rigid:
        raise SceneError(
            "a rigid surface is moved by its own table",
            where=where,
            got=target,
            allowed="an edge set of a body",
            hint=f"write ux, uy or turn under [rigid.{target}]",
        )
    if body not in bodies:
        raise SceneError(
            "no body of this name is declared",
            where=where,
            got=target,
            allowed=", ".join(bodies),
            hint=did_you_mean(body, bodies),
        )
    if needs_edges and not edge_set:
        raise SceneError(
            "an edge set of the body is needed here",
            where=where,
            got=target,
            allowed='"body.edge_set"',
            hint=f'"{body}.top", for instance',
        )


def _check_names(table: str, entries: Sequence[Contact | Support | Load], origin: Location) -> None:
    """Check that names are unique and do not look like numbers or paths."""
    seen: dict[str, int] = {}
    for number, entry in enumerate(entries):
        if entry.name is None:
            continue
        where = origin.at(f"{table}.{number}.name")
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


def check_times(
    time: Time,
    supports: Sequence[Support],
    loads: Sequence[Load],
    rigid: Mapping[str, Rigid],
    contacts: Sequence[Contact],
    origin: Location,
) -> None:
    """Raise SceneError for what begins after the end of a run of given length, or is not finished by then."""
    end, step = time.end, time.step
    if isinstance(end, str):
        return
    # a fixed step beyond the end is a slip of units
    if step is not None and step > end:
        raise SceneError(
            "the step is longer than the run", where=origin.at("time.step"), got=step, allowed=f"at most {end:g} [s]"
        )
    moved: dict[str, Support | Load | Rigid] = {f"supports.{number}": one for number, one in enumerate(supports)}
    moved |= {f"loads.{number}": load for number, load in enumerate(loads)}
    moved |= {f"rigid.{name}": surface for name, surface in rigid.items()}
    for table, entry in moved.items():
        for name, value in vars(entry).items():
            if isinstance(value, Ramp | Turn):
                _check_begin(f"{table}.{name}", value, end, origin)
    for number, contact in enumerate(contacts):
        duration = contact.start.duration if contact.start is not None else None
        if duration is not None and duration > end:
            raise SceneError(
                "the overlap is not pushed out before the end of the run",
                where=origin.at(f"contacts.{number}.start.duration"),
                got=duration,
                allowed=f"at most {end:g} [s], the end of the run",
                hint="omit it: overlaps are then pushed out by the end",
            )


def _check_begin(key: str, value: Ramp | Turn, end: float, origin: Location) -> None:
    points = value.points if isinstance(value, Ramp) else ()
    begin = value.begin + (points[0][0] if points and points[0][1] == 0.0 else 0.0)
    if begin >= end:
        raise SceneError(
            "this begins after the end of the run",
            where=origin.at(f"{key}.begin" if value.begin > 0.0 else key),
            got=begin,
            allowed=f"a time before {end:g} [s], the end of the run",
            hint="give the run a later time.end, or remove this",
        )
