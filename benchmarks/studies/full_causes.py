"""Why cells of the full matrix have no right answer, or miss a number: what was found out, or that it was not.

A test holds `CAUSES` complete and without entries that are no longer needed, so that the list can only shrink.
"""

from __future__ import annotations

NODES = "node-on-segment"
UNKNOWN = "not known"

LEANING = "normals averaged on the slave lean beside a node that has been let go, and work on what slides there"
ONE_PASS = "one-pass conditions do not pass a constant pressure between meshes that do not match"
VERTEX = "forces jump where a node lies on a vertex of the master: the iteration goes to and fro; the run says so"
FINE_ON_SOFT = (
    "a stiff slave of finer cells than the soft master: multipliers between the master's nodes have no answer, and "
    "statuses find no rest; the run says so, and with the sides exchanged it is met"
)
ROUGH = "very high friction: which nodes stick finds no rest; the run says so"
CORNERS = (
    "two corners that meet head on: nodes are pushed out of the other body's side, and contact makes energy; the run "
    "is stopped for it"
)
BEYOND = (
    "corner nodes that stand up to two per cent of a segment beyond the end of the master are held by its last node: "
    "the two forces are not in one line and turn the pair; with either body wider the change is 150 to 600 times less"
)
SLIDES_OFF = (
    "friction alone holds the upper layer, and there is none where nothing is pressed yet: the first iteration slides "
    "it off and opens all conditions; the run says so"
)
SOFT_SPRINGS = (
    "only springs of a ten-millionth of the stiffness hold the bodies, and the first iteration moves them far away; "
    "with springs a thousand times as stiff the run comes to its end; what loads the springs was not found"
)
NODE_BY_NODE = "contact ends node by node, one or two in an iteration: more than the limit of work allows on this mesh"

CAUSES: dict[tuple[str, str, str], str] = {
    ("dropped-block", "mortar-p0", "silent"): LEANING,
    ("dropped-block", "mortar-p1", "silent"): LEANING,
    ("pressed-block", "mortar-p0", "silent"): LEANING,
    ("pressed-block", "mortar-p1", "silent"): LEANING,
    ("stiffness-contrast", "mortar-p0", "failed"): FINE_ON_SOFT,
    ("stiffness-contrast", "mortar-p1", "failed"): FINE_ON_SOFT,
    ("inclined-layers", "mortar-p0", "failed"): SLIDES_OFF,
    ("inclined-layers", "mortar-p1", "failed"): SLIDES_OFF,
    ("inclined-layers", NODES, "silent"): f"{ONE_PASS}: the same on a slope",
    ("few-cells", NODES, "silent"): ONE_PASS,
    ("patch", NODES, "silent"): ONE_PASS,
    ("patch", NODES, "failed"): VERTEX,
    ("two-rings", NODES, "silent"): f"{ONE_PASS}: on a curve first order where the case allows second",
    ("disc-in-ring", NODES, "silent"): f"{ONE_PASS}: on a curve first order where the case allows second",
    ("disc-in-ring", NODES, "failed"): SOFT_SPRINGS,
    ("hertz", NODES, "silent"): f"{ONE_PASS}: the pressure swings over several nodes, which no saw-tooth is",
    ("hertz", NODES, "failed"): VERTEX,
    ("stiffness-contrast", NODES, "failed"): VERTEX,
    ("elastic-punch", NODES, "silent"): f"{ONE_PASS}: the exponent at the corner is fitted to such pressures",
    ("nafems-cgs1", NODES, "failed"): VERTEX,
    ("ironing", NODES, "not-judged"): VERTEX,
    ("lifted-beam", NODES, "not-judged"): NODE_BY_NODE,
    ("disc-on-block", NODES, "not-judged"): VERTEX,
    ("rigid-punch", NODES, "not-judged"): "statuses beside the singular edge find no rest",
    ("rough-plate", "mortar-p0", "not-judged"): ROUGH,
    ("rough-plate", "mortar-p1", "not-judged"): ROUGH,
    ("spinning-pair", NODES, "silent"): BEYOND,
    ("vertex-to-vertex", NODES, "failed"): CORNERS,
}
"""By case, algorithm and verdict: why there is no right answer, or none that says that it is wrong."""

