"""The arrangement of views that needs no clicking."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import rerun as rr
import rerun.blueprint as rrb

from contactlab.api.arrays import Floats
from contactlab.api.units import Units
from contactlab_rerun.gathered import Gathered, Look
from contactlab_rerun.plots import BOX, LEGEND, Plot
from contactlab_rerun.projection import bounds
from contactlab_rerun.series import Series

PAPER = (16, 18, 22)
IN_A_ROW = 4  # meshes of a comparison
_EDGE = rr.TimeRangeBoundary.infinite()
_WHOLE = rrb.TimeAxis(view_range=rr.TimeRange(_EDGE, _EDGE))


@dataclass(frozen=True)
class Shown:
    """One run as the arrangement needs it: `box` is what its mesh view shows, `series` those worth a line."""

    look: Look
    run: Gathered
    box: tuple[Floats, Floats]
    series: Sequence[Series]


def blueprint(shown: Sequence[Shown], plots: Sequence[Plot], timeline: str) -> rrb.Blueprint:
    """Meshes above; profiles, curves over time, states and events below."""
    profiles = [_profile_view(plot, shown) for plot in plots]
    layout = _one(shown, profiles) if len(shown) == 1 else _several(shown, profiles)
    return rrb.Blueprint(
        layout,
        rrb.TimePanel(state="collapsed", timeline=timeline),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        auto_views=False,
    )


def _one(shown: Sequence[Shown], profiles: Sequence[rrb.View]) -> rrb.Container:
    mesh, u = _mesh_view(shown[0]), _units(shown)
    energy = _series_view(shown, "energy", f"energy{_in(u.line_energy)}")
    reaction = _series_view(shown, "reaction", f"reaction{_in(u.line_force)}")
    below = [_tabs([energy, reaction]), _solver_tabs(shown), *_states(shown), _words(shown)]
    above = rrb.Horizontal(mesh, _tabs(profiles), column_shares=[3, 2]) if profiles else mesh
    return rrb.Vertical(above, rrb.Horizontal(*below), row_shares=[3, 2])


def _several(shown: Sequence[Shown], profiles: Sequence[rrb.View]) -> rrb.Container:
    """A row of meshes per slave surface, a column per algorithm."""
    slaves = list(dict.fromkeys(_slave(one) for one in shown))
    ordered = sorted(shown, key=lambda one: slaves.index(_slave(one)))
    columns = min(IN_A_ROW, max(sum(_slave(one) == slave for one in shown) for slave in slaves))
    meshes = rrb.Grid(*[_mesh_view(one) for one in ordered], grid_columns=columns)
    u = _units(shown)
    energy = [_series_view(shown, "energy", f"{n} energy{_in(u.line_energy)}", n) for n in ("internal", "kinetic")]
    reaction = _reaction_view(shown, f"reaction{_in(u.line_force)}")
    below = [_tabs([reaction, *energy]), _solver_tabs(shown), *_states(shown), _words(shown)]
    shares = [1.0] * len(below)
    if profiles:
        below, shares = [_tabs(profiles), *below], [1.7, *shares]
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
    path = one.look.path
    names = ("view", "mesh", "outline", "wire", "arrows", "bar")
    return rrb.Spatial2DView(
        origin=f"{path}/view",
        contents=[f"+ {path}/{name}/**" for name in names],
        name=one.look.title,
        visual_bounds=bounds(*one.box),
        background=PAPER,
    )


def _profile_view(plot: Plot, shown: Sequence[Shown]) -> rrb.Spatial2DView:
    profiles = [
        f"+ {one.look.path}/profile/{contact.name}/**"
        for one in shown
        for contact in one.run.layout.contacts
        if contact.slave == plot.slave
    ]
    return rrb.Spatial2DView(
        origin=f"{plot.path}/view",
        contents=[f"+ {plot.path}/**", *profiles],
        name=f"{plot.what} along {plot.slave}",
        visual_bounds=bounds(BOX[0], BOX[1] + (LEGEND if len(shown) > 1 else 0.0), margin=0.02),
        background=PAPER,
    )


def _solver_tabs(shown: Sequence[Shown]) -> rrb.Container:
    views = [
        _series_view(shown, "solver", "contact sweeps per step", "sweeps"),
        _series_view(shown, "solver", "Newton iterations", "iterations"),
        _series_view(shown, "contact", "nodes in contact, sticking", "nodes"),
        _series_view(shown, "contact", f"contact condition violated{_in(_units(shown).length)}", "penetration"),
        _series_view(shown, "solver", "contact residual", "residual"),
        _series_view(shown, "solver", "step length [s]", "dt"),
        _series_view(shown, "time-per-step", "time per step [s]"),
    ]
    return _tabs(views)


def _series_view(shown: Sequence[Shown], group: str, name: str, last: str = "") -> rrb.TimeSeriesView | None:
    """All series of a group that vary, or those whose path ends in `last`."""
    wanted = [
        f"{one.look.path}/{series.path}"
        for one in shown
        for series in one.series
        if series.group == group and last in ("", series.last)
    ]
    return _lines(wanted, name, legend=len(shown) == 1) if wanted else None


def _reaction_view(shown: Sequence[Shown], name: str) -> rrb.TimeSeriesView:
    """Of the reactions of each run the component that is largest at the end."""
    overrides = {}
    for one in shown:
        last = one.run.instants[-1].scalars
        ends = {(on, c): abs(last.get(f"{on}.{c}", 0.0)) for on in one.run.layout.supports for c in ("fx", "fy")}
        on, component = max(ends, key=lambda at: ends[at], default=("", ""))
        visible = rr.SeriesLines(visible_series=[component == "fx", component == "fy"])
        overrides[f"{one.look.path}/reaction/{on}"] = visible
    return _lines(list(overrides), name, legend=False, overrides=overrides)


def _lines(
    entities: Sequence[str], name: str, legend: bool, overrides: Mapping[str, rr.SeriesLines] | None = None
) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin="/",
        contents=[f"+ {entity}" for entity in entities],
        name=name,
        overrides=overrides,
        # lines of several runs have the colours of their meshes' outlines; a legend would hide half of them
        plot_legend=rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend),
        axis_x=_WHOLE,
    )


def _states(shown: Sequence[Shown]) -> list[rrb.View]:
    if not any(one.run.layout.contacts for one in shown):
        return []
    lanes = [f"+ {one.look.path}/state/**" for one in shown]
    return [rrb.StateTimelineView(origin="/", contents=lanes, name="states of slave nodes", time_view=_WHOLE)]


def _words(shown: Sequence[Shown]) -> rrb.Container:
    told = ["LogLevel", "Body"] if len(shown) == 1 else ["EntityPath", "Body"]
    log = rrb.TextLogView(
        origin="/",
        contents=[f"+ {one.look.path}/events" for one in shown],
        name="events",
        columns=rrb.TextLogColumns(timeline_columns=["step"], text_log_columns=told),
    )
    pages = [rrb.TextDocumentView(origin=f"{one.look.path}/scene", name=f"scene: {one.look.title}") for one in shown]
    return _tabs([log, *pages])


def _in(unit: str) -> str:
    return f" [{unit}]" if unit else ""


def _tabs(views: Sequence[rrb.View | None]) -> rrb.Container:
    return rrb.Tabs(*[view for view in views if view is not None], active_tab=0)
