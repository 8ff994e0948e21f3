"""Lines to words: the quick way and the thorough way agree, and what is wrong is said."""

import contextlib
import random
import time

import pytest

from gough.errors import ProgramError
from gough.program.ngc.expressions import Program
from gough.program.ngc.lexer import KEYWORDS, OWord, read_line
from gough.program.ngc.words import LONGEST, Words, plain, sorted_words


def words(text):
    """A line of numbers as Words, the thorough way."""
    return sorted_words(read_line(text).words, 1)


def error(text, **options):
    with pytest.raises(ProgramError) as caught:
        line = read_line(text, 1, **options)
        sorted_words(((w.letter, w.value, w.text) for w in line.words), 1)
    return str(caught.value)


BOTH = {
    "G1 X1 Y2": ((10,), (), {"X": 1.0, "Y": 2.0}),
    "g01x1y2": ((10,), (), {"X": 1.0, "Y": 2.0}),
    "G 1 X 1 2": ((10,), (), {"X": 12.0}),
    "\tG1\tX1 .5": ((10,), (), {"X": 1.5}),
    "N10 G1 X+5 Y-.5 Z3.": ((10,), (), {"X": 5.0, "Y": -0.5, "Z": 3.0}),
    "N99999999999999999999 G1": ((10,), (), {}),
    "N1": ((), (), {}),
    "": ((), (), {}),
    "G61.1 G90 M3 S12000 M8": ((611, 900), (3, 8), {"S": 12000.0}),
    "G0.9999999 X1": ((10,), (), {"X": 1.0}),
    "M3.00001": ((), (3,), {}),
    "G1 X1\r": ((10,), (), {"X": 1.0}),
    "G-1 X0": ((-10,), (), {"X": 0.0}),
}


@pytest.mark.parametrize("text", BOTH)
def test_a_plain_line_has_the_same_words_quickly_and_thoroughly(text):
    quick, thorough = plain(text, 1), words(text)
    assert quick == thorough
    assert (quick.g, quick.m, quick.values) == BOTH[text]


def test_words_tell_how_they_were_written():
    line = read_line("g01 x [#1 * 2] m06")
    assert [word.text for word in line.words] == ["G01", "X[#1*2]", "M06"]
    assert plain("g01 x01.50 m06", 7) == Words((10,), (6,), {"X": 1.5}, {"G1": "G01", "X": "X01.50", "M6": "M06"}, 7)


def test_random_plain_lines_have_the_same_words_quickly_and_thoroughly():
    rng = random.Random(2)
    for _ in range(2000):
        count = rng.randint(0, 7)
        letters = rng.choices("GGMMXYZABCDFHIJKLPQRSTE", k=count)
        text = "".join(
            rng.choice(["", " ", "\t"]) + rng.choice([c, c.lower()]) + rng.choice(["", "", "-", "+"])
            + rng.choice(["1", "01", "2.5", ".5", "3.", "61.1", "7.25", "1..2", ".", ""])
            for c in letters
        )  # fmt: skip
        quick = plain(text, 1)
        try:
            thorough = words(text)
        except ProgramError:
            assert quick is None, text
            continue
        # the quick way leaves some lines to the other: whole numbers that must be checked, signs twice, E
        assert quick in (None, thorough), text
        if not set("HLTE") & set(text.upper()):
            assert quick == thorough, text


def test_signs_may_repeat_as_in_linuxcnc():
    assert words("X--5 Y-+5 Z-+-5").values == {"X": 5.0, "Y": -5.0, "Z": 5.0}


@pytest.mark.parametrize(
    ("text", "left"),
    [("G1 X1 (c) Y2", "XY"), ("G1 (a;b) X1", "X"), ("G1 X1 ; (c", "X"), ("(c)(d) G1 X1", "X"), ("; all", ""),
     ("(äö\x01) G1 X1 ; ß", "X"), ("(MSG,a) X1 (DEBUG,#<no>)", "X"), ("(LOG,x)(PRINT,y)(LOGOPEN,z) X1", "X")],
)  # fmt: skip
def test_comments_are_left_out(text, left):
    assert "".join(words(text).values) == left


def test_the_last_comment_of_a_line_is_the_one_that_counts():
    assert read_line("(MSG, hello there)").comment == "hello there"
    assert read_line("(MSG,a)(b)").comment is None
    assert read_line("(c)(abort,too deep) ;d").stop == "too deep"
    assert read_line("(abort,x)(c)").stop is None
    assert read_line(";abort,x").stop is None


def test_a_deleted_line_is_read_only_where_block_delete_is_off():
    assert read_line("/ G1 garbage @").deleted
    assert [w.text for w in read_line("/N1 G1 X2", 1, False).words] == ["G1", "X2"]


