"""Files of subroutines: from the named folders only, and only plain files."""

import os
import time

import pytest

from gough.errors import ProgramError
from gough.program.ngc.search import find_subroutine

SUB = "O<face> sub\nO<face> endsub\n"


def error(label, folders):
    with pytest.raises(ProgramError) as caught:
        find_subroutine(label, folders)
    return caught.value.problems[0]


def test_the_first_folder_that_has_the_file_gives_it(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    one.mkdir()
    two.mkdir()
    (two / "face.ngc").write_text(SUB)
    assert find_subroutine("face", [one, two]) == (two / "face.ngc", SUB)
    (one / "face.ngc").write_text("(other)")
    assert find_subroutine("face", [one, two]) == (one / "face.ngc", "(other)")


def test_a_file_that_is_nowhere_is_none(tmp_path):
    assert find_subroutine("face", [tmp_path, tmp_path / "not there"]) is None
    assert find_subroutine("face", []) is None


@pytest.mark.parametrize(
    "label",
    [
        "../face",
        "../../etc/passwd",
        "/etc/passwd",
        "a/b",
        "..",
        ".hidden",
        "a\\b",
        "~root",
        "c:face",
        "a\0b",
        "",
        "$home",
        "face*",
        "a" * 101,
    ],
)
def test_a_name_that_could_lead_elsewhere_is_refused(label, tmp_path):
    (tmp_path / "inside").mkdir()
    (tmp_path / "face.ngc").write_text(SUB)
    found = error(label, [tmp_path / "inside"])
    assert found.rule == "a subroutine of this name cannot have a file"
    assert found.cure == "use letters, digits, _ and - only: a file is looked for in the program's folders"


def test_a_link_out_of_the_folder_is_refused_and_one_inside_is_followed(tmp_path):
    inside = tmp_path / "inside"
    inside.mkdir()
    (tmp_path / "secret.ngc").write_text(SUB)
    (inside / "face.ngc").symlink_to(tmp_path / "secret.ngc")
    assert error("face", [inside]).rule == "a subroutine's file must lie in its folder"
    (inside / "real.ngc").write_text(SUB)
    (inside / "alias.ngc").symlink_to("real.ngc")
    assert find_subroutine("alias", [inside]) == (inside / "alias.ngc", SUB)


def test_a_link_to_itself_and_a_link_to_nowhere_are_no_files(tmp_path):
    (tmp_path / "loop.ngc").symlink_to("loop.ngc")
    (tmp_path / "gone.ngc").symlink_to("nothing.ngc")
    assert find_subroutine("loop", [tmp_path]) is None
    assert find_subroutine("gone", [tmp_path]) is None


def test_pipes_folders_and_devices_are_not_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe.ngc")
    (tmp_path / "folder.ngc").mkdir()
    start = time.perf_counter()
    for label, kind in (("pipe", "a pipe"), ("folder", "a folder")):
        found = error(label, [tmp_path])
        assert (found.rule, found.value) == ("must be a regular file", kind)
    assert time.perf_counter() - start < 1  # a pipe would wait for ever


@pytest.mark.full
def test_a_file_beyond_64_mb_is_refused_before_it_is_read(tmp_path):
    with open(tmp_path / "large.ngc", "wb") as file:
        file.truncate(64 * 1024 * 1024 + 1)
    assert error("large", [tmp_path]).rule == "a file of this kind has at most 65536 kB"


def test_a_file_that_is_not_utf_8_is_told_with_its_line(tmp_path):
    (tmp_path / "latin.ngc").write_bytes(b"(a)\n(\xe4)\n")
    found = error("latin", [tmp_path])
    assert (found.rule, found.line) == ("is not UTF-8 text", 2)
