"""Checks of materials."""

from __future__ import annotations

import numpy as np

from contactlab.api import Floats, Material
from contactlab.api.differences import fastest_modulus, tangent_by_differences
from contactlab.api.formulas import formulas_of
from contactlab.testing import material_states, material_waves, scales
from contactlab.testing.assertions import Check, NotApplicable, agree, identical, require, untouched
from contactlab.testing.material_waves import stiffening_bounds_the_waves
from contactlab.testing.other_values import any_others, others, switched_on
from contactlab.testing.points import (
    DT,
    at_rest,
    deformation,
    elastic_step,
    gradients,
    matrices,
    modulus,
    no_history,
    respond,
    rotations,
    rows_of,
    some_history,
    stress_of_work,
    tensors,
    usual_step,
)
from contactlab.testing.scales import AROUND

HELD = 5, 50  # steps in which a law's own time passes: stresses of one of first order differ by a tenth
POINTS = 40
STRAIN = 0.1  # of random states: finite, and far from the folding that no law has to stand


def declarations(law: Material) -> None:
    """Kinematics is one of the three, every history number has a name, and speeds are real."""
    require(law.kinematics in ("small", "finite", "rate"), f"kinematics: got {law.kinematics!r}")
    names = law.history_names
    require(len(names) == law.history_size, f"history_names: {len(names)} names for {law.history_size} numbers")
    dilatational, shear = law.wave_speeds()
    require(law.density > 0.0, f"density: got {law.density}")
    require(0.0 < shear < dilatational < np.inf, f"wave_speeds: got {dilatational}, {shear}; 0 < shear < dilatational")


def no_stress_at_rest(law: Material) -> None:
    """An undeformed body has no stress and keeps its history of zeros."""
    stress, history = respond(law, at_rest(law, POINTS), no_history(law, POINTS))
    if not law.stress_free:
        within = 1e-12 * max(modulus(law), float(np.abs(stress).max()))
        agree(stress, stress[:, :1] + 0.0 * stress, within, "stress at rest of different points")
        if law.isotropic:
            agree(stress[[1, 3]], np.stack([stress[0], 0.0 * stress[0]]), within, "yy and xy at rest, and xx and 0")
        raise NotApplicable("assumes no stress at rest: stress_free is False")
    agree(stress, np.zeros((4, POINTS)), 1e-13 * modulus(law), "stress at rest (round-off of the moduli)")
    agree(history, no_history(law, POINTS), 0.0, "history at rest")


def speeds_belong_to_the_tangent(law: Material) -> None:
    """density c_p^2 and density c_s^2 are the moduli of the law at rest."""
    tangent = np.empty((4, 4, 1))
    law.tangent(at_rest(law, 1), no_history(law, 1), elastic_step(law), tangent)
    # "finite" laws are given F^-1, whose change is minus the strain
    sign = -1.0 if law.kinematics == "finite" else 1.0
    dilatational, shear = (law.density * c * c for c in law.wave_speeds())
    if not law.isotropic or law.needs:
        fastest = fastest_modulus(sign * tangent[..., 0])
        text = f"the fastest wave has the modulus {fastest:.6g} MPa, wave_speeds say {dilatational:.6g} MPa"
        require(fastest <= (1.0 + 1e-6) * dilatational, f"{text}: explicit steps would be too long")
        why = "in all directions: isotropic is False" if not law.isotropic else "at all places and times: it has needs"
        raise NotApplicable(f"assumes one modulus {why}; its waves are no faster")
    # differences of the default tangent leave about 1e-10 of the moduli
    agree(sign * tangent[[0, 1], [0, 3], 0], [dilatational] * 2, 1e-7 * dilatational, "tangent xx by xx and yy by yy")
    agree(sign * tangent[3, [1, 2], 0], [shear] * 2, 1e-7 * dilatational, "tangent xy by xy and by yx")


def objectivity(law: Material) -> None:
    """A rigid rotation only rotates the stress."""
    {"small": _infinitesimal_rotation, "finite": _superposed_rotation, "rate": _rotation_in_steps}[law.kinematics](law)


