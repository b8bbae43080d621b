"""What `cam classify --help` says, and the options of this command alone."""

from typing import Annotated

import typer

CLASSIFY_HELP = """Name the motion at each speed, measure its exponents, explain where it changes.

\b
classify.csv  rpm, label, period, impacts, chatter, stable, lyapunov_per_period, status
corners.csv   corner impacts of the solved branches (--explain), columns as bifurcations.csv
classify.png  labels and largest exponent against speed

\b
period: turns, 0 where the motion does not repeat. impacts: in one period, inf with a complete
chatter; of an aperiodic motion the mean per turn. chatter: complete, incomplete (8 impacts in a
row, each weaker, that do not accumulate) or none. stable: 1, 0, empty where no orbit is solved.
lyapunov_per_period: largest exponent per turn of the cam; -inf where the follower rests: both are
then, since every difference is forgotten. run.json has the second one, the error bar, and the sum
rule (sum = 2 ln r impacts per turn - b T/m) as a check.

\b
Labels: P(m;s1:...:sm) where Newton's iteration from the end of the record converges to an
admissible, attracting orbit of up to 64 turns that the record approaches; contact; aperiodic where
none does and the largest exponent is positive by three standard errors; undecided where neither can
be shown, or where a cycle through a rest is an accident of rounding.
--starts N classifies N more starts at each speed (Halton points, --seed): a row per attractor.

\b
--explain walks the range, follows every attracting orbit found, and gives each change its cause,
solved: period-doubling, fold, corner-impact (with its border-collision class), grazing,
accumulation-at-corner, corner-hit, chatter-completion, first-detachment, interior-crisis,
boundary-crisis, basin (both attractors live on, the start changes basins), itinerary (impacts of a
resting orbit change), or unexplained with what was tried.
--trace L,R --det L,R needs no machine: it names the border collision of two linear maps.
"""

CLASSIFY_OPTIONS = {
    "starts": (
        Annotated[
            int | None, typer.Option("--starts", help="Further starts at each speed.", metavar="N")
        ],
        None,
    ),
    "seed": (
        Annotated[int | None, typer.Option("--seed", help="Another cloud of starts.", metavar="N")],
        None,
    ),
    "explain": (
        Annotated[bool, typer.Option("--explain", help="Find the cause of every change.")],
        False,
    ),
    "trace": (
        Annotated[
            str | None, typer.Option("--trace", help="Traces of two linear maps.", metavar="L,R")
        ],
        None,
    ),
    "det": (
        Annotated[str | None, typer.Option("--det", help="Their determinants.", metavar="L,R")],
        None,
    ),
}
