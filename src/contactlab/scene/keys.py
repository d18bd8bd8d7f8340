"""The tables of a scene file: every key with its type, default, bounds, unit and meaning.

A new key is one line here; reading, checking, defaults and writing follow from it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Literal

from contactlab.api.profile import Profile, Vector
from contactlab.scene.fields import PartSpec, key, part

Targets = str | tuple[str, ...]
"""Single or several targets, "body.edge_set" or names of rigid surfaces."""


@dataclass(frozen=True)
class Time:
    """`[time]`: how long a run lasts and in which steps."""

    end: float | Literal["auto"] = key(
        "auto",
        unit="s",
        above=0.0,
        says="duration; auto: as long as all that the scene declares in time, with other ramps as slow as needed, "
        "then held until the run settles",
    )
    step: float | None = key(None, unit="s", above=0.0, says="fixed step; not written: a fraction of the stable step")
    fraction: float = key(0.9, above=0.0, most=1.0, says="step as a fraction of the stable step; unused with `step`")
    ramp: float | None = key(
        None,
        unit="s",
        above=0.0,
        says="duration of ramps that give none themselves; not written: the run from where they begin, or found",
    )
    hold: float | None = key(
        None,
        unit="s",
        least=0.0,
        says="with auto, time after all loading; not written: until it settles, at most one ramp",
    )
    damping: float | None = key(
        None, unit="1/s", least=0.0, says="mass-proportional damping; not written: none, or with auto found"
    )
    relaxation: float | None = key(
        None,
        unit="s",
        least=0.0,
        says="with auto, time in which motion that damping leaves alone follows velocities; 0: all motion is damped",
    )
    history: bool = key(
        False,
        says="true: every stored state is quasi-static, also where the end does not depend on the loading path; "
        "false: the path is followed where laws or friction remember it",
    )


def refuse_mean(profile: Profile | None) -> None:
    """Raise ValueError for a profile with a mean, which nothing but a load has a resultant to keep for."""
    if profile is not None and profile.mean is not None:
        raise ValueError("profile: got a mean, allowed: a mean under loads alone, whose resultant it keeps")


@dataclass(frozen=True)
class EdgePart:
    """`[bodies.NAME.sets]`: a part of an edge set, under a name of its own."""

    of: str = key(says="name of an edge set of the mesh")
    x: Vector | None = key(None, unit="mm", says="from and to, where the mesh stands at the start; not written: all")
    y: Vector | None = key(None, unit="mm", says="from and to, where the mesh stands at the start; not written: all")

    def __post_init__(self) -> None:
        for name in ("x", "y"):
            span = getattr(self, name)
            if span is not None and not span[0] < span[1]:
                raise ValueError(f"{name}: got {list(span)}, allowed: two increasing coordinates [mm]")


@dataclass(frozen=True)
class Body:
    """`[bodies.NAME]`: one mesh of one element and one material."""

    element: PartSpec = part("element", says="shape functions and quadrature")
    material: str = key(says="name of a table under [materials]")
    mesh: PartSpec = part("mesh", says="nodes, cells and named edge sets")
    velocity: Vector = key((0.0, 0.0), unit="mm/s", says="initial velocity")
    profile: Profile | None = key(None, says="how `velocity` varies from node to node; not written: it is uniform")
    spin: float = key(0.0, unit="1/s", says="initial angular velocity about the centre of mass, counter-clockwise")
    rotate: float = key(0.0, unit="degree", says="the mesh is turned about the origin by this, before the shift")
    shift: Vector = key((0.0, 0.0), unit="mm", says="the mesh is moved by this before the run: an initial gap")
    sets: Mapping[str, EdgePart] = key({}, says="further edge sets by name, each a part of one of the mesh")

    def __post_init__(self) -> None:
        refuse_mean(self.profile)


@dataclass(frozen=True)
class Start:
    """Treatment of an overlap or a small gap that the meshes of a contact have before the run."""

    overlap: Literal["refuse", "ramp", "adjust"] = key(
        "refuse",
        says="refuse: an error; ramp: taken as the zero of the gap, pushed out in time; adjust: the slave's nodes are "
        "moved onto the master before the run, without strain",
    )
    duration: float | None = key(
        None,
        unit="s",
        above=0.0,
        says="with ramp, time in which it is pushed out; not written: the ramp time of [time]",
    )
    gap: float | Literal["zero"] = key(
        0.0,
        unit="mm",
        least=0.0,
        says="with adjust, gaps up to this are closed as well; zero: the distance that the meshes have before the run, "
        "open or overlapping, is taken as a gap of zero all the time, for surfaces that fit and slide little",
    )

    def __post_init__(self) -> None:
        if self.duration is not None and self.overlap != "ramp":
            raise ValueError(f'duration: got {self.duration}, allowed: only with overlap = "ramp"')
        if self.gap == "zero":
            if self.overlap != "refuse":
                raise ValueError(
                    f'gap: got "zero" with overlap = "{self.overlap}", allowed: a length, or "zero" without overlap'
                )
        elif self.gap > 0.0 and self.overlap != "adjust":
            raise ValueError(f'gap: got {self.gap}, allowed: only with overlap = "adjust"')


@dataclass(frozen=True, kw_only=True)
class Contact:
    """`[[contacts]]`: two edge sets that must not overlap."""

    name: str | None = key(None, says="a further way to reach the contact: contacts.NAME")
    slave: Targets = key(says='"body.edge_set" that carries the multipliers, or a list of them')
    master: Targets = key(says='"body.edge_set" or rigid surface on the other side, or a list that makes one chain')
    algorithm: PartSpec = part("contact", says="how the gap is measured")
    swap: bool = key(False, says="exchange slave and master")
    smooth: bool = key(False, says="measure gaps between curves through the nodes of both sides, not between segments")
    friction: PartSpec | None = part("friction", None, says="friction law; not written: no tangential work at all")
    enforcement: PartSpec | None = part(
        "enforcement", None, says="how gap conditions become forces; not written: the integrator's own"
    )
    start: Start = key(Start(), says="treatment of an overlap before the run")
    corner: float | None = key(
        None, unit="degrees", above=0.0, most=180.0,
        says="turn of the slave above which a node is a corner, where each flank has its own normal and pressure; "
        "not written: 60, and 17 if the adjacent sides are straight",
    )  # fmt: skip

    @property
    def targets(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Edge sets of slave and master as they act, `swap` taken into account."""
        slave, master = ((side,) if isinstance(side, str) else side for side in (self.slave, self.master))
        return (master, slave) if self.swap else (slave, master)

    @property
    def sides(self) -> tuple[str, str]:
        """Slave and master as they act, in words."""
        slave, master = self.targets
        return " + ".join(slave), " + ".join(master)


