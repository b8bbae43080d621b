"""Periodic orbits: found, solved to rounding, followed, and what happens to them on the way."""
