"""Why cells of the full matrix have no right answer, or miss a number; or that the cause is not known.

A test holds `CAUSES` complete and without entries that are no longer needed, so that the list can only shrink.
"""

from __future__ import annotations

NODES = "node-on-segment"
UNKNOWN = "not known"

LEANING = "normals averaged on the slave are tilted next to a node just released, and do work on the sliding there"
ONE_PASS = "one-pass conditions do not transmit a constant pressure between non-matching meshes"
VERTEX = "forces jump where a node lies on a vertex of the master: the iteration alternates; the run reports it"
FINE_ON_SOFT = (
    "a stiff slave of finer cells than the soft master: multipliers between the master's nodes are not determined, and "
    "statuses keep changing; the run reports it, and with the sides exchanged the case is met"
)
LINEAR = (
    "statics with conjugate forces converge linearly, and forces jump where a segment comes within reach: they run out "
    "of iterations; the explicit run finishes"
)
ROUGH = "very high friction: the set of sticking nodes keeps changing; the run reports it"
CORNERS = (
    "two corners that meet head on: nodes are pushed out of the other body's side, and contact makes energy, for which "
    "the run is stopped"
)
FREE_NODES = (
    "nodes of the finer billet are free between those of the anvil, and metal sinks in by half a segment; on tools of "
    "equal segments explicit runs finish"
)
NODE_BY_NODE = "contact opens node by node, one or two per iteration: more than the work limit allows on this mesh"

MORTARS = ("mortar-p0", "mortar-p1", "mortar-dual")
POTENTIALS = ("midplane", "barrier")
LAW, NITSCHE = "gauss-point passes=2 + linear-pressure", "mortar-p1 + nitsche"
GIVES = "surfaces overlap, or stay apart, by what the potential needs; below 2 % of the work no run warns"
BY_LAW = "the law asks for an overlap that the exact answer has not, and what a scene asks for is not warned of"
HALVES = (
    "each half pass presses by its own gaps: forces of both sides balance, and keep energy, as far as meshes resolve"
)
STIFFENS = (
    "steps of implicit dynamics keep no energy of a potential that stiffens; a barrier pushes before surfaces meet"
)
BY_STEPS = "pressures follow the stress and are found by iterations: what is left is Newton's tolerance"
UNHELD = "nothing but friction holds the body, and friction of a potential holds nothing before surfaces press"
MORE = "potentials take 1.5 to 4 times the iterations of a mortar, more than the work limit allows"
SLOW = f"{MORE}, within the 60 s that a run had here"
SLIPS = "friction of a potential grows with the slip of a step: it stays below its bound by less than is warned of"
NO_START = "finds no first equilibrium, or presses no node; the run reports it"
NOT_EXAMINED = "not examined"
POINTS = "points of a slave segment do not see where segments of the master end: a constant pressure passes to 1 to 3 %"
TURNS = (
    "nothing but springs holds a disc in a ring against turning: forces along its facets turn it by 1e-4, "
    "far more than it deforms; the run tells the saw-tooth that this leaves"
)