def _infinitesimal_rotation(law: Material) -> None:
    gradient, history = gradients(law, POINTS, 0.01), some_history(law, POINTS)
    turned = gradient + np.array([[0.0], [-0.01], [0.01], [0.0]])
    agree(
        respond(law, turned, history)[0],
        respond(law, gradient, history)[0],
        1e-13 * modulus(law),
        "stress of a displacement gradient with and without an antisymmetric part",
    )


def _superposed_rotation(law: Material) -> None:
    gradient, history, turn = gradients(law, POINTS, STRAIN), some_history(law, POINTS), rotations(POINTS)
    if law.history_size:
        history = no_history(law, POINTS)  # a history may hold tensors of the unturned body
    stress, _ = respond(law, gradient, history)
    # x -> Q x: F becomes Q F, and dX/dx becomes (dX/dx) Q^T
    rotated, _ = respond(law, rows_of(matrices(gradient) @ turn.transpose(0, 2, 1)), history)
    expected = turn @ tensors(stress) @ turn.transpose(0, 2, 1)
    agree(tensors(rotated), expected, 1e-12 * modulus(law), "stress of a turned body against the turned stress")
    agree(rotated[2], stress[2], 1e-12 * modulus(law), "stress across the plane of a turned body")


def _rotation_in_steps(law: Material) -> None:
    """Rigid steps of any size: with the gradient referred to mid-step, W = 2 tan(angle/2) exactly."""
    stress, start = respond(law, gradients(law, POINTS, 0.002), no_history(law, POINTS))
    for steps in (1, 10):
        spin = 2.0 * np.tan(0.25 * np.pi / steps)
        increment = np.repeat(np.array([[0.0], [-spin], [spin], [0.0]]), POINTS, axis=1)
        history, turned = start, stress
        for _ in range(steps):
            turned, history = respond(law, increment, history)
        expected = np.stack([stress[1], stress[0], stress[2], -stress[3]])
        agree(turned, expected, 1e-11 * modulus(law), f"stress after a rigid turn by 90 degrees in {steps} steps")


def tangent_is_the_derivative(law: Material) -> None:
    """The tangent is the derivative of the stress that the law gives."""
    gradient, history = gradients(law, POINTS, STRAIN), some_history(law, POINTS)
    steps = [around * usual_step(law) for around in AROUND] if law.time_scale else [DT]
    for dt in steps:
        _tangent_of_a_step(law, gradient, history, dt)


def _tangent_of_a_step(law: Material, gradient: Floats, history: Floats, dt: float) -> None:
    tangent, expected = np.empty((4, 4, POINTS)), np.empty((4, 4, POINTS))
    law.tangent(gradient, history, dt, tangent)
    tangent_by_differences(law, gradient, history, dt, expected)
    # differences with a step of 6e-6 are good to some 1e-9 of the moduli; they see a kink
    # only where a plastic law starts to yield within the step, which few of 40 random points do
    error = np.abs(tangent - expected).max(axis=(0, 1)) / modulus(law)
    allowed = 1e-6
    bad = np.count_nonzero(~(error < allowed))
    few = 0 if law.history_size == 0 else POINTS // 10
    require(
        bad <= few,
        f"tangent of a step of {dt:g} s against differences: {bad} of {POINTS} points differ by up to "
        f"{error.max():.1e} of the moduli, allowed {allowed:.0e} at all but {few}",
    )


def formulas_are_what_runs(law: Material) -> None:
    """Formulas give in plain Python what they give compiled, and what a method by hand in their place gives."""
    if "stress" not in formulas_of(type(law)):
        raise NotApplicable("the law has no formula for its stress")
    from contactlab.formulas import laws

    few = POINTS // 4
    gradient, history = gradients(law, few, STRAIN), some_history(law, few)
    given, new = respond(law, gradient, history)
    size = max(modulus(law), float(np.abs(given).max()))
    for how, called in (("compiled", laws.stress), ("in plain Python", laws.stress_in_python)):
        stress, after = np.full_like(given, np.nan), np.full_like(new, np.nan)
        called(law, gradient, history, usual_step(law), stress, after)
        # a different order of the same sums, some of which cancel
        agree(stress, given, 1e-12 * size, f"stress of the formula {how}, against the method")
        agree(after, new, 1e-11 * max(1.0, float(np.abs(new).max(initial=0.0))), f"history of the formula {how}")


