"""gough export --target mjcf: the text, its numbers, its errors.  What the engines make of it: tests/oracle."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError, SheetError
from gough.export.mjcf import mjcf, stiffness, strut_frame

OKUMA = gk.load_machine("okuma-pm600")


def numbers(element, key):
    return np.array(element.get(key).split(), float)


def test_numbers_read_back_as_the_same_numbers():
    root = ET.fromstring(mjcf(OKUMA))
    tube = root.find(".//body[@name='tube 3']")
    assert float(tube.find("inertial").get("mass")) == OKUMA.strut.moving.mass
    assert float(tube.find("joint").get("armature")) == OKUMA.drive.inertia * (2 * np.pi / OKUMA.drive.lead) ** 2
    assert numbers(root.find(".//site[@name='platform B3']"), "pos").tolist() == OKUMA.platform_joints_np()[2].tolist()
    assert numbers(root.find("option"), "gravity").tolist() == OKUMA.gravity.tolist()
    assert numbers(root.find(".//body[@name='sleeve 3']"), "pos").tolist() == OKUMA.joints.base[2].tolist()


def test_drives_push_and_pull_with_the_force_of_their_torque_limit():
    for torque, bound in ((40.0, 40.0 * 2 * np.pi / OKUMA.drive.lead), (None, None)):
        root = ET.fromstring(mjcf(OKUMA.replace(**{"drive.torque_limit": torque})))
        drives = [one for one in root.find("actuator") if one.get("name").startswith("drive ")]
        assert len(drives) == 6
        for drive in drives:
            if bound is None:
                assert drive.get("ctrlrange") is None
            else:
                assert numbers(drive, "ctrlrange").tolist() == [-bound, bound]


def test_the_platforms_inertia_is_turned_into_the_tools_axes():
    quarter = {"position": [0.0, 0.0, 0.1], "angles": [np.pi / 2, 0.0, 0.0]}  # y of P is -z of T, z of P is y of T
    turned = OKUMA.replace(tool=gk.machine.hexapod_parts.Tool(**quarter), home=[0, 0, -0.7, np.pi / 2, 0, 0])
    inertial = ET.fromstring(mjcf(turned)).find(".//body[@name='platform']/inertial")
    c = OKUMA.platform.center - [0, 0, 0.1]
    np.testing.assert_allclose(numbers(inertial, "pos"), [c[0], c[2], -c[1]], atol=1e-15)
    a, b, c = np.diag(OKUMA.platform.inertia)
    found = numbers(inertial, "diaginertia" if inertial.get("diaginertia") else "fullinertia")
    np.testing.assert_allclose(found[:3], [a, c, b], rtol=1e-14)


def test_a_strut_frame_is_right_handed_with_the_strut_as_third_axis_and_the_forks_axis_across_the_second():
    for i in range(6):
        frame = strut_frame(OKUMA, i)
        R = frame.R_WS
        np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-15)
        assert np.linalg.det(R) == pytest.approx(1)
        np.testing.assert_allclose(frame.p_WA + frame.length * R[:, 2], frame.p_WB, atol=1e-15)
        assert abs(frame.axis_S[1]) < 1e-15 and frame.axis_S[0] > 0
        np.testing.assert_allclose(R @ frame.axis_S, OKUMA.joints.base_axis[i], atol=1e-15)


def test_a_cross_with_inertia_is_a_body_of_its_own_and_one_without_is_none():
    assert ET.fromstring(mjcf(OKUMA)).find(".//body[@name='cross 1']") is None
    inertial = ET.fromstring(mjcf(OKUMA.replace(**{"joints.cross": 0.05}))).find(".//body[@name='cross 1']/inertial")
    assert numbers(inertial, "diaginertia").tolist() == [0.05] * 3


def test_constant_viscous_friction_is_damping_and_the_file_says_what_is_left_out():
    text = mjcf(OKUMA.replace(friction={"kind": "stribeck", "coulomb": 90.0, "viscous": 70.0, "smoothing": 1e-3}))
    assert {joint.get("damping") for joint in ET.fromstring(text).iterfind(".//joint[@armature]")} == {"70.0"}
    assert "all friction of kind stribeck but its constant viscous part" in text
    assert "friction" not in mjcf(OKUMA.replace(friction=None))


def test_stiff_loops_are_critically_damped_springs_as_fast_as_the_step_bears():
    k, b = (-float(number) for number in stiffness(1e-3)["solref"].split())
    assert k == pytest.approx(0.7e3**2) and b == pytest.approx(2 * np.sqrt(k))
    root = ET.fromstring(mjcf(OKUMA, "stiff", timestep=1e-3))
    assert root.find("equality/connect").get("solref") == stiffness(1e-3)["solref"]
    assert root.find("option").get("integrator") == "RK4"
    assert ET.fromstring(mjcf(OKUMA)).find("equality/connect").get("solref") is None


def test_a_name_with_two_hyphens_is_still_a_comment():
    assert "a- -b" in mjcf(OKUMA.replace(name="a--b"))
    assert ET.fromstring(mjcf(OKUMA.replace(name="a--b"))).get("model") == "a--b"


@pytest.mark.parametrize(
    "options, text",
    [
        ({"loops": "stif"}, "loops: no such way to close the loops, got 'stif'; did you mean stiff?"),
        ({"timestep": 0.0}, "timestep: the step must be a positive number of seconds, got 0.0"),
        ({"timestep": float("nan")}, "timestep: the step must be a positive number of seconds, got nan"),
    ],
)
def test_a_wrong_option_is_refused_with_its_cure(options, text):
    with pytest.raises(ExperimentError) as caught:
        mjcf(OKUMA, **options)
    assert str(caught.value) == text


def test_a_body_that_mujoco_would_refuse_is_refused_here_with_its_name():
    with pytest.raises(SheetError, match="strut.fixed of okuma-pm600: .* got 1 against 0.15 kg m2"):
        mjcf(OKUMA.replace(**{"strut.fixed.axial": 1.0}))


def test_what_is_no_machine_is_refused_with_the_kinds_that_can_be_written():
    with pytest.raises(SheetError) as caught:
        gk.export(gk.Circle(radius=0.1, feed=0.1), "mjcf")
    rule = "kind: no machine of this kind can be written as mjcf, got ; hexapod, hexaglide, tripod, hybrid, axis can"
    assert str(caught.value) == rule or "hexapod, hexaglide, tripod, hybrid, axis can" in str(caught.value)


@pytest.mark.parametrize("name", gk.library())
def test_every_machine_of_the_library_can_be_written(gough, name):
    ended = gough("export", name, "--target", "mjcf")
    assert ended.status == 0 and ET.fromstring(ended.out).get("model") == name
    assert ("compliance" in ended.out) == bool(gk.load_machine(name).compliance)


@pytest.mark.parametrize(
    ("name", "said", "tree"), [("ccu-3prs", "slider", "link"), ("eth-hexaglide", "carriage", "leg")]
)
def test_machines_on_rails_are_written_with_their_own_words(gough, name, said, tree):
    machine = gk.load_machine(name)
    root = ET.fromstring(gough("export", name, "-t", "mjcf").out)
    for i, point in enumerate(machine.rails.point, 1):
        body = root.find(f".//body[@name='{said} {i}']")
        joint = body.find(f"joint[@name='{said} {i}']")
        assert numbers(joint, "axis").tolist() == machine.rails.direction[i - 1].tolist()
        assert numbers(joint, "range").tolist() == machine.limits.travel.tolist()
        np.testing.assert_allclose(numbers(body, "pos") - numbers(joint, "ref") * machine.rails.direction[i - 1], point)
        assert body.find(f"body[@name='{tree} {i}']") is not None
    assert len(root.findall("equality/connect")) == machine.joints_count
    assert "strut" not in gough("export", name, "-t", "mjcf").out


def test_screws_and_motors_of_a_3prs_weigh_on_its_slides_and_its_links_keep_their_angles():
    machine = gk.load_machine("ccu-3prs").replace(friction={"kind": "stribeck", "coulomb": 60.0, "viscous": 100.0,
                                                            "smoothing": 1e-3})  # fmt: skip
    root = ET.fromstring(mjcf(machine))
    slide, link = root.find(".//joint[@name='slider 2']"), root.find(".//joint[@name='link 2']")
    assert float(slide.get("armature")) == machine.drive.inertia * (2 * np.pi / machine.drive.lead) ** 2
    assert float(slide.get("damping")) == 100.0
    assert numbers(link, "range").tolist() == machine.limits.angle.tolist()
    assert float(link.get("ref")) == machine.standing(machine.home)[4]


def test_export_knows_its_targets_and_writes_whole_files(tmp_path):
    with pytest.raises(ExperimentError, match="no such target of an export, got 'mjfc'; did you mean mjcf?"):
        gk.export(OKUMA, "mjfc")
    text = gk.export(OKUMA, "mjcf", tmp_path / "m.xml", loops="stiff")
    assert (tmp_path / "m.xml").read_text() == text == mjcf(OKUMA, "stiff")


def test_the_command_prints_the_file_or_writes_it(gough, tmp_path):
    assert gough("export", "okuma-pm600", "--target", "mjcf").out == mjcf(OKUMA)
    ended = gough("export", "okuma-pm600", "-t", "mjcf", "--loops", "stiff", "--timestep", "0.5 ms", "-o", "m.xml")
    assert ended.status == 0 and (tmp_path / "m.xml").read_text() == mjcf(OKUMA, "stiff", 0.5e-3)
    assert ended.out == "m.xml is written: an MJCF model for MuJoCo and Pinocchio of okuma-pm600\n"
    again = gough("export", "okuma-pm600", "-t", "mjcf", "-o", "m.xml")
    assert again.status == 2 and "there is a file already; choose another name, or add --force" in again.err
    assert gough("export", "okuma-pm600", "-t", "mjcf", "-o", "m.xml", "--force", "--json").json["file"] == "m.xml"
    assert gough("export", "okuma-pm600", "-t", "mjcf", "--json").json["text"] == mjcf(OKUMA)


@pytest.mark.parametrize(
    "arguments, words",
    [
        (("okuma-pm60", "-t", "mjcf"), "did you mean okuma-pm600?"),
        (("okuma-pm600", "-t", "urdf"), "no such target of an export"),
        (("okuma-pm600", "-t", "mjcf", "--timestep", "1 mm"), "1 mm"),
        (("okuma-pm600", "-t", "mjcf", "--timestep", "nan"), "nan"),
        (("okuma-pm600", "-t", "mjcf", "--loops", "soft"), "no such way to close the loops"),
    ],
)
def test_wrong_arguments_of_the_command_end_with_two(gough, arguments, words):
    ended = gough("export", *arguments)
    assert ended.status == 2 and words in ended.err and ended.out == ""
