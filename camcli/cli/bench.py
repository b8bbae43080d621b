"""cam bench"""

from typing import Annotated

from typer import Argument, Option

from camcli.cli.options import DRAWING, Request

WITHOUT = DRAWING  # shared options that mean nothing here


def bench(
    request: Request,
    part: Annotated[
        str | None, Argument(help="precision or stability. Default: both.", metavar="[PART]")
    ] = None,
    quick: Annotated[bool, Option("--quick", help="A subset within a minute.")] = False,
) -> int:
    """How exact, how robust and how fast: cam bench [precision|stability].

    \b
    precision.csv  case, method, setting, seconds, error, impacts, evaluations, missed, extra,
                   bound, of_bound, status: ours and general integrators on the same motions
    precision.png  error against time, a panel per case
    stability.csv  case, expected, observed, status, seconds: the table of extreme cases, run

    \b
    Every case of precision has its own machine, start and whole turns; the reference comes from a
    multiple-precision solution stored with the program, not from this kernel. seconds: median of
    bench.repeats calls, or of the first where it takes long. error: the largest of impact and
    accumulation phases (turns) and of the final state (q over the cam's lift, v over omega times
    it). missed, extra: impacts of the reference not found, and found but not there; the last 1e-3
    turn of a complete chatter is not asked of anybody. bound: what is promised for ours where the
    error is largest; of_bound: the largest share of any bound, beyond 1 a failure.
    Status: ok; over-bound (exit code 3); missed or invented (impacts); given-up (time or impacts
    used up); failed (the method stopped with an error); not-installed.
    Methods: core (over its chatter tolerance), rk45, dop853, lsoda, radau (scipy's solve_ivp with
    contact events over rtol = atol, without a step limit and with steps of at most 1/16 turn),
    heyoka (Taylor series with terminal events; extra `bench`), rk4 (fixed steps and bisection).
    All integrate the gap from corner to corner of the cam, stick, and close a chatter by its map.

    \b
    The machine of the scene is not used; section bench chooses cases, methods and repeats. Exit
    code 3 if a row of stability fails, or if an error of ours is beyond its bound.
    """
    from camcli.cli.bench_run import run

    return run(request, part, quick)