def test_settings_keep_their_targets_and_their_values():
    line = read_line("#1=2 G1 #<Depth>=-[#3+1] #[1+1]=#<a> X1")
    assert [setting.text for setting in line.settings] == ["#1=2", "#<DEPTH>=-[#3+1]", "#[1+1]=#<A>"]
    assert line.settings[0][:2] == (1.0, 2.0)
    assert line.settings[1].target == "depth"
    assert isinstance(line.settings[2].target, Program)
    assert [word.text for word in line.words] == ["G1", "X1"]


@pytest.mark.parametrize(
    ("text", "keyword", "label", "values"),
    [
        ("O100 sub", "SUB", "100", 0), ("o<Face Mill> call [1] (c) [2] ;d", "CALL", "facemill", 2),
        ("N5 o007 end if", "ENDIF", "7", 0), ("o<1> while [1]", "WHILE", "1", 1), ("o1 return", "RETURN", "1", 0),
        ("o1 endsub [2] (c)", "ENDSUB", "1", 1), ("O0001", "", "1", 0), ("O1 (part)", "", "1", 0),
        ("o1.00001 do", "DO", "1", 0),
    ],
)  # fmt: skip
def test_an_o_line_has_a_keyword_a_label_and_values(text, keyword, label, values):
    found = read_line(text).oword
    assert isinstance(found, OWord)
    assert (found.keyword, found.label, len(found.values)) == (keyword, label, values)


def test_every_keyword_is_found_whole():
    for keyword in KEYWORDS:
        condition = " [1]" if keyword in ("IF", "ELSEIF", "WHILE", "REPEAT") else ""
        assert read_line(f"o<x> {keyword.lower()}{condition}").oword.keyword == keyword


ERRORS = {
    "G1 X": "X has no number, got 'X'; write e.g. X10",
    "G1 X Y2": "X has no number, got 'XY2'; write e.g. X10",
    "G1 X(c)1": "X has no number, got 'X()1'; write e.g. X10",
    "G1 XO": "a letter O in a number, got 'XO'; did you mean zero?",
    "G1 X1O": "a letter O in a number, got 'X1O'; did you mean zero?",
    "G1 X1..2": "a number has one point at most, got '1..2'; remove one",
    "G1 X1,5": "a number has a point, not a comma, got 'X1,5'; write a point",
    "G1 X1E3": "a number has no exponent, got 'X1E3'; write all its digits",
    "G1 X1+2": "an expression stands in brackets, got 'X1+2'; write e.g. X[1+2]",
    "G1 X[1]*2": "an expression stands in brackets, got 'X[1]*2'; write e.g. X[1+2]",
    "#1=2+3": "an expression stands in brackets, got '#1=2+3'; write e.g. #1=[#2+1]",
    "G1 X1 X2": "X twice in a block, got X1 X2; write it once",
    "M3 M4 M5 M6 M7": "more than 4 M codes in a block, got M3 M4 M5 M6 M7; write them in two blocks",
    "G1.05": "no such G code, got G1.05; a G code has one decimal at most, e.g. G1, G61.1",
    "M3.5": "an M code is a whole number, got M3.5; write e.g. M3",
    "T1.5": "T is a whole number, got T1.5; write e.g. T2",
    "G1 N10": "N is not the first word of its line, got 'N10'; remove it",
    "(c) N10": "N is not the first word of its line, got 'N10'; remove it",
    "N1 N2": "N is not the first word of its line, got 'N2'; remove it",
    "N1.5 G1": "a line number is a whole number, got 'N1.5G1'; write e.g. N10",
    "N-1": "a line number is a whole number, got 'N-1'; write e.g. N10",
    "N#1": "a line number is a whole number, got 'N#1'; write e.g. N10",
    "G1 o1 call": "an O word is not the first of its line, got 'O1CALL'; write it on a line of its own",
    "N1 /G1": "\"/\" stands only at the start of a line, got '/G1'; remove it",
    "G1 % X1": "\"%\" stands alone on its line, got '%X1'",
    "[1]": "an expression without a letter, got '[1]'; write e.g. X[1+2]",
    "1": "a number without a letter, got '1'",
    "-.5": "a number without a letter, got '-.5'",
    "G1 X1)": '")" without "(", got \')\'',
    "G1 @1": "not a word, got '@1'",
    "#1": "a parameter without a letter, and without a value, got '#1'; write e.g. #1=2, or a letter in front: X#1",
    "#1=": "a number is missing behind \"=\", got '#1='; write e.g. #1=2 or #1=[#2+1]",
    "#1==5": "a number is missing behind \"=\", got '#1==5'; write e.g. #1=2 or #1=[#2+1]",
    "#<a": "a name is not closed, got '<A'; write \">\" at its end",
    "G1 X1 (c": "a comment is not closed, got '(c'; write \")\" at its end",
    "G1 (c (d)) X1": "a comment inside a comment, got '(c (d)'; remove the second \"(\"",
    "(PY, import os)": "a comment that runs a script is not supported, got '(PY, import os)'; remove it",
    ";py,print(1)": "a comment that runs a script is not supported, got '(;py,print(1))'; remove it",
    "G1 Xä1": "a character that is not ASCII, outside a comment, got 'ä'",
    "G1 X\x01": "a control character in the line, got \\x01; remove it",
    "(\0)": "a control character in the line, got \\x00; remove it",
    "G1\rX1": "a control character in the line, got \\x0d; remove it",
    "(" + "c" * 251 + ")": "a line has at most 252 characters, got 253; split the line",
    "(" + "c" * 1_000_000 + ")": "a line has at most 252 characters, got 1000002; split the line",
    "o1 foo": "no such O word, got 'O1FOO'; there is "
    "sub, endsub, call, return, if, elseif, else, endif, while, endwhile, do, repeat, endrepeat, break, continue",
    "o1 ednif": "no such O word, got 'O1EDNIF'; did you mean endif?",
    "o1 if #1": "if without a condition in brackets, got 'O1IF#1'; write e.g. if [#1 lt 10]",
    "o1 if (c) [1]": "if without a condition in brackets, got 'O1IF()[1]'; write e.g. if [#1 lt 10]",
    "o1 repeat": "repeat without a count in brackets, got 'O1REPEAT'; write e.g. repeat [10]",
    "o1 if [1] x": "something behind if, got 'O1IF[1]X'; write it on a line of its own",
    "o1 else [1]": "something behind else, got 'O1ELSE[1]'; write it on a line of its own",
    "o1 endsub [1] [2]": "something behind endsub, got 'O1ENDSUB[1][2]'; write it on a line of its own",
    "o1 call 1": "something behind call, got 'O1CALL1'; write it on a line of its own",
    "o1 call" + "[1]" * 31: "a call has at most 30 arguments, got 31; use #<_names>",
    "o1.5 call": "the number of an O word is whole, got O1.5; write e.g. O100 or O<name>",
    "o-1 call": "the number of an O word is whole, got O-1; write e.g. O100 or O<name>",
    "o<> call": "a name is empty, got '<>CALL'; write e.g. <depth>",
    "o s call": "an O word without a label, got 'OSCALL'; write e.g. O100 or O<name>",
}


