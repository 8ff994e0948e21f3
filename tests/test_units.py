"""Quantities at the edge: what is read, to the digit, and what is refused however hostile."""

from __future__ import annotations

import math
import time

import pytest

from gough import units
from gough.errors import InputError, UnitError


@pytest.mark.parametrize(
    ("text", "expected", "value"),
    [
        ("20 mm", "m", 0.02),
        ("20mm", "m", 0.02),
        ("  -0.5 m ", "m", -0.5),
        ("1 in", "m", 0.0254),
        ("3 m/min", "m/s", 0.05),
        ("6000 mm/min", "m/s", 0.1),
        ("9.81 m/s2", "m/s2", 9.81),
        ("9.81 m/s^2", "m/s2", 9.81),
        ("9.81 m s-2", "m/s2", 9.81),
        ("9.81 m/s/s", "m/s2", 9.81),
        ("3e-3 kg m2", "kg m2", 3e-3),
        ("3e-3 kg*m^2", "kg m2", 3e-3),
        ("40 N m", "N m", 40.0),
        ("1 J", "N m", 1.0),
        ("1 kW", "W", 1000.0),
        ("1e9 N/m", "N/m", 1e9),
        ("2 N/um", "N/m", 2e6),
        ("930 N s/m", "N s/m", 930.0),
        ("1 kg/s", "N s/m", 1.0),
        ("180 deg", "rad", math.pi),
        ("1 rev", "rad", 2 * math.pi),
        ("60 rpm", "rad/s", 2 * math.pi),
        ("3600 arcsec", "rad", math.pi / 180),
        ("20 Hz", "Hz", 20.0),
        ("20 1/s", "Hz", 20.0),
        ("20 s-1", "Hz", 20.0),
        ("1.2 x", "1", 1.2),
        ("5 %", "1", 0.05),
        ("7", "1", 7.0),
        (".5 m", "m", 0.5),
        ("5. m", "m", 5.0),
        ("+1e+3 um", "m", 1e-3),
        ("40 N m/rad", "N m", 40.0),  # in a compound the radian does not count
        ("40 N m s/rad", "N m s", 40.0),
    ],
)
def test_a_quantity_is_read_in_si(text, expected, value):
    assert units.to_si(text, expected) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "expected", "message"),
    [
        ("20", "m", r"^'20' has no unit; write e\.g\. \"20 mm\"$"),
        ("0.2", "m", r"^'0.2' has no unit; write e\.g\. \"0.2 m\"$"),
        ("25", "rad", r"^'25' has no unit; write e\.g\. \"25 deg\"$"),
        ("40 Nm", "N m", r"^no unit 'Nm'; write N m, with a space$"),
        ("40 kgcm2", "kg m2", r"^no unit 'kgcm'; write kg cm2, with a space$"),
        ("2 t", "kg", r"^no unit 't'; write kg, 1 t is 1000 kg$"),
        ("25°", "rad", r"^a quantity is written in ASCII; write \"25 deg\"$"),
        ("4 kg·m²", "kg m2", r"^a quantity is written in ASCII; write \"4 kg m2\"$"),
        ("20 kg", "m", r"^'20 kg' is not a quantity in m; write e\.g\. \"20 m\"$"),
        ("20 m", "m/s", r"^'20 m' is not a quantity in m/s; write e\.g\. \"20 m/s\"$"),
        ("20 deg", "1", r"^'20 deg' is not a quantity in 1; write the number alone, e\.g\. 20$"),
        ("3 m", "", r"^'3 m' is not a number; write the number alone, e\.g\. 3$"),
        ("20", "rad", "has no unit"),
        # a factor of 2 pi would hide here
        ("20 Hz", "rad/s", r"^'20 Hz' is not a quantity in rad/s; 1 Hz is 2 pi rad/s: multiply by it$"),
        ("20 rad/s", "Hz", r"^'20 rad/s' is not a quantity in Hz; 1 Hz is 2 pi rad/s: divide by it$"),
        ("85,5 kg", "kg", r"^'85,5 kg' has a comma in its number; write a decimal point$"),
        ("85,", "kg", "is not a unit"),
        ("20 milimeter", "m", r"^no unit 'milimeter'"),
        ("20 MM", "m", r"^no unit 'MM'; did you mean mm\?$"),
        ("20 kn", "N", r"^no unit 'kn'; did you mean kN\?$"),
        ("mm", "m", r"^'mm' is not a quantity; write a number and its unit, e\.g\. \"20 mm\"$"),
        ("", "m", "is not a quantity"),
        ("nan m", "m", "is not a quantity"),
        ("inf m", "m", "is not a quantity"),
        ("-inf m", "m", "is not a quantity"),
        ("1e400 m", "m", "a quantity must be finite"),
        ("1e308 kN", "N", "a quantity must be finite"),
        ("1e9999 m", "m", "is not a unit|must be finite|no unit"),
        ("0x10 m", "m", "."),
        ("1_000 mm", "m", "."),
        ("1,5 mm", "m", "."),
        ("1 5 mm", "m", "."),
        ("20 mm/", "m", "is not a unit"),
        ("20 /mm", "m", "."),
        ("20 mm^^2", "m", "is not a unit"),
        ("20 mm99", "m", "is not a unit"),
        ("20 (mm)", "m", "is not a unit"),
        ("20 mm; import os", "m", "is not a unit"),
        ("__import__('os')", "m", "is not a quantity"),
        ("9**9**9**9 m", "m", "."),
        ("20 μm", "m", r"^a quantity is written in ASCII; write \"20 um\"$"),
        ("２０ mm", "m", "at most 64 ASCII characters"),
        ("20 mm\u202e", "m", "at most 64 ASCII characters"),
        ("1" * 65, "m", "at most 64 ASCII characters"),
        ("20\x00mm", "m", "."),
        ("20 mm\nkey = 1", "m", "."),
    ],
)
def test_what_is_no_quantity_is_refused_with_its_reason(text, expected, message):
    with pytest.raises(UnitError, match=message) as caught:
        units.to_si(text, expected)
    assert isinstance(caught.value, InputError) and caught.value.exit_status == 2


