"""The pictures. Matplotlib is imported in this folder only: import it where a picture is due."""

from camcli.plots.simulate import draw_simulation
from camcli.plots.sweep import draw_sweep

__all__ = ["draw_simulation", "draw_sweep"]
