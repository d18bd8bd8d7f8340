"""The cases on offer, the watches that they use, and measures of comparisons."""

from __future__ import annotations

from contactlab.api.plugin import Part, hookimpl

PACKAGE = "contactlab_cases"

WATCHES = (
    ("series", "series:Series", "quantities of every step as a table"),
    ("leapfrog-energy", "series:LeapfrogEnergy", "the energy that leapfrog keeps, and the force along a bar"),
    ("contact-changes", "dynamics:ContactChanges", "conditions that open or close in every step"),
    ("slips", "dynamics:Slips", "largest slip that a condition adds up to"),
    ("tip", "dynamics:Tip", "displacement of the first slave node"),
    ("nodal-forces", "dynamics:NodalForces", "contact forces on every node of the slave"),
    ("overlap-area", "dynamics:Overlap", "largest area between two surfaces"),
)
MEASURES = (
    ("contact-length", "measures:ContactLength", "length of the surface that is pressed"),
    ("pressure-centre", "measures:PressureCentre", "point where the resultant of the pressure acts"),
    ("peak-error", "measures:PeakError", "largest pressure against the reference's"),
)
REFERENCES = (("even-compression", "even_compression:EvenCompression", "two layers pressed evenly, exact"),)
CASES = (
    ("patch", "patch:Patch", "patch test", "Taylor & Papadopoulos 1991"),
    ("hertz", "hertz:Hertz", "cylinder on a block, like materials", "Johnson 1985"),
    ("nafems-cgs1", "cgs1:Cgs1", "steel cylinder on aluminium", "NAFEMS R0081"),
    ("stiffness-contrast", "stiffness_contrast:StiffnessContrast", "stiff cylinder on a soft block", "Johnson 1985"),
    ("mesh-ratio", "mesh_ratio:MeshRatio", "meshes 1:10", "Johnson 1985"),
    ("mesh-ladder", "mesh_ladder:MeshLadder", "mesh ratios with consistent forces", "energy and equilibrium"),
    ("incompressible", "incompressible:Incompressible", "cylinder on a nearly incompressible block", "Johnson 1985"),
    ("rigid-punch", "rigid_punch:RigidPunch", "rigid flat punch", "Johnson 1985"),
    ("elastic-punch", "elastic_punch:ElasticPunch", "exponent at the corners of a square punch", "Dundurs & Lee 1972"),
    ("mindlin", "mindlin:Mindlin", "partial slip and its reversal", "Mindlin 1949"),
    ("two-rings", "two_rings:RingsPressed", "two rings pressed together", "Michell 1899"),
    ("shrink-fit", "shrink_fit:ShrinkFit", "a ring shrunk onto another", "Lame 1852"),
    ("disc-in-ring", "disc_in_ring:DiscInRing", "a disc in a ring", "Michell 1899"),
    ("three-rings", "three_rings:ThreeRings", "three rings shrunk onto each other", "Lame 1852"),
    ("stuck-rings", "stuck_rings:StuckRings", "two rings that stick to each other", "Michell 1899"),
    ("torsion-fit", "torsion_fit:TorsionFit", "a ring pressed onto another and turned", "Coulomb 1784"),
    ("westergaard", "westergaard:Westergaard", "a rigid wave on a half plane", "Westergaard 1939"),
    ("blunt-wedge", "wedge:BluntWedge", "a blunt wedge on a half plane", "Johnson 1985"),
    ("rounded-punch", "rounded_punch:RoundedPunch", "rigid punch with rounded edges", "Ciavarella et al. 1998"),
    ("fourth-power", "fourth_power:FourthPower", "rigid profile x^4 on a half plane", "Steuermann 1939"),
    ("tilted-punch", "tilted_punch:TiltedPunch", "rigid flat punch that leans", "Johnson 1985"),
    ("sliding-punch", "sliding_punch:SlidingPunch", "rigid flat punch that slides", "Johnson 1985"),
    ("leaf-spring", "leaf_spring:LeafSpring", "two leaves that touch at the tip of the shorter", "Timoshenko"),
    ("lifted-beam", "lifted_beam:LiftedBeam", "heavy beam lifted at one end", "Timoshenko"),
    ("inclined-layers", "inclined_layers:InclinedLayers", "two layers with an inclined interface", "Coulomb"),
    ("pulled-strip", "pulled_strip:PulledStrip", "strip pulled out of its friction", "Coulomb"),
    ("upsetting", "upsetting:Upsetting", "plastic block between smooth dies", "plane strain flow"),
    ("prandtl-punch", "prandtl_punch:PrandtlPunch", "punch on a plastic half plane", "Prandtl 1920"),
    ("unlike-bars", "unlike_bars:UnlikeBars", "bars of unlike impedance", "de Saint-Venant 1867"),
    ("row-of-bars", "row_of_bars:RowOfBars", "a bar hits a row of bars", "de Saint-Venant 1867"),
    ("bar-between-walls", "bar_between_walls:BarBetweenWalls", "bar that flies between walls", "elastic waves"),
    ("sliding-cylinder", "sliding_cylinder:SlidingCylinder", "cylinder that slides, like materials", "Johnson 1985"),
    ("receding-layer", "receding_layer:RecedingLayer", "layer on a block, receding contact", "Keer et al. 1972"),
    ("few-cells", "few_cells:FewCells", "blocks of one element a side", ""),
    ("unlike-layers", "unlike_layers:UnlikeLayers", "layers that slide: short waves grow", "Ranjith & Rice 2001"),
    ("spring-friction", "spring_friction:SpringFriction", "block on a spring with friction", "Den Hartog 1931"),
    ("oblique-discs", "oblique_discs:ObliqueDiscs", "oblique impact of two discs with spin", "Routh 1860"),
    ("rolling-disc", "rolling_disc:RollingDisc", "disc thrown along a floor until it rolls", "Routh 1860"),
    ("tossed-block", "tossed_block:TossedBlock", "block tossed by a table", "free flight"),
    ("rocking-block", "rocking_block:RockingBlock", "block that rocks on its base", "Housner 1963"),
    ("chatter", "chatter:Chatter", "block that chatters on a shaken table", "Mehta & Luck 1990"),
    ("long-run", "long_run:LongRun", "block that swings for very many steps", "Hairer et al. 2003"),
    ("bars-with-gap", "bars_with_gap:BarsWithGap", "bars whose gap closes and opens", "Timoshenko"),
    ("rough-plate", "rough_plate:RoughPlate", "plate on a rough plane", "Code_Aster SSNV128"),
    ("pulled-block", "pulled_block:PulledBlock", "block that only friction holds", ""),
    ("tresca-block", "tresca_block:TrescaBlock", "block with Tresca friction", "Baillet & Sassi 2005"),
    ("ironing", "ironing:Ironing", "shallow ironing", "Fischer & Wriggers 2006"),
    ("disc-on-block", "disc_on_block:DiscOnBlock", "disc pressed deep into a block", "Baillet & Sassi 2005"),
    ("forging", "forging:Forging", "forging of three plastic bodies", "Baillet & Sassi 2005"),
    (
        "disc-with-friction",
        "disc_with_friction:DiscWithFriction",
        "disc on block loaded in time",
        "Baillet & Sassi 2005",
    ),
    ("taylor-bar", "taylor_bar:TaylorBar", "copper bar against a wall", "Taylor 1948"),
    ("wall-impact", "wall_impact:WallImpact", "bar against a wall, implicit", "Timoshenko & Goodier"),
    ("two-beams", "two_beams:TwoBeams", "two beams, one clamped", "Code_Aster SDNL111"),
    ("resting-block", "resting_block:RestingBlock", "block that comes to rest in large steps", ""),
    ("bouncing-bar", "bouncing_bar:BouncingBar", "bouncing bar", "Doyen, Ern & Piperno 2011"),
    ("two-bars", "two_bars:TwoBars", "two bars that exchange their momentum", "de Saint-Venant 1867"),
    ("block-on-incline", "block_on_incline:BlockOnIncline", "block on an incline", "Coulomb"),
    ("sliding-flutter", "sliding_flutter:SlidingFlutter", "block that flutters as it slides", "Martins et al. 1995"),
    ("corner-slide", "corner_slide:CornerSlide", "slide over a corner", ""),
    ("vertex-to-vertex", "vertex_to_vertex:VertexToVertex", "two squares, corner on corner", "Wriggers 2006"),
    ("initial-overlap", "initial_overlap:InitialOverlap", "initial overlap and gap", ""),
    ("stack", "stack:Stack", "blocks upon each other at rest", ""),
    ("dropped-block", "dropped_block:DroppedBlock", "a block bounces until it rests", ""),
    ("pressed-block", "dropped_block:PressedBlock", "a block pressed again and again", ""),
    ("spinning-pair", "spinning_pair:SpinningPair", "two blocks that turn freely", ""),
)


@hookimpl
def contactlab_parts() -> list[Part]:
    """Offer the cases, one file each, the watches that they use, and measures and references of comparisons."""
    measures = [Part("measure", name, f"{PACKAGE}.{target}", says) for name, target, says in MEASURES]
    watches = [Part("watch", name, f"{PACKAGE}.{target}", says) for name, target, says in WATCHES]
    references = [Part("reference", name, f"{PACKAGE}.{target}", says) for name, target, says in REFERENCES]
    offered = watches + measures + references
    return offered + [Part("case", name, f"{PACKAGE}.{target}", says, ref) for name, target, says, ref in CASES]
