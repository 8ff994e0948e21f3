"""LinuxCNC itself on exported machines; skipped with the reason where it cannot run."""
