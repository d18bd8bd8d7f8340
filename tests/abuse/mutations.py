# ruff: noqa: E501 - pieces of sources are as long as they are there
"""The defects: what is exchanged for what, in which shipped part."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple


class Mutation(NamedTuple):
    """`old`, as it first stands in the source, becomes `new`.

    file    the module of it where not the part's own: beside it, or by its dotted name
    fields  of the part that is checked
    """

    kind: str
    part: str
    says: str
    old: str
    new: str
    file: str = ""
    fields: Mapping[str, Any] = MappingProxyType({})


M = Mutation


def _of(kind: str, part: str, *defects: tuple[str, ...]) -> tuple[Mutation, ...]:
    """Defects of one part: what each says, the old piece, the new one, and the module where not the part's own."""
    return tuple(Mutation(kind, part, *defect) for defect in defects)


_DECLARED = {
    "mortar": '(mortar-operators.md, quadratic edges)\n    """\n',
    "node": "    closest_points: ClassVar[bool] = True\n",
    "gauss": "    keeps_energy: ClassVar[bool] = True\n",
    "half": "    points_press: ClassVar[bool] = True\n",
}
_TWO = {"passes": 2}
_MIDPLANE = "    @formula\n    def normal("
_FOOT = '''    passes_patch_test: ClassVar[bool] = False

    @formula
    def foot(x: Any, master: Any) -> Any:
        """The closest point of the segment's line."""
        edge = master.edge()
        return ((x.at - master.start) @ edge) / (edge @ edge)'''
"""Of two half passes."""


def _method(method: str, part: str, says: str, *lines: str) -> Mutation:
    """A contact algorithm, or that of two half passes, with a method of its own beside its formulas."""
    body, declared = "\n        ".join([f"    def {method}:", *lines]), _DECLARED[part.partition("-")[0]]
    name, fields = ("gauss-point", _TWO) if part == "half-pass" else (part, {})
    return M("contact", name, says, declared, f"{declared}\n{body}\n", fields=fields)


def _pieces(part: str, says: str, *lines: str) -> Mutation:
    """Pieces are spoilt after they are made."""
    return _method("pieces(self, view, out)", part, says, "count = super().pieces(view, out)", *lines, "return count")


_DERIVATIVES = "derivatives(self, view, pieces, count, out)"