CAUSES: dict[tuple[str, str, str], str] = {
    **{(case, LAW, "silent"): BY_LAW for case in ("bars-with-gap", "disc-in-ring", "disc-with-friction", "few-cells")},
    **{(case, LAW, "silent"): BY_LAW for case in ("inclined-layers", "patch", "two-rings")},
    **{
        (case, LAW, "silent"): HALVES
        for case in ("mindlin", "oblique-discs", "receding-layer", "spinning-pair", "two-beams")
    },
    **{(case, LAW, "silent"): NOT_EXAMINED for case in ("mesh-ladder", "unlike-layers")},
    (
        "shrink-fit",
        LAW,
        "silent",
    ): "facets of unlike meshes are as deep as the interference: no node of either side presses",
    ("corner-slide", LAW, "failed"): "contact changes more often than the case can hold: not examined",
    ("vertex-to-vertex", LAW, "failed"): CORNERS,
    **{(case, "gauss-point", "silent"): POINTS for case in ("bars-with-gap", "few-cells", "patch")},
    ("inclined-layers", "gauss-point", "silent"): f"{POINTS}: what moves less than one per cent is not warned of",
    ("two-rings", "gauss-point", "silent"): f"{POINTS}: on a curve first order where the case allows second",
    ("patch", "gauss-point", "failed"): "one segment over ten: two points of it do not see most of the master",
    ("mesh-ladder", "gauss-point", "failed"): "slave nodes and points leave nodes of a finer master between them",
    ("oblique-discs", "gauss-point", "failed"): "frozen forces along averaged normals make energy: the run is stopped",
    ("prandtl-punch", "gauss-point", "failed"): f"`q1` with cells of a fortieth beside the edge: {NOT_EXAMINED}",
    ("stiffness-contrast", "gauss-point", "failed"): FINE_ON_SOFT,
    ("lifted-beam", "gauss-point", "not-judged"): NODE_BY_NODE,
    ("rough-plate", "gauss-point", "not-judged"): ROUGH,
    ("disc-in-ring", "gauss-point", "silent"): TURNS,
    ("forging", "gauss-point", "failed"): NOT_EXAMINED,
    **{(case, part, "silent"): GIVES for case in ("bars-with-gap", "upsetting") for part in POTENTIALS},
    ("patch", "barrier", "silent"): GIVES,
    ("rigid-punch", "barrier", "silent"): "a clearance, and pressures spread over the segments beside a node",
    ("wall-impact", "midplane", "silent"): STIFFENS,
    **{("sliding-punch", part, "silent"): SLIPS for part in POTENTIALS},
    **{("pulled-block", part, "failed"): UNHELD for part in POTENTIALS},
    ("ironing", "barrier", "not-judged"): MORE,
    **{(case, "midplane", "not-judged"): MORE for case in ("disc-on-block", "lifted-beam", "receding-layer")},
    **{("forging", part, "not-judged"): SLOW for part in POTENTIALS},
    **{("rough-plate", part, "not-judged"): ROUGH for part in POTENTIALS},
    ("disc-on-block", "barrier", "not-judged"): MORE,
    ("mesh-ratio", "barrier", "not-judged"): SLOW,
    **{(case, "midplane", "failed"): NO_START for case in ("nafems-cgs1", "tilted-punch")},
    **{
        (case, "barrier", "failed"): NO_START
        for case in ("hertz", "mesh-ratio", "nafems-cgs1", "patch", "tilted-punch")
    },
    ("patch", f"{NITSCHE} theta=1", "silent"): BY_STEPS,
    **{("stiffness-contrast", name, "failed"): FINE_ON_SOFT for name in (*MORTARS, NITSCHE)},
    ("inclined-layers", NODES, "silent"): f"{ONE_PASS}: the same on a slope",
    ("few-cells", NODES, "silent"): ONE_PASS,
    ("patch", NODES, "silent"): ONE_PASS,
    ("patch", NODES, "failed"): VERTEX,
    ("two-rings", NODES, "silent"): f"{ONE_PASS}: on a curve first order where the case allows second",
    ("disc-in-ring", NODES, "silent"): f"{ONE_PASS}: on a curve first order where the case allows second",
    ("hertz", NODES, "silent"): f"{ONE_PASS}: the pressure oscillates over several nodes, which is no saw-tooth",
    ("hertz", NODES, "failed"): VERTEX,
    ("stiffness-contrast", NODES, "failed"): VERTEX,
    ("nafems-cgs1", NODES, "failed"): VERTEX,
    ("ironing", NODES, "not-judged"): VERTEX,
    ("ironing", NODES, "failed"): VERTEX,
    ("lifted-beam", NODES, "not-judged"): NODE_BY_NODE,
    **{("lifted-beam", name, "not-judged"): NODE_BY_NODE for name in ("mortar-p1", NITSCHE)},
    ("ironing", "mortar-dual", "not-judged"): f"19 iterations a step, of a case made for 10: {NOT_EXAMINED}",
    ("prandtl-punch", "mortar-dual", "failed"): (
        "`q1-fbar` with the block as slave: statuses of nodes beside the edge, a fortieth of it long, alternate"
    ),
    ("disc-on-block", NODES, "not-judged"): VERTEX,
    **{("rough-plate", name, "not-judged"): ROUGH for name in ("mortar-p0", "mortar-p1", NITSCHE)},
    ("bars-with-gap", NODES, "silent"): ONE_PASS,
    ("stuck-rings", NODES, "silent"): f"{ONE_PASS}: on a curve first order (0.97 to 1.1) where the case allows second",
    ("two-rings", NODES, "failed"): VERTEX,
    ("forging", NODES, "failed"): FREE_NODES,
    ("mesh-ratio", NODES, "failed"): VERTEX,
    ("prandtl-punch", NITSCHE, "failed"): f"`q1` with the block as slave, as `mortar-p0`; {NOT_EXAMINED}",
    ("prandtl-punch", "mortar-p0", "failed"): (
        "`q1` with the block as slave: cells beside the edge, a fortieth of it long, fold over at 93 % of the way; "
        "pushed in by a third of that, with a stiffness of 3000, they do not"
    ),
    ("mesh-ladder", NODES, "failed"): (
        "with like meshes and finer slaves runs do not settle; slave nodes sink between the nodes of a finer master"
    ),
    ("mesh-ladder", NODES, "not-judged"): LINEAR,
    **{("mesh-ladder", f"mortar-p{n}", "failed"): LINEAR for n in (0, 1)},
    ("mesh-ladder", "mortar-p1", "not-judged"): LINEAR,
}
"""By case, algorithm and verdict: why there is no right answer, or no warning that it is wrong."""

