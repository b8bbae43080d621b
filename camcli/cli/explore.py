"""cam explore"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from camcli.cli.exit_codes import note
from camcli.cli.options import DRAWING, VARY, Request, Values, flag, given, option, refuse_idle
from camcli.errors import Fault, SceneError, printable

if TYPE_CHECKING:
    from camcli.api.result import Result

WITHOUT = ("no_plot", "verbose", *DRAWING)  # shared options that mean nothing here


def explore(
    request: Request,
    with_: str | None = option("Also: basins (of basins.rpm), map.", "A,B"),
    vary: list[str] | None = VARY,
    open_: bool = flag("Open the page when it is written."),
) -> int:
    """A page for a browser on which the machine moves.

    Examples:
      cam explore --open                       the page, in a browser
      cam explore --rpm 340:400 --points 61 --with basins
      cam explore --with map --vary follower.restitution=0.6:0.9

    Files:
      explore.html     the page: one file, works offline

    \b
    explore.html  the cam and its follower in slow motion with the forces on it, time response,
                  contact force and phase plane of every motion, the bifurcation diagram to choose
                  it from, and stops that show what the machine does; one file, works offline

    \b
    The speeds are those of sweep.rpm (--rpm LO:HI, --points), at most 1000. The motions: of a
    sweep from the scene's start, of sweeps up and down where they end elsewhere, and the orbits
    solved over these speeds, stable and unstable. --with basins adds the basins at basins.rpm and
    the motions from a grid of starts in their window; --with map the map over the speeds and
    --vary KEY=LO:HI (a constant of the follower; --points N,M), or over two of them, and the
    motions at a grid of its points. Every motion is a cam simulate, whose command the page shows.
    A motion that a fault of camcli cost is left out: exit code 1, run.json has the traceback.
    """
    from camcli.cli.run import run

    asked = set(filter(None, (with_ or "").split(",")))
    if not asked <= {"basins", "map"}:
        cure = "e.g. --with basins,map"
        raise SceneError(Fault("--with", "", f"found '{with_}'", "expected basins or map", cure))
    mapped = "map" in asked or (vary and _maps(request))
    refuse_idle((vary and not mapped, "--vary", "without --with map", "add --with map"))
    values = _values(request, vary or [])
    values |= given("explore", "--with", basins="basins" in asked, map="map" in asked)
    values |= given("explore", "-c", source=source_of(request))
    done = run("explore", request, values, _show)
    path = (request.folder("explore") / "explore.html").resolve()
    if open_ and not request.dry_run and path.is_file():
        import webbrowser

        page = path.as_uri()
        if not webbrowser.open(page):
            note(f"no browser was found; open {page}")
    return done


def _maps(request: Request) -> bool:
    """Whether the scene itself asks for a map; one on stdin can be read only once."""
    from camcli.scene import load_scene

    if request.config is not None and str(request.config) == "-":
        return False
    return load_scene(request.config, request.sets or ()).explore.map


def _values(request: Request, vary: list[str]) -> Values:
    """The speeds, and what a map varies: --points N of the speeds, M of each other number."""
    from camcli.cli.run import ranges

    if not vary:
        return ranges(request, "sweep")
    count, _, more = (request.points or "").partition(",")
    others = replace(request, rpm=None, points=more or None)
    speeds = ranges(replace(request, points=count or None), "sweep")
    return speeds | ranges(others, "sweep", vary, most=2)


def source_of(request: Request) -> str:
    """The options that name the scene, as typed in a shell; bytes that are no text as escapes.

    A page is given away: of a file elsewhere on this machine its name stands in it, not its path.
    """
    from shlex import join

    words = [] if request.config is None else ["-c", printable(path_to_show(Path(request.config)))]
    for text in request.sets or ():
        words += ["--set", text]
    return join(words)


def path_to_show(file: Path) -> str:
    """A path as typed; of an absolute one what follows the working folder, or the name alone."""
    if not file.is_absolute():
        return str(file)
    here = Path.cwd()
    return str(file.relative_to(here)) if file.is_relative_to(here) else file.name


def _show(result: Result, _: bool) -> None:
    """Print how much the page shows."""
    from camcli.words.explore import page_line

    print(page_line(**result.summary, written=bool(result.files)))