CONTACT = (
    _pieces("mortar-p1", "master weights 1 % too large", "out.M[:count] *= 1.01"),
    _pieces("mortar-p1", "normals turned round", "out.normal *= -1.0"),
    _pieces("mortar-p1", "the last piece is lost", "count -= 1"),
    _pieces("mortar-p0", "slave nodes of a piece exchanged", "out.slave[:count] = out.slave[:count, ::-1].copy()"),
    _pieces("mortar-p0", "T scaled, so that pressures are wrong and forces right", "out.T[:count] *= 2.0"),
    _pieces("mortar-p1", "D without its last column", "out.D[:count, :, -1] = 0.0"),
    _pieces("mortar-p1", "normals of length 1.001", "out.normal *= 1.001"),
    _pieces("mortar-p0", "every second step with old weights",
            "out.M[:count] = self.__dict__.setdefault('seen', {}).setdefault(count, out.M[:count].copy())"),
    _pieces("mortar-p1", "positions of the slave are moved a little", "view.at.slave[:, 0] += 1e-9"),
    _method(_DERIVATIVES, "mortar-p1", "no derivatives, and says they are given", "out.count = out.normal_count = 0", "return True"),
    _method(_DERIVATIVES, "mortar-p0", "derivatives of normals forgotten", "super().derivatives(view, pieces, count, out)", "out.normal_count = 0", "return True"),
    M("contact", "mortar-p0", "jumps in another place than it says", "if xi < 0.5", "if xi < 0.4"),
    M("contact", "mortar-p1", "multipliers of both ends exchanged", "return 1.0 - xi, xi", "return xi, 1.0 - xi"),
    M("contact", "mortar-p1", "begins where it should end", "slave.meets(master, low), slave.meets(master, high)", "slave.meets(master, high), slave.meets(master, low)"),
    M("contact", "node-on-segment", "says that it passes the patch test", "passes_patch_test: ClassVar[bool] = False", "passes_patch_test: ClassVar[bool] = True"),
    _method("pieces(self, view, out)", "node-on-segment", "remembers beside its memory",
            "own = self.__dict__.setdefault('own', {}).setdefault(view.memory.shape, view.memory.copy())", "return super().pieces(view._replace(memory=own), out)"),
    _method("normals(self, view, pieces, count, out)", "node-on-segment", "normals at the start of a step are those of its end", "out[:] = pieces.normal"),
    _method("capacity(self, slave, near)", "node-on-segment", "room for half the pieces", "return len(slave.nodes) // 2"),
    _method(_DERIVATIVES, "node-on-segment", "derivatives of normals forgotten", "super().derivatives(view, pieces, count, out)", "out.normal_count = 0", "return True"),
    M("contact", "node-on-segment", "feet seen from the other end", "return ((x.at - master.start) @ edge) / (edge @ edge)", "return 1.0 - ((x.at - master.start) @ edge) / (edge @ edge)"),
    M("contact", "node-on-segment", "feet beside the closest point", "return ((x.at - master.start) @ edge) / (edge @ edge)", "return ((x.at - master.start) @ edge) / (edge @ edge) + 0.05"),
    *_of(
        "contact", "mortar-dual",
        ("tilt of the wrong sign", "return 1.0 - middle - tilt, middle + tilt", "return 1.0 - middle + tilt, middle - tilt"),
        ("tilt halved", "tilt = 12.0 *", "tilt = 6.0 *"),
        ("as if all of a segment were covered", "middle, width = 0.5 * (covered.low + covered.high), covered.high - covered.low", "middle, width = 0.5, 1.0"),
        ("what is covered shifted", "middle, width = 0.5 * (covered.low + covered.high)", "middle, width = 0.5 * (covered.low + covered.high) + 0.05"),
        ("what is covered begins at the segment's end", "covered.high - covered.low", "covered.high"),
        ("ends exchanged", "return 1.0 - middle - tilt, middle + tilt", "return middle + tilt, 1.0 - middle - tilt"),
        ("width not squared", "/ (width * width)", "/ width"),
        ("tilts about the middle of the segment", "(xi - middle)", "(xi - 0.5)"),
        ("does not sum to one", "return 1.0 - middle - tilt, middle + tilt", "return 1.0 - middle - tilt, middle + 0.9 * tilt"),
        ("begins where the master ends", "slave.between(slave.sees(master.start), slave.sees(master.end))", "slave.between(slave.sees(master.end), slave.sees(master.end))"),
        ("both ends meet the master at one point", "slave.meets(master, low), slave.meets(master, high)", "slave.meets(master, low), slave.meets(master, low)"),
        ("sees half of the master", "slave.sees(master.end)", "slave.sees(0.5 * (master.start + master.end))"),
    ),
    _pieces("mortar-dual", "gap of the other sign", "out.normal *= -1.0"),
    _pieces("mortar-dual", "integrals over whole segments in place of what is covered",
            "share = (out.ends[:count, 2] - out.ends[:count, 0])[:, None, None]", "for a in (out.D, out.M, out.T):", "    a[:count] /= share"),
    _pieces("mortar-dual", "the master takes forces by the slave's shape functions", "out.M[:count] = out.D[:count, :out.M.shape[1]]"),
    _pieces("mortar-dual", "pressures of the neighbour", "out.multiplier[:count] = out.multiplier[:count, ::-1].copy()"),
    _pieces("mortar-dual", "coupling of the multipliers lumped, and not of the forces",
            "import numpy as np", "out.T[:count] = out.T[:count].sum(axis=(1, 2))[:, None, None] * np.eye(2) / 2.0"),
    _method(_DERIVATIVES, "mortar-dual", "the basis does not follow what is covered", "super().derivatives(view, pieces, count, out)", "out.dT[: out.count] = 0.0", "return True"),
    _method(_DERIVATIVES, "mortar-dual", "derivatives of the master's weights forgotten", "super().derivatives(view, pieces, count, out)", "out.dM[: out.count] = 0.0", "return True"),
    _method("normals(self, view, pieces, count, out)", "mortar-dual", "slips that miss how normals turn", "out[:] = pieces.normal"),
    *_of(
        "contact", "gauss-point",
        ("foot from the other end", "(x.at - master.start) @ edge", "(x.at - master.end) @ edge"),
        ("foot along the edge in mm", "/ (edge @ edge)", "/ edge.length()"),
        ("foot that is not perpendicular", "((x.at - master.start) @ edge) / (edge @ edge)", "((x.at - master.start) @ edge) / (edge @ edge) + 0.05"),
        ("foot on the mirrored side", "return ((x.at - master.start) @ edge) / (edge @ edge)", "return 1.0 - ((x.at - master.start) @ edge) / (edge @ edge)"),
        ("one point for two multipliers", "points: ClassVar[int] = 3", "points: ClassVar[int] = 1"),
        ("says that it passes the patch test", "passes_patch_test: ClassVar[bool] = False", "passes_patch_test: ClassVar[bool] = True"),
    ),
    _pieces("gauss-point", "gap of the other sign", "out.normal *= -1.0"),
    _pieces("gauss-point", "weights of a rule from -1 to 1", "for a in (out.D, out.M, out.T):", "    a[:count] *= 2.0"),
    _pieces("gauss-point", "forces of points without their weights", "for a in (out.D, out.M):", "    a[:count] /= out.T[:count].sum(axis=(1, 2))[:, None, None]"),
    _pieces("gauss-point", "the master takes forces by the slave's shape functions", "out.M[:count] = out.D[:count, :out.M.shape[1]]"),
    _pieces("gauss-point", "the nearest end of the master takes all", "out.M[:count, 0] += out.M[:count, 1]", "out.M[:count, 1] = 0.0"),
    _pieces("gauss-point", "pressures of the other end", "out.multiplier[:count] = out.multiplier[:count, ::-1].copy()"),
    _pieces("gauss-point", "the last point of a chain is lost", "count -= 1"),
    _pieces("gauss-point", "both ends of a segment share a point evenly", "out.D[:count] = 0.5 * out.D[:count].sum(axis=1, keepdims=True)"),
    _method("pieces(self, view, out)", "gauss-point", "forgets what held a point", "return super().pieces(view._replace(memory=0.0 * view.memory), out)"),
    _method(_DERIVATIVES, "gauss-point", "feet that do not move", "super().derivatives(view, pieces, count, out)", "out.dM[: out.count] = 0.0", "return True"),
    _method(_DERIVATIVES, "gauss-point", "normals that do not turn", "super().derivatives(view, pieces, count, out)", "out.normal_count = 0", "return True"),
    _method(_DERIVATIVES, "gauss-point", "weights that do not grow with a segment", "super().derivatives(view, pieces, count, out)", "out.dD[: out.count] = 0.0", "return True"),
    _method("normals(self, view, pieces, count, out)", "gauss-point", "slips that miss how normals turn", "out[:] = pieces.normal"),
    M("contact", "gauss-point", "half passes, feet that are not perpendicular", _FOOT, f"{_FOOT} + 0.05", fields=_TWO),
    M("contact", "gauss-point", "half passes, feet from the other end", _FOOT, _FOOT.replace("return ", "return 1.0 - "), fields=_TWO),
    M("contact", "gauss-point", "half passes, feet along the edge in mm", _FOOT, _FOOT.replace("(edge @ edge)", "edge.length()"), fields=_TWO),
    _pieces("half-pass", "half passes, gap of the other sign", "out.normal *= -1.0"),
    _pieces("half-pass", "half passes, each side counts twice", "for a in (out.D, out.M):", "    a[:count] *= 2.0"),
    _pieces("half-pass", "half passes, pressures of half the weights", "out.T[:count] *= 0.5"),
    _pieces("half-pass", "half passes, forces at the other end of a segment", "out.D[:count] = out.D[:count, ::-1].copy()"),
    _pieces("half-pass", "half passes, forces of a side without those of its last point", "count -= 1"),
    _pieces("half-pass", "half passes, normals of length 1.01", "out.normal *= 1.01"),
    _pieces("half-pass", "half passes, all points of a segment share a pressure", "out.multiplier[:count] %= len(view.slave.nodes)"),
    _method(_DERIVATIVES, "half-pass", "half passes, feet that do not move", "super().derivatives(view, pieces, count, out)", "out.dM[: out.count] = 0.0", "return True"),
    _method(_DERIVATIVES, "half-pass", "half passes, normals that do not turn", "super().derivatives(view, pieces, count, out)", "out.normal_count = 0", "return True"),
    _method("normals(self, view, pieces, count, out)", "half-pass", "half passes, slips that miss how normals turn", "out[:] = pieces.normal"),
    *_of(
        "contact", "barrier",
        ("pulls where it should push", "return np.asarray(found).reshape(-1, 2)", "return -np.asarray(found).reshape(-1, 2)"),
        ("half of the Hessian", "return self._barrier(view).hessian(", "return 0.5 * self._barrier(view).hessian("),
        ("steps through the other side", "displacement / (1.0 - KEPT)", "0.0 * displacement"),
        ("friction that drives", "found = potential.gradient(rubbing", "found = -potential.gradient(rubbing"),
        ("ignores mu", "bound.coefficient)", "1.0)"),
        ("friction without stiffness", "return potential.hessian(rubbing", "return 0.0 * potential.hessian(rubbing"),
        ("slip from the beginning of the run", "positions - view.start)\n        return np.asarray", "positions - view.reference)\n        return np.asarray"),
        ("a distance without a unit", "return self.dhat * float(", "return self.dhat + 0.0 * float("),
        ("a scale of pressure without a unit", "pressure = self.stiffness * float(", "pressure = 1e5 * self.stiffness + 0.0 * float("),
        ("energies without lengths", "use_physical_barrier=True", "use_physical_barrier=False"),
        ("forces without lengths", "found.use_area_weighting = True", "found.use_area_weighting = False"),
        ("sides that do not see each other", "(np.arange(len(points)) >= slaves)", "(np.arange(len(points)) >= 0)"),
        ("says that it passes the patch test", "passes_patch_test: ClassVar[bool] = False", "passes_patch_test: ClassVar[bool] = True"),
    ),
    *_of(
        "contact", "midplane",
        ("normals into the body", "return (own.edge()", "return -(own.edge()"),
        ("normals as long as segments", "(own.edge().unit() + other.edge().unit()).unit().turned()", "(own.edge() + other.edge()).turned()"),
        ("every part is a whole segment", "return own.opposite(other)", "return 0.0 * own.foot(other.start), 1.0 + 0.0 * own.foot(other.end)"),
        ("parts beyond their segment", "return own.opposite(other)", "return own.foot(other.start), own.foot(other.end)"),
        ("parts of the other side", "return own.opposite(other)", "return other.opposite(own)"),
        ("ends of sides pull", "return own.opposite(other)", "return max(0.0, own.foot(other.start)), min(1.0, own.foot(other.end))"),
        ("one pressure for every overlap", "stiffness * gap * gap", "stiffness * abs(gap)"),
        ("a stiffness without a unit", "p.stiffness * stiffness", "1e5 * p.stiffness"),
        ("ignores its stiffness", "0.5 * p.stiffness", "15.0"),
        ("surfaces attract", "return 0.5 * p", "return -0.5 * p"),
        *(
            (says, _MIDPLANE, f"    def {method}:\n        {body}\n\n{_MIDPLANE}")
            for says, method, body in (
                ("pulls from afar", "begins(self, view)", "return 1.0"),
                ("cuts all corrections", "largest_step(self, view, positions, displacement)", "return 0.5 * super().largest_step(view, positions, displacement)"),
                ("presses one side alone", "gradient(self, view, positions)", "return super().gradient(view, positions) * (np.arange(len(positions)) < len(view.slave.nodes))[:, None]"),
                ("half the stiffness", "hessian(self, view, positions)", "return 0.5 * super().hessian(view, positions)"),
                ("friction that drives", "friction_gradient(self, view, positions)", "return -super().friction_gradient(view, positions)"),
                ("friction without stiffness", "friction_hessian(self, view, positions)", "return 0.0 * super().friction_hessian(view, positions)"),
                ("slip from the beginning of the run", "friction_gradient(self, view, positions)", "return super().friction_gradient(view._replace(start=view.reference), positions)"),
                ("rubs one side alone", "friction_gradient(self, view, positions)", "return super().friction_gradient(view, positions) * (np.arange(len(positions)) < len(view.slave.nodes))[:, None]"),
                ("shear turned round", "nodal_forces(self, view, positions)", "found = super().nodal_forces(view, positions)\n        return found._replace(rub=-found.rub)"),
                ("shows twice the push", "nodal_forces(self, view, positions)", "found = super().nodal_forces(view, positions)\n        return found._replace(push=2.0 * found.push)"),
            )
        ),
    ),
)  # fmt: skip

