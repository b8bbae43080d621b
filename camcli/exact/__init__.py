"""The motion in ball arithmetic: what doubles cannot decide. Nothing here imports an analysis."""
