"""Tuning: gains that make a controller's contour error small on drawn machines, within limits of its effort."""
