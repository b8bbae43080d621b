"""The pictures. Matplotlib is imported in this folder only: import it where a picture is due."""

from camcli.artefacts.figures.simulate import draw_simulation
from camcli.artefacts.figures.sweep import draw_sweep

__all__ = ["draw_simulation", "draw_sweep"]
