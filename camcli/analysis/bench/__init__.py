"""How exact, how robust and how fast: the checks and measurements behind `cam bench`."""
