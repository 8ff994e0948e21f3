"""Rows P1 to P4, K7 and more of a data sheet's faults, as a person meets them: changing one line of a good sheet."""

from __future__ import annotations

import numpy as np
import pytest

from gough.errors import SheetError
from gough.machine.hexapod import Hexapod
from gough.machine.hexapod_parts import StrutPart
from gough.machine.limits import Workspace
from gough.machine.sheet import load_machine
from gough.machine.strut_limits import StrutLimits


@pytest.fixture(scope="module")
def okuma():
    return load_machine("okuma-pm600")


def wrong(machine, **changes):
    """The problems of a sheet with changed keys, dots written as two underscores, read as from a file."""
    table = machine.to_file()
    for key, value in changes.items():
        *above, last = key.split("__")
        inner = table
        for name in above:
            inner = inner[name]
        if value is None:
            del inner[last]
        else:
            inner[last] = value
    with pytest.raises(SheetError) as caught:
        Hexapod.from_file(table)
    assert caught.value.exit_status == 2
    return [str(p) for p in caught.value.problems]


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("platform__mass", "0 kg", "platform.mass: must be above 0 kg, got '0 kg'"),
        ("platform__mass", "-150 kg", "platform.mass: must be above 0 kg, got '-150 kg'"),
        (
            "platform__mass",
            "nan kg",
            "platform.mass: 'nan kg' is not a quantity; write a number and its unit, e.g. \"20 mm\"",
        ),
        ("platform__mass", float("nan"), 'platform.mass: has no unit, got nan; write e.g. "nan kg"'),
        ("platform__mass", "1e400 kg", "platform.mass: a quantity must be finite, got '1e400 kg'"),
        ("platform__mass", 150, 'platform.mass: has no unit, got 150; write e.g. "150 kg"'),
        ("platform__mass", "150", "platform.mass: '150' has no unit; write e.g. \"150 kg\""),
        ("platform__mass", True, "platform.mass: must be a quantity, got true"),
        ("platform__mass", "150 N", "platform.mass: '150 N' is not a quantity in kg; write e.g. \"150 kg\""),
        ("platform__mass", None, "platform.mass: is missing; give mass in kg"),
        ("strut__moving__mass", "0 kg", "strut.moving.mass: must be above 0 kg, got '0 kg'"),
        ("strut__fixed__transverse", "-1 kg m2", "strut.fixed.transverse: must be at least 0 kg m2, got '-1 kg m2'"),
        ("drive__lead", "0 mm", "drive.lead: must be above 0 m, got '0 mm'"),
        ("drive__inertia", "-1 kg m2", "drive.inertia: must be at least 0 kg m2, got '-1 kg m2'"),
        ("drive__encoder", "-1 um", "drive.encoder: must be above 0 m, got '-1 um'"),
        ("friction__coulomb", "-90 N", "friction.coulomb: must be at least 0 N, got '-90 N'"),
        ("limits__cone", "-45 deg", "limits.cone: must be above 0 rad, got '-45 deg'"),
        (
            "gravity",
            {"unit": "m/s2", "value": [0, -9.81]},
            "gravity: must have shape 3, got 2; give a list of 3: gravity, in W",
        ),
        ("platfrom", {}, "platfrom: no such key; did you mean platform?"),
    ],
)
def test_p1_p4_a_wrong_number_is_named_with_its_key(okuma, key, value, message):
    assert wrong(okuma, **{key: value}) == [message]


def test_p2_a_wrong_inertia_is_named_with_the_inequality(okuma):
    (text,) = wrong(okuma, platform__inertia={"unit": "kg m2", "value": [[6, 0, 0], [0, 6, 0], [0, 0, 13]]})
    assert (
        text == "platform: inertia violates the triangle inequality A + B >= C, got 6 + 6 < 13 kg m2; "
        "it must be about the centre of mass"
    )
    (text,) = wrong(okuma, platform__inertia={"unit": "kg m2", "value": [[6, 1, 0], [0, 6, 0], [0, 0, 9]]})
    assert text.startswith("platform: inertia must be symmetric, got [[6.0, 1.0, 0.0]")
    (text,) = wrong(okuma, platform__inertia={"unit": "kg m2", "value": [[6, 7, 0], [7, 6, 0], [0, 0, 9]]})
    assert text == "platform: inertia must be positive definite, got principal moments -1, 9, 13 kg m2"