@dataclass(frozen=True)
class Ramp:
    """A value that changes in time: `{ ramp = ..., to = ... }`."""

    ramp: Literal["parabola", "linear", "smooth", "constant", "table", "function"] = key(
        says="parabola: fast at first, at rest at the end; linear: at constant speed; smooth: at rest at both ends; "
        "constant: at once; table: as `points` or `file` say; function: as `function` says"
    )
    to: float = key(unit="of the key", says="value at the end of the ramp")
    duration: float | None = key(None, unit="s", above=0.0, says="not written: the ramp time of [time]")
    begin: float = key(0.0, unit="s", least=0.0, says="when the ramp begins; the value is zero until then")
    points: tuple[Vector, ...] = key(
        (), says="with table: [time in s after `begin`, factor of `to`] each, straight between them"
    )
    file: Path | None = key(None, says="with table, instead of `points`: CSV file with such pairs, without a header")
    function: PartSpec | None = part(
        "function", None, says="with function: what gives the factor of `to` at times in s after `begin`"
    )

    def __post_init__(self) -> None:
        times = [time for time, _ in self.points]
        if self.ramp == "table" and self.file is None and not (len(times) > 1 and _rising(times)):
            raise ValueError(
                f"points: got {self.points}, allowed: at least two points at increasing times, also "
                "for a jump: times that differ by a thousandth of a step, or less"
            )
        if self.points and (self.ramp != "table" or self.file is not None):
            raise ValueError(f'points: got {self.points}, allowed: only with ramp = "table", without a file')
        if self.file is not None and self.ramp != "table":
            raise ValueError(f'file: got {self.file}, allowed: only with ramp = "table"')
        if (self.function is None) == (self.ramp == "function"):
            raise ValueError(f'function: got {self.function}, allowed: a function with ramp = "function", else none')
        if self.ramp in ("table", "function") and self.duration is not None:
            raise ValueError(f"duration: got {self.duration}, allowed: none with times in seconds")


