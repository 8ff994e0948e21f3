"""Runs under Debian's own Python: LinuxCNC's interpreter as a library, every call it makes of the machine written down.

    /usr/bin/python3 gcode_module.py FOLDER SECONDS    file names on stdin, one a line; one JSON object a line on stdout

FOLDER holds tools.json, the tool table [[number, x, y, z in mm], ...];
a program may take SECONDS.  Lengths come in inch whatever the program says and whatever unit the machine claims.
$HOME must hold the .tool.mmap which `rs274` leaves behind: the library reads the tools from there and dies of a
segmentation fault without it.
"""

import ctypes
import json
import os
import signal
import sys

import gcode

KEPT = {
    "straight_traverse", "straight_feed", "arc_feed", "dwell", "set_feed_rate", "set_plane", "tool_offset",
    "set_g5x_offset", "set_g92_offset", "set_xy_rotation",
}  # fmt: skip


class Recorder:
    """What the interpreter calls the canon: answers its questions, keeps its commands."""

    def __init__(self, parameter_file, tools):
        self.parameter_file = parameter_file
        self.tools, self.pocket = tools, 0
        self.calls, self.line = [], 0

    def next_line(self, state):
        self.line = state.sequence_number

    def change_tool(self, pocket):
        self.pocket = pocket

    def get_external_length_units(self):
        return 1.0  # per mm: the offsets in the numbered parameters are in mm

    def get_external_angular_units(self):
        return 1.0

    def get_axis_mask(self):
        return 0b111111

    def get_block_delete(self):
        return False

    def get_tool(self, place):
        place = self.pocket if place == 0 else place
        if not 1 <= place <= len(self.tools):
            return (-1, *[0.0] * 12, 0)
        number, *offset = self.tools[place - 1]
        return (number, *offset, *[0.0] * 9, 0)

    def check_abort(self):
        return False

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        if name in KEPT:
            return lambda *numbers: self.calls.append((name, self.line, numbers))
        return lambda *_: None


def read(file, folder, tools):
    """One program: the JSON object."""
    parameters = os.path.join(folder, "gcode.var")
    with open(parameters, "w"):
        pass
    recorder = Recorder(parameters, tools)
    status, line = gcode.parse(file, recorder, "G21", "")
    text = gcode.strerror(status) if status > gcode.MIN_ERROR else None
    return {"error": text, "line": line, "calls": recorder.calls}


def main(folder, seconds):
    with open(os.path.join(folder, "tools.json")) as f:
        tools = json.load(f)
    shared = os.path.join(os.environ["HOME"], ".tool.mmap")
    with open(shared, "rb") as f:
        fresh = f.read()
    ctypes.CDLL("libtooldata.so.0")._Z14tool_mmap_userv()
    out = os.dup(1)
    os.dup2(2, 1)  # the interpreter prints too: (PRINT,...) and its own troubles
    for name in sys.stdin:
        with open(shared, "r+b") as f:  # the tool in the spindle is kept in there from program to program
            f.write(fresh)
        # a process for each: the interpreter remembers offsets and parameters, it may crash, and it may never end
        child = os.fork()
        if child == 0:
            signal.alarm(seconds)
            answer = json.dumps(read(name.rstrip("\n"), folder, tools)) + "\n"
            with open(out, "w") as f:
                f.write(answer)
            os._exit(0)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if status:
            text = "hangs" if status == -signal.SIGALRM else f"crashes with status {status}"
            os.write(out, (json.dumps({"error": text, "line": None, "calls": []}) + "\n").encode())


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
