"""Columns that a comparison reports for each run: names, titles, units and meaning."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True)
class Column:
    """Column of numbers of a table: its name, title, unit and meaning.

    name     as in `table.csv`
    title    heading of tables and plots
    unit     "share" (0.01 is shown as 1 %), "" or the kind of a unit (`contactlab.api.drawing.units`)
    meaning  one sentence
    digits   significant digits shown
    better   what a reader should look for: "small", or "" if neither is better
    """

    name: str
    title: str
    unit: str
    meaning: str
    digits: int = 3
    better: str = ""


MEASURES: Final = (
    Column("reaction", "reaction", "line_force", "Force of the driven support on its body.", 5),
    Column(
        "peak_force",
        "peak force",
        "line_force",
        "Largest force of the driven support, else of the contact; at the end if only that is in equilibrium.",
        5,
    ),
    Column("peak_force_time", "time of peak force", "time", "Time at which the peak force acts.", 4),
    Column("reaction_error", "reaction error", "share", "Reaction against the reference's, relative.", 2, "small"),
    Column(
        "reaction_against_pressure",
        "reaction vs pressure",
        "share",
        "Support force of the slave body (else of the master) against the integral of the contact pressure "
        "over the deformed slave surface, relative.",
        2,
        "small",
    ),
    Column(
        "reaction_mismatch",
        "sum of reactions",
        "share",
        "Sum of all support forces over the largest one: zero in equilibrium without body forces.",
        2,
        "small",
    ),
    Column(
        "pressure_error",
        "pressure error",
        "share",
        "Relative L2 distance of the pressure from the reference, both as linear interpolants over the "
        "deformed position.",
        3,
        "small",
    ),
    Column(
        "largest_pressure_error",
        "largest pressure error",
        "share",
        "Largest nodal distance from the reference two segments or more inside the edge of contact, over the "
        "largest reference pressure.",
        3,
        "small",
    ),
    Column(
        "swap_asymmetry",
        "swap asymmetry S",
        "share",
        "S = 2 ||p_a - p_b|| / (||p_a|| + ||p_b||) of the two choices of slave.",
        3,
        "small",
    ),
    Column(
        "swap_reaction_difference",
        "swap reaction difference",
        "share",
        "Reactions of the two choices of slave, relative difference.",
        2,
        "small",
    ),
    Column(
        "oscillation",
        "oscillation O",
        "",
        "Second differences of the nodal pressures over their sum, minus the reference's at the same positions.",
        2,
        "small",
    ),
    Column(
        "turning_points",
        "turning points",
        "",
        "Sign changes of the first differences of the nodal pressures beyond the reference's.",
        0,
        "small",
    ),
    Column("edge_error", "edge error", "h", "Distance of the edge of contact from the reference's, in segments.", 2),
    Column(
        "mirror_asymmetry",
        "mirror asymmetry",
        "share",
        "||p(x) - p(-x)|| / ||p|| if the scene declares symmetry.",
        2,
        "small",
    ),
    Column("sideways_force", "sideways force", "", "Horizontal over vertical contact force.", 2, "small"),
    Column(
        "peak_pressure",
        "peak pressure",
        "pressure",
        "Largest nodal value of the multiplier over the loading; at the end if only that is in equilibrium.",
        4,
    ),
    Column("peak_pressure_time", "time of peak pressure", "time", "Time at which the peak pressure acts.", 4),
    Column("max_pressure", "max pressure", "pressure", "Largest nodal value of the multiplier at the end.", 4),
    Column("max_penetration", "max penetration", "length", "Deepest node of either surface.", 2, "small"),
    Column("kinetic_share", "kinetic/internal", "", "Kinetic energy over the work of stresses at the end.", 2, "small"),
    Column("steps", "steps", "", "Accepted time or load steps.", 0),
    Column("sweeps", "sweeps per step", "", "Gauss-Seidel iterations of the contact solver per step, on average.", 3),
    Column("cpu_s", "CPU", "s", "CPU time of the steps, without compiling or loading kernels.", 3, "small"),
    Column("wall_s", "wall", "s", "Wall time of the steps, without compiling or loading kernels.", 3),
    Column("memory_mib", "memory", "MiB", "Largest memory of the process so far, earlier runs in it included.", 4),
)

BY_NAME: Final = {column.name: column for column in MEASURES}
