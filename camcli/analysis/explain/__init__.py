"""Why a bifurcation diagram changes where it does: every change with a solved cause."""
