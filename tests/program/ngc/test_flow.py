"""The order in which lines run: subroutines, conditions, loops, ends; and that every program ends.

What runs is told by G4 P words: `dwells` is the list of their numbers.
"""

import os
import time
import tracemalloc

import pytest

from gough.errors import ProgramError
from gough.program.ngc import flow
from gough.program.ngc.flow import DEEPEST, run
from gough.program.ngc.parameters import Parameters


def dwells(text, **options):
    out = []

    def execute(words):
        if 40 in words.g:
            out.append(words.values["P"])
        return bool({2, 30} & set(words.m))

    run(text, execute, Parameters(), **options)
    return out


def body(*lines, **options):
    return dwells("\n".join([*lines, "M2"]), **options)


def error(*lines, text=None, **options):
    with pytest.raises(ProgramError) as caught:
        dwells("\n".join([*lines, "M2"]) if text is None else text, **options)
    return str(caught.value)


# -- values on a line -------------------------------------------------------------------------------------------------


def test_all_values_of_a_line_are_those_from_before_it():
    assert body("#1=3", "#1=4 #2=#1 G4 P#1", "G4 P#1", "G4 P#2") == [3, 4, 3]


def test_the_last_of_two_settings_of_a_line_holds():
    assert body("#1=1 #1=2", "G4 P#1") == [2]


def test_parameters_are_set_before_the_words_of_their_line_act():
    seen, parameters = [], Parameters()
    run("#5=7 G1\nM2", lambda words: seen.append(parameters.get(5)) or 2 in words.m, parameters)
    assert seen == [7.0, 7.0]


def test_parameters_have_indirect_numbers_and_names():
    assert body("#1=2", "##1=7", "G4 P#2", "#[1+2]=#[#1]", "G4 P#3", "#<A b>=9", "G4 P#<ab>") == [7, 7, 9]


def test_the_line_number_is_a_parameter():
    assert body("G4 P#<_line>", "", "G4 P#<_line>") == [1, 3]


# -- conditions and loops ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("a", "b", "ran"), [(1, 1, [1]), (1, 0, [1]), (0, 1, [2]), (0, 0, [4]), (0.00001, 0, [1]), (-1, 0, [1])]
)
def test_one_branch_of_a_condition_runs(a, b, ran):
    lines = [f"#1={a} #2={b}", "o1 if [#1]", "G4 P1", "o1 elseif [#2]", "G4 P2", "o1 elseif [#2]", "G4 P3", "o1 else"]
    assert body(*lines, "G4 P4", "o1 endif", "G4 P9") == [*ran, 9]


def test_a_condition_without_else_may_run_nothing():
    assert body("o1 if [0]", "G4 P1", "o1 endif", "G4 P2") == [2]


def test_the_conditions_behind_a_branch_that_was_taken_are_not_asked():
    assert body("o1 if [1]", "G4 P1", "o1 elseif [1/0]", "o1 endif") == [1]


@pytest.mark.parametrize("first", [0, 3, 7])
def test_while_asks_first_and_do_asks_last(first):
    counted = [float(n) for n in range(first, 5)]
    lines = [f"#1={first}", "o1 while [#1 lt 5]", "G4 P#1", "#1=[#1+1]", "o1 endwhile"]
    assert body(*lines) == counted
    lines = [f"#1={first}", "o1 do", "G4 P#1", "#1=[#1+1]", "o1 while [#1 lt 5]"]
    assert body(*lines) == (counted or [float(first)])


@pytest.mark.parametrize(
    ("count", "times"), [("0", 0), ("-1", 0), ("0.5", 0), ("0.51", 1), ("1.4", 1), ("1.5", 2), ("2.5", 2), ("3", 3)]
)
def test_repeat_rounds_its_count_as_linuxcnc_does(count, times):
    assert body(f"o1 repeat [{count}]", "G4 P1", "o1 endrepeat", "G4 P2") == [1] * times + [2]


def test_break_and_continue_belong_to_the_loop_of_their_label():
    lines = ["#1=0", "o1 while [#1 lt 6]", "#1=[#1+1]", "o2 if [#1 eq 2]", "o1 continue", "o2 endif"]
    lines += ["o3 if [#1 eq 4]", "o1 break", "o3 endif", "G4 P#1", "o1 endwhile", "G4 P[#1*10]"]
    assert body(*lines) == [1, 3, 40]
    lines = ["#1=0", "o1 do", "#1=[#1+1]", "o2 while [1]", "o1 continue", "o2 endwhile", "o1 while [#1 lt 3]", "G4 P#1"]
    assert body(*lines) == [3]
    assert body("o1 while [1]", "o2 while [1]", "o1 break", "o2 endwhile", "o1 endwhile", "G4 P1") == [1]


