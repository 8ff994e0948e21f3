"""Speed along a path: from cells with limits to phases of constant jerk."""
