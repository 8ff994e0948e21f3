"""Before anything moves: what a machine can do, where it can go, and what to do where it cannot."""
