"""Which parameters a motion shows, and what they are called."""

from __future__ import annotations

import numpy as np
import pytest

from gough.identify.base import base_parameters, sizes
from gough.identify.design import structural
from gough.identify.rows import rows_of_motion

from .motions import fourier, machine_of, planted, sampled


def shown(machine, program, friction=()):
    """Base parameters of a planned motion, without noise."""
    x, xd, xdd = sampled(machine, program)
    rows = rows_of_motion(machine, x, xd, xdd, np.zeros((len(x), 6)), friction)
    size = sizes(rows.names, rows.units, rows.values, np.ones(len(rows.names)))
    return rows, base_parameters(rows.Y.reshape(-1, len(size)) * size, rows.names, rows.units, size, noise=False)


def named(rows, base, how):
    return {name for name, seen in zip(rows.names, base.seen, strict=True) if seen == how}


def test_struts_that_hold_a_flat_platform_count_as_masses_at_its_joints():
    """Six equal masses at B_i: m grows by 6 m_s, I by the sum of their moments; the joints of nist lie in z = 0."""
    nist = machine_of("nist-octahedral")
    base, _, rows = structural(nist, ())
    B = nist.joints.platform
    at = dict(zip(rows.names, np.arange(len(rows.names)), strict=True))
    row = dict(zip(base.kept, base.K, strict=True))
    strut = at["strut.moving.m"]
    for name, moment in (("Ixx", B[:, 1] ** 2), ("Iyy", B[:, 0] ** 2), ("Izz", (B[:, :2] ** 2).sum(1))):
        assert row[at[f"platform.{name}"]][strut] == pytest.approx(moment.sum(), rel=1e-6)
    assert row[at["platform.m"]][strut] == pytest.approx(6, rel=1e-9)
    assert "platform.m + 6 strut.moving.m" in base.names
    assert "strut.moving.I + strut.fixed.I" in base.names
    assert named(rows, base, "not") == {"strut.fixed.m"}, "it stands in the base joint and never moves"
    assert base.rank == 14


def test_the_hexaglide_shows_every_parameter_alone():
    base, _, rows = structural(machine_of("eth-hexaglide"), ())
    assert base.names == rows.names and set(base.seen) == {"alone"}


def test_a_translation_does_not_show_the_inertias_and_a_motion_that_turns_does():
    machine = machine_of("eth-hexaglide")
    rows, base = shown(machine, fourier(1, turn=0.0))
    inertias = {name for name in rows.names if name.startswith("platform.I")}
    assert len(inertias) == 6
    assert named(rows, base, "not") == inertias
    assert base.names == ("platform.m", "platform.m cx", "platform.m cy", "platform.m cz", "carriage.m")
    rows, base = shown(machine, fourier(1))
    assert base.rank == 11 and not named(rows, base, "not")


def test_a_turn_about_the_tip_at_rest_shows_the_mass_by_its_weight_alone():
    """T does not accelerate: without gravity the mass at T is not felt; m c and I are, as what turns about T."""
    machine = machine_of("eth-hexaglide")
    rows, base = shown(machine, fourier(2, tip=0.0))
    assert base.rank == 11
    weightless = machine.replace(gravity=np.zeros(3))
    rows, base = shown(weightless, fourier(2, tip=0.0))
    assert named(rows, base, "not") == {"platform.m"}


def test_a_machine_at_rest_shows_six_combinations_at_most():
    machine = machine_of("nist-octahedral")
    x = np.tile(machine.home, (50, 1))
    rows = rows_of_motion(machine, x, 0 * x, 0 * x, np.zeros((50, 6)), ())
    base = base_parameters(rows.Y.reshape(-1, 17), rows.names, rows.units, np.ones(17), noise=False)
    assert base.rank <= 6
    inertial = {name for name in rows.names if ".I" in name} | {"drive.m"}
    assert inertial <= named(rows, base, "not")


@pytest.mark.quick("eth-hexaglide")
@pytest.mark.parametrize("name", ["nist-octahedral", "okuma-pm600", "eth-hexaglide"])
def test_base_parameters_carry_the_whole_force(name):
    """Y pi = Y[:, kept] (K pi) for any pi: nothing that acts is lost in the grouping.  1e-11: RELIABILITY C1."""
    machine = machine_of(name)
    rows, base = shown(machine, fourier(3), ("coulomb", "viscous"))
    pi = planted(machine, rows.names)
    whole = rows.Y @ pi
    assert np.abs(rows.Y[..., base.kept] @ (base.K @ pi) - whole).max() < 1e-11 * np.abs(whole).max()


def test_noise_hides_what_is_smaller_and_its_column_is_not_shown():
    rng = np.random.default_rng(0)
    A = rng.standard_normal((400, 3)) * [100, 100, 0.01]  # rows over deviations: the third is a hundredth of the noise
    base = base_parameters(A, ("a", "b", "c"), ("1",) * 3, np.ones(3))
    assert base.seen == ("alone", "alone", "not") and base.rank == 2
    A[:, 2] = A[:, 1] + rng.standard_normal(400)  # apart from b by one deviation of the noise in every row
    base = base_parameters(A, ("a", "b", "c"), ("1",) * 3, np.ones(3))
    assert base.rank == 3, "400 rows of 1 are known to a twentieth"
    A[:, 2] = A[:, 1] + 1e-4 * rng.standard_normal(400)
    base = base_parameters(A, ("a", "b", "c"), ("1",) * 3, np.ones(3))
    assert base.rank == 2 and base.names in (("a", "b + c"), ("a", "c + b"))


def test_a_name_shows_the_weightiest_terms_and_their_signs():
    A = np.zeros((40, 7))
    rng = np.random.default_rng(1)
    A[:, :6] = rng.standard_normal((40, 6))
    A[:, 6] = A[:, :6] @ [2.0, -0.5, 1.0, 0.25, 0.125, 0.0]
    base = base_parameters(A, tuple("abcdefg"), ("kg",) * 7, np.ones(7), noise=False)
    assert base.names == ("a + 2 g", "b - 0.5 g", "c + g", "d + 0.25 g", "e + 0.125 g", "f")
    B = A[:, [6, 0, 1, 2, 3, 4]] @ np.diag([1.0, 1, 1, 1, 1, 1])
    B[:, 1:] = B[:, :1] * np.array([1, 2, 3, 4, 5])
    base = base_parameters(B, tuple("abcdef"), ("kg",) * 6, np.ones(6), noise=False)
    assert base.names == ("a + 5 f + 4 e + 3 d + 2 c + ...",)


def test_sizes_are_those_of_a_body_where_the_sheet_has_a_zero():
    names = ("p.m", "p.m cx", "p.Ixx", "p.Ixy", "f[0]")
    size = sizes(names, ("kg", "kg m", "kg m2", "kg m2", "N"), [100.0, 0, 4, 0, 0], np.full(5, 7.0))
    assert size.tolist() == [100, 20, 4, 4, 7]
