"""The chapter's machine for the package and for the oracle, and comparisons between the two."""

from functools import cache
from math import pi

from camcli.analysis.integrate import Orbit
from camcli.cams.arcs import ArcsCam
from camcli.cams.compile import phase_of
from camcli.system import Follower, System
from tests.conftest import settings
from tests.support import oracle

CLOSED = 0.85 - 0.45  # exact in doubles: package and oracle then have the same circles
GEOMETRY = {
    "base_radius": CLOSED,
    "flank_center": 0.45,
    "flank_radius": 0.85,
    "nose_center": 0.40393320723821,
    "nose_radius": 0.15,
    "top_dwell_deg": 40.0,
    "offset": 0.3,
}
CHAPTER = {"mass": 1.221, "stiffness": 146 * 9.8, "restitution": 0.8}
ORACLE_CAM = oracle.ArcsCam()
KINDS = {1: "impact", 2: "chatter", 3: "detachment"}
MEANINGLESS = 1e9  # stretching above which doubles cannot follow


@cache
def machine(strobe_deg):
    """The chapter's machine."""
    return System.build(Follower(**CHAPTER), ArcsCam(kind="arcs", **GEOMETRY), phase_of(strobe_deg))


def cam(strobe_deg=0.0):
    """The table of the chapter's cam."""
    return machine(strobe_deg).cam


def system(strobe_deg=0.0, **changes):
    """The chapter's follower on the chapter's cam, some constants changed."""
    return machine(strobe_deg).with_follower(**changes)


def run(rpm, machine=None, record=3, transient=0, tolerance=1e-9, budget=1_000_000, **start):
    """The record of one orbit."""
    wanted = settings(transient, record, tolerance, budget, **start)
    return Orbit(machine or system(), rpm, wanted).run()


def events(tape, first=0):
    """(kind, turn, theta, q, u) of every logged event; `first`: 1 for a start off the strobe."""
    columns = zip(tape.kind, tape.period, tape.theta, tape.q, tape.u, strict=True)
    return [
        (KINDS[int(k)], int(p) + first, float(t), float(q), float(u)) for k, p, t, q, u in columns
    ]


def reference(rpm, *, impacts=20, turns=None, cut=None, start=None, **changes):
    """Events of the oracle for the same machine; `start` as for `Oracle.run`."""
    reference = oracle.Oracle(ORACLE_CAM, rpm=rpm, **{**CHAPTER, **changes})
    return reference.run(impacts=impacts, turns=turns, chatter_cut=cut, **(start or {}))


def worst_phase_error(ours, theirs):
    """(largest phase error in turns over the event's stretching, events compared)."""
    worst, compared = 0.0, 0
    for (kind, turn, theta, _, _), event in zip(ours, theirs, strict=False):
        assert kind == event.kind, (compared, kind, event)
        if event.stretching > MEANINGLESS:
            break
        error = abs(theta - event.theta + 2 * pi * (turn - event.turn)) / (2 * pi)
        worst = max(worst, float(error / event.stretching))
        compared += 1
    return worst, compared