MATERIAL = (
    *_of("material", "linear-elastic",
        ("half the shear", "2.0 * shear * H.symmetric()", "shear * H.symmetric()"),
        ("shear of one component alone", "H.symmetric()\n\n", "H\n\n"),
        ("energy without shear", " + shear * strain.dot(strain)", ""),
        ("says nothing of its rate: stress grows with the step", '(H: Any, p: Any) -> Any:\n        """Compute sigma = lambda tr(eps) I + 2 mu eps."""\n        first, shear = lame(p)', "(H: Any, dt: Any, p: Any) -> Any:\n        first, shear = lame(p)\n        shear = shear * (1.0 + dt)")),
    *_of("material", "neo-hookean",
        ("says a wave speed of shear that is too small", "    def elastic_limit(self)", "    def wave_speeds(self) -> Any:\n        fast, slow = super().wave_speeds()\n        return fast, 0.7 * slow\n\n    def elastic_limit(self)"),
        ("stiffening forgets tension", "+ tension\n", "+ 0.0 * tension\n"),
        ("stress of the transposed gradient", "neo_hookean(gradient, stress,", "neo_hookean(gradient[[0, 2, 1, 3]], stress,"),
        ("energy per undeformed volume", "+ 0.5 * first * log_j * log_j) / J", "+ 0.5 * first * log_j * log_j)"),
        ("ignores Poisson's ratio", "*lame_constants(self.young, self.poisson))\n\n    @formula", "*lame_constants(self.young, 0.3))\n\n    @formula")),
    *_of("material", "hypoelastic",
        ("stress of the last step is lost", "mean = 0.5 * (history.stress_xx + history.stress_yy)", "mean = 0.0 * history.stress_xx"),
        ("stiffening forgets that stresses turn", "+ 2.0 * radius) / shear", "- 2.0 * mean) / shear")),
    *_of("material", "linear-hardening",
        ("dissipation with half the yield stress", "(p.yield_stress + 0.5 * p.hardening * plastic)", "(0.5 * p.yield_stress + 0.5 * p.hardening * plastic)"),
        ("stiffening forgets the stress", "j2.stiffening(gradient, stress,", "j2.stiffening(gradient, 0.0 * stress,"),
        ("tangent as if it did not harden", "p.yield_stress + p.hardening * plastic, p.hardening", "p.yield_stress, 0.0"),
        ("says that it has another history", '    history_size: ClassVar[int] = 4\n', '    history_size: ClassVar[int] = 3\n'),
        ("returns to the strength in the middle of the step", "flow(plastic + step, p)", "flow(plastic + 0.5 * step, p)", "j2")),
)  # fmt: skip

