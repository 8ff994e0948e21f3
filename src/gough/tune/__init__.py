"""Tuning: gains that make a controller's contour error small on machines that are drawn, within limits of its effort."""
