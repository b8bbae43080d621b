"""cam explore"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from typer import Option

from camcli.cli.options import Request

if TYPE_CHECKING:
    from camcli.api.result import Result


def explore(
    request: Request,
    with_: Annotated[
        str | None, Option("--with", help="Also: basins (of basins.rpm).", metavar="WHAT")
    ] = None,
) -> int:
    """One page for a browser on which the machine moves, for every speed of a range.

    \b
    explore.html  the cam and its follower in slow motion, time response, contact force and phase
                  plane of every motion, and the bifurcation diagram to choose it from; one file,
                  works offline

    \b
    The speeds are those of sweep.rpm (--rpm LO:HI, --points), at most 1000. The motions: of a
    sweep from the scene's start, of sweeps up and down where they end elsewhere, and the orbits
    solved over these speeds, stable and unstable. --with basins adds the basins at basins.rpm and
    the motions from a grid of starts in their window. Every motion is a cam simulate, whose
    command the page shows.
    """
    from camcli.cli.run import ranges, run
    from camcli.errors import Fault, SceneError

    if with_ not in (None, "basins"):
        raise SceneError(Fault("--with", "", f"found '{with_}'", "expected basins", ""))
    options = {"with_basins": with_ == "basins", "source": _source(request)}
    return run("explore", request, ranges(request, "sweep"), _show, options=options)


def _source(request: Request) -> str:
    """The options that name the scene, as typed in a shell."""
    from shlex import join

    words = [] if request.config is None else ["-c", str(request.config)]
    for text in request.sets or ():
        words += ["--set", text]
    return join(words)


def _show(result: Result) -> None:
    found = result.summary
    print(
        f"{found['motions']} motions at {found['speeds']} speeds, "
        f"{found['bifurcations']} bifurcations of solved branches; open explore.html in a browser"
    )
