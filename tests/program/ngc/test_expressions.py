"""Values: what LinuxCNC makes of them (pinned from rs274 2.9), and random expressions against Python's arithmetic."""

import math
import random

import pytest

from gough.errors import ProgramError
from gough.program.ngc.compiler import compile_value
from gough.program.ngc.expressions import Program, evaluate
from gough.program.ngc.functions import UNARY
from gough.program.ngc.parameters import Parameters


def value(text, parameters=None):
    text = text.upper().replace(" ", "")
    found, end = compile_value(text)
    assert end == len(text), f"stopped at {text[end:]!r}"
    return evaluate(found, parameters or Parameters()) if isinstance(found, Program) else found


def error(text):
    with pytest.raises(ProgramError) as caught:
        value(text)
    return str(caught.value)


# what `#1=[...] (DEBUG, #1)` shows in LinuxCNC 2.9
LINUXCNC = {
    "1+2*3": 7, "2**3**2": 64, "-2**2": 4, "2*-3": -6, "[2]-[3]": -1, "8/2/2": 2, "10-3-2": 5, "2**2*3": 12,
    "2*2**3": 16, "2**-1": 0.5, "2 * * 3": 8, "--5": 5, "-[5]": -5, "+[5]": 5, "2---3": -1, "2+-+3": -1, "1 2": 12,
    "7 mod 3": 1, "-7 mod 3": 2, "7 mod -3": 1, "-7 mod -3": 2, "7.5 mod 2": 1.5, "-7.5 mod 3": 1.5,
    "1 eq 1.00009": 1, "1 eq 1.00011": 0, "0 eq 0.0001": 0, "1 ne 1.00005": 0, "1 le 0.99995": 0, "1 ge 1.00005": 0,
    "1 lt 1.00005": 1, "1 gt 0.99995": 1, "1+1 eq 2": 1, "1 lt 2 and 3 lt 2": 0, "1 or 0 and 0": 0, "1 xor 1 or 1": 1,
    "2 gt 1 eq 1": 1, "1 eq 1 eq 1": 1, "2 lt 1 lt 3": 1, "1 and 2": 1, "0.00001 and 1": 1, "0.00001 or 0": 1,
    "0.00001 xor 0": 1, "1 and [2 or 0]": 1, "0**0": 1,
    "round[2.5]": 3, "round[-2.5]": -3, "round[2.4999999999999996]": 2, "fix[-2.8]": -3, "fix[2.99999999]": 2,
    "fup[-2.8]": -2, "fup[2.1]": 3, "fup[2.00000001]": 3, "abs[-2]": 2, "sqrt[16]": 4, "ln[1]": 0, "exp[0]": 1,
    "atan[1]/[1]": 45, "atan[1]/[-1]": 135, "atan[0]/[0]": 0, "atan[-1]/[0]": -90, "atan[0]/[-1]": 180,
    "2*atan[1]/[1]": 90, "sin[30]": 0.5, "-sin[30]": -0.5, "cos[60]": 0.5, "tan[45]": 1, "acos[0.5]": 60,
    "asin[0.5]": 30, "fix[2*sin[30]]": 1,
    "exists[#1]": 1, "exists[#5601]": 1, "exists[#5602]": 0, "exists[#0]": 0, "exists[##2]": 0, "exists[#[1]]": 1,
    "exists[#<_x1>]": 0, "exists[#<a b>]": 0, "#1.00005": 0, "#0.99999": 0, "#[1+1]": 0, "-#1": 0, "#+1": 0,
}  # fmt: skip


@pytest.mark.parametrize("text", LINUXCNC)
def test_an_expression_has_the_value_that_linuxcnc_gives_it(text):
    assert value(f"[{text}]") == LINUXCNC[text]


@pytest.mark.parametrize(
    ("text", "angle"),
    [("atan[1]/[2]", math.degrees(math.atan(0.5))), ("asin[0.3]", math.degrees(math.asin(0.3))),
     ("acos[-0.7]", math.degrees(math.acos(-0.7)))],
)  # fmt: skip
def test_inverse_functions_answer_in_degrees(text, angle):
    assert value(text) == angle


@pytest.mark.parametrize("turns", [-3, 0, 5])
@pytest.mark.parametrize("angle", range(-180, 181, 15))
def test_functions_of_angles_agree_with_their_rounded_forms_and_are_exact_where_they_are_short(angle, turns):
    radians = math.radians(angle)
    for name, exact in (("sin", math.sin(radians)), ("cos", math.cos(radians))):
        found = value(f"{name}[{angle + 360 * turns}]")
        assert abs(found - exact) < 4e-16  # the argument's rounding, pi at most, times the slope, 1 at most
        if angle % 30 == 0 and abs(round(2 * exact) - 2 * exact) < 1e-9:
            assert found == round(2 * exact) / 2


