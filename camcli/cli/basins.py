"""cam basins"""

from __future__ import annotations

from typing import TYPE_CHECKING

from camcli.cli.options import CLUSTER, SHARD, VARY, Request, flag, given, numbers, option
from camcli.cli.report import MORE, table
from camcli.errors import Fault, SceneError, shown
from camcli.quantities import Q, V

if TYPE_CHECKING:
    from camcli.analysis.basins.study import Study
    from camcli.api.result import Result


def basins(
    request: Request,
    cells: str | None = option("Cells along q and v.", "N or NQ,NV"),
    q: str | None = option("Window of positions, m.", "LO:HI"),
    v: str | None = option("Window of velocities, m/s.", "LO:HI"),
    refine: int | None = option("Times that cells at boundaries are cut in four.", "N"),
    boundary: bool = flag("Measure the boundary's dimension."),
    exponents: bool = flag("Multipliers and exponents of attractors."),
    vary: list[str] | None = VARY,
    saddles: bool = flag("Saddles on the boundaries."),
    shard: str | None = SHARD,
    cluster: str | None = CLUSTER,
) -> int:
    """Which attractor a start lands on, over a window of starts.

    Examples:
      cam basins --rpm 358.5 --cells 256 --refine 4     a fine picture
      cam basins --rpm 358:359 --points 3 --saddles     side by side
      cam basins --rpm 340:400 --points 31 --cells 60   shares against speed

    Files:
      attractors.csv   the motions found, their shares and standard errors
      basins.csv       a row for each cell: where its centre ends
      saddles.csv      saddles on the boundaries (--saddles)
      basins.png       the window in the colours of the motions

    \b
    basins.png      basins with the attractors on them; over more speeds, their fractions

    \b
    The window holds starts (q, v) at the strobe phase, run.strobe_deg.
    Codes of cells: 1, 2, ... the attractors; 0 undecided after basins.budget turns; -1 below the
    cam (not computed); -2 impact-budget, -3 no-return, -4 unresolved: numerical trouble, exit
    code 3; -7 fault: a fault of camcli cost this block of cells, or this speed, alone, exit code 1,
    run.json has the traceback (piece_faults). Attractors are found, not given: cells that end on
    no known one are looked at. A periodic one counts once the orbit solver has it and it attracts;
    q_m, v_m_per_s is its state where its label begins. An aperiodic one is told by recurrence over
    32768 turns and listed with its lowest state; two that visit a common box of the section are
    one. Slow transients are followed on or stay undecided; where nothing dissipates all is
    undecided.

    \b
    Every cell is followed until it meets an attractor: a whole period of it within the ellipses
    about its points, with its impacts and shrinking (rings of starts are seen to come back).
    fraction is of the cells not below the cam; standard_error counts a cell beside a boundary as a
    sample with the shares of its 3 x 3 cells, others as exact.
    --refine N cuts cells at boundaries in four, N times; the picture has cells x 2^N.
    --boundary measures how the share of starts in doubt falls with their error: f ~ error^alpha,
    the boundary's dimension is 2 - alpha. Basin and boundary entropy are of boxes of 5 x 5 cells.
    --rpm LO:HI gives fractions against speed; an attractor keeps its number while its state goes
    on continuously, or while each started at the other's speed ends on the other.
    --vary KEY=LO:HI varies any number of follower, cam or run at the speed --rpm.
    --exponents appends multiplier_1_re, ..., lyapunov_per_period to attractors.csv: multipliers
    where the orbit is solved, the largest exponent per turn everywhere (-inf where it rests).
    --saddles brings starts on either side of a boundary together; the motion between them is led to
    a saddle, whose stable manifold the boundary is: led of the motions tried.
    The criterion of each attractor, with radius and checks, is in run.json.
    """
    from camcli.cli.run import ranges, run

    values = ranges(request, "basins", vary)
    low_high = "two numbers LO:HI"
    window = {
        "q": numbers(q, "--q", low_high, "0.1:0.9"),
        "v": numbers(v, "--v", low_high, "-20:40"),
    }
    values |= given("basins", cells=_cells(cells), **window, refine=refine)
    values |= given("basins", boundary=boundary, exponents=exponents, saddles=saddles)
    return run("basins", request, values, show, shard=shard, cluster=cluster)


def _cells(text: str | None) -> list[int] | None:
    """The cells along q and v, of a text N, NQ,NV or NQxNV; the scene says how many may be."""
    if text is None:
        return None
    words = text.replace("x", ",").split(",")
    if len(words) > 2 or not all(word.strip().isdecimal() for word in words):
        expected = "expected N or NQ,NV, whole numbers"
        raise SceneError(Fault("--cells", "", f"found '{text}'", expected, "e.g. 400,300"))
    return [int(words[0]), int(words[-1])]


def show(result: Result, verbose: bool) -> None:
    """The table of attractors, and for one speed what else the grid says."""
    from camcli.analysis.sweep import status_name
    from camcli.system import omega_of
    from camcli.words.basins import LONGEST_LABEL, fraction_text, grid_lines, grid_title

    found, _ = result.values
    if len(found.speeds) > 1:
        _show_range(found, result.scene.basins.key, result.scene.cam.kind)
        return
    (speed,) = found.speeds
    rows = []
    for k, (attractor, number) in enumerate(zip(speed.attractors, speed.branches, strict=True)):
        q, w = attractor.states[0]  # position, m, and rate, m/rad, at the strobe
        fraction, error = speed.fractions[k + 1]
        rows.append(
            [
                shown(attractor.label, LONGEST_LABEL),
                str(number),
                f"{q:.9g}",
                f"{w * omega_of(speed.rpm):.9g}",
                fraction_text(fraction, error),
            ]
        )
    for code, (fraction, error) in speed.fractions.items():
        if code <= 0:  # cells that belong to no attractor
            name = status_name(-code) if code else "undecided"
            rows.append([name, str(code), "", "", fraction_text(fraction, error)])
    table(
        grid_title(speed, result.scene.cam.kind),
        ["attractor", "no.", Q.heading, V.heading, "fraction"],
        rows,
    )
    for line in grid_lines(speed, verbose):
        print(line)
    if not verbose:
        print(MORE)


def _show_range(found: Study, key: str, kind: str) -> None:
    """Print, of several speeds, the attractors of each with their shares; kind: of the cam."""
    from camcli.words.basins import grids_title, share_words

    rows = []
    for speed in found.speeds:
        shares = []
        for k, attractor in enumerate(speed.attractors):
            fraction, _ = speed.fractions[k + 1]
            shares.append(share_words(speed.branches[k], attractor.label, fraction))
        rows.append([f"{speed.value:.10g}", ", ".join(shares), str(speed.undecided)])
    columns = [key, "attractors and their fractions", "undecided cells"]
    table(grids_title(found, key, kind), columns, rows, "attractors.csv")
