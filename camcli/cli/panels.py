"""Panels that are asked for: those that this run will draw, or a fault before it begins."""

from __future__ import annotations

from collections.abc import Sequence

from camcli.api.rows import has_seat
from camcli.cli.exit_codes import note
from camcli.cli.options import Request
from camcli.errors import Fault, SceneError
from camcli.quantities import SEAT
from camcli.scene import Scene
from camcli.scene.schema import PANELS, no_panel

CURES = {  # what makes a command draw what it does not draw in this run
    "motion": "leave --profile-only out",
    "profile": "add --profile-only",
    "diagram": "vary one number, not two",
    "map": "vary two numbers: --vary KEY=LO:HI twice",
    "branches": "give a range: --rpm LO:HI",
    "orbits": "give one speed: --rpm X",
    "curve": "add --curve KIND",
    "cover": "add --all N,M",
    "chaos": "add --chaos",
    "window": "ask for at most three speeds",
    "range": "ask for more than three speeds",
}
MOST_WINDOWS = 3  # speeds whose basins are drawn as windows


def check_panels(command: str, scene: Scene, request: Request) -> None:
    """Raise SceneError for panels of the command line that this run does not draw.

    The scene's own may be meant for another command: where none of them is drawn, a note says so.
    """
    panels = scene.plot.panels
    if panels is None or command not in PANELS or request.no_plot:
        return
    drawn: list[str] = []
    for picture in _drawn(command, scene):
        drawn += PANELS[command][picture]
    not_drawn = [name for name in panels if name not in drawn]
    option = _asked_by(request)
    if option is not None:
        if not_drawn:
            raise SceneError(*(_fault(option, command, name, drawn) for name in not_drawn))
        _refuse_lacking(option, command, scene, panels)
    if len(not_drawn) == len(panels) and not request.quiet:
        note(
            f"note: plot.panels of the scene names none that cam {command} draws here "
            f"({', '.join(drawn)}): the usual ones are drawn"
        )


def _asked_by(request: Request) -> str | None:
    """The option of the command line that names panels; None where the scene's file does."""
    if request.panels is not None:
        return "--panels"
    keys = [text.partition("=")[0].strip() for text in request.sets or ()]
    if "plot" in keys or "plot.panels" in keys:
        return "--set"
    return None


def _refuse_lacking(option: str, command: str, scene: Scene, panels: Sequence[str]) -> None:
    """Raise SceneError for panels that would be empty in this run.

    Either what they show is not measured, or they do not belong to this machine.
    """
    faced = scene.contact is not None and scene.contact.face is not None
    cures = _cures_of_lacking(command, scene, faced)
    faults = []
    for name in panels:
        if name in cures:
            found = f"found '{name}', not measured"
            faults.append(Fault(option, "plot.panels", found, "", cures[name]))
    if faults:
        raise SceneError(*faults)
    if "geometry" in panels and (faced or scene.cam.kind == "eccentric"):
        expected = "expected a cam under a tip that has no face of its own"
        fault = Fault(option, "plot.panels", "found 'geometry'", expected, "ask for outline")
        raise SceneError(fault)


def _cures_of_lacking(command: str, scene: Scene, faced: bool) -> dict[str, str]:
    """Panels of what is not measured in this run, and what to give so that it is.

    faced: the scene says what runs on the lobe.
    """
    cures = {}
    if command == "sweep" and not scene.sweep.lyapunov:
        cures["exponents"] = "add --lyapunov"
    if command == "sweep" and not has_seat(scene, [axis.key for axis in scene.sweep.vary]):
        cures |= dict.fromkeys(SEAT, "give cam.lash in m: without it there is no seat")
    if command == "simulate" and not faced:
        cures["radius"] = cures["angle"] = "give contact.face: knife, roller or flat"
    if command == "orbits" and not scene.orbits.prove:
        cures["attraction"] = "add --prove"
    if command == "detach":
        if scene.detach.hold_to is None:
            cures["springs"] = "add --hold-to RPM"
        if scene.spring is None or scene.spring.mass is None:
            cures["surge"] = "give spring.mass in kg"
        if not scene.detach.tolerance:
            cures["machines"] = cures["shares"] = "add --tolerance KEY=5%"
    return cures


def _fault(where: str, command: str, name: str, known: list[str]) -> Fault:
    """A panel that is not drawn: what would draw it, or the nearest one that is.

    where: the option that named it; known: the panels that this run draws.
    """
    found, expected, cure = no_panel(name, known)
    pictures = [picture for picture, panels in PANELS[command].items() if name in panels]
    if pictures:
        cure = CURES[pictures[0]]
    elif "did you mean" not in cure:
        commands = [
            other
            for other, pictures_of_other in PANELS.items()
            if any(name in panels for panels in pictures_of_other.values())
        ]
        cure = f"it is a panel of cam {commands[0]}"
    return Fault(where, "plot.panels", found, expected, cure)


def _drawn(command: str, scene: Scene) -> list[str]:
    """Which of the command's pictures this run draws."""
    if command == "simulate":
        return ["profile" if scene.simulate.profile_only else "motion"]
    if command == "sweep":
        return ["map" if len(scene.sweep.vary) == 2 else "diagram"]
    if command == "basins":
        return ["window" if scene.basins.count <= MOST_WINDOWS else "range"]
    if command == "orbits":
        section = scene.orbits
        over_speeds = not section.vary and section.parameter == "rpm"
        at_one_speed = over_speeds and section.rpm.start == section.rpm.stop
        all_orbits = section.all is not None
        drawn = ["orbits" if at_one_speed or all_orbits else "branches"]
        if all_orbits:
            drawn.append("cover")
        if section.chaos:
            drawn.append("chaos")
        if section.curve is not None and not all_orbits:
            drawn.append("curve")
        return drawn
    return list(PANELS[command])