def test_a_repeat_that_was_left_in_the_middle_counts_anew():
    lines = ["#1=0", "o1 while [#1 lt 2]", "#1=[#1+1]", "o2 repeat [3]", "G4 P#1", "o1 continue", "o2 endrepeat"]
    assert body(*lines, "o1 endwhile", "o3 repeat [2]", "o4 repeat [2]", "G4 P9", "o4 endrepeat", "o3 endrepeat") == [
        1, 2, 9, 9, 9, 9,
    ]  # fmt: skip


def test_blanks_case_and_line_numbers_do_not_count_in_o_lines():
    assert body("N5 O 1 I F [1] (c)", "G4 P1", "n7 o1 End If ;d", "o2if[0]", "G4P2", "o2endif") == [1]


def test_what_does_not_run_is_not_read():
    assert body("o1 if [0]", "garbage @", "o1 endif", "G4 P1") == [1]


# -- subroutines ------------------------------------------------------------------------------------------------------

SUB = ["o<s> sub", "G4 P[#1*100+#2*10+#30]", "#1=77 #2=77", "o<s> endsub"]


def test_a_call_has_its_arguments_and_leaves_its_callers_alone():
    assert body(*SUB, "#1=5", "o<s> call [1] [2]", "G4 P#1", "o<S> CALL [#1]", "o<s> call") == [120, 5, 500, 0]


@pytest.mark.parametrize(
    "call", ["o100 call", "o0100 call", "O<100> call", "o#1 call", "o[#1] call", "o[99+1.00001] call"]
)
def test_a_label_is_a_number_however_it_is_written(call):
    assert body("o100 sub", "G4 P8", "o100 endsub", "#1=100", call) == [8]


def test_what_a_subroutine_returns_is_a_value():
    lines = ["o<a> sub", "o1 if [#1]", "o<a> return [5]", "o1 endif", "o<a> endsub [6]"]
    values = "G4 P[#<_value>*10+#<_value_returned>]"
    lines += ["o<b> sub", "o<b> endsub", "o<a> call [1]", values, "o<a> call", values, "o<b> call", values]
    assert body(*lines) == [51, 61, 0]


def test_a_return_leaves_loops_and_the_next_call_begins_them_anew():
    lines = [
        "o<s> sub",
        "o2 repeat [5]",
        "#1=[#1+1]",
        "o3 if [#1 ge 2]",
        "o<s> return [#1]",
        "o3 endif",
        "o2 endrepeat",
    ]
    lines += ["o<s> endsub", "o<s> call", "G4 P#<_value>", "o<s> call", "G4 P#<_value>"]
    assert body(*lines) == [2, 2]


def test_labels_of_conditions_belong_to_their_subroutine():
    assert body("o1 sub", "o2 if [1]", "G4 P1", "o2 endif", "o1 endsub", "o2 if [1]", "o1 call", "o2 endif") == [1]


FACTORIAL = [
    "o<f> sub",
    "o1 if [#1 le 1]",
    "o<f> return [1]",
    "o1 endif",
    "o<f> call [#1-1]",
    "o<f> endsub [#1*#<_value>]",
]


def test_a_subroutine_may_call_itself():
    assert body(*FACTORIAL, "o<f> call [6]", "G4 P#<_value>") == [720]


def test_the_tenth_call_inside_another_is_refused():
    assert DEEPEST == 9
    assert body(*FACTORIAL, "o<f> call [9]", "G4 P#<_value>") == [362880]
    told = "5: more than 9 calls inside one another, got 'O<F>CALL[#1-1]'; check the condition that ends the recursion"
    assert error(*FACTORIAL, "o<f> call [10]") == told


def test_a_subroutine_may_stand_behind_the_end_of_the_program():
    assert dwells("\n".join(["o<s> call [1]", "o<s> call [2]", "M2", *SUB])) == [100, 200]


def test_a_subroutine_between_its_call_and_the_end_is_refused_as_in_linuxcnc():
    told = (
        "2: a subroutine that was called before its lines, got 'O<S>SUB'; write it before the first call, or behind M2"
    )
    assert error("o<s> call [1]", *SUB) == told


