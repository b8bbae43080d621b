"""Which attractor a start lands on: attractors, cells, boundaries, speeds."""
