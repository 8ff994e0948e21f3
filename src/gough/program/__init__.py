"""Programs: a geometric path with a feed profile, from G-code or from the standard shapes."""
