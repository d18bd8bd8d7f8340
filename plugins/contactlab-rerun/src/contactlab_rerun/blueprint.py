"""The arrangement of views that needs no clicking."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint.components import AbsoluteTimeRange
from rerun.blueprint.encodings import TimelineColumn

from contactlab.api.arrays import Floats
from contactlab.api.drawing.units import Units
from contactlab.api.state import CONTACT_WORK
from contactlab_rerun.axes import BOX
from contactlab_rerun.convergence import PATH as CONVERGENCE
from contactlab_rerun.gathered import Appearance, Gathered
from contactlab_rerun.iterations import CHANGES, RESIDUALS
from contactlab_rerun.node_tables import FOLDER as TABLES
from contactlab_rerun.notes import track_folders
from contactlab_rerun.pages import Picture
from contactlab_rerun.profiles import Profile
from contactlab_rerun.projection import bounds
from contactlab_rerun.series import Series
from contactlab_rerun.stream import Arrangement

LEGEND = np.array([0.75, 0.0])  # room for a legend right of a plot
PAPER = (16, 18, 22)
IN_A_ROW = 4  # meshes of a comparison
_EDGE = rr.TimeRangeBoundary.infinite()
_WHOLE = rrb.TimeAxis(view_range=rr.TimeRange(_EDGE, _EDGE))


@dataclass(frozen=True)
class Shown:
    """A run and what the arrangement of views needs of it.

    box     what its mesh view shows
    series  and flags of their lines worth drawing
    frames  that are drawn
    pictures, active_sets  of the contact record, node by step, and of Newton's iterations
    """

    appearance: Appearance
    run: Gathered
    box: tuple[Floats, Floats]
    series: Sequence[tuple[Series, Sequence[bool]]]
    frames: Sequence[int]
    pictures: Sequence[Picture] = ()
    active_sets: Sequence[Picture] = ()


def arrange(
    shown: Sequence[Shown], profiles: Sequence[Profile], converged: bool, timeline: str, panel: str = ""
) -> Arrangement:
    """Meshes above; profiles, curves over time, states and events below. `converged`: Newton's iteration is drawn.

    With `panel` only the panel whose name has this in it, nearest to its beginning. Raises ValueError if none has.
    """
    curves = [_profile_view(profile, shown) for profile in profiles]
    newton = _newton_views(shown) if converged else []
    solver = _tabs([*([_convergence_view(shown)] if converged else []), *_solver_views(shown), *newton])
    layout = _one(shown, curves, solver) if len(shown) == 1 else _several(shown, curves, solver)
    if panel:
        layout = _alone(layout, panel)
    window = shown[0].run.window() if len(shown) == 1 else None
    selected = AbsoluteTimeRange(*window) if window else None
    return Arrangement(
        layout,
        rrb.TimePanel(state="collapsed", timeline=timeline, time_selection=selected),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        auto_views=False,
    )


def _alone(layout: rrb.Container, panel: str) -> rrb.Container:
    views = list(_views(layout))
    names = {str(view.name): view for view in views}
    wanted = [view for name, view in names.items() if panel.lower() in name.lower()]
    if not wanted:
        raise ValueError(f"no panel has {panel} in its name; allowed: {'; '.join(names)}")
    # the title of a run may have the word in it, too: "node-on-segment"
    first = min(wanted, key=lambda view: str(view.name).lower().index(panel.lower()))
    return rrb.Horizontal(names.get(panel, first))


def _views(layout: Any) -> Iterator[rrb.View]:
    """All views below a container."""
    if isinstance(layout, rrb.View):
        yield layout
        return
    for part in layout.contents:
        yield from _views(part)


def _one(shown: Sequence[Shown], profiles: Sequence[rrb.View], solver: rrb.Container) -> rrb.Container:
    mesh, u = _mesh_view(shown[0]), _units(shown)
    energy = _series_view(shown, "energy", f"energy{_in(u.line_energy)}", legend=True)
    reaction = _series_view(shown, "reaction", f"reaction{_in(u.line_force)}", legend=True)
    works = _tabs([energy, _work_view(shown, (), legend=True), reaction])
    below: list[rrb.Container | rrb.View] = [works, solver, *_states(shown), _words(shown)]
    beside: rrb.Container = _tabs(profiles)
    if pictures := [_picture_view(picture, picture.name) for picture in shown[0].pictures]:
        beside = rrb.Vertical(beside, _tabs(pictures), row_shares=[1, 1])
    above = rrb.Horizontal(mesh, beside, column_shares=[3, 2]) if profiles else mesh
    shares = [1.0] * (len(below) - 1) + [1.3]
    return rrb.Vertical(above, rrb.Horizontal(*below, column_shares=shares), row_shares=[3, 2])


def _several(shown: Sequence[Shown], profiles: Sequence[rrb.View], solver: rrb.Container) -> rrb.Container:
    """A row of meshes per slave surface, a column per algorithm."""
    slaves = list(dict.fromkeys(_slave(one) for one in shown))
    ordered = sorted(shown, key=lambda one: slaves.index(_slave(one)))
    columns = min(IN_A_ROW, max(sum(_slave(one) == slave for one in shown) for slave in slaves))
    meshes = rrb.Grid(*[_mesh_view(one) for one in ordered], grid_columns=columns)
    u = _units(shown)
    energy = [_series_view(shown, "energy", f"{n} energy{_in(u.line_energy)}", (n,)) for n in ("internal", "kinetic")]
    works = [_work_view(shown, (part,)) for part in CONTACT_WORK]
    below: list[rrb.Container | rrb.View] = [
        _tabs([_reaction_view(shown, f"reaction{_in(u.line_force)}"), *energy, *works]),
        solver,
    ]
    below += [*_states(shown), _words(shown)]
    shares = [1.0] * (len(below) - 1) + [1.5]
    if profiles:
        below, shares = [_tabs(profiles), *below], [1.9, *shares]
    rows = -(-len(shown) // columns)
    return rrb.Vertical(
        meshes, rrb.Horizontal(*below, column_shares=shares), row_shares=[3, 2] if rows == 1 else [2, 1]
    )


def _slave(one: Shown) -> str:
    contacts = one.run.layout.contacts
    return contacts[0].slave if contacts else ""


def _units(shown: Sequence[Shown]) -> Units:
    return Units.of_label(shown[0].run.layout.units)


# --- views ----------------------------------------------------------------------------------------


def _mesh_view(one: Shown) -> rrb.Spatial2DView:
    path = one.appearance.path
    names = ("view", "mesh", "outline", "wire", "arrows", "nodes", "bar")
    return rrb.Spatial2DView(
        origin=f"{path}/view",
        contents=[f"+ {path}/{name}/**" for name in names],
        name=one.appearance.title,
        visual_bounds=bounds(*one.box, margin=0.03),
    )


def _profile_view(profile: Profile, shown: Sequence[Shown]) -> rrb.Spatial2DView:
    curves = [
        f"+ {one.appearance.path}/{profile.folder}/{contact.name}/**"
        for one in shown
        for contact in one.run.layout.contacts
        if contact.slave == profile.slave
    ]
    return _plot_view(profile.axes.path, curves, f"{profile.what} along {profile.slave}", legend=len(shown) > 1)


def _convergence_view(shown: Sequence[Shown]) -> rrb.Spatial2DView:
    curves = [f"+ {one.appearance.path}/convergence/**" for one in shown if one.run.iterations]
    return _plot_view(CONVERGENCE, curves, "residual: force, contact (dashed)", legend=False)


def _plot_view(path: str, curves: Sequence[str], name: str, legend: bool) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        origin=f"{path}/view",
        contents=[f"+ {path}/**", *curves],
        name=name,
        visual_bounds=bounds(BOX[0], BOX[1] + (LEGEND if legend else 0.0), margin=0.02),
    )


def _newton_views(shown: Sequence[Shown]) -> list[rrb.View | None]:
    """Return views on the timeline of iterations."""
    several = len(shown) > 1
    views: list[rrb.View | None] = [
        _picture_view(picture, f"{one.appearance.title}: {picture.name}" if several else picture.name)
        for one in shown
        for picture in one.active_sets
    ]
    for path, name in ((RESIDUALS, "residual by iteration"), (CHANGES, "active set by iteration, in numbers")):
        iterating = [f"{one.appearance.path}/{path}" for one in shown if one.run.iterations]
        views.append(_lines(iterating, name, legend=not several))
    return views


def _solver_views(shown: Sequence[Shown]) -> list[rrb.View | None]:
    length = _in(_units(shown).length)
    alone = len(shown) == 1
    return [
        _series_view(shown, "solver/sweeps", "Gauss-Seidel iterations per step"),
        _series_view(shown, "solver/iterations", "iterations per step"),
        _series_view(shown, "nodes", "nodes in contact", legend=alone),
        _series_view(shown, "violation", f"contact condition violated{length}"),
        _series_view(shown, "solver/residual", "contact residual"),
        _series_view(shown, "solver/dt", "step length [s]"),
        _series_view(shown, "time-per-step", "time per step [s]", legend=alone),
    ]


def _series_view(
    shown: Sequence[Shown], group: str, name: str, wanted: Sequence[str] = (), legend: bool = False
) -> rrb.TimeSeriesView | None:
    """Lines of a group that are not always zero, all or the `wanted` ones; None without lines."""
    entities, overrides = [], {}
    for one in shown:
        for series, varying in one.series:
            lines = [v and (not wanted or n in wanted) for n, v in zip(series.names, varying, strict=True)]
            if series.path.startswith(group) and any(lines):
                entities.append(f"{one.appearance.path}/{series.path}")
                if lines != list(varying):
                    overrides[entities[-1]] = rr.SeriesLines(visible_series=lines)
    return _lines(entities, name, legend, overrides) if entities else None


def _work_view(shown: Sequence[Shown], parts: Sequence[str], legend: bool = False) -> rrb.TimeSeriesView | None:
    """View of the work of contact, all of it or some `parts`; None if no run has split it."""
    name = f"work of contact{_in(_units(shown).line_energy)}" + "".join(f": {part}" for part in parts)
    return _series_view(shown, "contact-work", name, parts, legend)


def _reaction_view(shown: Sequence[Shown], name: str) -> rrb.TimeSeriesView | None:
    """View of one reaction component of one support in all runs: the largest at their ends."""
    ends: dict[str, float] = {}
    for one in shown:
        last = one.run.instants[-1].scalars
        for on in one.run.layout.supports:
            for component in (f"{on}.fx", f"{on}.fy"):
                ends[component] = ends.get(component, 0.0) + abs(last.get(component, 0.0))
    chosen = max(ends, key=lambda component: round(ends[component], 3), default="")
    return _series_view(shown, "reaction", name, (chosen,))


def _lines(
    entities: Sequence[str],
    name: str,
    legend: bool,
    overrides: Mapping[str | rr.datatypes.EntityPath, rr.SeriesLines] | None = None,
) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin="/",
        contents=[f"+ {entity}" for entity in entities],
        name=name,
        overrides=overrides,
        # lines of several runs have the colours of their meshes' outlines; a legend would hide half of them
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend),
    )


def _picture_view(picture: Picture, name: str) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        origin=picture.path,
        contents=["+ $origin/**", f"+ {picture.beside}/**"],
        name=name,
        visual_bounds=rrb.VisualBounds2D(
            x_range=[picture.low[0], picture.high[0]], y_range=[picture.low[1], picture.high[1]]
        ),
    )


def _states(shown: Sequence[Shown]) -> list[rrb.View | rrb.Container]:
    """Tracks of some nodes; among several runs the picture of all nodes of each in a tab next to it."""
    if not any(one.run.layout.contacts for one in shown):
        return []
    tracks = [f"+ {folder}/**" for one in shown for folder in track_folders(one.run, one.appearance, len(shown) > 1)]
    view = rrb.StateTimelineView(origin="/", contents=tracks, name="states of slave nodes", time_view=_WHOLE)
    if len(shown) == 1 or not any(one.pictures for one in shown):
        return [view]
    pictures = [_picture_view(one.pictures[0], one.appearance.title) for one in shown if one.pictures]
    return [_tabs([view, *pictures])]


def _words(shown: Sequence[Shown]) -> rrb.Container:
    logs: list[rrb.View] = [_log_view(shown, "events")]
    if any(one.run.iterations for one in shown):
        logs.append(_log_view(shown, "iterations"))
    if len(shown) == 1:
        path = shown[0].appearance.path
        logs += [
            rrb.TextDocumentView(origin=f"{path}/{TABLES}/{contact.name}", name=f"nodes of {contact.slave}")
            for contact in shown[0].run.layout.contacts
        ]
    pages = [
        rrb.TextDocumentView(origin=f"{one.appearance.path}/scene", name=f"scene: {one.appearance.title}")
        for one in shown
    ]
    return _tabs([*logs, *pages])


def _log_view(shown: Sequence[Shown], name: str) -> rrb.TextLogView:
    return rrb.TextLogView(
        origin="/",
        contents=[f"+ {one.appearance.path}/{name}" for one in shown],
        name=name,
        columns=rrb.TextLogColumns(timeline_columns=[TimelineColumn("step", visible=False)], text_log_columns=["Body"]),
    )


def _in(unit: str) -> str:
    return f" [{unit}]" if unit else ""


def _tabs(views: Sequence[rrb.View | None]) -> rrb.Container:
    there = [view for view in views if view is not None]
    return rrb.Tabs(*there, active_tab=0 if there else None)  # nothing to show if nothing ever moved