ELEMENT = (
    *_of("element", "q2",
        ("a mid-side function with half its height", "(0.5 * (1.0 - points", "(0.25 * (1.0 - points"),
        ("corner functions of the wrong sign", "(a + b - 1.0)", "(a + b + 1.0)"),
        ("row sums, which give corners no mass", '= "hrz"', '= "row-sum"'),
        ("says that it is cubic", "degree: ClassVar[int] = 2", "degree: ClassVar[int] = 3"),
        ("sides ordered start, middle, end", "((0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7))", "((0, 4, 1), (1, 5, 2), (2, 6, 3), (3, 7, 0))", "quadratic"),
        ("sides listed clockwise", "EDGES: Final = ((0, 1, 4),", "EDGES: Final = ((1, 0, 4),", "quadratic"),
        ("two points in each direction", "leggauss(3)", "leggauss(2)", "quadratic")),
    *_of("element", "q1",
        ("points in the corners", "Quadrature(_G * self.nodes", "Quadrature(0.9 * self.nodes"),
        ("weights that sum to 2", "np.ones(4)", "0.5 * np.ones(4)"),
        ("nodes numbered from another corner", "[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]", "[[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]]"),
        ("functions of the other side's nodes", "(1.0 + points[:, :1]", "(1.0 - points[:, :1]")),
    *_of("element", "q1-reduced",
        ("without hourglass stiffness", "return BlockKernels(kernels.gradient, kernels.force, stabilise)", "return BlockKernels(kernels.gradient, kernels.force)"),
        ("hourglass forces that push", "factor * shear, force", "-factor * shear, force")),
)  # fmt: skip

MESH = (
    *_of("mesh", "rectangle",
        ("one column too few", "along_x = axis(self.x, self.cells[0], self.grading[0], level)", "along_x = axis(self.x, self.cells[0], self.grading[0], 1)"),
        ("x and y exchanged", "(along_x(s), along_y(t))", "(along_y(t), along_x(s))"),
        ("mirrored", "lambda s, t: (along_x(s), along_y(t))", "lambda s, t: (-along_x(s), along_y(t))")),
    *_of("mesh", "arc-block",
        ("cells below the arc", "low + rows(t) * (self.top - low)", "low - rows(t) * (self.top - low)"),
        ("counts of level 1 at every level", "rows = axis((0.0, 1.0), self.cells[1], self.grading[1], level)", "rows = axis((0.0, 1.0), self.cells[1], self.grading[1], 1)"),
        ("edge sets without a name", '{"bottom": "arc", "right": "right", "top": "top", "left": "left"}', "{}"),
        ("depends on the calls before", "        mesh = structured(element, (columns.cells, rows.cells), place)\n        return renamed(", "        mesh = structured(element, (columns.cells, rows.cells), place)\n        mesh.nodes[:] += self.__dict__.setdefault('calls', [0.0])[0]\n        self.__dict__['calls'][0] += 1e-9\n        return renamed(")),
    *_of("mesh", "quad-block",
        ("corners in another order", "a, b, c, d = (np", "b, a, c, d = (np"),
        ("a corner counted twice", "x = rows + columns - corners", "x = rows + columns - 1.5 * corners")),
    *_of("mesh", "ring",
        ("not closed where it should be", "return welded([renamed(mesh, {\"inner\": \"inner\", \"outer\": \"outer\"})])", "return renamed(mesh, {\"inner\": \"inner\", \"outer\": \"outer\"})"),
        ("inside out", "return radius * np.cos(angle), radius * np.sin(angle)", "return radius * np.sin(angle), radius * np.cos(angle)")),
    *_of("mesh", "disc",
        ("quarters that do not meet", "return CORE * self.radius * np.array([math.cos(angle), math.sin(angle)])", "return CORE * self.radius * np.array([math.cos(angle), math.sin(angle + 1e-3 * number)])"),
        ("no cells in the middle", "mesh = welded([core, *quarters])", "mesh = welded(quarters)")),
)  # fmt: skip

FRICTION = (
    *_of("friction", "coulomb",
        ("ignores mu", "coefficient=self.mu", "coefficient=0.2"),
        ("mu of the wrong sign", "coefficient=self.mu", "coefficient=-self.mu"),
        ("never rubs", "coefficient=self.mu", "coefficient=0.0"),
        ("a bound that falls with pressure", "adhesion=0.0, cap=0.0", "adhesion=100.0, cap=-1.0"),
        ("mu becomes an adhesion without a number", "adhesion=0.0", "adhesion=float('nan')"),
        ("another mu in every call", "return FrictionBound(coefficient=self.mu", "self.__dict__['mu'] *= 1.01\n        return FrictionBound(coefficient=self.mu"),
        ("gives three numbers, not a bound", "return FrictionBound(coefficient=self.mu, adhesion=0.0, cap=0.0)", "return (self.mu, 0.0, 0.0)")),
    *_of("friction", "tresca",
        ("ignores the slip stress", "adhesion=self.stress", "adhesion=200.0"),
        ("no bound at all", "adhesion=self.stress", "adhesion=math.inf"),
        ("a cap of nothing", "cap=cap", "cap=0.0"),
        ("stress of the wrong sign", "adhesion=self.stress", "adhesion=-self.stress")),
)  # fmt: skip

