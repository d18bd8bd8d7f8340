"""Cases that are hard for contact algorithms, each with what is measured and what must come out.

A case is a function of the name of an algorithm and of `full`: False for meshes and times that suit a test suite,
True for those of the published figures. It runs bundled scenes and returns figures; it raises SimulationFailure
where a run does not come to its end.
"""

from collections.abc import Callable

from contactlab.testing.cases.bars import bouncing_bar, two_bars
from contactlab.testing.cases.corner import corner_slide
from contactlab.testing.cases.figures import Figure
from contactlab.testing.cases.resting import dropped_block, stack_at_rest
from contactlab.testing.cases.sliding import block_on_incline
from contactlab.testing.cases.start import initial_overlap
from contactlab.testing.cases.turning import spinning_pair
from contactlab.testing.cases.vertex import vertex_to_vertex

Case = Callable[[str, bool], list[Figure]]

CASES: dict[str, Case] = {
    "bouncing bar": bouncing_bar,
    "two bars": two_bars,
    "block on an incline": block_on_incline,
    "slide over a corner": corner_slide,
    "vertex to vertex": vertex_to_vertex,
    "initial overlap and gap": initial_overlap,
    "stack at rest": stack_at_rest,
    "dropped block": dropped_block,
    "spinning pair": spinning_pair,
}

__all__ = ["CASES", "Case", "Figure"]
