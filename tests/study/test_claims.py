"""A verdict follows from band and evidence, at the edges too; the rows have one shape."""

from __future__ import annotations

import json
import math

import pytest

from gough.study.claims import BY_DESIGN, MET, NOT_MET, Claim, Evidence, told, told_band
from gough.study.text import notes, summary

UM = 1e-6


def claim(measured, band=(8 * UM, 12 * UM), **more):
    return Claim("glitch", measured, "m", band, shown="um", **more)


@pytest.mark.parametrize(
    ("measured", "verdict"),
    [
        (8 * UM, MET), (12 * UM, MET), (10 * UM, MET),
        (math.nextafter(8 * UM, 0), NOT_MET), (math.nextafter(12 * UM, 1), NOT_MET),
        (math.nan, NOT_MET), (math.inf, NOT_MET), (None, NOT_MET),
    ],
)  # fmt: skip
def test_a_band_holds_its_ends_and_nothing_beyond_them(measured, verdict):
    assert claim(measured).verdict == verdict


@pytest.mark.parametrize(
    ("measured", "band", "verdict"),
    [
        (0.0, (None, 0.0), MET), (5e-324, (None, 0.0), NOT_MET), (-1e9, (None, 0.0), MET),
        (1e9, (3.0, None), MET), (-math.inf, (None, 0.0), NOT_MET), (math.inf, (3.0, None), NOT_MET),
    ],
)  # fmt: skip
def test_a_band_without_an_end_still_refuses_what_is_not_finite(measured, band, verdict):
    assert claim(measured, band).verdict == verdict


def evidence(measured=20 * UM):
    return Evidence("with half the torque", measured, "m", (18 * UM, None), "um")


def test_different_by_design_needs_evidence_that_holds():
    assert claim(144 * UM, reason="torque", evidence=[evidence()]).verdict == BY_DESIGN
    assert claim(144 * UM, reason="torque", evidence=[evidence(), evidence(17 * UM)]).verdict == NOT_MET
    assert claim(144 * UM, reason="torque", evidence=[evidence(math.nan)]).verdict == NOT_MET
    assert claim(math.nan, reason="torque", evidence=[evidence()]).verdict == NOT_MET
    assert claim(10 * UM, reason="torque", evidence=[evidence(17 * UM)]).verdict == MET


def test_evidence_that_fails_is_what_the_note_tells():
    failing = claim(144 * UM, reason="torque", evidence=[evidence(), evidence(17 * UM)])
    assert failing.remark == "the evidence does not hold (with half the torque: 17 um (at least 18 um))"
    holding = claim(144 * UM, reason="torque", evidence=[evidence()], note="no limit")
    assert holding.remark == "torque (with half the torque: 20 um (at least 18 um)); no limit"


@pytest.mark.parametrize("more", [{"reason": "because"}, {"evidence": [evidence()]}])
def test_a_reason_without_evidence_is_refused_and_so_is_the_other_way_round(more):
    with pytest.raises(ValueError, match="a reason needs evidence"):
        claim(1.0, **more)


@pytest.mark.parametrize("band", [(None, None), (2.0, 1.0), (math.nan, 1.0)])
def test_what_is_no_band_is_refused(band):
    with pytest.raises(ValueError, match="is no band"):
        claim(1.0, band)


def test_a_row_is_json_with_the_keys_of_the_contract_and_si_values():
    row = claim(9e-6, (8e-6, 1.2e-5), published=1e-5, calibrated="friction was chosen", note="band: 20 %").row(
        "garagic2004"
    )
    assert json.loads(json.dumps(row, allow_nan=False)) == {
        "paper": "garagic2004", "claim": "glitch", "published": 1e-5, "measured": 9e-6, "unit": "m",
        "band": [8e-6, 1.2e-5], "verdict": "met", "note": "calibrated: friction was chosen; band: 20 %",
    }  # fmt: skip
    lost = claim(math.nan, (3.0, None)).row("garagic2004")
    assert lost["measured"] is None and lost["published"] is None and lost["band"] == [3.0, None]


def test_numbers_and_bands_for_people():
    assert told(350e-6, "m", "um") == "350 um"
    assert told(4472.6, "N m") == "4473 N m"
    assert told(12, "1") == "12"
    assert told(0.05, "1", "%") == "5 %"
    assert told(None, "m") == "-"
    assert told(math.nan, "m", "um") == "nan"
    assert told_band((8e-6, 12e-6), "m", "um") == "8 to 12 um"
    assert told_band((None, 20e-6), "m", "um") == "at most 20 um"
    assert told_band((3e-6, None), "m", "um") == "at least 3 um"
    assert told_band((12, 12), "1") == "12"


def test_rows_with_one_note_share_its_line_and_the_summary_counts():
    rows = [
        claim(9 * UM, note="a"), claim(9 * UM), claim(9 * UM, note="a"), claim(9 * UM, calibrated="poles"),
        claim(1.0, reason="torque", evidence=[evidence()]), claim(1.0),
    ]  # fmt: skip
    assert notes(rows)[:2] == ["1, 3: a", "4: calibrated: poles"]
    assert summary(rows) == "6 claims: 4 met (1 of them calibrated), 1 different by design, 1 not met"
