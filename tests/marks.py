"""Which cases of a test are quick: `@pytest.mark.quick("a-*", "b")` names them, and the others are full."""

from __future__ import annotations

import fnmatch

import pytest


def part(items) -> set[str]:
    """Mark as full what is not named quick; the ids of tests whose mark names none of their cases: they stay quick."""
    cases = {}
    for item in items:
        mark, case = item.get_closest_marker("quick"), getattr(item, "callspec", None)
        if mark is not None and case is not None:
            chosen = any(fnmatch.fnmatchcase(case.id, pattern) for pattern in mark.args)
            cases.setdefault(name_of(item), []).append((item, chosen))
    none = {name for name, found in cases.items() if not any(chosen for _, chosen in found)}
    for name in cases.keys() - none:
        for item, chosen in cases[name]:
            if not chosen:
                item.add_marker(pytest.mark.full)
    return none


def name_of(item) -> str:
    """The id of a test without its case."""
    return item.nodeid.partition("[")[0]
