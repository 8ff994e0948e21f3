"""What a program can read of the machine: #<_x>, #<_metric>, #5420 and their kind."""

from __future__ import annotations

from . import codes
from .modes import DEGREE, MM


def offer(interpreter) -> None:
    """Fill `system` and `system_numbers` of the interpreter's parameters; the values are those of LinuxCNC 2.9."""
    modes, offsets, tip = interpreter.modes, interpreter.offsets, interpreter.tip
    parameters = interpreter.parameters

    def flag(test):
        return lambda: float(test())

    def here(k):
        # in the program's unit, X Y Z A B C
        return lambda: offsets.to_program(tip.pose)[k] / (modes.unit if k < 3 else DEGREE)

    def tool(k):
        return lambda: offsets.tool[k] * 1e3  # mm, whatever the program's unit

    parameters.system.update(
        {
            "_motion_mode": lambda: float(codes.CANCEL if modes.motion is None else modes.motion),
            "_plane": lambda: float(modes.plane),
            "_ccomp": lambda: 400.0,
            "_metric": flag(lambda: modes.unit == MM),
            "_imperial": flag(lambda: modes.unit != MM),
            "_absolute": flag(lambda: modes.absolute),
            "_incremental": flag(lambda: not modes.absolute),
            "_inverse_time": flag(lambda: modes.inverse_time),
            "_units_per_minute": flag(lambda: not modes.inverse_time),
            "_units_per_rev": lambda: 0.0,
            "_coord_system": lambda: float(codes.SYSTEMS[offsets.system - 1]),
            "_tool_offset": flag(lambda: modes.tool_offset != 490),
            "_retract_r_plane": flag(lambda: modes.retract_r),
            "_retract_old_z": flag(lambda: not modes.retract_r),
            "_spindle_rpm_mode": lambda: 1.0,
            "_spindle_css_mode": lambda: 0.0,
            "_ijk_absolute_mode": flag(lambda: modes.absolute_center),
            "_lathe_diameter_mode": lambda: 0.0,
            "_lathe_radius_mode": lambda: 1.0,
            "_spindle_on": flag(lambda: modes.spindle != 0),
            "_spindle_cw": flag(lambda: modes.spindle > 0),
            "_mist": flag(lambda: modes.mist),
            "_flood": flag(lambda: modes.flood),
            "_speed_override": flag(lambda: modes.speed_override),
            "_feed_override": flag(lambda: modes.feed_override),
            "_adaptive_feed": flag(lambda: modes.adaptive_feed),
            "_feed_hold": flag(lambda: modes.feed_hold),
            "_feed": lambda: modes.feed_word,
            "_rpm": lambda: modes.speed,
            "_current_tool": lambda: float(modes.current_tool),
            "_selected_tool": lambda: float(modes.selected_tool),
            **{f"_{letter}": here(k) for k, letter in enumerate("xyzabc")},
            **{f"_{letter}": lambda: 0.0 for letter in "uvw"},
        }
    )
    parameters.system_numbers.update({5420 + k: here(k) for k in range(6)})
    parameters.system_numbers.update({5426 + k: lambda: 0.0 for k in range(3)})
    parameters.system_numbers[5400] = lambda: float(modes.current_tool)
    parameters.system_numbers.update({5401 + k: tool(k) for k in range(3)})
    parameters.system_numbers[5410] = lambda: interpreter.diameter() * 1e3