def test_the_square_of_sine_and_cosine_add_to_one_at_random_angles():
    rng = random.Random(1)
    for _ in range(200):
        a = rng.uniform(-1e4, 1e4)
        # two squares, each rounded twice
        assert abs(value(f"[sin[{a:.6f}]**2 + cos[{a:.6f}]**2]") - 1) < 5e-16


ERRORS = {
    "[1/0]": "a division by zero, got '[1/0]'; check the divisor",
    "[3 mod 0]": "MOD by zero, got '[3MOD0]'; check the divisor",
    "[sqrt[-1]]": "the square root of a negative number, got '[SQRT[-1]]'; check what stands in its brackets",
    "[ln[0]]": "LN needs a number above 0, got '[LN[0]]'; check what stands in its brackets",
    "asin[1.0000001]": "ASIN needs a number from -1 to 1, got 'ASIN[1.0000001]'; check what stands in its brackets",
    "acos[-2]": "ACOS needs a number from -1 to 1, got 'ACOS[-2]'; check what stands in its brackets",
    "exp[710]": "EXP gives a number that is too large, got 'EXP[710]'; at most EXP[709]",
    "tan[-90]": "TAN has no value at a right angle, got 'TAN[-90]'; check the angle, in degrees",
    "[[-8]**0.5]": "a negative number to a power that is not whole, got '[[-8]**0.5]'; "
    "check the base, or use a whole power",
    "[0**-1]": "zero to a negative power, got '[0**-1]'; check the base",
    "[10**309]": "a number that is too large, got '[10**309]'; check the power",
    "[1/[10**308*10]]": "a number that is too large, got '[1/[10**308*10]]'; check the numbers in this expression",
    "[10**308*10 gt 1]": "a number that is too large, got '[10**308*10GT1]'; check the numbers in this expression",
    "[1+2": "an expression is not closed, got '[1+2'; write \"]\" at its end",
    "[[1+2]*3": "an expression is not closed, got '[[1+2]*3'; write \"]\" at its end",
    "[]": "a number is missing in an expression, got '[]'; write e.g. 10, #1 or [#1+2]",
    "[2*]": "a number is missing in an expression, got '[2*]'; write e.g. 10, #1 or [#1+2]",
    "[eq 2]": "a number is missing in an expression, got '[EQ2]'; write e.g. 10, #1 or [#1+2]",
    "": "a number is missing, got ''; write e.g. 10, #1 or [#1+2]",
    "-": "a number is missing, got '-'; write e.g. 10, #1 or [#1+2]",
    "#": "a number is missing, got '#'; write e.g. 10, #1 or [#1+2]",
    "[1 foo 2]": "no such operation, got 'FOO'; "
    "operations are **, *, /, MOD, +, -, EQ, NE, GT, GE, LT, LE, AND, OR, XOR",
    "[[1][2]]": "no such operation, got '[2]]'; "
    "operations are **, *, /, MOD, +, -, EQ, NE, GT, GE, LT, LE, AND, OR, XOR",
    "[1e3]": "a number has no exponent, got '[1E3]'; write all its digits",
    "[1()+2]": "a comment inside an expression, got '[1()+2]'; write it behind the expression",
    "[sine[2]]": "no such function, got '[SINE[2]]'; did you mean SIN?",
    "sin 30": "SIN without \"[\", got 'SIN30'; write SIN[...]",
    "atan[1]": "ATAN has two values, got 'ATAN[1]'; write ATAN[y]/[x]",
    "atan[1]/2": "ATAN has two values, got 'ATAN[1]/2'; write ATAN[y]/[x]",
    "exists[1]": "EXISTS asks for a parameter, got 'EXISTS[1]'; write e.g. EXISTS[#<depth>]",
    "exists[#1+1]": "EXISTS asks for one parameter, got 'EXISTS[#1+1]'; write e.g. EXISTS[#<depth>]",
    "exists[#<a>+1]": "EXISTS asks for one parameter, got 'EXISTS[#<A>+1]'; write e.g. EXISTS[#<depth>]",
    "[5.3.2]": "a number has one point at most, got '[5.3.2]'; remove one",
    ".": "a point without digits, got '.'; write the number",
    "#<a": "a name is not closed, got '<A'; write \">\" at its end",
    "#<>": "a name is empty, got '<>'; write e.g. <depth>",
    "#<a()>": 'a name has no brackets "(", ")", "<", got \'<A()>\'; use letters, digits and _',
    "##1": "parameters go from #1 to #5601, got #0; use e.g. #100",
    "#-1": "parameters go from #1 to #5601, got #-1; use e.g. #100",
    "#5602": "parameters go from #1 to #5601, got #5602; use e.g. #100",
    "#1.5": "the number of a parameter is whole, got #[1.5]; use FIX[...] or ROUND[...]",
    "#[10**300]": "parameters go from #1 to #5601, got #1e+300; use e.g. #100",
    "#<x>": "a named parameter that was never set, got #<x>; write #<x>=... before it",
}


