"""Which cases of a test run when: `@pytest.mark.quick("a-*", "b")` names those of `make check`, the others are full;
`@pytest.mark.full("a-*", "b")` names those of `make test`, the others are slow."""

from __future__ import annotations

import fnmatch

import pytest

OTHERS = {"quick": "full", "full": "slow"}  # what a case is that the mark does not name


def part(items) -> set[str]:
    """Mark what is not named; the ids of tests of which a mark names no case: they stay as they are, and are told."""
    cases = {}
    for item in items:
        for kind in OTHERS:
            mark, case = item.get_closest_marker(kind), getattr(item, "callspec", None)
            if mark is not None and mark.args and case is not None:
                chosen = any(fnmatch.fnmatchcase(case.id, pattern) for pattern in mark.args)
                cases.setdefault((name_of(item), kind), []).append((item, chosen))
    none = {key for key, found in cases.items() if not any(chosen for _, chosen in found)}
    for key in cases.keys() - none:
        for item, chosen in cases[key]:
            if not chosen:
                item.add_marker(getattr(pytest.mark, OTHERS[key[1]]))
    return {name for name, _ in none}


def name_of(item) -> str:
    """The id of a test without its case."""
    return item.nodeid.partition("[")[0]
