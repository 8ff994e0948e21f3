"""Inside LinuxCNC: switch on, home, run the program, record.  Runs with the system's Python, apart from gough.

    session.py PROGRAM CHANNELS SECONDS DELETE      the [DISPLAY] program: LinuxCNC ends when it does
    session.py record CHANNEL TYPES                 its child: one sampler's stream, to channel-N.bin, until stdin ends

Its outcome is the file result.json: status "done" or "failed", and what LinuxCNC said.
"""

from __future__ import annotations

import array
import json
import os
import subprocess
import sys
import time

_KEY = 0x48534130  # of sampler's first stream in HAL
_STEP = 0.01  # s, real time, between looks at LinuxCNC


def record(channel, types):
    """Every sample of one sampler as doubles, number first, until stdin closes and the stream is empty."""
    import select

    import hal

    component = hal.component(f"gough-record-{channel}")
    component.ready()
    stream = hal.stream(component, _KEY + channel, types)
    open_, kept = True, array.array("d")
    with open(f"channel-{channel}.bin", "wb") as file:
        while True:
            while stream.readable:
                row = stream.read()
                if row is None:
                    break
                kept.append(stream.sampleno)
                kept.extend(row)
                if len(kept) > 1 << 16:
                    kept.tofile(file)
                    kept = array.array("d")
            if not open_:
                break
            open_ = not select.select([sys.stdin], [], [], 0.002)[0]
        kept.tofile(file)
    with open(f"channel-{channel}.json", "w") as file:
        json.dump({"overruns": stream.num_overruns}, file)
    component.exit()


class Failed(Exception):
    """LinuxCNC said no."""


class Session:
    """One program from start to end."""

    def __init__(self, seconds):
        import hal
        import linuxcnc

        self.linuxcnc = linuxcnc
        self.stat, self.command, self.errors = linuxcnc.stat(), linuxcnc.command(), linuxcnc.error_channel()
        self.until = time.monotonic() + seconds
        self.component = hal.component("gough-session")
        self.component.newpin("inhibit", hal.HAL_BIT, hal.HAL_OUT)
        self.component.ready()
        self.component["inhibit"] = True
        hal.connect("gough-session.inhibit", "gough-inhibit")
        self.said = []

    def look(self):
        """The state now; Failed for an error that LinuxCNC has told since."""
        self.stat.poll()
        wrong = False
        while True:
            found = self.errors.poll()
            if not found:
                break
            kind, text = found
            bad = kind in (self.linuxcnc.NML_ERROR, self.linuxcnc.OPERATOR_ERROR)
            self.said.append({"error": bad, "text": text.strip(), "line": self.stat.motion_line})
            wrong = wrong or bad
        if wrong:
            raise Failed
        if time.monotonic() > self.until:
            self.said.append({"error": True, "text": "timeout", "line": self.stat.motion_line})
            raise Failed
        return self.stat

    def wait(self, holds):
        while not holds(self.look()):
            time.sleep(_STEP)

    def run(self, program, delete):
        c, command = self.linuxcnc, self.command
        command.state(c.STATE_ESTOP_RESET)
        self.wait(lambda s: s.task_state != c.STATE_ESTOP)
        command.state(c.STATE_ON)
        self.wait(lambda s: s.task_state == c.STATE_ON)
        command.mode(c.MODE_MANUAL)
        command.wait_complete()
        command.teleop_enable(0)
        command.wait_complete()
        command.home(-1)
        self.wait(lambda s: all(s.homed[: s.joints]))
        command.teleop_enable(1)
        self.wait(lambda s: s.motion_mode == c.TRAJ_MODE_TELEOP)
        command.mode(c.MODE_AUTO)
        command.wait_complete()
        self.look()
        command.set_block_delete(delete)  # lines that begin with "/"
        command.wait_complete()
        command.program_open(program)
        command.wait_complete()
        self.look()
        command.auto(c.AUTO_RUN, 0)
        self._filled()
        self.component["inhibit"] = False
        rested = 0
        while rested < 5:  # the interpreter is idle before the last segment stands
            stat = self.look()
            if stat.interp_state == c.INTERP_PAUSED and stat.paused:
                command.auto(c.AUTO_RESUME)  # M0, M1: nobody is there to press start
            idle = stat.interp_state == c.INTERP_IDLE and stat.queue == 0 and stat.inpos
            rested = rested + 1 if idle else 0
            time.sleep(_STEP)

    def _filled(self):
        """Wait until the queue of segments grows no more: the planner then begins the same way every time."""
        began, last, same = time.monotonic(), -1, 0
        while same < 10:
            stat = self.look()
            started = stat.interp_state != self.linuxcnc.INTERP_IDLE or time.monotonic() - began > 1.0
            same = same + 1 if started and stat.queue == last else 0
            last = stat.queue
            time.sleep(_STEP)


def main(program, channels, seconds, delete):
    children = [
        subprocess.Popen([sys.executable, __file__, "record", str(k), types], stdin=subprocess.PIPE)
        for k, types in enumerate(channels.split(","))
    ]
    status, session = "failed", None
    try:
        session = Session(seconds)
        session.run(program, delete)
        status = "done"
    except Failed:
        session.command.abort()
    finally:
        for child in children:
            child.stdin.close()
        for child in children:
            child.wait(60)
        said = session.said if session else []
        with open("result.tmp", "w") as file:
            json.dump({"status": status, "said": said}, file)
        os.replace("result.tmp", "result.json")


if __name__ == "__main__":
    if sys.argv[1] == "record":
        record(int(sys.argv[2]), sys.argv[3])
    else:
        main(sys.argv[1], sys.argv[2], float(sys.argv[3]), sys.argv[4] == "1")