@pytest.mark.parametrize("text", ERRORS)
def test_what_is_wrong_in_an_expression_is_said_in_these_words(text):
    assert error(text) == ERRORS[text]


# -- random expressions, built as trees and evaluated twice ---------------------------------------------------------

TIGHT = {"**": 5, "*": 4, "/": 4, "MOD": 4, "+": 3, "-": 3, "GT": 2, "LE": 2, "EQ": 2, "AND": 1, "OR": 1, "XOR": 1}
PYTHON = {
    "**": lambda a, b: a**b, "*": lambda a, b: a * b, "/": lambda a, b: a / b, "MOD": lambda a, b: a % abs(b),
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "GT": lambda a, b: float(a > b), "LE": lambda a, b: float(a <= b),
    "EQ": lambda a, b: float(abs(a - b) < 1e-4), "AND": lambda a, b: float(bool(a) and bool(b)),
    "OR": lambda a, b: float(bool(a) or bool(b)), "XOR": lambda a, b: float(bool(a) ^ bool(b)),
}  # fmt: skip


def tree(rng, depth):
    """(text, value, tightness): brackets only where the grammar needs them."""
    if depth == 0 or rng.random() < 0.2:
        number = rng.randint(-20, 20)
        if rng.random() < 0.4:
            return f"#{number % 5 + 1}", KEPT[number % 5], 9
        return str(number), float(number), 9
    if rng.random() < 0.15:
        text, x, _ = tree(rng, depth - 1)
        return f"ABS[{text}]", abs(x), 9
    operation = rng.choice(list(TIGHT))
    (left, a, one), (right, b, two) = tree(rng, depth - 1), tree(rng, depth - 1)
    mine = TIGHT[operation]
    if operation in ("/", "MOD") and b == 0 or operation == "**" and (abs(a) > 50 or not 0 <= b <= 4 or b % 1):
        operation, mine = "+", 3
    left = f"[{left}]" if one < mine else left
    right = f"[{right}]" if two <= mine else right  # from the left: a - (b - c) needs its brackets
    return f"{left} {operation} {right}", PYTHON[operation](a, b), mine


KEPT = [3.0, -1.5, 0.0, 7.0, 2.0]


@pytest.mark.parametrize("seed", range(300))
def test_a_random_expression_with_as_few_brackets_as_can_be_has_the_value_of_its_tree(seed):
    parameters = Parameters()
    for number, kept in enumerate(KEPT, 1):
        parameters.set(number, kept)
    text, expected, _ = tree(random.Random(seed), 5)
    # the same operations on the same doubles; fmod(a, b) + |b| rounds once where Python's % rounds elsewhere
    assert value(f"[{text}]", parameters) == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_every_operation_and_function_is_known_to_the_tests_of_values():
    texts = " ".join(LINUXCNC).upper()
    assert all(name in texts for name in [*UNARY, "ATAN", "EXISTS", *"+-*/", "**", "MOD"])
    assert all(name in texts for name in ("EQ", "NE", "GT", "GE", "LT", "LE", "AND", "OR", "XOR"))


@pytest.mark.quick("text0", "text3")
@pytest.mark.parametrize(
    "text",
    [
        "[" * 100_000 + "1" + "]" * 100_000,
        "abs[" * 50_000 + "1" + "]" * 50_000,
        "[1" + "+[1" * 50_000 + "]" * 50_001,
        "-" * 100_000 + "1",
        "[1" + "+1" * 100_000 + "]",
    ],
)
def test_a_hundred_thousand_brackets_are_no_deeper_than_one(text):
    assert value(text) in (1.0, 50_001.0, 100_001.0)


@pytest.mark.parametrize("text", ["[" * 100_000, "#" * 100_000 + "1", "[" * 99_999 + "1" + "]" * 99_998])
def test_a_hundred_thousand_wrong_brackets_are_an_error(text):
    with pytest.raises(ProgramError):
        value(text)
