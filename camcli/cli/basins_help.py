"""What `cam basins --help` says, and the options of this command alone."""

from typing import Annotated

import typer

BASINS_HELP = """Which attractor a start lands on: basins over a window of starts.

\b
attractors.csv  attractor, label, q_m, v_m_per_s, fraction, standard_error, rpm
basins.csv      q_m, v_m_per_s, attractor: a row per cell at its centre (one speed only); with
                refinement cells are of different sizes, those cut in four have no row
basins.png      basins with the attractors on them; over a range of speeds, their fractions

\b
The window holds starts (q, v) at the strobe phase, run.strobe_deg.
Codes of cells: 1, 2, ... the attractors; 0 undecided after basins.budget turns; -1 below the cam
(not computed); -2 impact-budget, -3 no-return, -4 unresolved: numerical trouble, exit code 3.
Attractors are found, not given: cells that end on no known one are looked at. A periodic one counts
once the orbit solver has it and it attracts; q_m, v_m_per_s is its state where its label begins.
An aperiodic one is told by recurrence over 32768 turns and listed with its lowest state; two that
visit a common box of the section are one. Slow transients are followed on or stay undecided;
where nothing dissipates all is undecided.

\b
Methods: orbit follows every cell until it meets an attractor: a whole period of it within the
ellipses about its points, with its impacts and shrinking (rings of starts are seen to come back
from there), or for aperiodic ones so many turns in its boxes that no trial did so and left again.
simple (Hsu's simple cell mapping) maps each centre by one turn and follows the graph of cells: some
times faster, wrong near boundaries; what leaves the window is followed as an orbit.
fraction is of the cells not below the cam; standard_error counts a cell beside a boundary as a
sample with the shares of its 3 x 3 cells, others as exact.
--refine N cuts cells at boundaries in four, N times; the picture has cells x 2^N.
--boundary measures how the share of starts in doubt falls with their error: f ~ error^alpha, the
boundary's dimension is 2 - alpha. Basin and boundary entropy are of boxes of 5 x 5 cells.
--rpm LO:HI gives fractions against speed; an attractor keeps its number while its state goes on
continuously, or while each started at the other's speed ends on the other.
--exponents appends multiplier_1_re, ..., lyapunov_per_period to attractors.csv: multipliers where
the orbit is solved, the largest exponent per turn everywhere (-inf where it rests).
The criterion of each attractor, with radius and checks, is in run.json.
"""

BASINS_OPTIONS = {
    name: (Annotated[kind | None, typer.Option(*words, help=text, metavar=metavar)], None)
    for name, kind, words, metavar, text in (
        ("cells", str, ("--cells",), "N or NQ,NV", "Cells along q and v."),
        ("q", str, ("--q",), "LO:HI", "Window of positions, m."),
        ("v", str, ("--v",), "LO:HI", "Window of velocities, m/s."),
        ("method", str, ("--method",), "NAME", "orbit, or simple (fast and approximate)."),
        ("refine", int, ("--refine",), "N", "Times that cells at boundaries are cut in four."),
    )
}
BASINS_OPTIONS["boundary"] = (
    Annotated[bool, typer.Option("--boundary", help="Measure the boundary's dimension.")],
    False,
)
BASINS_OPTIONS["exponents"] = (
    Annotated[bool, typer.Option("--exponents", help="Multipliers and exponents of attractors.")],
    False,
)
