"""Observers: what cannot be measured, from what can."""