ENFORCEMENT = (
    *_of("enforcement", "active-set",
        ("pulls", "trial = np.maximum(force - stiffness * gap, 0.0)\n", "trial = force - stiffness * gap\n"),
        ("gap of the wrong sign", "force - stiffness * (gap - TOUCHING", "force + stiffness * (gap - TOUCHING"),
        ("derivative by the gap forgotten", "out.by_gap[0] = np.where(closed, stiffness, 0.0)", "out.by_gap[0] = 0.0"),
        ("slip of the wrong sign", "trial = force - stiffness * conditions.slip", "trial = force + stiffness * conditions.slip"),
        ("bound does not follow the normal force", "np.where(follows, -sign * growth, 0.0)", "np.where(follows, 0.0 * growth, 0.0)"),
        ("absent conditions ask for nothing", "out.by_force[0] = np.where(closed, 0.0, 1.0)", "out.by_force[0] = np.where(closed | ~conditions.present, 0.0, 1.0)"),
        ("mu ignored", "FrictionBound(*conditions.bound)", "FrictionBound(0.2, *conditions.bound[1:])"),
        ("adhesion per node, not per length", "np.where(conditions.present, conditions.measure, 0.0)", "np.where(conditions.present, 1.0, 0.0)"),
        ("sticking told as slipping", "np.where(stick, STICK,", "np.where(stick, SLIP,")),
    *_of("enforcement", "penalty",
        ("says that it is exact", "exact: ClassVar[bool] = False", "exact: ClassVar[bool] = True"),
        ("softness forgotten in the derivative", "out.by_force += out.by_gap * softness", "pass"),
        ("a hundred times too soft", "1.0 / (factor * conditions.stiffness)", "1.0 / (0.01 * factor * conditions.stiffness)")),
    *_of("enforcement", "augmented-lagrangian",
        ("never takes forces over", "augments: ClassVar[bool] = True", "augments: ClassVar[bool] = False"),
        ("anchors of the tangential force", "conditions.anchor[0], out)", "conditions.anchor[-1], out)")),
    *_of("enforcement", "nitsche",
        ("tension presses", "max(0.0, -traction", "max(0.0, traction"),
        ("open gaps press", "-traction - p.gamma", "-traction + p.gamma"),
        ("glues", "return max(0.0, -traction - p.gamma * stiffness * gap)", "return -traction - p.gamma * stiffness * gap"),
        ("gamma without the depth of cells", "p.gamma * stiffness * gap", "p.gamma * 1e4 * gap"),
        ("gamma ignored", "p.gamma * stiffness * gap", "10.0 * stiffness * gap"),
        ("half of the stress", "max(0.0, -traction", "max(0.0, -0.5 * traction"),
        ("the stress alone", " - p.gamma * stiffness * gap", " + 0.0 * gap"),
        ("stress and gap press each on its own", "max(0.0, -traction - p.gamma * stiffness * gap)", "max(0.0, -traction) + max(0.0, -p.gamma * stiffness * gap)"),
        ("a pressure of its own", "max(0.0, -traction", "max(0.0, 0.1 - traction"),
        ("the distance of surfaces, whatever its sign", "stiffness * gap)", "stiffness * abs(gap))"),
        ("no traction is asked for", '("traction",)', "()"),
        ("adjoint without the pressure", "p.theta * (pressure + traction)", "p.theta * traction"),
        ("adjoint with a pressure of the wrong sign", "p.theta * (pressure + traction)", "p.theta * (traction - pressure)"),
        ("adjoint without the depth of cells", "/ (p.gamma * stiffness)", "/ (p.gamma * 1e4)"),
        ("adjoint in N, not mm", "/ (p.gamma * stiffness)", "* p.gamma * stiffness"),
        ("theta in the pressure", "max(0.0, -traction", "max(0.0, (p.theta - 1.0) * traction"),
        ("derivatives by the traction forgotten", "    @formula\n    def adjoint", "    def pressure_by_hand(self, gap, stiffness, size, pressure, slope, traction=None, by_traction=None):\n        wish = -traction - self.gamma * stiffness * gap\n        pressure[:] = wish * (wish > 0.0)\n        slope[:] = -self.gamma * stiffness * (wish > 0.0)\n        by_traction[:] = 0.0\n\n    @formula\n    def adjoint"),
        ("slope without gamma", "    @formula\n    def adjoint", "    def pressure_by_hand(self, gap, stiffness, size, pressure, slope, traction=None, by_traction=None):\n        wish = -traction - self.gamma * stiffness * gap\n        pressure[:] = wish * (wish > 0.0)\n        slope[:] = -stiffness * (wish > 0.0)\n        by_traction[:] = -1.0 * (wish > 0.0)\n\n    @formula\n    def adjoint")),
    *_of("enforcement", "linear-pressure",
        ("its own stiffness is never used", "if p.stiffness > 0.0", "if p.stiffness < 0.0"),
        ("pulls", "return max(0.0, -k * gap)", "return -k * gap"),
        ("gap of the wrong sign", "max(0.0, -k * gap)", "max(0.0, k * gap)"),
        ("factor ignored", "p.factor * stiffness", "10.0 * stiffness"),
        ("a stiffness without the depth of cells", "p.factor * stiffness", "p.factor * 1e5"),
        ("presses before surfaces meet", "max(0.0, -k * gap)", "max(0.0, 0.01 - k * gap)"),
        ("pressure falls as surfaces overlap", "max(0.0, -k * gap)", "max(0.0, -k * gap) / (1.0 + 1e6 * gap * gap)")),
    *_of("enforcement", "exponential-pressure",
        ("jumps where it begins", "if u <= 0.0:", "if u <= 0.2:"),
        ("given pressure ignored", "if p.pressure_at_zero > 0.0", "if p.pressure_at_zero < 0.0"),
        ("begins at touch, it says", "return self.clearance", "return 0.0"),
        ("begins at twice the clearance", "u = 1.0 - gap / p.clearance", "u = 2.0 - gap / p.clearance"),
        ("clearance ignored", "u = 1.0 - gap / p.clearance", "u = 1.0 - gap / 0.01"),
        ("grows as surfaces part", "u = 1.0 - gap / p.clearance", "u = 1.0 + gap / p.clearance"),
        ("names a length that it has not", 'length_scale: ClassVar[str] = "clearance"', 'length_scale: ClassVar[str] = "pressure_at_zero"'),
        ("a pressure in place of a stiffness behind", "p.factor * stiffness * p.clearance", "p.factor * 1e3"),
        ("pulls where it should end", "if u <= 0.0:", "if u <= -1.0:")),
    *_of("enforcement", "tabular-pressure",
        ("slope of the wrong sign", "slope[:] = (np.diff(values) / np.diff(gaps))[part]", "slope[:] = -(np.diff(values) / np.diff(gaps))[part]"),
        ("the slope of the entry before", "(np.diff(values) / np.diff(gaps))[part]", "(np.diff(values) / np.diff(gaps))[np.maximum(part - 1, 0)]"),
        ("steps in place of lines", "values[part] + slope * (gap - gaps[part])", "values[part]"),
        ("ends at once", "return self.gaps[-1]", "return self.gaps[0]"),
        ("pulls beyond its last gap", "beyond = gap >= gaps[-1]", "beyond = gap >= 1e9"),
        ("slope left beyond its last gap", "slope[beyond] = pressure[beyond] = 0.0", "pressure[beyond] = 0.0"),
        ("half of what the table says", "pressure[:] = values[part] + slope", "pressure[:] = 0.5 * values[part] + slope"),
        ("the mean of all gaps", "(gap - gaps[part])", "(gap.mean() - gaps[part])")),
    *_of("enforcement", "forward-increment",
        ("stops after two sweeps", "force, self.tolerance, self.sweeps", "force, self.tolerance, 2"),
        ("half the compliance", "rows.count, rows, compliance, multipliers", "rows.count, rows, 0.5 * compliance, multipliers"),
        ("forces of the last solve are kept", "solve = kernels.solve_dense if", "force[:] = 0.0\n        return Solve(0, 0.0, 0, 0.0) if rows.count else Solve(0, 0.0, 0, 0.0)\n        solve = kernels.solve_dense if")),
)  # fmt: skip

