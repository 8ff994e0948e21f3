"""What `make check` leaves out of the cases of a test, and that it never leaves out all of them unsaid."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

import marks


class Item:
    """As much of a test of pytest's as is asked."""

    def __init__(self, name, case=None, quick=None):
        self.nodeid = name if case is None else f"{name}[{case}]"
        if case is not None:
            self.callspec = SimpleNamespace(id=case)
        self.quick, self.added = quick and getattr(pytest.mark.quick(*quick), "mark", None), []

    def get_closest_marker(self, name):
        return self.quick if name == "quick" else None

    def add_marker(self, mark):
        self.added.append(mark.name)


@pytest.mark.parametrize(
    "patterns, full",
    [(["b"], ["a", "b-c"]), (["b*"], ["a"]), (["a", "b"], ["b-c"]), (["*"], [])],
)
def test_cases_that_no_pattern_names_are_full(patterns, full):
    items = [Item("f.py::test_x", case, patterns) for case in ("a", "b", "b-c")]
    assert marks.part(items) == set()
    assert [item.callspec.id for item in items if item.added == ["full"]] == full


def test_a_test_without_a_quick_case_is_told_and_stays_quick():
    items = [Item("f.py::test_x", case, ["z"]) for case in "ab"] + [Item("f.py::test_y", case, ["z"]) for case in "yz"]
    items += [Item("f.py::test_w", "a"), Item("f.py::test_v", quick=["z"])]
    assert marks.part(items) == {"f.py::test_x"}
    assert [item.nodeid for item in items if item.added] == ["f.py::test_y[y]"]
