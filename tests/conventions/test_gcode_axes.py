"""How NC words lie in space, with numbers: no identity can see a sense of rotation."""

from types import SimpleNamespace

import numpy as np
import pytest

from gough.program import NCProgram


class Direct:
    """A machine whose joints are the tool's coordinates."""

    home, joints_count = np.zeros(6), 6
    feed = SimpleNamespace(rapid=0.3, acceleration=2.0, jerk=50.0, angular_rate=1.0, angular_acceleration=5.0)

    task = ("x", "y", "z", "a", "b", "c")
    program_zero = property(lambda self: self.home)

    def task_motion(self, x, xd, xdd):
        return x, xd, xdd

    def joint_motion(self, x, xd, xdd, on_fail="raise"):
        return x, xd, xdd


MACHINE = Direct()


def run(*lines, Ts=1e-3, machine=MACHINE, **options):
    return NCProgram(text="\n".join([*lines, "M2"]), **options).sample(Ts, machine)


@pytest.mark.parametrize(
    "words, axis",
    [
        ("A5", (0, -0.08715574274765817, 0.9961946980917455)),  # about +x: from +z towards -y
        ("B5", (0.08715574274765817, 0, 0.9961946980917455)),  # about +y: from +z towards +x
        ("C5", (0, 0, 1)),  # about the tool's own axis
        ("A90", (0, -1, 0)),
        ("B90", (1, 0, 0)),
        ("A90 C90", (1, 0, 0)),  # A first, then C about the frame's z: -y goes to +x
        ("A90 B90", (0, -1, 0)),  # A first; then B turns -y about y, which leaves it
        ("B90 C90", (0, 1, 0)),
    ],
)
def test_a_b_c_turn_the_tool_about_the_axes_of_the_frame_in_this_order(words, axis):
    np.testing.assert_allclose(run(f"G0 {words}").axis[-1], axis, atol=1e-15)


def test_a_positive_c_rate_is_a_positive_angular_velocity_about_z():
    r = run("G1 C10 F600")
    np.testing.assert_allclose(r.xd[500], [0, 0, 0, 0, 0, np.radians(10)], atol=1e-15)


def test_g2_is_clockwise_seen_from_above():
    r = run("G0 X10", "G2 X0 Y-10 I-10 J0 F600")
    assert (r.x[:, 1] <= 1e-15).all()  # from +x through -y
    assert r.x[-1, 1] == pytest.approx(-0.010, rel=1e-14)


def test_g3_is_counter_clockwise_seen_from_above():
    r = run("G0 X10", "G3 X0 Y10 I-10 J0 F600")
    assert (r.x[:, 1] >= -1e-15).all()
    assert r.x[-1, 1] == pytest.approx(0.010, rel=1e-14)


def test_x_words_are_millimetres_and_f_millimetres_a_minute():
    r = run("G1 X100 F3000")
    assert r.x[-1, 0] == pytest.approx(0.1, rel=1e-15)
    assert r.xd[1000, 0] == pytest.approx(0.05, rel=1e-14)


def test_the_tip_stays_on_its_path_while_the_tool_tilts():
    r = run("G1 X50 A8 B-5 F600")
    np.testing.assert_array_equal(r.x[:, 1:3], 0)
    np.testing.assert_allclose(r.x[-1, 3:5], np.radians([8, -5]), rtol=1e-14)


def test_angles_of_a_program_turn_about_the_axes_of_its_own_frame():
    """Frame turned by +90 deg about z: the program's x is W's y, so A5 leans the tool towards +x of W."""
    r = run("G0 X10 A5", origin=(0, 0, 0, 0, 0, np.pi / 2))
    np.testing.assert_allclose(r.x[-1, :3], [0, 0.010, 0], atol=1e-16)
    np.testing.assert_allclose(r.axis[-1], [np.sin(np.radians(5)), 0, np.cos(np.radians(5))], atol=1e-15)