@pytest.mark.parametrize("text", ERRORS, ids=lambda text: repr(text[:20]))
def test_what_is_wrong_in_a_line_is_said_in_these_words(text):
    assert error(text, block_delete=False) == ERRORS[text]


def test_the_longest_line_of_linuxcnc_is_read_and_no_longer_one():
    assert words("G1 X1".ljust(LONGEST)).values == {"X": 1.0}
    assert plain("G1 X1".ljust(LONGEST), 1) is not None
    assert plain("G1 X1".ljust(LONGEST + 1), 1) is None
    assert "252" in error("(" + "ä" * 126 + ")")  # 254 bytes


@pytest.mark.parametrize(
    "text",
    [
        "X" + "1" * 250 + "@",
        ("X1111Y2222Z3333A4444" * 12) + "@",
        " " * 251 + "@",
        "O" + " " * 250,
        "N" + "1" * 251,
        "(" * 252,
        "#<" * 126,
        "[" * 252,
        "X" + "-" * 251,
        "X1" + "E1" * 125,
        ";" * 252,
    ],
)
def test_no_line_takes_long_however_wrong_it_is(text):
    start = time.process_time()
    for _ in range(20):
        plain(text, 1)
        with contextlib.suppress(ProgramError):
            read_line(text, 1, False)
    assert time.process_time() - start < 0.2  # 10 ms a line is a thousand times more than it needs


@pytest.mark.parametrize("seed", range(10))
def test_random_text_gives_words_or_an_error_of_the_program(seed):
    rng = random.Random(seed)
    pieces = [
        "G",
        "X",
        "#",
        "<",
        ">",
        "[",
        "]",
        "=",
        "1",
        ".",
        "-",
        "(",
        ")",
        ";",
        "O",
        "call",
        "if",
        "sub",
        "atan",
        "/",
        "%",
        "exists",
        "**",
        "mod",
        " ",
        "\t",
        "é",
        "\x7f",
        "N",
        "E",
        "sin",
        "o<a>",
        "#<b>",
        "[1]",
        "\udc80",
    ]
    for _ in range(300):
        text = "".join(rng.choices(pieces, k=rng.randint(1, 14)))
        try:
            read_line(text, 1, bool(rng.getrandbits(1)))
        except ProgramError as found:
            assert str(found).isprintable()