def test_a_subroutine_in_a_branch_that_did_not_run_is_not_there():
    told = (
        "6: a subroutine whose lines were not reached before its call, got O<s>; "
        "write it outside conditions, or behind the call"
    )
    assert error("o1 if [0]", *SUB[:2], SUB[3], "o1 endif", "o<s> call") == told
    assert body("o1 if [1]", *SUB, "o1 endif", "o<s> call [1]") == [100]


def test_a_subroutine_in_a_loop_is_defined_twice():
    lines = ["o1 repeat [2]", *SUB, "o1 endrepeat"]
    assert error(*lines) == "2: a subroutine is defined a second time, got 'O<S>SUB'; write it outside the loop"


def test_the_end_of_the_program_may_stand_in_a_subroutine():
    assert body("o1 sub", "G4 P1", "M2", "o1 endsub", "o1 call", "G4 P2") == [1]


# -- subroutines in files ---------------------------------------------------------------------------------------------


def test_a_file_gives_its_subroutine_and_nothing_else_of_it_runs(tmp_path):
    (tmp_path / "face.ngc").write_text("G4 P5\no<face> sub\nG4 P#1\no<more> call\no<face> endsub [8]\nG4 P6\n"
                                       "o<more> sub\nG4 P7\no<more> endsub\n")  # fmt: skip
    assert body("o<face> call [3]", "G4 P#<_value>", "o<face> call [4]", folders=[tmp_path]) == [3, 7, 8, 4, 7]


def test_words_from_a_file_have_the_line_of_the_main_text_that_called(tmp_path):
    (tmp_path / "a.ngc").write_text("\n\n%\no<a> sub\nG1 X1\nG1 X#1\no<b> call\no<a> endsub\n%\n")
    (tmp_path / "b.ngc").write_text("o<b> sub\nG1 X2\no<b> endsub\n")
    seen = []
    text = "\no<a> call\nG1 X3\n\no<a> call\nM2"
    run(text, lambda words: seen.append(words.line) or 2 in words.m, Parameters(), folders=[tmp_path])
    assert seen == [2, 2, 2, 3, 5, 5, 5, 6]


def test_words_of_the_main_text_have_their_own_line_in_subroutines_too(tmp_path):
    (tmp_path / "a.ngc").write_text("o<a> sub\nG1 X1\no<main> call\nG1 X#1\no<a> endsub\n")
    seen = []
    text = "o<main> sub\nG1 X1\nG1 X#1\no<main> endsub\no<main> call\no<a> call\nM2"
    run(text, lambda words: seen.append(words.line) or 2 in words.m, Parameters(), folders=[tmp_path])
    assert seen == [2, 3, 6, 2, 3, 6, 7]


def test_a_mistake_in_a_file_has_the_files_name_and_line(tmp_path):
    (tmp_path / "a.ngc").write_text("o<a> sub\n\nG1 X1 @\no<a> endsub\n")
    assert error("o<a> call", file="main.ngc", folders=[tmp_path]) == f"{tmp_path}/a.ngc:3: not a word, got '@'"
    (tmp_path / "b.ngc").write_text("o<b> sub\n")
    told = f"{tmp_path}/b.ngc:1: sub without its endsub, got 'O<B>SUB'; write O<b> endsub"
    assert error("o<b> call", file="main.ngc", folders=[tmp_path]) == told
    (tmp_path / "c.ngc").write_text("o<d> sub\no<d> endsub\n")
    told = "the file has no such subroutine, got O<c>; write O<c> sub and O<c> endsub around its lines"
    assert error("o<c> call", folders=[tmp_path]) == f"{tmp_path}/c.ngc:1: {told}"


def test_a_mistake_that_the_machine_finds_gets_its_line_and_file(tmp_path):
    (tmp_path / "a.ngc").write_text("o<a> sub\nG1\no<a> endsub\n")

    def refuse(words):
        raise ProgramError("no")

    with pytest.raises(ProgramError) as caught:
        run("\no<a> call\nM2", refuse, Parameters(), folders=[tmp_path], file="main.ngc")
    assert str(caught.value) == f"{tmp_path}/a.ngc:2: no"
    with pytest.raises(ProgramError) as caught:
        run("\n\nG1\nM2", refuse, Parameters(), file="main.ngc")
    assert str(caught.value) == "main.ngc:3: no"


