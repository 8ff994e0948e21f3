"""The page holds all it shows, loads nothing, runs nothing of a stranger, and is quick."""

import base64
import hashlib
import json
import re
import time
from html.parser import HTMLParser

import numpy as np
import pytest

from conftest import make_log
from gough.report.page import page, report

HOSTILE = "\"><script>alert(1)</script><img src=x onerror=alert(2)>'</style></pre>{{js}}&amp;"


class Page(HTMLParser):
    """Tags with attributes, the text of each script, and the text people see."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.scripts, self.text, self.inside = [], [], "", None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.inside = tag if tag in ("script", "style") else None
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag):
        self.inside = None

    def handle_data(self, data):
        if self.inside == "script":
            self.scripts[-1] += data
        elif self.inside is None:
            self.text += data

    @property
    def policy(self):
        return next(attrs["content"] for _, attrs in self.tags if attrs.get("http-equiv") == "Content-Security-Policy")

    @property
    def charts(self):
        return json.loads(self.scripts[0], parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))


def unpacked(entry):
    values = np.frombuffer(base64.b64decode(entry["bdata"]), f"<{entry['dtype']}")
    return values.reshape([int(n) for n in entry["shape"].split(",")]) if "shape" in entry else values


@pytest.fixture(scope="module")
def text(logs):
    return page(logs, {"experiment.toml": '[machine]\nuse = "nist-octahedral"\n'})


@pytest.fixture(scope="module")
def parsed(text):
    return Page(text)


def test_nothing_is_loaded_from_anywhere(text, parsed):
    for tag, attrs in parsed.tags:
        assert tag not in ("link", "iframe", "img", "object", "embed", "base", "form"), tag
        assert not {"src", "srcset", "data", "action", "background", "poster"} & set(attrs), (tag, attrs)
        assert attrs.get("href", "#").startswith("#")
        assert not any(name.startswith("on") for name in attrs)
    ours = text.replace(parsed.scripts[1], "")  # plotly.js names its makers in texts; the policy keeps it from asking
    assert not re.search(r"(?i)https?://|url\(|@import|//cdn", ours)
    assert parsed.policy.startswith("default-src 'none';")
    assert not re.search("http|connect-src|unsafe-eval|script-src[^;]*unsafe", parsed.policy)


def test_only_the_scripts_named_by_their_hash_may_run(parsed):
    allowed = re.search(r"script-src ([^;]*)", parsed.policy)[1].split()
    digests = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in parsed.scripts[1:]]
    hashes = [f"'sha256-{digest}'" for digest in digests]
    assert allowed == hashes and len(hashes) == 2
    assert "\r" not in "".join(parsed.scripts)


def test_a_chart_is_never_offered_to_a_server(parsed):
    assert "showSendToCloud: false" in parsed.scripts[2]
    assert 'plotlyServerURL: ""' in parsed.scripts[2]
    assert "modeBarButtons" in parsed.scripts[2]


def test_hostile_names_are_only_text():
    log = make_log(HOSTILE, seconds=2.0, rate=100, failed=HOSTILE, program_name=HOSTILE)
    info = log.info | {
        "machine_name": HOSTILE,
        "version": HOSTILE,
        "versions": {HOSTILE: HOSTILE},
        "machine": {HOSTILE: HOSTILE},
        "program": {"name": HOSTILE, "text": HOSTILE},
        "drawing": [{"name": HOSTILE, "points": [[0, 0, 0], [1, 1, 1]]}],
    }
    log.dataset.attrs["gough"] = json.dumps(info)
    text = page(log, {HOSTILE: HOSTILE})
    found = Page(text)
    assert len(found.scripts) == 3
    assert not any(tag == "img" or any(name.startswith("on") for name in attrs) for tag, attrs in found.tags)
    assert found.text.count("<script>alert(1)</script>") >= 8  # seen as text
    names = [trace.get("name", "") for chart in found.charts.values() for trace in chart["data"]]
    assert names and not any("<" in name for name in names)


def test_the_page_tells_everything_in_reading_order(parsed):
    ids = [attrs["id"] for tag, attrs in parsed.tags if tag == "section"]
    assert ids == ["numbers", "path", "circles", "contour", "forces", "machine", "inputs"]
    for words in (
        "3.3 times as closely",
        "contour error, max",
        "NC program circle-diamond.ngc",
        "Machine sheet",
        "casadi",
        'use = "nist-octahedral"',
        "abababab",
        "seed = 1",
        "G21 G90 G17",
    ):
        assert words in parsed.text, words


def test_inputs_that_are_the_same_stand_once(parsed):
    heads = re.findall(r"(Machine sheet|Controller|Run)", parsed.text)
    assert heads.count("Machine sheet") == 1
    assert parsed.text.count("(circle, diamond, square)") == 12  # its lines, once
    assert parsed.text.count("substeps = 4") == 2  # the seeds differ


def test_a_program_among_the_files_stands_once_and_with_line_numbers(logs):
    found = Page(page(logs, {"part.ngc": logs[0].info["program"]["text"]}))
    assert found.text.count("(circle, diamond, square)") == 12
    assert {"class": "numbered"} in [attrs for tag, attrs in found.tags if tag == "pre"]


def test_what_the_controller_was_not_told_is_set_beside_what_it_believed(short):
    from gough.log import Log

    machine = {"platform": {"mass": "150.0 kg"}, "drive": {"lead": {"unit": "m", "value": 0.025}}}
    true = {"platform": {"mass": "170.0 kg"}, "drive": {"lead": {"unit": "m", "value": 0.025}}}
    info = short.info | {"machine": machine, "plant": {"machine": true}}
    text = page(Log(short.dataset.assign_attrs(gough=json.dumps(info))))
    assert "<tr><td>platform.mass</td><td>150.0 kg</td><td>170.0 kg</td></tr>" in text
    assert "<td>drive.lead</td>" not in text


def test_every_chart_has_its_place_and_every_place_its_chart(parsed):
    places = [attrs["id"] for _, attrs in parsed.tags if attrs.get("class") == "chart"]
    assert sorted(places) == sorted(parsed.charts)
    assert {"contour", "machine", "circle-0", "circle-1", "path-0", "path-1", "forces-0", "forces-1"} == set(places)


def test_charts_keep_the_largest_error_and_no_trace_is_long(logs, parsed):
    for i, log in enumerate(logs):
        # single precision: 2^-24 relative
        shown = unpacked(parsed.charts["contour"]["data"][i]["y"]).max() * 1e-6
        assert shown == pytest.approx(log["contour_error"].max(), rel=1e-7)
        shown = unpacked(parsed.charts[f"path-{i}"]["data"][1]["marker"]["color"]).max()
        assert shown * 1e-6 == pytest.approx(log["contour_error"].max(), rel=1e-7)
    for chart in parsed.charts.values():
        for trace in chart["data"]:
            assert len(unpacked(trace["x"])) <= 4000


def test_hovering_over_the_path_tells_the_line_error_and_time_of_one_row(logs, parsed):
    trace = parsed.charts["path-0"]["data"][1]
    lines, times = unpacked(trace["customdata"]).T
    rows = np.round(times * 1000).astype(int)
    np.testing.assert_array_equal(lines, logs[0]["line"][rows])
    np.testing.assert_allclose(unpacked(trace["marker"]["color"]), 1e6 * logs[0]["contour_error"][rows], rtol=1e-6)


def test_only_counted_rows_are_coloured_and_the_colours_end_at_their_worst(logs, parsed):
    for i, log in enumerate(logs):
        rows = np.round(unpacked(parsed.charts[f"path-{i}"]["data"][1]["customdata"])[:, 1] * 1000).astype(int)
        assert len(rows) > 1000 and np.all(log["counted"][rows] == 1)
    top = max(log["contour_error"][log["counted"] == 1].max() for log in logs)
    assert parsed.charts["path-0"]["data"][1]["marker"]["cmax"] * 1e-6 == pytest.approx(top, rel=1e-12)


def test_both_paths_share_one_scale_of_colours(parsed):
    ends = {parsed.charts[f"path-{i}"]["data"][1]["marker"]["cmax"] for i in range(2)}
    assert len(ends) == 1


def test_reversals_are_marked_in_the_chart(logs, parsed):
    marks = [trace for trace in parsed.charts["contour"]["data"] if trace["name"].startswith("reversals")]
    assert len(marks) == 2
    assert len(unpacked(marks[0]["x"])) == len(logs[0].info["reversals"])
    struts = unpacked(marks[0]["customdata"])[:, 0]
    assert struts.min() == 1 and struts.max() == 6


def test_all_controllers_are_laid_over_one_another_on_each_circle(parsed):
    names = [trace["name"] for trace in parsed.charts["circle-1"]["data"] if trace["name"]]
    assert names == ["programmed circle", "PID", "computed torque"]


def test_a_failed_log_is_marked_before_anything_else(logs):
    found = Page(page([logs[0], make_log("b", seconds=1.0, rate=100, failed="strut 3 is too long")]))
    assert 0 < found.text.index("FAILED at 1.00 s b: strut 3 is too long") < found.text.index("In numbers")
    assert "b, FAILED at 1.00 s" in found.text[found.text.index("In numbers") :]  # the head of its column
    assert "FAILED" not in Page(page([logs[0]])).text


def warned(log, found):
    from gough.log import Log

    return Log(log.dataset.assign_attrs(gough=json.dumps(log.info | {"warnings": found})))


def test_what_the_simulation_warned_of_stands_above_the_verdict_by_controller(short, logs):
    found = Page(page([warned(short, ["the loop is <b>unstable</b>", "strut 2 is near its end"]), logs[1]]))
    above = found.text[: found.text.index("follows the path")]
    assert "Warned PID" in above and "Warned computed torque" not in above
    assert "the loop is <b>unstable</b>" in above and "strut 2 is near its end" in above
    assert [attrs.get("role") for tag, attrs in found.tags if attrs.get("class") == "warned"] == ["note"]


@pytest.mark.parametrize("found", [None, [], "text", {"a": 1}, [None, ""]])
def test_a_log_without_warnings_has_no_box(short, found):
    assert not any(attrs.get("class") == "warned" for _, attrs in Page(page(warned(short, found))).tags)


def test_of_very_many_warnings_some_are_shown_and_the_rest_counted(short):
    text = Page(page(warned(short, [f"warning {i}." for i in range(1000)]))).text
    assert "warning 11." in text and "warning 12." not in text and "988 more" in text


def test_under_the_table_stand_time_and_nc_line_of_the_largest_contour_error_of_each(logs, parsed):
    below = parsed.text[parsed.text.index("In numbers") : parsed.text.index("Seen in the")]
    error = [log.metrics["contour_error"] for log in logs]
    told = [f"at {e['at']:.3f} s, NC line {e['line']:.0f}" for e in error]
    assert f"Largest contour error: PID {told[0]}; computed torque {told[1]}." in below


def test_where_no_log_knows_its_nc_lines_no_place_is_told():
    log = make_log("pid", seconds=3.0, rate=100)
    metrics = log.info["metrics"]
    without = metrics | {"contour_error": metrics["contour_error"] | {"line": 0}}
    log.dataset.attrs["gough"] = json.dumps(log.info | {"metrics": without})
    assert "Largest contour error" not in Page(page([log])).text


def test_the_terms_of_the_table_are_said_under_it(parsed):
    below = parsed.text[parsed.text.index("In numbers") : parsed.text.index("Seen in the")]
    for term in ("Contour error:", "within 5 mm + 0.1 s of feed", "Lag:", "Velocity reversal:", "Glitch:"):
        assert term in below, term


def test_forces_of_all_controllers_share_one_scale_that_shows_them_all(logs, parsed):
    layouts = [parsed.charts[f"forces-{i}"]["layout"]["yaxis"] for i in range(2)]
    assert layouts[0]["range"] == layouts[1]["range"] and layouts[0]["title"] == layouts[1]["title"]
    low, high = layouts[0]["range"]
    for i in range(2):
        for k, trace in enumerate(parsed.charts[f"forces-{i}"]["data"]):
            y = unpacked(trace["y"])
            assert low < y.min() and y.max() < high
            assert trace["name"] == f"strut {k + 1}"


def test_the_tool_is_the_thickest_part_of_the_machine(parsed):
    width = {trace["name"]: trace["line"]["width"] for trace in parsed.charts["machine"]["data"]}
    assert width.pop("tool") > 2 * max(width.values())
    (tool,) = (trace for trace in parsed.charts["machine"]["data"] if trace["name"] == "tool")
    assert tool["marker"]["size"] == [0, 7], "a tool without length is a dot"


@pytest.mark.quick("0")
@pytest.mark.parametrize("rows", [0, 1])
def test_a_run_that_failed_at_once_still_has_its_page(rows, tmp_path):
    target = report(make_log(seconds=rows / 1000, failed="no path"), tmp_path / "new")
    assert f"FAILED at {'0.001' if rows else '0.00'} s PID: no path" in Page(target.read_text("utf-8")).text


def test_a_log_without_anything_known_still_has_its_page():
    from gough.log import Log

    log = Log.build(np.arange(3.0), {"contour_error": np.full(3, np.nan)}, task=(), joints=0, info={})
    assert "The logs hold no contour error of a feed move." in Page(page(log)).text


def test_the_same_logs_give_the_same_page(logs, text):
    assert page(logs, {"experiment.toml": '[machine]\nuse = "nist-octahedral"\n'}) == text


def test_report_writes_page_and_pictures_and_leaves_nothing_else(short, tmp_path):
    target = report([short], tmp_path, {"experiment.toml": "x = 1"})
    assert target == tmp_path / "report.html"
    names = {p.name for p in tmp_path.iterdir()}
    assert names == {
        "report.html",
        "contour_error.png",
        "circle_1.png",
        "path_pid.png",
        "forces_pid.png",
        "velocities_pid.png",
        "tracking_pid.png",
    }


def test_the_page_of_two_minutes_is_smaller_than_8_megabytes(text):
    assert len(text.encode()) < 8e6


@pytest.mark.slow
def test_the_report_of_two_logs_of_100_000_samples_takes_less_than_8_seconds(tmp_path):
    logs = [make_log("pid", seconds=100.0), make_log("computed_torque", 1e-6, seconds=100.0)]
    start = time.process_time()
    report(logs, tmp_path)
    assert time.process_time() - start < 8