def _rising(times: Sequence[float]) -> bool:
    return all(a < b for a, b in pairwise(times))


@dataclass(frozen=True)
class Turn:
    """A rotation in time about a point: `{ to = ..., about = [x, y] }`."""

    to: float = key(unit="degree", says="angle at the end of the ramp, counter-clockwise")
    about: Vector = key((0.0, 0.0), unit="mm", says="centre; ux and uy move it")
    ramp: Literal["parabola", "linear", "smooth", "constant"] = key("linear", says="as of a displacement")
    duration: float | None = key(None, unit="s", above=0.0, says="not written: the ramp time of [time]")
    begin: float = key(0.0, unit="s", least=0.0, says="when the ramp begins")


@dataclass(frozen=True, kw_only=True)
class Support:
    """`[[supports]]`: prescribed displacements of an edge set or of a whole body."""

    name: str | None = key(None, says="a further way to reach the support: supports.NAME")
    on: str = key(says='"body.edge_set", or "body" for all its nodes')
    ux: float | Ramp | None = key(None, unit="mm", says="displacement along x; not written: free")
    uy: float | Ramp | None = key(None, unit="mm", says="displacement along y; not written: free")
    turn: Turn | None = key(None, says="rotation of the nodes about a point; ux and uy then move all of them together")
    profile: Profile | None = key(None, says="how ux and uy vary from node to node; not written: they are uniform")

    def __post_init__(self) -> None:
        if self.profile is not None and self.turn is not None:
            raise ValueError("profile: got a profile with turn, allowed: only ux and uy vary from node to node")
        refuse_mean(self.profile)


@dataclass(frozen=True)
class Arc:
    """An arc of a rigid surface: `{ centre = [x, y], radius = ..., angles = [from, to] }`."""

    centre: Vector = key(unit="mm", says="centre of the circle")
    radius: float = key(unit="mm", above=0.0, says="radius of the circle")
    angles: Vector = key(
        unit="degree",
        says="from and to, from the x axis; rising: solid inside, like a roll; falling: outside, like a die",
    )


@dataclass(frozen=True, kw_only=True)
class Rigid:
    """`[rigid.NAME]`: a rigid surface, at rest or moved in time; a master only. It has no mass and no step limit."""

    line: tuple[Vector, ...] | None = key(
        None, unit="mm", says="points of a polyline, the solid on its left; closed if the last point is the first"
    )
    arc: Arc | None = key(None, says="an arc instead of a line")
    segment: float | None = key(
        None, unit="mm", above=0.0, says="longest segment; not written: as in the edge sets it touches"
    )
    ux: float | Ramp = key(0.0, unit="mm", says="displacement along x")
    uy: float | Ramp = key(0.0, unit="mm", says="displacement along y")
    turn: Turn | None = key(None, says="rotation about a point, which ux and uy move")

    def __post_init__(self) -> None:
        if (self.line is None) == (self.arc is None):
            raise ValueError("a rigid surface is either a line or an arc: write one of them")
        if self.line is not None and (len(self.line) < 2 or any(a == b for a, b in pairwise(self.line))):
            raise ValueError(f"line: got {self.line}, allowed: at least two points, none twice in a row")
        line = self.line or ()
        for a, b, c in zip(line, line[1:], line[2:], strict=False):
            (x, y), (u, v) = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
            if x * v == y * u and x * u + y * v < 0.0:
                raise ValueError(f"line: got {[*a]}, {[*b]}, {[*c]}, allowed: points without a reversal of direction")
        if self.arc is not None and not 0.0 < abs(self.arc.angles[1] - self.arc.angles[0]) <= 360.0:
            raise ValueError(f"arc: got {self.arc.angles}, allowed: two angles, at most 360 degrees apart")


