"""LinuxCNC in namespaces of its own: processes, network, shared memory, mounts.  Nothing of it is left behind.

Its clean-up kills by name and its server listens on every interface; so it never runs outside.  Modules are loaded
from /usr/lib/linuxcnc/modules alone: inside, that folder is one of ours.  The realtime process is a copy without the
setuid bit, so that the faster clock can be loaded before it.
"""

from __future__ import annotations

import contextlib
import functools
import os
import shutil
import signal
import subprocess
from importlib import resources
from pathlib import Path

from ..errors import ExperimentError, RunError

VERSION = "2.9"
_MODULES = Path("/usr/lib/linuxcnc/modules")
_APT = "apt-get install --no-install-recommends linuxcnc-uspace linuxcnc-uspace-dev gcc make libc6-dev"
_NEEDED = ("linuxcnc", "rtapi_app", "halcompile", "gcc", "make", "unshare", "setpriv", "mount", "dpkg-query")


@functools.cache
def missing() -> str | None:
    """Why LinuxCNC cannot run here, in words; None where it can."""
    absent = [name for name in _NEEDED[:-1] if shutil.which(name) is None]
    if absent:
        return f"not installed: {', '.join(absent)}"
    if not Path("/usr/bin/python3").exists():
        return "not installed: /usr/bin/python3"
    asked = subprocess.run(
        ["/usr/bin/python3", "-c", "import hal, linuxcnc; print(linuxcnc.version)"], capture_output=True, text=True,
        timeout=60, check=False,
    )  # fmt: skip
    if asked.returncode:
        return "the system's Python cannot import hal and linuxcnc"
    version = asked.stdout.strip()
    if not version.startswith(VERSION):
        return f"LinuxCNC {version[:40]} is installed, not {VERSION}"
    tried = subprocess.run(
        [*_spaces(), "mount", "--make-rprivate", "/"], capture_output=True, text=True, timeout=60, check=False
    )
    if tried.returncode:
        return f"namespaces are refused: {(tried.stderr.strip() or 'unshare failed').splitlines()[-1][:200]}"
    return None


def check() -> None:
    """Refuse to go on where LinuxCNC cannot run.

    Raises
    ------
    ExperimentError
        what is missing, and what to install.
    """
    reason = missing()
    if reason is not None:
        if "is installed, not" in reason:
            cure = f"install LinuxCNC {VERSION} (Debian 12 has it)"
        elif "refused" in reason:
            cure = "run as root, or allow user namespaces; in a container give it the right to mount"
        else:
            cure = _APT
        raise ExperimentError("LinuxCNC cannot run here", value=reason, cure=cure)


def _spaces() -> list[str]:
    own = ["--user", "--map-root-user"] if os.geteuid() else []
    kinds = ["--pid", "--net", "--ipc", "--mount", "--mount-proc"]
    # should gough be killed itself, unshare goes with it, and its child with that
    return ["setpriv", "--pdeathsig", "KILL", "unshare", *own, *kinds, "--fork", "--kill-child=KILL"]


def compile_modules(folder: Path) -> None:
    """`make` of an exported folder.

    Raises
    ------
    RunError
        what the compiler said.
    """
    done = subprocess.run(
        ["make", "-j4", "-C", str(folder)], capture_output=True, text=True, errors="replace", timeout=600, check=False,
        env=_environment(),
    )  # fmt: skip
    if done.returncode:
        said = [line for line in done.stderr.splitlines() if line.strip()][:4]
        raise RunError("the modules do not compile", value=" / ".join(said)[:600], cure=_APT)


def compile_clock(folder: Path) -> None:
    """fastclock.so in `folder`.  RunError as above."""
    source = folder / "fastclock.c"
    source.write_text((resources.files("gough.linuxcnc") / "fastclock.c").read_text())
    done = subprocess.run(
        ["gcc", "-O2", "-shared", "-fPIC", "-o", str(folder / "fastclock.so"), str(source), "-ldl"],
        capture_output=True, text=True, errors="replace", timeout=120, check=False, env=_environment(),
    )  # fmt: skip
    if done.returncode:
        raise RunError("the clock does not compile", value=done.stderr.strip()[:600], cure=_APT)


def _environment() -> dict[str, str]:
    """Little of the caller's: what a shell sets for itself must not change what is compiled or run."""
    kept = {name: os.environ[name] for name in ("PATH", "LANG") if name in os.environ}
    return {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", **kept, "LC_ALL": "C"}


def prepare(folder: Path) -> None:
    """The places that inside.sh mounts: folders of the run, and the realtime process without its setuid bit."""
    for name in ("modules", "originals", "tmp", "home"):
        (folder / name).mkdir(exist_ok=True)
    (folder / "tmp").chmod(0o777)
    shutil.copy(shutil.which("rtapi_app") or "/usr/bin/rtapi_app", folder / "rtapi_app")
    (folder / "rtapi_app").chmod(0o755)
    for module in folder.glob("*.so"):
        if module.name != "fastclock.so":
            shutil.copy(module, folder / "modules" / module.name)
    for name in ("inside.sh", "session.py"):
        (folder / name).write_text((resources.files("gough.linuxcnc") / name).read_text())
    (folder / "session.py").chmod(0o755)
    if os.geteuid() == 0:
        for path in [folder, *folder.rglob("*")]:
            os.chown(path, 65534, 65534, follow_symlinks=False)


def run_inside(folder: Path, ini: str, speed: int, seconds: float) -> str:
    """Run LinuxCNC on the INI in `folder` until it ends; what it wrote.  Ends it and all it started whatever happens.

    Raises
    ------
    RunError
        it did not end by itself within `seconds`.
    """
    how = "user" if os.geteuid() else "root"
    log = folder / "linuxcnc.log"
    with open(log, "wb") as out:
        process = subprocess.Popen(
            [*_spaces(), "sh", str(folder / "inside.sh"), str(folder), ini, how],
            stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT, start_new_session=True,
            env=_environment() | {"GOUGH_SPEED": str(speed)},
        )  # fmt: skip
        try:
            process.wait(seconds)
        except subprocess.TimeoutExpired:
            raise RunError(
                "LinuxCNC did not end in time", value=tail(log), limit=f"{seconds:g} s",
                cure="give a longer --timeout",
            ) from None  # fmt: skip
        finally:
            _end(process)
    return log.read_text(errors="replace")


def _end(process: subprocess.Popen) -> None:
    """End unshare's child, the first process of its namespace: all others die with it, and unshare waits for them."""
    if process.poll() is None:
        with contextlib.suppress(OSError):
            for child in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split():
                os.kill(int(child), signal.SIGKILL)
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
    process.wait(30)


def tail(log: Path, lines: int = 6) -> str:
    """The last lines of a log, in one."""
    text = log.read_text(errors="replace") if log.exists() else ""
    return " / ".join(line.strip() for line in text.splitlines()[-lines:] if line.strip())[-600:]
