"""What `make check` and `make test` leave out of the cases of a test, and that neither does so unsaid."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

import marks


class Item:
    """As much of a test of pytest's as is asked."""

    def __init__(self, name, case=None, named=None, kind="quick"):
        self.nodeid = name if case is None else f"{name}[{case}]"
        if case is not None:
            self.callspec = SimpleNamespace(id=case)
        self.marks, self.added = {kind: getattr(pytest.mark, kind)(*named).mark} if named is not None else {}, []

    def get_closest_marker(self, name):
        return self.marks.get(name)

    def add_marker(self, mark):
        self.added.append(mark.name)


@pytest.mark.parametrize(
    "patterns, others",
    [(["b"], ["a", "b-c"]), (["b*"], ["a"]), (["a", "b"], ["b-c"]), (["*"], [])],
)
@pytest.mark.parametrize("kind, other", [("quick", "full"), ("full", "slow")])
def test_cases_that_no_pattern_names_wait_for_the_next_longer_run(kind, other, patterns, others):
    items = [Item("f.py::test_x", case, patterns, kind) for case in ("a", "b", "b-c")]
    assert marks.part(items) == set()
    assert [item.callspec.id for item in items if item.added == [other]] == others


def test_full_without_names_is_all_cases():
    items = [Item("f.py::test_x", case, [], "full") for case in "ab"]
    assert marks.part(items) == set() and not any(item.added for item in items)


def test_a_test_without_a_quick_case_is_told_and_stays_quick():
    items = [Item("f.py::test_x", case, ["z"]) for case in "ab"] + [Item("f.py::test_y", case, ["z"]) for case in "yz"]
    items += [Item("f.py::test_w", "a"), Item("f.py::test_v", named=["z"])]
    assert marks.part(items) == {"f.py::test_x"}
    assert [item.nodeid for item in items if item.added] == ["f.py::test_y[y]"]
