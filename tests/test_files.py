"""Reading with places, writing that is whole or not at all."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap

import pytest

from gough.errors import ExperimentError, Problem, SheetError, StorageError
from gough.files import free_space, parse_toml, read_text, read_toml, write_atomic
from gough.names import check_name, slug

TEXT = '[platform]\nmass = "150 kg"\n\n[joints]\n"base.axis" = 1\n\n[[controller]]\nkind = "pid"\n'


def test_a_problem_gets_the_file_and_the_line_of_its_key(tmp_path):
    path = tmp_path / "sheet.toml"
    path.write_text(TEXT)
    document = read_toml(path, SheetError)
    assert document.data["platform"]["mass"] == "150 kg"
    assert [document.line(key) for key in ("platform.mass", "controller.0.kind", "nothing")] == [2, 8, None]
    error = document.locate(SheetError("must be above 0 kg", key="mass", value="-1 kg"), "platform")
    assert str(error) == f"{path}:2: platform.mass: must be above 0 kg, got -1 kg"


def test_a_missing_key_is_placed_at_the_table_it_is_missing_from():
    document = parse_toml(TEXT, "f.toml")
    assert (
        str(document.locate(ExperimentError("is missing", key="joints.platform")))
        == "f.toml:4: joints.platform: is missing"
    )
    assert str(document.locate(ExperimentError("is missing", key="drive"))) == "f.toml: drive: is missing"


def test_a_problem_that_has_its_file_keeps_it():
    found = ExperimentError(problems=[Problem("x", file="part.ngc", line=3), Problem("y", key="mass")])
    placed = parse_toml(TEXT, "f.toml").locate(found, "platform")
    assert [(p.file, p.line, p.key) for p in placed.problems] == [("part.ngc", 3, None), ("f.toml", 2, "platform.mass")]


def test_the_error_is_of_the_kind_asked_for(tmp_path):
    with pytest.raises(SheetError, match="no such file"):
        read_toml(tmp_path / "none.toml", SheetError)
    with pytest.raises(ExperimentError, match="no such file"):
        read_toml(tmp_path / "none.toml")


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path):
    path = tmp_path / "f.toml"
    path.write_bytes(b"\xef\xbb\xbfa = 1\r\nb = 2\r\n")
    document = read_toml(path)
    assert document.data == {"a": 1, "b": 2}
    assert document.line("b") == 2


def test_what_is_written_is_what_was_given(tmp_path):
    for content, expected in (
        (b"\x00\xff", b"\x00\xff"),
        ("é\n", "é\n".encode()),
        (lambda p: p.write_bytes(b"f"), b"f"),
    ):
        write_atomic(tmp_path / "out.bin", content)
        assert (tmp_path / "out.bin").read_bytes() == expected
    assert os.listdir(tmp_path) == ["out.bin"]


def test_a_function_that_writes_sees_the_suffix_of_the_file(tmp_path):
    seen = []
    write_atomic(tmp_path / "a.png", lambda p: (seen.append(p.suffix), p.write_bytes(b"")))
    assert seen == [".png"]


def test_an_interrupted_writer_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "log.nc"
    path.write_bytes(b"old")

    def interrupted(temporary):
        temporary.write_bytes(b"half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_atomic(path, interrupted)
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["log.nc"]


def test_a_full_disk_leaves_the_old_file_and_says_how_much_is_free(tmp_path):
    """A file size limit stands for the disk: the write fails in the middle, as on a full one."""
    (tmp_path / "log.nc").write_bytes(b"old")
    script = """
        import resource, sys
        from gough.errors import StorageError
        from gough.files import write_atomic
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        try:
            write_atomic(sys.argv[1], b"x" * 5000)
        except StorageError as error:
            print(error)
    """
    out = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script), str(tmp_path / "log.nc")],
        capture_output=True,
        text=True,
        timeout=20,
    )
    assert out.stdout.startswith(f"{tmp_path}/log.nc: cannot be written, got File too large; "), out.stderr
    assert "B free in " in out.stdout
    assert (tmp_path / "log.nc").read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["log.nc"]


def test_a_folder_that_is_not_there_or_is_a_file_is_a_storage_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="No such file or directory"):
        write_atomic(tmp_path / "none" / "a", b"")
    with pytest.raises(StorageError, match="Not a directory"):
        write_atomic(tmp_path / "file" / "a", b"")


def test_free_space_is_that_of_the_nearest_folder_that_exists(tmp_path):
    assert free_space(tmp_path / "a" / "b").endswith(f" free in {tmp_path}")


def test_text_is_read_up_to_the_cap_and_not_beyond(tmp_path):
    path = tmp_path / "part.ngc"
    path.write_text("x" * 2048)
    assert read_text(path, 2048) == "x" * 2048
    with pytest.raises(ExperimentError, match=r"has at most 1 kB, got 2 kB"):
        read_text(path, 1024)


@pytest.mark.parametrize("name", ["a", "okuma-pm600", "01_circle.v2", "A" * 64])
def test_a_safe_name_is_its_own_slug(name):
    assert check_name(name) == slug(name) == name


@pytest.mark.parametrize(
    "name", ["", ".gough", "-o", "a b", "../x", "a/b", "é", "ехр", "a\u202eb", "a\n", "A" * 65, "<script>"]
)
def test_an_unsafe_name_is_refused_and_its_slug_is_safe(name):
    with pytest.raises(ExperimentError, match="a name has 1 to 64 ASCII letters"):
        check_name(name)
    assert check_name(slug(name)) == slug(name)


def test_two_names_never_share_a_slug_because_they_lost_their_letters():
    assert slug("ä/b") != slug("ö/b") != slug("-b")
