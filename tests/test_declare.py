"""Parts: checked numbers, theta and the view on it, change, text and equality."""

from __future__ import annotations

import pickle
import subprocess
import sys

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose
from pydantic import Field

from gough.declare import Array, Part, quantity
from gough.errors import ExperimentError, InputError
from gough.machine.sheet import load_machine
from oracle.machines import general


class Spring(Part):
    stiffness: float = quantity("N/m", "stiffness", above=0)
    length: float | None = quantity("m", "length at rest", default=None, at_least=0)


class Rig(Part):
    gain: float = quantity("1", "gain", default=1.0, at_least=0, at_most=10)
    frame: Array = quantity("m", "corners", shape=(2, 3))
    levels: float | Array = quantity("N", "one level or one a joint", default=5.0, shape=(-1,))
    pose: Array = quantity("m, m, rad", "x y a", default=[0.0, 0.0, 0.0], shape=(3,))
    budget: float = quantity("s", "time it may take", default=1.0, above=0, theta=False)
    spring: Spring
    second: Spring | None = None
    name: str = Field(default="rig", max_length=8)


def rig(**changes):
    return Rig(**{"frame": [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "spring": Spring(stiffness=100.0)} | changes)


TABLE = {
    "gain": 2,
    "frame": {"unit": "mm", "value": [[1, 2, 3], [4, 5, 6]]},
    "levels": ["1 N", "2 N", "1 kN"],
    "pose": ["10 mm", "20 mm", "90 deg"],
    "spring": {"stiffness": "2 N/mm", "length": "5 cm"},
}


# -- reading ----------------------------------------------------------------------------------------------------------


def test_a_table_is_read_in_si():
    r = Rig.from_file(TABLE)
    assert r.gain == 2.0 and r.spring.stiffness == 2000.0 and r.spring.length == 0.05 and r.budget == 1.0
    assert_allclose(r.frame, [[1e-3, 2e-3, 3e-3], [4e-3, 5e-3, 6e-3]], rtol=1e-15)
    assert_allclose(r.levels, [1, 2, 1000], rtol=1e-15)
    assert_allclose(r.pose, [0.01, 0.02, np.pi / 2], rtol=1e-15)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"budget": 5}, r'^budget: has no unit, got 5; write e\.g\. "5 s"$'),
        ({"frame": [[1, 2, 3], [4, 5, 6]]}, r'^frame: has no unit.*; write \{ unit = "m", value = \.\.\. \}$'),
        ({"spring": {"stiffness": 2000}}, r'^spring\.stiffness: has no unit, got 2000; write e\.g\. "2000 N/m"$'),
        ({"spring": {"stiffness": "2000"}}, r"^spring\.stiffness: '2000' has no unit"),
        (
            {"spring": {"stiffness": "2 mm"}},
            r"^spring\.stiffness: '2 mm' is not a quantity in N/m; write e\.g\. \"2 N/m\"$",
        ),
        ({"spring": {"stifness": "2 N/mm"}}, r"stifness: no such key; did you mean stiffness\?"),
        ({"spring": {}}, r"^spring\.stiffness: is missing; give stiffness in N/m$"),
        ({"spring": {"stiffness": "-2 N/m"}}, r"^spring\.stiffness: must be above 0 N/m, got '-2 N/m'$"),
        ({"frame": {"unit": "kg", "value": [[1, 2, 3], [4, 5, 6]]}}, "^frame: 'kg' is not a unit of m$"),
        ({"frame": {"unit": "m", "values": [[1, 2, 3], [4, 5, 6]]}}, r"^frame: an array is written \{ unit = "),
        ({"frame": {"unit": "m", "value": [[1, 2, 3], [4, 5]]}}, "^frame: rows of an array must be of one length"),
        ({"frame": {"unit": "m", "value": [[1, 2], [4, 5]]}}, "^frame: must have shape 2 x 3, got 2 x 2$"),
        ({"frame": {"unit": "m", "value": [["1", "2", "3"], ["4", "5", "6"]]}}, "^frame: must be a number"),
        ({"frame": {"unit": 5, "value": [[1, 2, 3], [4, 5, 6]]}}, "^frame: a unit is a text"),
        ({"frame": {"unit": "m", "value": [[1, 2, 3], [4, 5, float("nan")]]}}, "^frame: must be finite"),
        ({"frame": {"unit": "m", "value": [[1, 2, 3], [4, 5, True]]}}, "^frame: must be a number, got True"),
        ({"gain": True}, "^gain: must be a quantity, got true$"),
        ({"gain": float("inf")}, "^gain: must be finite, got inf$"),
        ({"gain": float("nan")}, "^gain: must be finite, got nan$"),
        ({"gain": 10**400}, "^gain: must be finite"),
        ({"gain": "1e400"}, "^gain: must be a number, without quotes, got '1e400'$"),
        ({"gain": "3"}, "^gain: must be a number, without quotes, got '3'$"),
        ({"gain": "1e400 %"}, "^gain: a quantity must be finite"),
        ({"gain": 10.5}, "^gain: must be at most 10, got 10.5$"),
        ({"gain": -0.1}, "^gain: must be at least 0, got -0.1$"),
        ({"gain": None}, "^gain: "),
        ({"gain": {"a": 1}}, "^gain: an array is written"),
        ({"pose": ["10 mm", "20 mm", "90 mm"]}, r"^pose: '90 mm' is not a quantity in rad; write e\.g\. \"90 deg\"$"),
        ({"pose": ["10 mm", "20 mm"]}, "^pose: must have shape 3, got 2; give "),
        ({"name": 5}, "^name: "),
        ({"name": "a much too long name"}, "^name: "),
        ({"spring": 5}, "^spring: "),
    ],
)
def test_a_wrong_table_is_refused_with_key_rule_and_cure(change, message):
    with pytest.raises(ExperimentError, match=message) as caught:
        Rig.from_file(TABLE | change)
    assert caught.value.exit_status == 2


