"""Which attractor a start lands on: attractors, cell mapping, boundaries, speeds."""