RIM = "segments that a rim covers in part are shown on whole ones"
EDGE = "where the edge of contact lies between two nodes decides; the tolerance falls with the cells"
SAW = "the run warns of it: cells feel little of a pressure that alternates from node to node, so that it is free to"
FACETS = "nodes of two polygons that do not meet: their facets are as deep as the interference"
LATE_FORCE = "a step's force acts where the surfaces are at its end; half the step, half the change"
CIRCLES = "the tip of the master lies within a quadratic segment of the slave: Newton goes round in circles"
FINE_SLAVE = "a slave of finer cells than the master carries the pressure of the master's facets"

MISSED: dict[tuple[str, str], str] = {
    ("", "saw-tooth of the pressure"): SAW,
    ("", "saw-tooth of the shear"): "the run warns of it: the same of the shear",
    ("corner-slide", "saw-tooth of the pressure"): "the base is a zigzag, whose vertices press",
    ("rigid-punch", "resultant against integral of the pressure"): RIM,
    ("tilted-punch", "resultant against integral of the pressure"): RIM,
    ("elastic-punch", "resultant against integral of the pressure"): RIM,
    ("leaf-spring", "resultant against integral of the pressure"): RIM,
    ("inclined-layers", "resultant against integral of the pressure"): "slips of 2e-5 uncover as much of a segment",
    ("inclined-layers", "stress along y"): "the layer slides a little before friction holds it, as where runs failed",
    ("hertz", "L2 of the pressure"): EDGE,
    ("hertz", "half-width in segments"): EDGE,
    ("hertz", "largest pressure"): FINE_SLAVE,
    ("sliding-cylinder", "L2 of the pressure"): EDGE,
    ("rounded-punch", "L2 of the pressure"): "most of the face is flat: the pressure rises at its rim within few cells",
    ("rounded-punch", "largest pressure"): "most of the face is flat: the pressure rises at its rim within few cells",
    ("rigid-punch", "L2 of the pressure over 0.9 a"): "the singular edge leaves its mark on the cells beside it",
    ("stiffness-contrast", "largest pressure"): FINE_SLAVE,
    ("stiffness-contrast", "L2 of the pressure"): ONE_PASS,
    ("oblique-discs", "change of the angular momentum"): LATE_FORCE,
    ("vertex-to-vertex", "change of the angular momentum"): LATE_FORCE,
    ("oblique-discs", "energy gained"): LEANING,
    ("taylor-bar", "energy taken by flow over the kinetic one, less one"): "with `q1-reduced` alone",
    ("bouncing-bar", "highest point after the last period, later than exact [periods]"):
        "implicit alone: lumped masses and the trapezoidal rule slow waves (docs/statics.md)",
    ("bar-between-walls", "speed in the end"): "late by a part of an impact after twenty: the run ends within one",
    ("wall-impact", "mean force"): "five cells a step, and contact begins in the middle of one",
    ("shrink-fit", "mean pressure"): FACETS,
    ("shrink-fit", "largest difference of a node from the mean"): FACETS,
    ("initial-overlap", "ramped: force in the end"): "free master nodes swing through the coarser slave",
    ("pulled-block", "slip of sticking nodes in segments"):
        "`q2` alone: with friction, multipliers stand at the ends of quadratic edges, and what is between them is free",
    ("two-rings", "order of the carried pressure"): "meshes too coarse for the order that they tend to",
    ("patch", "stress"): ONE_PASS,
    ("mindlin", "loaded: peak of the shear"): ONE_PASS,
    ("nafems-cgs1", "largest pressure"): ONE_PASS,
    ("elastic-punch", "exponent less the exact one"): ONE_PASS,
    ("two-rings", "L2 of the carried pressure"): ONE_PASS,
    ("disc-in-ring", "L2 of the carried pressure"): ONE_PASS,
    ("corner-slide", "normal force until the edge, largest deviation"): VERTEX.partition(":")[0],
    ("two-rings", "coarse: stopped"): VERTEX,
    ("disc-in-ring", "stopped"): VERTEX,
    ("leaf-spring", "stopped"): CIRCLES,
    ("pulled-strip", "error of the energy ledger"): f"{UNKNOWN}: it stays with four times as many steps; the run warns",
}  # fmt: skip
"""By case ("" for any) and the number that misses first: why, as far as it was looked into."""


def why_missed(case: str, what: str) -> str:
    """The cause of a missed number."""
    return MISSED.get((case, what)) or MISSED.get(("", what)) or UNKNOWN