_IMPLICIT = "contactlab.implicit."
"""The package of the core in which implicit steps are made."""

INTEGRATOR = (
    *_of("integrator", "implicit-dynamics",
        ("says order 3", "order: ClassVar[int] = 2", "order: ClassVar[int] = 3"),
        ("internal forces of the end alone", "self.equations.internal_force(self.share * dt, self.share)", "self.equations.internal_force(dt)", _IMPLICIT + "time_step"),
        ("loads of the end alone", "out += self._at(self.start.load, self.load)", "out += self.load", _IMPLICIT + "time_step"),
        ("damping forgotten", "        if self.damping:\n", "        if False:\n", _IMPLICIT + "time_step"),
        ("work of contact not booked", "work[CONTACT] += np.vdot(normal, moved) + found.lost", "work[CONTACT] += 0.0", _IMPLICIT + "time_step"),
        ("work of loads with half its size", "work[EXTERNAL] += np.vdot(", "work[EXTERNAL] += 0.5 * np.vdot(", _IMPLICIT + "time_step"),
        ("reaction of the wrong sign", "reaction[held] = mass * (after - before) / self.dt + passed", "reaction[held] = -(mass * (after - before) / self.dt + passed)", _IMPLICIT + "time_step"),
        ("contact leaves velocities", "found = solve_impulses(contact, self.iteration.trial.response, self.mobility, self.v)", "found = solve_impulses(contact, self.iteration.trial.response, self.mobility, self.v.copy())", _IMPLICIT + "time_step"),
        ("a step that fails leaves the state", "            take_back(self.equations, state, start)\n", "            pass\n", _IMPLICIT + "motion")),
    *_of("integrator", "newton",
        ("work of contact lost", "work[CONTACT] += _work(pressed, normal, moved)", "pass", _IMPLICIT + "load_step"),
        ("work of the start alone", "0.5 * np.vdot(before + after, moved)", "np.vdot(before, moved)", _IMPLICIT + "load_step"),
        ("reaction with the load", "forces = self.external + (", "forces = -self.external + (", _IMPLICIT + "load_step"),
        ("contact forces without friction", "state[\"contact_force\"][:] = own.total()", "state[\"contact_force\"][:] = own.normal", _IMPLICIT + "load_step"),
        ("a step that fails leaves the state", "            take_back(self.equations, state, start)\n", "            pass\n", _IMPLICIT + "motion")),
    *_of("integrator", "central-difference",
        ("no half step at the start", "motion.kick(0.5 * (motion.last_dt + dt))", "motion.kick(dt)"),
        ("kicks that are too long", "0.5 * (motion.last_dt + dt)", "0.5 * (motion.last_dt + 1.1 * dt)"),
        ("no kick", "        motion.kick(0.5 * (motion.last_dt + dt))\n", ""),
        ("half the compliance for contact", "motion.contact(ahead=dt)", "motion.contact(ahead=0.5 * dt)"),
        ("no contact", "        motion.contact(ahead=dt)\n", ""),
        ("drifts that are too short", "motion.drift(dt)", "motion.drift(0.9 * dt)"),
        ("contact after the drift", "        motion.contact(ahead=dt)\n        motion.drift(dt)\n", "        motion.drift(dt)\n        motion.contact(ahead=dt)\n")),
)  # fmt: skip

EFFECT = (
    *_of("effect", "gravity",
        ("overwrites what others push", "force += weight if", "force[:] = weight if"),
        ("no force at all", "force += weight if time >= self.ramp else _smooth(time / self.ramp) * weight", "pass"),
        ("ignores the acceleration", "np.asarray(self.acceleration)", "np.array([0.0, -9810.0])"),
        ("grows with every call", "force += weight if", "self.__dict__['n'] = self.__dict__.get('n', 0) + 1\n            force += self.__dict__['n'] * weight if"),
        ("writes to the masses", "        weight = np.zeros((len(view.mass), 2))\n", "        weight = np.zeros((len(view.mass), 2))\n        view.mass[:] += 1e-9\n")),
    *_of("effect", "spring",
        ("positions of the start for ever", "view.shares(self.on), view.displacement\n", "view.shares(self.on), view.displacement.copy()\n"),
        ("pushes away", "force[nodes] -= each", "force[nodes] += each"),
        ("ignores the stiffness", "np.outer(shares, self.stiffness)", "np.outer(shares, (100.0, 200.0))"),
        ("writes displacements", "            force[nodes] -= each * displacement[nodes]", "            displacement[nodes] *= 0.999\n            force[nodes] -= each * displacement[nodes]")),
    *_of("effect", "vibration-damping",
        ("drives in place of damping", "view.velocity, self.rate, force", "view.velocity, -self.rate, force"),
        ("velocities of the start for ever", "        first = np.array([nodes[0] for nodes in ranges])\n", "        view = view._replace(velocity=view.velocity.copy())\n        first = np.array([nodes[0] for nodes in ranges])\n")),
    *_of("effect", "attraction",
        ("pushes one body alone", "attract(first, second, view.reference, view.displacement, view.mass, self.force, force)", "kept = force[second].copy()\n            attract(first, second, view.reference, view.displacement, view.mass, self.force, force)\n            force[second] = kept"),
        ("ignores the force", "view.mass, self.force, force", "view.mass, 10.0, force")),
    M("effect", "gravity", "needs no mass, in statics either", "needs_mass: ClassVar[bool] = True", "needs_mass: ClassVar[bool] = False"),
)  # fmt: skip