def rate_is_declared(law: Material) -> None:
    """A law that does not declare `rate_dependent` gives the same stress for any length of the step."""
    gradient, history = gradients(law, POINTS, STRAIN), some_history(law, POINTS)
    if law.rate_dependent:
        _feels_the_rate(law, gradient, history)
        raise NotApplicable("rate_dependent is True")
    require(not law.time_scale, "time_scale is declared, but rate_dependent is False")
    expected, _ = respond(law, gradient, history)
    for dt in (0.0, 1e3 * DT, 1.0, 1e6):
        stress, new = np.full_like(expected, np.nan), np.full_like(history, np.nan)
        law.stress(gradient, np.ascontiguousarray(history), dt, stress, new)
        identical(stress, expected, f"stress of a step of {dt:g} s against one of {DT:g} s (rate_dependent is False)")


def _feels_the_rate(law: Material, gradient: Floats, history: Floats) -> None:
    """A law that names its own time relaxes about then: steps of other lengths give other stresses."""
    if not law.time_scale:
        return
    quick, middle, slow = (respond(law, gradient, history, around * usual_step(law))[0] for around in AROUND)
    for other, text in ((quick, "a hundredth"), (slow, "a hundred times")):
        change = float(np.abs(other - middle).max())
        require(
            change > 1e-4 * float(np.abs(middle).max()),
            f"steps of its own time ({law.time_scale}) and of {text} of it give the same stress: rate_dependent is set",
        )
    _relaxes_if_held(law, gradient, history)


def _relaxes_if_held(law: Material, gradient: Floats, history: Floats) -> None:
    """The stress of a strain that is reached at once and then held changes by time, and not by the number of steps."""
    if not law.history_size:
        return
    reached, history = respond(law, gradient, history, elastic_step(law))
    held = at_rest(law, POINTS) if law.kinematics == "rate" else gradient
    few, many = (_change(law, held, reached, history, steps) for steps in HELD)
    require(
        many <= 2.0 * few and few <= 2.0 * many,
        f"a strain that is held for the law's own time ({law.time_scale}): its stress changes by {few:.3g} MPa in "
        f"{HELD[0]} steps and by {many:.3g} MPa in {HELD[1]}, allowed: a factor of 2 between them",
    )


def _change(law: Material, held: Floats, before: Floats, history: Floats, steps: int) -> float:
    """Largest change of stress [MPa] while the law's own time passes in so many steps."""
    stress = before
    for _ in range(steps):
        stress, history = respond(law, held, history, usual_step(law) / steps)
    return float(np.abs(stress - before).max())


def energy_is_positive(law: Material) -> None:
    """The stored energy is zero at rest and positive everywhere else."""
    _require_energy(law)
    if not law.stress_free:
        raise NotApplicable("assumes that nothing is stored at rest: stress_free is False")
    rest = np.full(1, np.nan)
    law.energy(at_rest(law, 1), no_history(law, 1), rest)
    agree(rest, [0.0], 1e-14 * modulus(law), "energy at rest")
    energy = _energy(law, matrices(gradients(law, POINTS, 0.01)))
    require(np.all(energy > 0.0), "energy: not positive in a deformed state")


def energy_belongs_to_the_stress(law: Material) -> None:
    """The stress is the derivative of the stored energy."""
    _require_energy(law)
    # laws with history store what they do not dissipate: there the elastic range close to rest is taken
    size, step, allowed = (1e-4, 1e-6, 1e-9) if law.history_size else (0.01, 1e-5, 1e-7)
    gradient = gradients(law, POINTS, size if law.kinematics == "small" or law.history_size else STRAIN)
    work, base = stress_of_work(law, gradient), deformation(law, gradient)
    for i in range(2):
        for j in range(2):
            shift = np.zeros((2, 2))
            shift[i, j] = step
            slope = (_energy_of(law, base + shift) - _energy_of(law, base - shift)) / (2.0 * step)
            # truncation is step^2 times the curvature, which is some tens of the modulus
            agree(slope, work[:, i, j], allowed * modulus(law), f"dW/dF component {i}{j} against the stress")