def test_p4_limits_the_wrong_way_round_are_refused(okuma):
    (text,) = wrong(okuma, limits__length=["1.25 m", "0.45 m"])
    assert text == "limits.length: the shortest must be below the longest, got [1.25, 0.45] m"


def test_p4_friction_below_coulomb_and_of_wrong_length_is_refused(okuma):
    (text,) = wrong(okuma, friction={"kind": "stribeck", "coulomb": "90 N", "static": "80 N", "stribeck": "2 mm/s"})
    assert "static friction must be at least the Coulomb friction" in text
    for key in ("coulomb", "static", "viscous"):
        table = {"kind": "stribeck", "coulomb": "90 N", "static": "100 N", "stribeck": "2 mm/s"}
        table[key] = [f"{100} {'N s/m' if key == 'viscous' else 'N'}"] * 5
        (text,) = wrong(okuma, friction=table)
        assert text == f"friction.{key}: friction needs one value or six, got 5"


def test_p4_a_delay_is_none_or_one_sample(okuma):
    assert wrong(okuma, drive__delay=2) == ["drive.delay: must be 0 or 1 samples, got 2"]


def test_an_unknown_friction_law_is_named_with_those_there_are(okuma):
    assert wrong(okuma, friction__kind="lugree") == ["friction.kind: no such kind 'lugree'; did you mean lugre?"]
    assert wrong(okuma, friction={"coulomb": "90 N"}) == [
        "friction.kind: is missing; there is stribeck, lugre, load_stribeck, load_lugre, or leave friction out"
    ]


def test_every_mistake_of_a_sheet_is_found_at_once(okuma):
    found = wrong(okuma, platform__mass="-1 kg", drive__lead="x", limits__cone=45, strut__moving__mas="1 kg")
    assert [text.split(":")[0] for text in found] == ["platform.mass", "strut.moving.mas", "drive.lead", "limits.cone"]


# -- geometry (K7, and home) ------------------------------------------------------------------------------------------


def joints(machine, end, change):
    return {"unit": "m", "value": change(getattr(machine.joints, end).copy()).tolist()}


def test_k7_millimetres_given_for_metres_are_suspected(okuma):
    found = wrong(okuma, joints__base=joints(okuma, "base", lambda p: 1000 * p))
    assert found == [
        "joints.base: base joints span a strange distance, got 1409.54 m; "
        'did you mean mm? write { unit = "mm", value = ... }'
    ]


def test_k7_joints_on_one_line_are_refused(okuma):
    found = wrong(okuma, joints__platform=joints(okuma, "platform", lambda p: p * [1, 0, 0]))
    assert found == ["joints.platform: platform joints lie on one line, got span 0.526228 m"]


def test_k7_two_struts_with_the_same_joints_are_named_both(okuma):
    def same(p):
        p[4] = p[1]
        return p

    found = wrong(okuma, joints__base=joints(okuma, "base", same), joints__platform=joints(okuma, "platform", same))
    assert found == [
        "joints: struts 2 and 5 have the same joints, got 0 m and 0 m apart; move base or platform joint 5"
    ]


def test_k7_a_machine_that_is_singular_at_home_is_refused(okuma):
    """A platform that is the base made smaller: every pose above the base lets it turn about its axis."""
    found = wrong(okuma, joints__platform=joints(okuma, "base", lambda p: 0.4 * p + [0, 0, 0.4]))
    assert len(found) == 1 and found[0].startswith("home: home is a singular pose, or near one, got condition number ")
    assert "(limit 100)" in found[0] and "similar hexagons" in found[0]