def test_files_of_subroutines_have_a_budget_together(tmp_path, monkeypatch):
    for name in "ab":
        (tmp_path / f"{name}.ngc").write_text(f"o<{name}> sub\no<{name}> endsub\n")  # 21 characters each
    lines = ["o<a> call", "o<a> call", "o<b> call"]
    monkeypatch.setattr(flow, "LARGEST_FILE", 42)
    assert body(*lines, folders=[tmp_path]) == []
    monkeypatch.setattr(flow, "LARGEST_FILE", 41)
    assert error(*lines, folders=[tmp_path]).startswith("3: files of subroutines have at most")
    monkeypatch.setattr(flow, "MOST_FILES", 1)
    assert error(*lines, folders=[tmp_path]) == "3: more than 1 files of subroutines, got 'b.ngc'"


def test_no_folder_is_searched_unless_it_is_named(tmp_path, monkeypatch):
    (tmp_path / "face.ngc").write_text("o<face> sub\no<face> endsub\n")
    monkeypatch.chdir(tmp_path)
    assert error("o<face> call") == "1: no such subroutine, got O<face>; write it in this file"
    told = "1: no such subroutine, got O<fad>; write it in this file, or as fad.ngc in the program's folder"
    assert error("o<fad> call", folders=[tmp_path]) == told
    assert body("o<face> call", folders=[tmp_path]) == []


def test_the_cure_for_a_subroutine_that_is_not_there_is_the_one_most_like_it():
    assert error("o<face> sub", "o<face> endsub", "o<fase> call") == (
        "3: no such subroutine, got O<fase>; did you mean O<face>?"
    )


def test_a_name_with_a_folder_in_it_is_never_looked_for(tmp_path):
    (tmp_path / "x.ngc").write_text("o<x> sub\no<x> endsub\n")
    (tmp_path / "in").mkdir()
    for name in ("../x", "/etc/passwd", "../../../../../../etc/passwd"):
        told = (
            f"1: a subroutine of this name cannot have a file, got '{name}'; "
            "use letters, digits, _ and - only: a file is looked for in the program's folders"
        )
        assert error(f"o<{name}> call", folders=[tmp_path / "in"]) == error(f"o<{name}> call") == told


def test_what_is_wrong_with_a_file_is_told_at_its_call(tmp_path):
    os.mkfifo(tmp_path / "pipe.ngc")
    told = "part.ngc:2: pipe.ngc must be a regular file, got a pipe"
    assert error("G1", "o<pipe> call", file="part.ngc", folders=[tmp_path]) == told
    (tmp_path / "latin.ngc").write_bytes(b"\n(\xe4)")
    told = f"{tmp_path}/latin.ngc:2: is not UTF-8 text, got byte 0xe4; save it as UTF-8"
    assert error("o<latin> call", file="part.ngc", folders=[tmp_path]) == told


# -- beginnings and ends ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        "%\nG4 P1\n%\n@@ what follows is not looked at",
        "\n \n%\nG4 P1\nM2\n%\n@@",
        " % \r\nG4 P1\r\n%\r\n",
        "G4 P1\nM2",
        "G4 P1 M30\n\n(c)\n%\n",
        "%\nG4 P1\n%\n%\nG4 P5",
        "O0001 (part)\nG4 P1\nM2",
        "G4P1\nM2\n\n\n/G4 P3",
        "G4 P1\no5\nM2\nO6",
    ],
)
def test_a_program_ends_with_m2_m30_or_its_second_percent(text):
    assert dwells(text) == [1]


ENDS = {
    "": "1: the program has no end; write M2 or M30 as its last line",
    "G1 X1\n\n": "1: the program has no end; write M2 or M30 as its last line",
    "%\nG1 X1\n": '2: the program has no end; write "%" or M2 as its last line',
    "%": '1: the program has no end; write "%" or M2 as its last line',
    "G1 X1\n%": '2: "%" ends a program only if its first line is "%"; write M2',
    "G1 X1\n%%": "2: \"%\" stands alone on its line, got '%%'",
    "(c)\n%\nG1 X1\n%": '2: "%" ends a program only if its first line is "%"; write M2',
    "M2\nG1 X2": "2: a block behind the end of the program, got 'G1 X2'; remove it",
    "M2\n\n(c)\no1 sub\nG1\no1 endsub\n%\n#1=2": "8: a block behind the end of the program, got '#1=2'; remove it",
    "o1 sub\no1 endsub\nM2\no1 call": "4: a block behind the end of the program, got 'o1 call'; remove it",
    "M2\nwhatever": "2: a block behind the end of the program, got 'whatever'; remove it",
}