FUNCTION = (
    *_of("function", "half-ellipse",
        ("ignores the width", "(at - self.centre) / self.half_width", "(at - self.centre) / 0.8"),
        ("no number beyond the edge", "np.maximum(0.0, 1.0 - ((at - self.centre) / self.half_width) ** 2)", "1.0 - ((at - self.centre) / self.half_width) ** 2"),
        ("of unit height whatever the places", "return np.sqrt(", "at = at / max(1e-9, np.abs(at).max(initial=0.0))\n        return np.sqrt("),
        ("writes to the places", "return np.sqrt(", "at -= self.centre\n        at *= 0.99\n        return np.sqrt(")),
    *_of("function", "sine",
        ("ignores the period", "/ self.period)", "/ 1.5)"),
        ("grows with every call", "return np.sin(", "self.__dict__['n'] = self.__dict__.get('n', 0) + 1\n        return self.__dict__['n'] * np.sin("),
        ("gives one number", "return np.sin(", "return np.mean(at) + 0.0 * np.sin("),
        ("in single precision", "return np.sin(2.0 * np.pi * (at - self.start) / self.period)", "return np.sin(2.0 * np.pi * (at - self.start) / self.period).astype(np.float32)"),
        ("nothing at all", "return np.sin(", "return 0.0 * np.sin(")),
    *_of("function", "polynomial",
        ("ignores the coefficients", "polyval(at, self.coefficients)", "polyval(at, (1.0, 0.5, -0.2))"),
        ("not finite at 0", "return np.asarray(np.polynomial.polynomial.polyval(at, self.coefficients))", "return np.asarray(np.polynomial.polynomial.polyval(at, self.coefficients)) * at / at"),
        ("gives back its places", "return np.asarray(np.polynomial.polynomial.polyval(at, self.coefficients))", "at[:] = np.polynomial.polynomial.polyval(at, self.coefficients)\n        return at"),
        ("a row in place of a vector", "return np.asarray(np.polynomial.polynomial.polyval(at, self.coefficients))", "return np.asarray(np.polynomial.polynomial.polyval(at, self.coefficients))[None, :]")),
)  # fmt: skip

WATCH = (
    *_of("watch", "series",
        ("counts rows outside its memory", 'count = int(memory["count"][0])\n        if', "count = self.__dict__.setdefault('rows', [0])[0]\n        self.__dict__['rows'][0] += 1\n        if"),
        ("forgets what it saw", '            memory["rows"][count] =', '            memory["rows"][0] ='),
        ("finds nothing", 'return {**found, "left out"', 'return {} if found else {**found, "left out"'),
        ("gives its table a new shape", '        memory["count"][0] = count + 1\n\n    def end', '        memory["rows"] = memory["rows"][:-1].copy()\n        memory["count"][0] = count + 1\n\n    def end'),
        ("random numbers in its table", 'memory["count"][0] = count + 1\n\n    def end', 'memory["rows"][min(count, self.most - 1)] += np.random.default_rng().normal()\n        memory["count"][0] = count + 1\n\n    def end'),
        ("moves what it looks at", '        count = int(memory["count"][0])\n        if', '        np.lib.stride_tricks.as_strided(view.field("velocity"), writeable=True)[:] *= 1.0001\n        count = int(memory["count"][0])\n        if')),
    *_of("watch", "contact-changes",
        ("closed conditions outside its memory", 'changes = float(np.count_nonzero(closed != memory["closed"]))', "changes = float(np.count_nonzero(closed != self.__dict__.get('closed', 0.0 * closed)))\n        self.__dict__['closed'] = closed"),
        ("counts its own steps", 'count = int(memory["count"][0])\n        memory["rows"][count] = changes', "count = self.__dict__['n'] = self.__dict__.get('n', -1) + 1\n        memory[\"rows\"][count] = changes")),
    *_of("watch", "slips",
        ("adds up outside its memory", 'memory["total"] += view.slips()', "self.__dict__['t'] = self.__dict__.get('t', 0.0) + view.slips()\n            memory[\"total\"][:] = self.__dict__['t']"),
        ("the clock of the computer", 'max(memory["largest"][0], largest(memory["total"]))', "__import__('time').perf_counter()")),
    M("watch", "overlap-area", "memory made at the first step", 'return {"largest": np.zeros(1)}', "return {}"),
)  # fmt: skip

CASE = (
    *_of("case", "patch",
        ("names an element that is not there", '("q1", "q2-lagrange", "q1-fbar")', '("q1", "q3")'),
        ("a tolerance without a reason", "error(name, 1e-10, why, ", 'error(name, 1e-10, "", '),
        ("two measures of one name", 'in ("displacement", "stress"))', 'in ("displacement", "displacement"))'),
        ("nothing is judged", 'return *exact, reported("iterations")', 'return (reported("displacement"),)'),
        ("an axis that is no field", '"upper": (1, 3, 4, 10)', '"top": (1, 3, 4, 10)'),
        ("finds what it does not measure", '"iterations": iterations(record)', '"rounds": iterations(record)'),
        ("a source of nothing", '"Taylor & Papadopoulos 1991; Crisfield 2000"', '""'),
        ("a body on an edge set that is not there", '"slave": "upper.bottom"', '"slave": "upper.sole"'),
        ("never stops planning", "        return (\n            static_job(\n                \"pressed\", setup,", "        return (\n            static_job(\n                f\"pressed {len(done)}\", setup,"),
        ("is no data", "    upper: int = 4\n", "    upper: int = 4\n    asked: object = lambda: None\n")),
    *_of("case", "hertz",
        ("a margin that is no field", '("ratio", 10.0)', '("rate", 10.0)'),
        ("no element to choose from", 'elements: ClassVar[tuple[str, ...]] = ("q1", "q2", "q1-fbar")', "elements: ClassVar[tuple[str, ...]] = ()")),
)  # fmt: skip