@pytest.mark.parametrize(
    "text", ["9" * 10**6, "1 " + "m " * 10**6, "1 " + "/" * 10**6, "1e" + "9" * 10**6, "(" * 10**6]
)
def test_a_long_hostile_text_is_refused_at_once(text):
    """A general units library hung on such a text for minutes."""
    start = time.process_time()
    with pytest.raises(UnitError) as caught:
        units.to_si(text, "m")
    assert time.process_time() - start < 0.1 and len(str(caught.value)) < 200


def test_every_divided_atom_divides_and_only_that_one():
    """m/s kg: the slash takes the one atom behind it."""
    assert units.unit("m/s kg") == (1.0, (1, 1, -1, 0, 0))
    assert units.unit("m/s/kg") == (1.0, (1, -1, -1, 0, 0))
    factor, dimension = units.unit("mm2/min-1")
    assert (factor, dimension) == (pytest.approx(60e-6), (2, 0, 1, 0, 0))


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (1.27e-5, "m", "12.7 um"), (0.5, "m", "500 mm"), (3.0, "m", "3 m"), (2e-9, "m", "2 nm"), (0.0, "m", "0 m"),
        (-0.02, "m", "-20 mm"), (1234.0, "N", "1.234 kN"), (999.0, "N", "999 N"), (2.5e-4, "s", "250 us"),
        (1e-3, "rad", "1 mrad"), (0.0174, "rad", "17.4 mrad"), (math.pi / 180, "rad", "1 deg"),
        (-1.5, "rad", "-85.94 deg"), (2e-6, "rad", "2 urad"), (0.0, "rad", "0 rad"),
        (0.05, "m/s", "0.05 m/s"), (5.0, "1", "5"), (float("nan"), "m", "nan m"),
        (9.99999e-4, "m", "1 mm"),  # not 1000 um
    ],
)  # fmt: skip
def test_a_number_is_shown_in_the_unit_people_read(value, unit, shown):
    assert units.show(value, unit) == shown


def test_what_is_shown_is_read_back():
    for value in (1.27e-5, 0.5, -3.25, 4e-8):
        assert units.to_si(units.show(value, "m", digits=15), "m") == pytest.approx(value, rel=1e-14)
