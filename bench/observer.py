"""Time of the exported disturbance observer, a step as HAL's thread calls it: python -m bench.observer [MACHINE ...]

Compiled as the exported Makefile does (gcc -O2 -ffp-contract=off), driven along a slow circle of the joints about home,
200 batches of 500 steps: median and worst batch, microseconds a step.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import gough as gk
from gough.export.linuxcnc import files_of

DRIVER = """
#include <math.h>
#include <stdio.h>
#include <time.h>
#include "m_wrench.h"
#define JOINTS %(n)d
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1e6 + t.tv_nsec * 1e-3;
}
int main(void)
{
    static const double home[JOINTS] = {%(home)s};
    m_wrench_state state;
    double found[13], q[JOINTS], u[JOINTS], kept = 0;
    long k = 0;
    m_wrench_start(&state);
    for (int batch = 0; batch < 200; batch++) {
        double from = now();
        for (int i = 0; i < 500; i++, k++) {
            for (int j = 0; j < JOINTS; j++) {
                q[j] = home[j] + 1e-3 * (sin(1e-3 * k + j) - sin((double)j));
                u[j] = 100.0 * j;
            }
            m_wrench_step(&state, q, u, 1, found);
            kept += found[0];
        }
        printf("%%.4f\\n", (now() - from) / 500);
    }
    return isfinite(kept) ? 0 : 1;
}
"""


def times(machine) -> list[float]:
    """Microseconds a step, sorted, of each batch; sines of the joints are in it."""
    files = files_of(machine, "m")
    home = ", ".join(map(repr, machine.inverse_kinematics(machine.home).tolist()))
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for name in ("m_wrench.c", "m_wrench.h"):
            (folder / name).write_text(files[name])
        (folder / "driver.c").write_text(DRIVER % {"n": machine.joints_count, "home": home})
        flags = ["-std=gnu99", "-O2", "-ffp-contract=off"]
        sources = [str(folder / name) for name in ("driver.c", "m_wrench.c")]
        subprocess.run(["gcc", *flags, "-o", str(folder / "driver"), *sources, "-lm"], check=True)
        done = subprocess.run([str(folder / "driver")], capture_output=True, text=True, check=True)
    return sorted(map(float, done.stdout.split()))


if __name__ == "__main__":
    for name in sys.argv[1:] or ["nist-octahedral", "okuma-pm600", "eth-hexaglide", "ccu-3prs"]:
        found = times(gk.load_machine(name))
        print(f"{name:18} median {found[100]:6.2f} us   worst batch {found[-1]:6.2f} us", flush=True)