def _require_energy(law: Material) -> None:
    if not law.has_energy:
        raise NotApplicable("the law declares no stored energy")
    if law.kinematics == "rate":
        raise NotApplicable("the energy of a rate law is not a function of the gradient")


def _energy(law: Material, gradient: Floats) -> Floats:
    out, rows = np.full(len(gradient), np.nan), rows_of(gradient)
    history = no_history(law, len(gradient))
    if law.rate_dependent and law.history_size:  # what relaxes is stored in the history
        _, history = respond(law, rows, history, elastic_step(law))
    law.energy(rows, history, out)
    return out


def _energy_of(law: Material, deformation: Floats) -> Floats:
    """Energy per undeformed volume of F or du/dX."""
    if law.kinematics == "small":
        return _energy(law, deformation)
    return np.asarray(np.linalg.det(deformation) * _energy(law, np.asarray(np.linalg.inv(deformation))))


def any_cut_gives_the_same(law: Material) -> None:
    """Points are independent: any division and order of a block gives the same bits."""
    gradient, history = gradients(law, 61, STRAIN), some_history(law, 61)
    stress, new = respond(law, gradient, history)
    order = np.random.default_rng(9).permutation(61)
    mixed, mixed_new = respond(law, gradient[:, order], history[:, order])
    identical(mixed, stress[:, order], "stress in another order")
    identical(mixed_new, new[:, order], "history in another order")
    for begin, end in ((0, 1), (1, 18), (18, 61)):
        part, part_new = respond(law, gradient[:, begin:end], history[:, begin:end])
        identical(part, stress[:, begin:end], f"stress of points {begin} to {end} alone")
        identical(part_new, new[:, begin:end], f"history of points {begin} to {end} alone")


def no_points_at_all(law: Material) -> None:
    """Blocks without points are accepted."""
    stress, history = respond(law, gradients(law, 0, STRAIN), no_history(law, 0))
    require(stress.shape == (4, 0), "a block of no points changed its shape")
    require(history.shape == (law.history_size, 0), "the history of no points changed its shape")


def inputs_untouched(law: Material) -> None:
    """Gradient and history are read only, and every row of the stress is filled."""
    gradient, history = gradients(law, POINTS, STRAIN), some_history(law, POINTS)
    with untouched(gradient=gradient, history=history):
        stress, new = respond(law, gradient, history)
    require(np.all(np.isfinite(stress)), "stress: a row or a point was left unfilled, or is not finite")
    require(np.all(np.isfinite(new)), "new_history: a row or a point was left unfilled, or is not finite")


def history_in_place(law: Material) -> None:
    """`history` and `new_history` may be the same array."""
    if not law.history_size:
        raise NotApplicable("the law has no history")
    gradient, history = gradients(law, POINTS, STRAIN), some_history(law, POINTS)
    expected, expected_history = respond(law, gradient, history)
    stress = np.empty_like(expected)
    law.stress(gradient, history, usual_step(law), stress, history)
    identical(stress, expected, "stress with the same array for both histories")
    identical(history, expected_history, "history with the same array for both")


def same_answer_twice(law: Material) -> None:
    """The result depends on the arguments alone: a part keeps nothing between calls."""
    gradient, history = gradients(law, POINTS, STRAIN), some_history(law, POINTS)
    first = respond(law, gradient, history)
    respond(law, 1.01 * gradient, history)
    again = respond(law, gradient, history)
    identical(again[0], first[0], "stress of the same arguments after another call")
    identical(again[1], first[1], "history of the same arguments after another call")


