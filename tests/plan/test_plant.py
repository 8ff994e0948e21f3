"""What a plant adds to a preflight: its payload, its friction, the force on its tool; against the closed loop too."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import gough as gk
from gough.plan import fix_feed, preflight
from gough.plan.demand import FORCE, Demand
from gough.program.nc import NCProgram

QUICK = NCProgram(text="G21 G90\nG1 X-150 F40000\nX150\nM2\n", name="part.ngc")


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("eth-hexaglide").replace(friction=None)


def top(found):
    return found.found.top[found.demand.kinds == FORCE]


def test_forces_are_those_of_the_true_machine_under_the_force_on_its_tool(machine):
    plant = gk.Plant(machine=machine, payload=12.0, wrench=[50.0, -20.0, 300.0, 4.0, 0.0, -2.0])
    demand = Demand(machine, plant=plant)
    rng = np.random.default_rng(3)
    x = machine.home + rng.uniform(-0.03, 0.03, (5, 6))
    xd, xdd = rng.normal(0, 0.2, (2, 5, 6))
    expected = plant.true_machine.inverse_dynamics(x, xd, xdd, np.tile(plant.wrench, (5, 1)))
    np.testing.assert_allclose(demand.values(x, xd, xdd)[FORCE], expected, rtol=0, atol=1e-8)
    assert np.abs(Demand(machine).values(x, xd, xdd)[FORCE] - expected).max() > 50


@pytest.mark.full
def test_a_payload_nobody_told_of_is_announced_where_the_drives_of_the_loop_give_out(machine):
    """1950 N a drive: the line takes 85 % of them, and 115 % with 100 kg that the controller does not know of."""
    weak = machine.replace(**{"drive.force_limit": 1950.0, "drive.encoder": None, "drive.noise": None})
    heavy = gk.Plant(machine=weak, payload=100.0)
    for plant, hit in ((gk.Plant(machine=weak), False), (heavy, True)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            log = gk.simulate(weak, gk.ComputedTorque(bandwidth=12.0), QUICK, plant=plant, period=1e-4)
        assert (top(preflight(weak, QUICK, plant=plant)) > 1).any() == hit == bool(log["saturated"].any())
    fixed = fix_feed(weak, QUICK).program
    assert preflight(weak, fixed).passed and not preflight(weak, fixed, plant=heavy).passed


def test_the_curves_of_the_figure_reach_the_peaks_and_the_limit_where_it_is_exceeded(machine):
    from gough.report.preflight import preflight_figure

    slow = machine.replace(**{"limits.speed": 0.3})
    found = preflight(slow, NCProgram(text="G21 G90\nG1 X-150 F40000\nX150 F9000\nM2\n", name="part.ngc"))
    panels = preflight_figure(found).axes
    assert len(panels) == 4 and not found.passed
    for ax, kind in zip(panels, ("pose", "speed", "acceleration", "force"), strict=True):
        top = max(peak.use for peak in found.peaks if peak.kind == kind)
        assert ax.lines[0].get_ydata().max() == pytest.approx(min(100 * top, 250.0), rel=1e-6), kind
        (words,) = [text.get_text() for text in ax.texts]
        assert words.startswith("line ") and words.endswith(" %)")


def test_the_figure_shows_no_load_of_drives_where_the_pose_is_outside():
    from gough.report.preflight import preflight_figure

    found = preflight(gk.load_machine("nist-octahedral"), NCProgram(text="G21 G90\nG1 X900 F5000\nM2\n", name="p.ngc"))
    pose, *drives = (ax.lines[0].get_ydata() for ax in preflight_figure(found).axes)
    assert (pose > 100).any() and all((np.isnan(use) == (pose > 100)).all() for use in drives)


def test_what_a_plant_has_that_no_force_tells_is_named(machine):
    plant = gk.Plant(machine=machine, friction_drift=0.01)
    (said,) = [text for text in preflight(machine, QUICK, plant=plant).warnings if "plant" in text]
    assert said == "not in the forces told here: friction_drift of the plant"
    assert not any("plant" in text for text in preflight(machine, QUICK, plant=gk.Plant(machine=machine)).warnings)