RIM = (
    "pressures on partly covered segments at a rim are shown on whole segments; over what is covered the integral "
    "agrees to 0.7 % or better"
)
EDGE = "the position of the edge of contact between two nodes decides; the tolerance falls with the cells"
SAW = "the run warns of it: a pressure that alternates from node to node does little work on the cells"
FACETS = "nodes of two polygons that do not meet: their facets are as deep as the interference"
LATE_FORCE = "a step's force acts along the surfaces at its end; half the step gives half the change"
CIRCLES = "the tip of the master lies within a quadratic segment of the slave: Newton's method cycles"
BESIDE = (
    "a node that lies half a cell beyond the tip is held by the last node of the master: the force acts 0.44 of 20 mm "
    "beyond the tip (measured from its place)"
)
CORNER_NORMALS = (
    "nodes lie on vertices of the master, where forces act along the normal of one of both segments: the resultant "
    "turns by two thirds of half their angle, and by half as much on cells half as long"
)
FINE_SLAVE = "a slave of finer cells than the master carries the pressure of the master's facets"

TOLD = "potentials: overlaps or clearances, of which the run warns (`kept-overlap`)"
CREEPS = "potentials: friction gives way by slips, of which the run warns (`creep`)"

MISSED: dict[tuple[str, str], str] = {
    ("few-cells", "way of the top"): TOLD,
    ("few-cells", "pressure, largest difference"): TOLD,
    ("patch", "displacement"): f"{TOLD}; nitsche: {BY_STEPS}",
    ("receding-layer", "nodes that the load closes or opens"): TOLD,
    ("disc-on-block", "work that would open all pressed nodes over that of the stresses"): TOLD,
    ("inclined-layers", "stress along y"): CREEPS,
    ("pulled-strip", "length that slips"): CREEPS,
    ("mindlin", "stick half-width in segments"): "potentials: nodes whose segments slip in part count as sticking",
    ("disc-in-ring", "mean pressure"): BY_LAW,
    ("ironing", "sum of all contact forces"): HALVES,
    ("prandtl-punch", "sum of all contact forces"): HALVES,
    ("", "saw-tooth of the pressure"): SAW,
    ("", "saw-tooth of the shear"): "the run warns of it: as for the pressure",
    ("corner-slide", "saw-tooth of the pressure"): "the base is a zigzag, whose vertices are pressed",
    ("rigid-punch", "resultant against integral of the pressure"): RIM,
    ("tilted-punch", "resultant against integral of the pressure"): RIM,
    ("elastic-punch", "resultant against integral of the pressure"): RIM,
    ("leaf-spring", "resultant against integral of the pressure"): RIM,
    ("sliding-punch", "resultant against integral of the pressure"): RIM,
    ("mesh-ladder", "reaction against statics with the same forces"):
        "slaves five or eight times coarser: overlaps that came in an instant stay, and the run warns of them "
        "(`kept-overlap`); the run with nodes on segments warns that its end is not symmetric",
    ("rolling-disc", "momentum lost while it slides over mu times the impulse of the floor, less one"):
        "normals averaged on the disc lean at the ends of contact; nodes on segments meet it",
    ("disc-with-friction", "reaction"):
        "four or five nodes carry it: -3 % (mortars) and -6 to +5 % (nodes on segments) become -0.2 and -0.7 to 0.5 % "
        "on cells half as long",
    ("disc-with-friction", "reaction with the slaves exchanged, less one"):
        f"{ONE_PASS}; it falls with the cells, shallow from 11 to 1.2 %",
    ("forging", "force on the floor"): "nodes of the billet sink in: -10 % becomes -3.4 % on cells half as long",
    ("rolling-disc", "speed when it rolls over that of a rigid disc, less one"):
        "cells of the disc: -3.4 % becomes -2.0 % on cells half as long, and -3.5 % with four times the modulus",
    ("disc-on-block", "resultant against integral of the pressure"): RIM,
    ("forging", "resultant against integral of the pressure"): RIM,
    ("prandtl-punch", "resultant against integral of the pressure"): RIM,
    ("prandtl-punch", "mean pressure over the limit, less one"):
        "`q1` locks, and the run warns of it; `q2`, where it is below: cells, -2.2 % becomes -1.7 % on cells two "
        "thirds as long; nodes on segments with the block as slave hold nodes beyond the punch",
    ("ironing", "resultant against integral of the pressure"): RIM,
    ("mesh-ratio", "resultant against integral of the pressure"): RIM,
    ("shrink-fit", "resultant against integral of the pressure"): CORNER_NORMALS,
    ("three-rings", "resultant against integral of the pressure"): CORNER_NORMALS,
    ("inclined-layers", "resultant against integral of the pressure"): "slips of 2e-5 uncover as much of a segment",
    ("hertz", "L2 of the pressure"): EDGE,
    ("hertz", "half-width in segments"): EDGE,
    ("hertz", "largest pressure"): FINE_SLAVE,
    ("sliding-cylinder", "L2 of the pressure"): EDGE,
    ("rounded-punch", "L2 of the pressure"): "most of the face is flat: the pressure rises at its rim within few cells",
    ("rounded-punch", "largest pressure"): "most of the face is flat: the pressure rises at its rim within few cells",
    ("rigid-punch", "L2 of the pressure over 0.9 a"): "the singular edge affects the cells next to it",
    ("stiffness-contrast", "largest pressure"): FINE_SLAVE,
    ("stiffness-contrast", "L2 of the pressure"): ONE_PASS,
    ("oblique-discs", "change of the angular momentum"): LATE_FORCE,
    ("vertex-to-vertex", "change of the angular momentum"): LATE_FORCE,
    ("oblique-discs", "energy gained"): LEANING,
    ("oblique-discs", "part of the normal speed that is left"):
        "facets: without friction forces on a polygon still lean, and the spin, 4.5 times the energy of flight, passes "
        "4 % of its own to it (60 to 58.7 1/s); at levels 2 and 4 nothing (0.979, 0.976), without spin 0.955",
    ("taylor-bar", "energy taken by flow over the kinetic one, less one"): "with `q1-reduced` only",
    ("bouncing-bar", "highest point after the last period, later than exact [periods]"):
        "implicit runs only: lumped masses and long steps slow waves (docs/statics.md)",
    ("bar-between-walls", "speed in the end"): "late by part of an impact after twenty: the run ends during one",
    ("wall-impact", "mean force"): "five cells a step, and contact begins in the middle of a step",
    ("shrink-fit", "mean pressure"): FACETS,
    ("shrink-fit", "largest difference of a node from the mean"): FACETS,
    ("initial-overlap", "ramped: force in the end"): "free master nodes oscillate through the coarser slave",
    ("pulled-block", "slip of sticking nodes in segments"):
        "`q2` only: with friction, multipliers are at the ends of quadratic edges, and nodes between them are free",
    ("two-rings", "order of the carried pressure"): "meshes too coarse for the asymptotic order",
    ("patch", "stress"): ONE_PASS,
    ("mindlin", "loaded: peak of the shear"): ONE_PASS,
    ("nafems-cgs1", "largest pressure"): ONE_PASS,
    ("elastic-punch", "exponent less the exact one"): ONE_PASS,
    ("two-rings", "L2 of the carried pressure"): ONE_PASS,
    ("disc-in-ring", "L2 of the carried pressure"): ONE_PASS,
    ("corner-slide", "normal force until the edge, largest deviation"): VERTEX.partition(":")[0],
    ("two-rings", "coarse: stopped"): VERTEX,
    ("leaf-spring", "stopped"): CIRCLES,
    ("leaf-spring", "force between the leaves"): BESIDE,
    ("leaf-spring", "torque of all contact forces in segments"): BESIDE,
    ("incompressible", "oscillation"): "second differences at the edge of contact: 0.202, on cells half as long 0.097",
    ("mindlin", "shear reversed against loaded"): "a node at the end of contact: 7e-4, on cells half as long 2e-5",
    ("lifted-beam", "pull of a contact node over the largest push"):
        "the iteration ends with a node just let go, which still carries its pull; the run warns of it",
    ("westergaard", "pull of a contact node over the largest push"):
        "gaps of 1e-9 of a segment count as touching: under the smallest load their pull shows; the run warns of it",
    ("bars-with-gap", "stopped"):
        f"{VERTEX.partition(':')[0]}: with all statuses fixed the residual alternates at 1e-7, where 1e-8 is asked",
    ("stuck-rings", "order of the carried pressure"):
        "mortars: meshes too coarse for it (1.89 and 1.85 on cells half as long); nodes on segments: first order",
    ("stuck-rings", "L2 of the carried pressure"): ONE_PASS,
    ("torsion-fit", "pull of a contact node over the largest push"):
        "what the iteration leaves, of which the run warns: below 1e-13 with a tolerance of 1e-7 and 1e-5 with 1e-9",
    ("torsion-fit", "L2 of the carried pressure"): ONE_PASS,
    ("torsion-fit", "L2 of the carried shear"):
        "a shear of 1/50 to 1/5 of the pressure, of which leaning normals add a part: with ten times the friction the "
        "error is a fifth to a seventh",
}  # fmt: skip
"""By case ("" for any) and the number that misses first: the cause, as far as it was examined."""


def why_missed(case: str, what: str) -> str:
    """The cause of a missed number."""
    return MISSED.get((case, what)) or MISSED.get(("", what)) or UNKNOWN
