"""Standard programs and the [program] table."""

import numpy as np
import pytest

from gough.errors import ExperimentError, InputError, ProgramError
from gough.program import Circle, CircleDiamondSquare, Ellipse, Line, Polyline, load_program, program_from_table
from gough.program.load import KINDS

TABLES = {
    "circle": {"radius": "0.2 m", "feed": "3 m/min"},
    "ellipse": {"first": "100 mm", "second": "30 mm", "feed": "3 m/min", "direction": "cw"},
    "line": {"to": ["50 mm", "0 mm", "10 mm"], "feed": "0.1 m/s", "back": True},
    "polyline": {"points": {"unit": "mm", "value": [[0, 0, 0], [50, 50, 10], [0, 98, 20]]}, "feed": "0.2 m/s",
                 "corner": "constant"},
    "spline": {"points": {"unit": "mm", "value": [[0, 0, 0], [50, 50, 10], [0, 98, 20]]}, "feed": "0.2 m/s",
               "angles": {"unit": "deg", "value": [[0, 0, 0], [5, 0, 0], [0, 5, 0]]}, "closed": True},
    "fourier": {"period": "4 s", "sine": {"unit": "mm", "value": [[20, 0, 0], [-10, 0, 0]]},
                "turn_sine": {"unit": "deg", "value": [[0, 2, 0], [0, -1, 0]]}},
    "circle_diamond_square": {"feed": "2400 mm/min", "settle": "0.1 s"},
    "circular_test": {"radius": "100 mm", "feed": "3 m/min", "overlap": "90 deg",
                      "plane": ["90 deg", "0 deg", "0 deg"]},
    "square_corners": {"feed": "2 m/min", "side": {"unit": "mm", "value": [20, 50]}, "pause": "0.1 s"},
    "zigzag": {"feed": "2 m/min", "angles": ["45 deg", "135 deg"], "back": True},
    "cone_frustum": {"feed": "1 m/min", "half_angle": "12 deg", "tilt": "6 deg", "chord": "20 um"},
    "s_piece": {"feed": "1 m/min", "lean": "15 deg", "chord": "20 um"},
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_table_gives_a_program_that_plans_and_writes_itself_back(kind, machine):
    program = program_from_table({"kind": kind, **TABLES[kind]})
    assert type(program) is KINDS[kind]
    assert type(program).from_file(program.to_file()) == program
    motion = program.plan(machine)
    r = motion.sample(0, 50, 1e-3)
    assert np.isfinite(np.concatenate([np.ravel(a) for a in r])).all()


def test_a_circle_runs_where_it_says(machine):
    circle = Circle(radius=0.1, feed=0.05, center=(0.3, 0, 0), start=np.pi / 2, turns=0.25, direction="cw")
    r = circle.sample(1e-3, machine)
    np.testing.assert_allclose(r.x[0, :3], [0.3, 0.1, 0], atol=1e-15)
    np.testing.assert_allclose(r.x[-1, :3], [0.4, 0, 0], atol=1e-15)


def test_a_tilted_circle_lies_in_its_plane(machine):
    r = Circle(radius=0.1, feed=0.05, plane=(np.pi / 2, 0, 0)).sample(1e-3, machine)  # y of the plane is z of the frame
    np.testing.assert_allclose(r.x[:, 1], 0, atol=1e-16)
    assert r.x[200, 2] > 0


def test_a_partial_circle_still_has_its_polar_plot(machine):
    motion = Circle(radius=0.1, feed=0.05, turns=0.5).plan(machine)
    assert len(motion.path.circles) == 1


def test_an_ellipse_starts_at_its_angle_and_turns_its_way(machine):
    own = {"first": 0.1, "second": 0.03, "feed": 0.05}
    left, right = (Ellipse(**own, start=0.5, direction=way).sample(1e-2, machine) for way in ("ccw", "cw"))
    start = [0.1 * np.cos(0.5), 0.03 * np.sin(0.5), 0]
    for r in (left, right):
        np.testing.assert_allclose(r.x[0, :3], start, atol=1e-15)
        np.testing.assert_allclose(r.x[-1, :3], start, atol=1e-14)
    assert left.xd[20, 0] < 0 < right.xd[20, 0]


def test_a_line_comes_back(machine):
    r = Line(to=(0.1, 0, 0), back=True, feed=0.05).sample(1e-3, machine)
    assert r.x[:, 0].max() == pytest.approx(0.1, abs=1e-6)
    assert r.x[-1, 0] == 0


def test_the_corner_of_garagic_keeps_its_speed_through_90_degrees(machine):
    points = [[0, 0, 0], [0.05, 0.05, 0.01], [0, 0.098, 0.02]]
    r = Polyline(points=points, feed=0.2, corner="constant").sample(1e-4, machine)
    speed = np.linalg.norm(r.xd[:, :3], axis=1)
    corner = np.searchsorted(r.s[:, 0], np.linalg.norm(points[1]))
    np.testing.assert_allclose(speed[corner - 200 : corner + 200], 0.2, rtol=1e-14)
    turn = np.degrees(np.arccos(r.tangent[corner - 2] @ r.tangent[corner + 2]))
    assert turn == pytest.approx(90, abs=2)  # "make a 90-degree angle", of points given as approximate


def test_the_square_the_diamond_and_the_circle_touch():
    """The circle is the largest that fits; each level reaches the corners of the one inside it."""
    path = CircleDiamondSquare(feed=0.04, radius=0.16 / np.sqrt(8)).path()
    every = np.arange(len(path))
    along = [path.point(every, share * path.length) for share in np.linspace(0, 1, 33)]
    r, z = np.array([np.hypot(p[:, 0], p[:, 1]) for p in along]), np.array([p[:, 2] for p in along])
    for level, least, most in (
        (-0.006, 0.08, np.hypot(0.08, 0.08)),
        (-0.004, 0.08 / np.sqrt(2), 0.08),
        (-0.002, 0.08 / np.sqrt(2), 0.08 / np.sqrt(2)),
    ):
        on = (np.abs(z - level) < 1e-12).all(0)  # blocks that stay at this level
        assert on.sum() == (2 if level == -0.002 else 4)
        assert r[:, on].min() == pytest.approx(least, rel=1e-12)
        assert r[:, on].max() == pytest.approx(most, rel=1e-12)


@pytest.mark.parametrize(
    "table, message",
    [
        ({}, 'kind: is missing; write file = "part.ngc" or kind = "circle"'),
        ({"kind": "circel"}, "kind: no such program, got 'circel'; did you mean circle?"),
        ({"kind": 3},
         "kind: no such program, got 3; there is circle, ellipse, line, polyline, spline, fourier, "
         "circle_diamond_square, circular_test, square_corners, zigzag, cone_frustum, s_piece"),
        ({"file": 3}, "file: must be the name of a file, got 3"),
        ({"file": "none.ngc"}, "file: cannot be read: No such file or directory, got none.ngc"),
        ({"file": "a.ngc", "kind": "circle"}, "kind: a program has a file or a kind, not both"),
        ({"file": "cone-frustrum"},
         "file: no program of the library has this name, got cone-frustrum; did you mean cone-frustum?"),
        ({"file": "a\0.ngc"}, "file: cannot be read: no such name, got a\0.ngc"),
        ({"kind": "circle", "feed": "1 m/s"}, "radius: is missing; give radius in m"),
        (
            {"kind": "circle", "radius": "1 m", "feed": "6 m"},
            "feed: '6 m' is not a quantity in m/s; write e.g. \"6 m/s\"",
        ),
        ({"kind": "circle", "radius": 0.1, "feed": "1 m/s"}, 'radius: has no unit, got 0.1; write e.g. "0.1 m"'),
        ({"kind": "circle", "radius": "-1 m", "feed": "1 m/s"}, "radius: must be above 0 m, got '-1 m'"),
        ({"kind": "circle", "raduis": "1 m", "radius": "1 m", "feed": "1 m/s"},
         "raduis: no such key; did you mean radius?"),
        ({"kind": "circle_diamond_square", "radius": "0.1 m", "feed": "1 m/s"},
         "radius: the circle must fit into the diamond, got 0.1 m; at most 0.05657 m for this side"),
        ({"kind": "cone_frustum", "feed": "1 m/s", "half_angle": "60 deg", "tilt": "25 deg"},
         "tilt: half_angle and tilt together lean the tool over by more than 80 deg, got 25 deg; "
         "at most 20 deg for this half_angle"),
        ({"kind": "cone_frustum", "feed": "1 m/s", "half_angle": "75 deg", "tilt": "0 deg", "height": "85 mm"},
         "height: the frustum ends in its tip, got 0.085 m; at most 0.08282 m for this radius and half_angle"),
        ({"kind": "square_corners", "feed": "1 m/s", "side": {"unit": "mm", "value": [20, -1]}},
         "side: must be above 0 m, got {'unit': 'mm', 'value': [20, -1]}"),
        ({"kind": "square_corners", "feed": "1 m/s", "side": {"unit": "mm", "value": []}},
         "side: is empty; give one side or more"),
        ({"kind": "zigzag", "feed": "1 m/s", "angles": {"unit": "deg", "value": []}},
         "angles: is empty; give one angle or more"),
        ({"kind": "zigzag", "feed": "1 m/s", "angles": "180 deg"}, "angles: must be below 3.14159 rad, got '180 deg'"),
        ({"kind": "polyline", "points": {"unit": "mm", "value": [[0, 0, 0]]}, "feed": "1 m/s"},
         "points: must be two or more points of x y z, got 1 x 3"),
    ],
)  # fmt: skip
def test_a_wrong_table_names_its_key(table, message, tmp_path):
    with pytest.raises(ExperimentError) as caught:
        program_from_table(table, tmp_path)
    assert str(caught.value) == message


def test_a_wrong_corner_is_told():
    with pytest.raises(
        InputError, match="corner: is none of the words allowed here, got 'round'; write 'stop', 'constant' or 'blend'"
    ):
        Circle(radius=0.1, feed=0.05, corner="round")


def test_a_file_in_a_table_is_sought_beside_the_table(tmp_path, machine):
    (tmp_path / "part.ngc").write_text("G1 X10 F600\nM2\n")
    table = {"file": "part.ngc", "corner": "constant", "origin": ["0 mm", "5 mm", "0 mm", "0 deg", "0 deg", "0 deg"]}
    program = program_from_table(table, tmp_path)
    assert program == load_program(tmp_path / "part.ngc", corner="constant", origin=[0, 5e-3, 0, 0, 0, 0])
    np.testing.assert_allclose(program.sample(1e-2, machine).x[-1, :3], [0.01, 0.005, 0], atol=1e-16)


def test_a_wrong_file_in_a_table_gives_the_line_of_the_file(tmp_path):
    (tmp_path / "part.ngc").write_text("G1 X10\nM2\n")
    with pytest.raises(ProgramError) as caught:
        program_from_table({"file": "part.ngc"}, tmp_path)
    assert str(caught.value) == "part.ngc:1: G1 without a feed; write F, in mm/min, before it or with it"