def test_every_mistake_is_found_at_once():
    with pytest.raises(ExperimentError) as caught:
        Rig.from_file(TABLE | {"gain": -1, "budget": "1 m", "spring": {"stiffness": "x", "colour": 1}, "extra": 2})
    keys = {p.key for p in caught.value.problems}
    assert keys == {"gain", "budget", "spring.stiffness", "spring.colour", "extra"}


def test_made_in_python_a_part_takes_si_numbers_of_every_kind():
    r = rig(gain=np.float64(2), levels=np.array([1.0, 2.0]), pose=(1, 2, 3))
    assert r.gain == 2.0 and type(r.gain) is float and r.levels.tolist() == [1, 2]
    assert rig(gain="2 x").gain == 2.0  # a text with its unit serves too
    with pytest.raises(ExperimentError, match="gain: must be a number"):
        rig(gain=ca.SX.sym("k"))  # a symbol never enters a part


# -- immutable, equal, hashed -----------------------------------------------------------------------------------------


def test_parts_do_not_change():
    r = rig()
    with pytest.raises(ValueError, match="frozen"):
        r.gain = 5.0
    for array in (r.frame, r.pose):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 9.0


def test_an_array_handed_in_is_copied():
    frame = np.ones((2, 3))
    r = rig(frame=frame)
    frame[0, 0] = 7.0
    assert r.frame[0, 0] == 1.0


def test_parts_are_equal_and_hashed_by_content():
    a, b = rig(gain=2.0), rig(gain=2)
    assert a == b and hash(a) == hash(b) and a.digest() == b.digest() and a is not b
    for change in ({"gain": 2.0000000000000004}, {"frame": [[1.0, 2, 3], [4, 5, 7]]}, {"spring": Spring(stiffness=1.0)},
                   {"name": "other"}, {"second": Spring(stiffness=1.0)}, {"levels": [5.0]}):  # fmt: skip
        assert rig(**{"gain": 2.0} | change) != a
    assert Spring(stiffness=1.0) != rig() and rig() != 5
    assert len({a, b, rig()}) == 2


@pytest.mark.full
def test_the_digest_is_the_same_in_every_process():
    """Hashes of texts are seeded anew in each process; a digest that used them would never find a cache."""
    code = "from gough.machine.sheet import load_machine; print(load_machine('okuma-pm600').digest())"
    found = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    ]
    assert found[0] == found[1] == load_machine("okuma-pm600").digest() + "\n"


def test_a_part_survives_pickling():
    m = general()
    assert pickle.loads(pickle.dumps(m)) == m


# -- theta ------------------------------------------------------------------------------------------------------------


def test_theta_and_names_go_together():
    r = rig(levels=[7.0, 8.0], second=Spring(stiffness=3.0, length=0.25))
    assert dict(zip(r.names, r.theta, strict=True)) == {
        "gain": 1, "frame[0,0]": 1, "frame[0,1]": 2, "frame[0,2]": 3, "frame[1,0]": 4, "frame[1,1]": 5, "frame[1,2]": 6,
        "levels[0]": 7, "levels[1]": 8, "pose[0]": 0, "pose[1]": 0, "pose[2]": 0,
        "spring.stiffness": 100, "second.stiffness": 3, "second.length": 0.25,
    }  # fmt: skip