def other_values_are_right(law: Material) -> None:
    """Tangent, wave speeds, energy and dissipation belong to the stress for other than usual numbers, too."""
    checks = (speeds_belong_to_the_tangent, tangent_is_the_derivative, energy_belongs_to_the_stress)
    works = material_states.work_is_stored_or_dissipated
    for name, other, all_of_it in (
        *((*o, checks) for o in others(law)),
        *((*o, (*checks, works)) for o in switched_on(law)),
    ):
        for check in all_of_it:
            try:
                check(other)
            except NotApplicable:
                continue
            except AssertionError as failure:
                raise AssertionError(f"with another value of {name}: {failure}") from failure


def numbers_count(law: Material) -> None:
    """Every number that a scene can give changes something: stress, history, energy, speeds, limits."""
    told = _all_told(law)
    for name, other in any_others(law):
        same = all(np.array_equal(a, b, equal_nan=True) for a, b in zip(_all_told(other), told, strict=True))
        require(not same, f"the field {name} changes no result of the law, under strains up to {STRAIN:.0%}")


def needs_count(law: Material) -> None:
    """Everything that a law declares in needs changes its stress."""
    if not law.needs:
        raise NotApplicable("the law declares no needs")
    gradient, history = gradients(law, POINTS, STRAIN), some_history(law, POINTS)
    before = respond(law, gradient, history)
    for row, name in list(enumerate(law.history_names))[law.own_history() :]:
        if name == "y" and "position" in law.needs:
            continue  # a law may follow x alone; that it follows neither is seen at x and y together
        other = history.copy()
        other[[row, row + 1] if name == "x" else row] *= 1.3
        same = all(np.array_equal(a, b) for a, b in zip(respond(law, gradient, other)[:1], before, strict=False))
        require(not same, f"it declares {'position' if name == 'x' else name} in needs, but no stress depends on it")


def young_and_poisson_are_meant(law: Material) -> None:
    """Fields `young` and `poisson` of an elastic law are Young's modulus and Poisson's ratio of small strains."""
    young, poisson = getattr(law, "young", None), getattr(law, "poisson", None)
    if not isinstance(young, float) or not isinstance(poisson, float) or not law.isotropic:
        raise NotApplicable("the law is not isotropic with fields young and poisson")
    if law.rate_dependent or law.needs:
        raise NotApplicable("assumes moduli that are the same at any rate, place and time: rate_dependent, needs")
    dilatational, shear = (law.density * c * c for c in law.wave_speeds())
    ratio = (dilatational - 2.0 * shear) / (2.0 * (dilatational - shear))
    given = f"moduli at rest are E = {2.0 * shear * (1.0 + ratio):.6g} and nu = {ratio:.6g}"
    near = np.isclose([2.0 * shear * (1.0 + ratio), ratio], [young, poisson], rtol=1e-6, atol=1e-9).all()
    require(bool(near), f"{given}, its fields young and poisson say {young:g} and {poisson:g}: 2 mu = E/(1 + nu)?")


def _all_told(law: Material) -> list[Floats]:
    """All results of a law at some strained points; steps are short, usual and long."""
    gradient, history, out = gradients(law, POINTS, STRAIN), some_history(law, POINTS), np.full(POINTS, np.nan)
    found = [a for dt in (DT, 1.0, usual_step(law)) for a in respond(law, gradient, history, dt)]
    methods = [law.energy, law.dissipation] if law.has_energy else [law.dissipation]
    for method in methods:
        method(gradient, found[1], out)
        found.append(out.copy())
    law.stiffening(gradient, found[0], out)
    return [*found, out, np.array([law.density, *law.wave_speeds(), law.elastic_limit()])]


CHECKS: tuple[Check, ...] = (
    declarations,
    no_stress_at_rest,
    speeds_belong_to_the_tangent,
    objectivity,
    tangent_is_the_derivative,
    formulas_are_what_runs,
    rate_is_declared,
    energy_is_positive,
    energy_belongs_to_the_stress,
    stiffening_bounds_the_waves,
    any_cut_gives_the_same,
    no_points_at_all,
    inputs_untouched,
    history_in_place,
    same_answer_twice,
    other_values_are_right,
    numbers_count,
    needs_count,
    young_and_poisson_are_meant,
    *material_states.CHECKS,
    *material_waves.CHECKS,
    *scales.CHECKS,
)