@pytest.mark.parametrize("text", ENDS)
def test_a_wrong_end_is_told_with_its_line(text):
    assert error(text=text) == ENDS[text]


def test_blocks_behind_an_end_that_need_not_run_are_fine():
    assert dwells("o1 if [1]\nM2\no1 endif\nG4 P1\nM2") == []
    assert dwells("o1 if [0]\nM2\no1 endif\nG4 P1\nM2") == [1]


def test_lines_with_a_stroke_run_only_without_block_delete():
    lines = ["G4 P1", "/G4 P2", " / o1 if [0]", "G4 P3", "/o1 endif"]
    assert body(*lines) == [1, 3]
    assert body(*lines, block_delete=False) == [1, 2]


def test_a_program_may_stop_itself():
    told = "2: the program stops itself here, got '(ABORT,tool 5 is missing)'"
    assert error("o1 if [1]", "(abort,tool 5 is missing)", "o1 endif") == told
    assert body("o1 if [0]", "(abort,tool 5 is missing)", "o1 endif") == []


# -- mistakes in the structure ----------------------------------------------------------------------------------------

WRONG = {
    "o1 if [1]": "1: if without its endif, got 'O1IF[1]'; write O1 endif",
    "o1 while [0]": "1: while without its endwhile, got 'O1WHILE[0]'; write O1 endwhile",
    "o1 do": "1: do without its while, got 'O1DO'; write O1 while [...]",
    "o<s> sub": "1: sub without its endsub, got 'O<S>SUB'; write O<s> endsub",
    "o1 endif": "1: endif without its if, got 'O1ENDIF'; write O1 if before it, or remove it",
    "o1 else": "1: else without its if, got 'O1ELSE'; write O1 if before it, or remove it",
    "o1 endwhile": "1: endwhile without its while, got 'O1ENDWHILE'; write O1 while before it, or remove it",
    "o1 if [1]|o2 endif": "2: endif without its if, got 'O2ENDIF'; did you mean O1?",
    "o1 while [1]|o1 endrepeat": "2: endrepeat without its repeat, got 'O1ENDREPEAT'; "
    "write O1 repeat before it, or remove it",
    "o1 if [1]|o2 if [1]|o1 endif|o2 endif": "3: endif before the endif of O2 in line 2, got 'O1ENDIF'; "
    "end what begins last first",
    "o1 if [1]|o1 if [1]|o1 endif|o1 endif": "2: the label O1 is already that of line 1, got 'O1IF[1]'; "
    "give it another label",
    "o1 if [1]|o1 endif|o1 repeat [2]|o1 endrepeat": "3: the label O1 is already that of line 1, got 'O1REPEAT[2]'; "
    "give it another label",
    "o1 if [0]|o1 else|o1 elseif [1]|o1 endif": "3: elseif behind else, got 'O1ELSEIF[1]'; write else last",
    "o1 if [0]|o1 else|o1 else|o1 endif": "3: else behind else, got 'O1ELSE'; write else last",
    "o<s> sub|o<t> sub|o<t> endsub|o<s> endsub": "2: a subroutine inside another, got 'O<T>SUB'; "
    "write endsub for O<s> before it",
    "o<s> sub|o<s> endsub|o<s> sub|o<s> endsub": "3: a second subroutine O<s>, the first is in line 1, got 'O<S>SUB'; "
    "give it another label",
    "o<s> return": "1: return outside a subroutine, got 'O<S>RETURN'; write M2 to end the program",
    "o<s> sub|o<t> return|o<s> endsub": "2: return with the label of another subroutine, got 'O<T>RETURN'; "
    "write O<s> return",
    "o1 break": "1: break is not inside a while or do loop of its label, got 'O1BREAK'; write it inside while or do",
    "o1 repeat [3]|o1 continue|o1 endrepeat": "2: continue is not inside a while or do loop of its label, "
    "got 'O1CONTINUE'; write it inside while or do",
    "o1 while [1]|o2 break|o1 endwhile": "2: break is not inside a while or do loop of its label, got 'O2BREAK'; "
    "did you mean O1?",
    "o#1 if [1]|o1 endif": "1: if with a computed label, got 'O#1IF[1]'; "
    "write a number or a name; only call computes its label",
    "G1|o1 if": "2: if without a condition in brackets, got 'O1IF'; write e.g. if [#1 lt 10]",
    "o1 while [1/0]|o1 endwhile": "1: a division by zero, got '[1/0]'; check the divisor",
    "o1 if [0]|o1 elseif [sqrt[-1]]|o1 endif": "2: the square root of a negative number, got '[SQRT[-1]]'; "
    "check what stands in its brackets",
    "#1=0.5|o[#1] call": "2: the number of an O word is whole, got O0.5; write e.g. O100 or O<name>",
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_in_the_structure_is_said_in_these_words(text):
    assert error(*text.split("|")) == WRONG[text]


# -- every program ends -----------------------------------------------------------------------------------------------

ENDLESS = {
    "o1 while [1]|o1 endwhile": 1,
    "G1|o1 do|o1 while [1]": 2,
    "o1 repeat [10**9]|o1 endrepeat": 1,
    "o1 while [1]|o2 repeat [10**300]|G4 P1|o2 endrepeat|o1 endwhile": 2,
    "#1=0|o1 while [#1 lt 1]|o1 continue|#1=1|o1 endwhile": 2,
    "o1 sub|o2 while [1]|#1=[#1+1]|o2 endwhile|o1 endsub|o1 call": 2,
}


@pytest.mark.parametrize("text", ENDLESS)
def test_a_loop_without_end_is_told_with_its_line(text):
    told = (
        f"{ENDLESS[text]}: possible endless loop, got 5000 lines run beyond the length of the text; "
        "check the condition that ends it"
    )
    assert error(*text.split("|"), steps=5000) == told


def test_calls_that_call_each_other_ten_times_over_end_as_well():
    lines = []
    for k in range(8):
        lines += [f"o{k} sub", *[f"o{k + 1} call"] * 30, f"o{k} endsub"]
    assert "possible endless loop" in error(*lines, "o8 sub", "o8 endsub", "o0 call", steps=10_000)


def test_the_budget_is_for_lines_that_run_again_however_long_the_text_is():
    assert body(*["G4 P1"] * 50, steps=0) == [1] * 50
    # 12 lines run: #1=0, 4 times while, 3 times the two lines behind it, M2; the text has 5
    lines = ["#1=0", "o1 while [#1 lt 3]", "#1=[#1+1]", "o1 endwhile"]
    assert body(*lines, steps=7) == []
    assert "possible endless loop" in error(*lines, steps=6)


@pytest.mark.quick("o1 repeat*")
@pytest.mark.parametrize(
    "text",
    ["o1 while [1]|o1 endwhile", "o1 while [#1 lt 1]|#2=[#2+1]|o1 endwhile", "o1 repeat [10**9]|G4|o1 endrepeat"],
)
def test_a_million_lines_of_a_loop_run_in_seconds_and_in_constant_memory(text):
    tracemalloc.start()
    start = time.process_time()
    with pytest.raises(ProgramError, match="possible endless loop"):
        run("\n".join([*text.split("|"), "M2"]), lambda words: False, Parameters(), steps=100_000)
    took, (_, peak) = time.process_time() - start, tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert took < 5  # a tenth of the default budget, traced: 0.3 s measured
    assert peak < 1e6


@pytest.mark.full
def test_lines_of_straight_text_are_not_kept():
    text = "\n".join([f"G1 X{k}" for k in range(20_000)] + ["M2"])
    tracemalloc.start()
    run(text, lambda words: 2 in words.m, Parameters())
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # the lines themselves are 60 bytes each, and a byte each for their structure; words would be 600 more each
    assert peak < 20_000 * 150


def test_a_hundred_conditions_may_lie_inside_one_another_and_no_more():
    def nested(n):
        return [f"o{k} if [1]" for k in range(n)] + ["G4 P1"] + [f"o{k} endif" for k in reversed(range(n))]

    assert body(*nested(100)) == [1]
    told = "101: more than 100 conditions and loops inside one another, got 'O100IF[1]'; use subroutines"
    assert error(*nested(101)) == told


def test_progress_is_told_every_thousand_lines():
    seen = []
    body(*["G1 X1"] * 2500, tell=lambda done, total: seen.append((done, total)))
    assert seen == [(1000, 2501), (2000, 2501)]
