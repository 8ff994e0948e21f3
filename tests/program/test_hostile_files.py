"""Programs and subroutine files that are no text, no file, or far too much: a clear error, soon, in little memory."""

import os
import time
import tracemalloc

import pytest

from gough.errors import ProgramError
from gough.program.ngc.read import read_program


def refusal(text, **more):
    """The message, with time and memory bounded."""
    tracemalloc.start()
    began = time.process_time()
    try:
        with pytest.raises(ProgramError) as caught:
            read_program(text, "part.ngc", **more)
        seconds, (_, most) = time.process_time() - began, tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert seconds < 5, "tracing memory makes it some five times slower than the second it may take"
    assert most < 20e6 + 3 * len(text), "the text and little else"
    return str(caught.value)


def test_a_line_of_a_megabyte_is_refused_by_its_length():
    assert "at most 252 characters" in refusal("G0 X1 (" + "a" * 1_000_000 + ")\nM2\n")


def test_a_hundred_thousand_brackets_are_refused():
    deep = "[" * 100_000
    assert refusal(f"G0 X{deep}1{deep.replace('[', ']')}\nM2\n").startswith("part.ngc:1: ")


def test_a_nul_byte_is_told_by_its_line():
    assert refusal("G21\nG0 X\0 1\nM2\n").startswith("part.ngc:2: ")


@pytest.mark.full
def test_a_million_moves_more_than_there_may_be_end_in_constant_memory():
    text = "G91\no1 while [1]\nG0 X1\nG0 X-1\no1 endwhile\nM2\n"
    assert "endless loop" in refusal(text, steps=20_000)


@pytest.mark.parametrize("text", ["", "\n" * 10_000, "%\n", "%\n%\n", "\ufeff", "\r\n", " ", "(a)\n; b\n"])
def test_a_program_of_nothing_says_that_it_is_nothing(text):
    assert refusal(text).startswith("part.ngc")


# -- subroutines in files ---------------------------------------------------------------------------------------------

GOOD = "o<side> sub\nG91 G1 X[#1] F100\no<side> endsub\nM2\n"


def call(name, folder, **more):
    return read_program(f"G21\no<{name}> call [5]\nM2\n", "part.ngc", folders=[folder], **more)


def test_a_subroutine_is_found_in_its_folder(tmp_path):
    (tmp_path / "side.ngc").write_text(GOOD)
    blocks = call("side", tmp_path)
    assert [block.segment.end[0] for block in blocks] == [pytest.approx(5e-3)]


def test_a_subroutine_is_not_found_without_a_folder(tmp_path):
    (tmp_path / "side.ngc").write_text(GOOD)
    assert refusal("G21\no<side> call [5]\nM2\n").startswith("part.ngc:2: ")


@pytest.mark.parametrize(
    "name", ["../outside", "/etc/passwd", "..", "inner/side", "../../../../etc/passwd", "side.ngc", "."]
)
def test_a_call_never_leaves_its_folders(name, tmp_path):
    folder = tmp_path / "subs"
    (folder / "inner").mkdir(parents=True)
    for place in (tmp_path / "outside.ngc", folder / "inner" / "side.ngc"):
        place.write_text(GOOD.replace("side", name))
    with pytest.raises(ProgramError, match=r"part\.ngc:2: "):
        call(name, folder)


def test_a_link_out_of_the_folder_is_not_followed(tmp_path):
    folder = tmp_path / "subs"
    folder.mkdir()
    (tmp_path / "outside.ngc").write_text(GOOD)
    (folder / "side.ngc").symlink_to(tmp_path / "outside.ngc")
    with pytest.raises(ProgramError, match=r"part\.ngc:2: "):
        call("side", folder)


def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "side.ngc")
    with pytest.raises(ProgramError, match=r"part\.ngc:2: "):
        call("side", tmp_path)


def test_a_device_is_not_read(tmp_path):
    (tmp_path / "side.ngc").symlink_to("/dev/zero")
    with pytest.raises(ProgramError, match=r"part\.ngc:2: "):
        call("side", tmp_path)


def test_a_folder_is_no_subroutine(tmp_path):
    (tmp_path / "side.ngc").mkdir()
    with pytest.raises(ProgramError, match=r"part\.ngc:2: "):
        call("side", tmp_path)


def test_a_huge_subroutine_file_is_not_read(tmp_path):
    with open(tmp_path / "side.ngc", "wb") as file:
        file.truncate(10**9)  # a hole: it takes no room
    began = time.process_time()
    with pytest.raises(ProgramError, match=r"part\.ngc:2: "):
        call("side", tmp_path)
    assert time.process_time() - began < 0.5


@pytest.mark.parametrize(
    "wrong", [b"o<side> sub\nG0 X\xff1\no<side> endsub\nM2\n", b"\x00" * 100, b"\x7fELF" + bytes(range(256))]
)
def test_a_subroutine_file_that_is_no_text_is_refused(wrong, tmp_path):
    (tmp_path / "side.ngc").write_bytes(wrong)
    with pytest.raises(ProgramError):
        call("side", tmp_path)


def test_an_error_in_a_subroutine_file_names_that_file_and_its_line(tmp_path):
    (tmp_path / "side.ngc").write_text(GOOD.replace("F100", "F100 G77"))
    with pytest.raises(ProgramError) as caught:
        call("side", tmp_path)
    assert "side.ngc:2: " in str(caught.value)


def test_files_that_call_each_other_end_by_the_depth_of_calls(tmp_path):
    (tmp_path / "a.ngc").write_text("o<a> sub\no<b> call\no<a> endsub\nM2\n")
    (tmp_path / "b.ngc").write_text("o<b> sub\no<a> call\no<b> endsub\nM2\n")
    with pytest.raises(ProgramError, match="more than 9 calls inside one another"):
        call("a", tmp_path)