MEASURE = (
    *_of("measure", "contact-length",
        ("a column without a title", '"length of contact"', '""'),
        ("a unit that no table knows", 'unit: ClassVar[str] = "length"', 'unit: ClassVar[str] = "miles"'),
        ("says nothing of its meaning", '"Length of the deformed slave surface that is pressed, to half a segment beyond its nodes."', '""'),
        ("stretches the curve", "        length = np.zeros(len(curve.x))\n", "        curve.x[:] *= 1.001\n        length = np.zeros(len(curve.x))\n"),
        ("random numbers", "return float(length[_pressed(curve)].sum())", "return float(length[_pressed(curve)].sum() * np.random.default_rng().normal())"),
        ("counts its calls", "return float(length[_pressed(curve)].sum())", "self.__dict__['n'] = self.__dict__.get('n', 0) + 1\n        return float(self.__dict__['n'])"),
        ("finds nothing at all", "return float(length[_pressed(curve)].sum())", "return math.nan"),
        ("a number for each node", "return float(length[_pressed(curve)].sum())", "return length")),
    *_of("measure", "pressure-centre",
        ("divides by no pressure", "        if total == 0.0:\n            return math.nan\n", ""),
        ("infinitely far where nothing is pressed", "            return math.nan\n        return float((curve.x", "            return math.inf\n        return float((curve.x"),
        ("writes to the summary", "        pressed = _pressed(curve)\n        total", "        record.summary['status'] = 'seen'\n        pressed = _pressed(curve)\n        total")),
    *_of("measure", "peak-error",
        ("needs a reference", "        if reference is None:\n            return math.nan\n", ""),
        ("scales the reference", "        exact = float(np.max(reference", "        reference.pressure[:] *= 2.0\n        exact = float(np.max(reference")),
)  # fmt: skip

REFERENCE = (
    *_of("reference", "disc-on-block-deep",
        ("no title", 'str(content["title"]),', '"",'),
        ("no origin", ', str(content["origin"])', ', ""'),
        ("holds for everything", "return self.stored.mismatch(scene)", 'return ""'),
        ("holds for one mesh alone", "return self.stored.mismatch(scene)", 'return self.stored.mismatch(scene) or ("another level" if scene["level"] != 1 else "")'),
        ("holds for one slave alone", "return self.stored.mismatch(scene)", 'return self.stored.mismatch(scene) or ("exchanged" if scene["contacts"][0]["swap"] else "")'),
        ("raises where there is no contact", "return self.stored.mismatch(scene)", 'return scene["contacts"][0] and self.stored.mismatch(scene)'),
        ("a pressure twice as large", "found.profile.x, found.profile.value,", "found.profile.x, 2.0 * found.profile.value,"),
        ("positions that run backwards", "found.profile.x, found.profile.value,", "found.profile.x[::-1], found.profile.value,"),
        ("a reaction that no pressure carries", 'Scalar(float(s["value"])', 'Scalar(1.1 * float(s["value"])'),
        ("a spread of other nodes", "found.spread, found.window", "found.spread[:-1], found.window"),
        ("random pressures", "found.profile.x, found.profile.value,", "found.profile.x, found.profile.value * (1.0 + 1e-9 * __import__('numpy').random.default_rng().normal()),"),
        ("changes the scene", "        found = self.stored\n", "        found = self.stored\n        scene['level'] = 7\n")),
    *_of("reference", "disc-on-block-shallow",
        ("an error in percent", "found.pressure_uncertainty, meaning", "1000.0 * found.pressure_uncertainty, meaning"),
        ("a pressure that is none", "found.profile.x, found.profile.value,", "found.profile.x, 0.0 * found.profile.value,")),
)  # fmt: skip

RECORDER = (
    *_of("recorder", "vtkhdf",
        ("the file is never closed", "        finally:\n            self.growing.close()", "        finally:\n            pass"),
        ("scales displacements in place", "        self.grid.write(row, frame)\n", "        frame.displacement[:] *= 1000.0\n        self.grid.write(row, frame)\n"),
        ("rounds stresses in place", "        self.grid.write(row, frame)\n", "        for fields in frame.cells.values():\n            fields['stress'][:] = np.round(fields['stress']) + 1e-3\n        self.grid.write(row, frame)\n"),
        ("writes beside the folder", "GrowingFile(folder / FILE, new=True)", "GrowingFile(folder.parent / FILE, new=True)"),
        ("needs a frame to close", "        try:\n            made =", "        assert self.history is not None\n        try:\n            made ="),
        ("cannot close a run that failed", "json.dumps(summary))\n            stored", "json.dumps({'steps': summary['steps'], 'status': {'finished': 0}[summary['status']]}))\n            stored"),
        ("keeps the block of steps, which is used again", "        self.steps_kept.add([block,", "        self.__dict__.setdefault('kept', []).append(block)\n        for old in self.kept:\n            assert np.isfinite(old).all()\n        self.steps_kept.add([block,"),
        ("every second frame is lost", "    def frame(self, frame: Frame) -> None:\n", "    def frame(self, frame: Frame) -> None:\n        if frame.number % 2:\n            return\n"),
        ("steps are lost", "        self.steps_kept.add([block,", "        return\n        self.steps_kept.add([block,"),
        ("one room for all runs", "        self.events.add(event)", "        VtkHdfRecording.__dict__['iterations'].__dict__.setdefault('all', []).append(event)\n        for one in VtkHdfRecording.__dict__['iterations'].__dict__['all']:\n            self.events.add(one)"),
        ("displacements recorded half as large", "        self.grid.write(row, frame)\n", "        import dataclasses\n        self.grid.write(row, dataclasses.replace(frame, displacement=0.5 * frame.displacement))\n")),
)  # fmt: skip

MUTATIONS: tuple[Mutation, ...] = (
    *CONTACT, *MATERIAL, *ELEMENT, *MESH, *FRICTION, *ENFORCEMENT, *INTEGRATOR, *EFFECT, *FUNCTION, *WATCH, *CASE, *MEASURE, *REFERENCE,
    *RECORDER,
)  # fmt: skip