@dataclass(frozen=True, kw_only=True)
class Load:
    """`[[loads]]`: forces spread over an edge set."""

    name: str | None = key(None, says="a further way to reach the load: loads.NAME")
    on: str = key(says='"body.edge_set"')
    pressure: float | Ramp | None = key(None, unit="MPa", says="against the outward normal, positive pushes")
    shear: float | Ramp | None = key(None, unit="MPa", says="along the edges, positive with the body on the left")
    tx: float | Ramp | None = key(None, unit="MPa", says="dead load along x, per undeformed length")
    ty: float | Ramp | None = key(None, unit="MPa", says="dead load along y, per undeformed length")
    profile: Profile | None = key(None, says="how all of these vary along the edges; not written: they are uniform")
    follower: bool = key(
        True,
        says="pressure and shear follow the deformed edges; false: they keep the undeformed directions and lengths",
    )

    def __post_init__(self) -> None:
        if all(value is None for value in (self.pressure, self.shear, self.tx, self.ty)):
            raise ValueError("this load has no traction: write pressure, shear, tx or ty")


@dataclass(frozen=True, kw_only=True)
class Field:
    """`[fields.NAME]`: a number at every place and time, such as a temperature, for parts that need it by this name."""

    value: float | Ramp = key(says="the number, or how it changes in time; its unit is set by the parts that use it")
    profile: Profile | None = key(None, says="how it varies over the undeformed bodies; not written: it is uniform")

    def __post_init__(self) -> None:
        refuse_mean(self.profile)


@dataclass(frozen=True)
class Record:
    """`[record]`: what is kept of a run."""

    frames: int = key(50, least=1, says="stored frames, evenly spaced over the run, the last one at its end")
    recorders: tuple[PartSpec, ...] | None = part(
        "recorder",
        None,
        says="what writes to the results folder in addition to small text files; not written: the usual recorders",
    )
    from_: int | None = key(None, least=1, says="first step of the contact record; not written: the first of the run")
    to: int | None = key(None, least=1, says="last step of the contact record; not written: the last of the run")
    every: int | None = key(
        None,
        least=1,
        says="steps from one row of the contact record to the next; not written: 1",
    )
    budget: float | None = key(
        None,
        unit="MB",
        least=0.0,
        says="size of the contact record, whose older steps are thinned when it is reached, and of the displacements "
        "of Newton's iterations; 0: neither; scalars of steps may take four times as much, and 40 000 steps at least; "
        "not written: 64, of a run in a comparison 3",
    )
    last: int | None = key(
        None,
        least=0,
        says="steps before a failure, and before the first warning of a guard, that are stored with all fields; "
        "0: none; not written: 200",
    )
    warnings: Literal["guards", "all"] | None = key(
        None,
        says="which first warning these steps are kept before: of a guard, which watches the steps, or of all, also "
        "warnings at frames and at the end; not written: guards",
    )
    contact_work: bool = key(
        False,
        says="true: every step's work of normal contact forces is split into what it comes from: surfaces that come "
        "closer or separate, rows at predicted positions, turning normals, changing weights (explicit leapfrog)",
    )

    def __post_init__(self) -> None:
        if self.to is not None and self.to < (self.from_ or 1):
            raise ValueError(f"to: got {self.to}, allowed: a step from `from` = {self.from_ or 1} on")