def numbers_of(part, view, path=""):
    """(path, number of the part, entry of the view) of every number in theta, from the fields alone."""
    for name, field in type(part).model_fields.items():
        value = getattr(part, name)
        if isinstance(value, Part):
            yield from numbers_of(value, getattr(view, name), f"{path}{name}.")
        elif name in type(part).specs() and value is not None and field.json_schema_extra["theta"]:
            yield f"{path}{name}", value, getattr(view, name)


MACHINES = [load_machine("nist-octahedral"), load_machine("okuma-pm600"), general()]


@pytest.mark.parametrize("part", [rig(levels=[7.0, 8.0]), *MACHINES],
                         ids=["rig", "nist-octahedral", "okuma-pm600", "general"])  # fmt: skip
def test_the_view_shows_every_number_in_its_place(part):
    """theta is random numbers made to differ: a transposed matrix or a shifted entry cannot hide."""
    theta = ca.SX.sym("theta", len(part.theta))
    found = list(numbers_of(part, part.at(theta)))
    assert sum(np.size(value) for _, value, _ in found) == len(part.theta) == len(set(part.names))
    other = np.random.default_rng(0).normal(size=len(part.theta))
    where = {name: value for name, value in zip(part.names, other, strict=True)}  # noqa: C416
    for name, value, entry in found:
        f = ca.Function("f", [theta], [entry])
        assert_allclose(np.array(f(part.theta)).reshape(np.shape(value)), value, rtol=0)
        if np.ndim(value) == 2:
            assert entry.shape == value.shape
            for i, j in np.ndindex(value.shape):
                assert float(f(other)[i, j]) == where[f"{name}[{i},{j}]"]


def test_what_is_absent_or_kept_out_of_theta_is_seen_as_it_is():
    r = rig()
    view = r.at(ca.SX.sym("theta", len(r.theta)))
    assert view.spring.length is None and view.second is None and view.budget == 1.0 and view.name == "rig"
    with pytest.raises(AttributeError):
        _ = view.nothing


def test_theta_of_the_wrong_length_is_refused():
    with pytest.raises(ExperimentError, match=r"theta of Rig has \d+ entries, got \(3, 1\)"):
        rig().at(ca.SX.sym("theta", 3))


# -- change -----------------------------------------------------------------------------------------------------------


def test_replace_reaches_inside_and_checks():
    r = rig()
    assert r.replace(**{"spring.stiffness": 5.0, "gain": 3.0}).spring.stiffness == 5.0
    assert r.spring.stiffness == 100.0 and r.replace() == r
    with pytest.raises(ExperimentError, match=r"^spring\.stiffness: must be above 0 N/m, got -1 N/m$"):
        r.replace(**{"spring.stiffness": -1.0})
    with pytest.raises(ExperimentError, match=r"^spring\.stifness: no such key; did you mean .*stiffness\?$"):
        r.replace(**{"spring.stifness": 1.0})
    with pytest.raises(ExperimentError, match=r"^gian: no such key; did you mean gain\?$"):
        r.replace(gian=1.0)


def test_replace_from_file_takes_texts_and_factors():
    r = rig(levels=[7.0, 8.0])
    changed = r.replace_from_file({"spring.stiffness": "1.5 x", "levels": "2 x", "budget": "3 ms"})
    assert changed.spring.stiffness == 150.0 and changed.levels.tolist() == [14, 16] and changed.budget == 3e-3
    with pytest.raises(InputError, match="cannot be scaled"):
        r.replace_from_file({"spring.length": "2 x"})
    with pytest.raises(InputError, match=r'has no unit, got 5; write e\.g\. "5 N/m"'):
        r.replace_from_file({"spring.stiffness": 5})


def test_several_wrong_changes_are_all_named():
    with pytest.raises(ExperimentError) as caught:
        rig().replace(gain=-1.0, nothing=1, **{"spring.stiffness": 0.0})
    assert {p.key for p in caught.value.problems} == {"gain", "nothing", "spring.stiffness"}


# -- text -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [rig(), Rig.from_file(TABLE), *MACHINES],
                         ids=["rig", "table", "nist-octahedral", "okuma-pm600", "general"])  # fmt: skip
def test_what_is_written_is_read_back_equal_to_the_last_bit(part):
    table = part.to_file()
    again = type(part).from_file(table)
    assert again == part and again.digest() == part.digest() and again.to_file() == table


def test_what_is_written_carries_its_units():
    table = Rig.from_file(TABLE).to_file()
    assert table["spring"] == {"stiffness": "2000.0 N/m", "length": "0.05 m"}
    assert table["frame"]["unit"] == "m" and table["pose"][2] == f"{np.pi / 2!r} rad" and "second" not in table
