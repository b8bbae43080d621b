"""Why a chaotic attractor changes size at once, or is lost, between two speeds.

Tried are a corner first reached, a new contact, and a crisis (Grebogi, Ott & Yorke, Physica D 7
(1983) 181): the attractor, closure of the unstable manifold W^u of an orbit B in it, meets the
stable manifold W^s of a saddle p one side of which leads out. With t along W^u(B), x_n the state
n turns on and eta across W^s, min over t of eta(x_n(t; rpm)) = 0 is solved for rpm, n so large that
W^s is straight at x_n; the minimum is a fold, smooth or the image of an impact at a corner.

The chapter's machine: 740.1065 rpm, P(7;1:1:1:1:1:1:1) of multiplier 12.6, corner c; 361.1673,
P(3;3:3:2), 35.9, smooth; 682.2047, P(1;1) on A1, 1.176, corner b, chaos is lost; runs of 3 or 4
million turns agree.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from camcli.analysis.explain.crisis import words
from camcli.analysis.explain.crisis.approach import Approach, Fact, approach
from camcli.analysis.explain.crisis.meeting import Contact, contact, corner_of, fold_beside, kind_of
from camcli.analysis.explain.crisis.runs import STAYS, Carried
from camcli.analysis.integrate import Settings
from camcli.analysis.orbits.orbit import PeriodicOrbit
from camcli.system import System

UNEXPLAINED = "unexplained"
TURNS = 200_000  # of each run, unless told otherwise
ENDS = ("lower", "upper")


@dataclass(frozen=True)
class Crisis:
    """The cause found, or `unexplained`, at rpm +- error.

    kind: interior-crisis, boundary-crisis, corner-impact, grazing or unexplained; error: rpm, of a
    crisis an estimate of how much earlier a fold that was not sampled may touch (`tangency.width`),
    otherwise the distance to the runs, inf where nothing happens; bracket: rpm, the last run that
    stays and the first that leaves; orbit: the saddle met; corner, phase (rad): reached first, or
    whose image touches W^s; evidence: measured farther before and nearer to (or after) the change.
    """

    kind: str
    rpm: float
    error: float
    bracket: tuple[float, float]
    orbit: PeriodicOrbit | None = None
    corner: str = ""
    phase: float | None = None
    evidence: tuple[Fact, ...] = ()
    words: tuple[str, ...] = ()
    stays: bool = False  # the chaotic attractor lives on at both speeds


def find_crisis(
    system: System,
    settings: Settings,
    low: float,
    high: float,
    end: str = "lower",
    turns: int = TURNS,
) -> Crisis:
    """The crisis between two speeds (rpm) of the attractor carried from the `end` named.

    That end is the side on which the attractor is the smaller one, or exists at all: the start of
    the scene settles on it there. Unexplained, and said so, where it is not chaotic or where no run
    of `turns` turns leaves its range. Raises ValueError for another end, StartError for a start
    below the cam.
    """
    if end not in ENDS:
        raise ValueError(f"found end {end!r}, expected one of {', '.join(ENDS)}")
    near, far = (low, high) if end == "lower" else (high, low)
    carried = Carried(system, settings, near, far, turns)
    nothing = carried.narrow()
    if nothing:
        stays = nothing.startswith(STAYS)
        return Crisis(UNEXPLAINED, far, inf, carried.bracket, words=(nothing,), stays=stays)
    reached, met = approach(carried), contact(carried)
    if met.first is None:
        return _without_saddle(carried, reached, met)
    return _with_saddle(carried, reached, met)


def _without_saddle(carried: Carried, reached: Approach, met: Contact) -> Crisis:
    """What is reached first, if anything: no saddle is met."""
    error = max(abs(reached.rpm - rpm) for rpm in carried.bracket)
    said = [words.seen_in_runs(carried), *words.approach_said(reached, True)]
    said += [*words.saddles_seen(met), *words.contact_said(met, None)]
    corner = reached.corner
    return Crisis(
        reached.kind or UNEXPLAINED, reached.rpm, error, carried.bracket, None,
        corner.name if corner else "", corner.theta if corner else None,
        reached.facts, tuple(said),
    )  # fmt: skip


def _with_saddle(carried: Carried, reached: Approach, met: Contact) -> Crisis:
    """The crisis at the saddle met first."""
    first = met.first
    at = first.tangency
    _, saddle = first.folds.at(at.rpm)
    corner = corner_of(first)
    said = [words.seen_in_runs(carried), *words.saddles_seen(met)]
    said += words.contact_said(met, saddle.orbit)
    said += [words.fold_said(corner), *words.approach_said(reached, False)]
    facts = (
        Fact("eta of the fold beside the speed solved, relative", *fold_beside(first)),
        Fact("saddles seen", met.inside, met.beyond),
        *reached.facts,
    )
    return Crisis(
        kind_of(first, saddle), at.rpm, at.error, carried.bracket, saddle.orbit,
        corner.name if corner else "", corner.theta if corner else None, facts, tuple(said),
    )  # fmt: skip