def test_struts_beyond_their_stroke_at_home_are_all_named(okuma):
    found = wrong(okuma, home=["0 mm", "0 mm", "-1600 mm", "0 deg", "0 deg", "0 deg"])
    assert found == [
        "home: struts 1, 2, 3, 4, 5, 6 are too long at home, got 1.32633 m (limit 0.45 to 1.25 m); "
        "change home, the joints or limits.length"
    ]


def test_limits_of_the_struts_in_another_unit_are_told_as_such(okuma):
    found = wrong(okuma, limits__length=["450 m", "1250 m"])
    assert len(found) == 1 and found[0].endswith("(limit 450 to 1250 m); did you mean limits.length in mm?")


@pytest.mark.parametrize(
    ("key", "value", "cure"),
    [
        ("drive__max_speed", "40 m/min", "did you mean limits.speed, in [limits]?"),
        ("strut__mass", "48 kg", "did you mean strut.moving.mass or strut.fixed.mass?"),
        ("drive__lead", 10, 'write e.g. "10 mm"'),
        ("drive__lead", 0.01, 'write e.g. "0.01 m"'),
        ("platform__inertia", {"unit": "kg m2", "value": [9, 9, 11]},
         "a diagonal is written in full, [[a, 0, 0], [0, b, 0], [0, 0, c]]"),
        ("limits__length", "600 mm", "give a list of 2: shortest and longest strut"),
        ("home", ["0 mm", "0 mm", "0 mm", "0 deg"], "give pose at rest, x y z a b c of T in W"),
        ("strut", {"moving": {"mass": "1 kg", "center": "0 m", "transverse": "0 kg m2"}},
         "give a table with mass, center, or leave strut out"),
    ],
)  # fmt: skip
def test_what_a_newcomer_writes_is_answered_with_what_to_write(okuma, key, value, cure):
    found = wrong(okuma, **{key: value})
    assert len(found) == 1 and found[0].endswith(f"; {cure}"), found


def test_axes_of_the_joints_are_unit_vectors_across_their_struts(okuma):
    axis = okuma.joints.base_axis.copy()
    axis[3] *= 1.01
    (text,) = wrong(okuma, joints__base_axis={"unit": "1", "value": axis.tolist()})
    assert text == "joints.base_axis: an axis must have length 1, got 1.01 for strut 4; divide it by its length"
    axis = okuma.joints.base_axis.copy()
    axis[1] = okuma.jacobian(okuma.home)[1, :3]
    (text,) = wrong(okuma, joints__base_axis={"unit": "1", "value": axis.tolist()})
    assert text.startswith("joints.base_axis: the base axis of strut 2 lies along the strut at home")


def test_axial_inertia_without_a_base_axis_is_refused(okuma):
    assert wrong(okuma, joints__base_axis=None) == [
        f"strut.{part}.axial: needs joints.base_axis, which fixes the spin of the struts; "
        f"give joints.base_axis or leave strut.{part}.axial out"
        for part in ("moving", "fixed")
    ]


def test_home_is_a_table_of_one_pose(okuma):
    (text,) = wrong(okuma, home={"pose": ["0 mm"] * 3 + ["0 deg"] * 3, "speed": 1})
    assert text.startswith("home: [home] has one key, pose, got pose, speed")


def test_a_name_is_short_and_plain(okuma):
    for name in ("", "a" * 65, "two words", "../../etc/passwd", "\u202ename"):
        (text,) = wrong(okuma, name=name)
        assert text.startswith("name: ")


def test_python_made_parts_speak_the_same_language():
    with pytest.raises(SheetError, match=r"^mass: must be above 0 kg, got 0 kg$"):
        StrutPart(mass=0.0, center=0.1, transverse=0.0)
    with pytest.raises(SheetError, match=r"^determinant: must be below 1, got 1$"):
        StrutLimits(length=[0.1, 1.0], determinant=1.0)
    with pytest.raises(SheetError, match=r"^radius: must be above 0 m, got 0 m$"):
        Workspace(radius=0.0, height=1.0, tilt=0.0, c=0.0)
    with pytest.raises(SheetError, match=r"^length: must be above 0 m"):
        StrutLimits(length=np.array([0.0, 1.0]))
