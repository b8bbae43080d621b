"""The load columns of a record from its events alone, by dense samples of flights and rests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import nan
from typing import NamedTuple

import numpy as np

from tests.support.mechanics import RAD, TURN, Flight, Machine

SHUT, BOUNCE = 0.01, 0.1  # of the lift, of the hardest impact: what the columns count
EVENT = ("event", "period", "theta_deg", "u_minus_m_per_s", "u_plus_m_per_s")
ON_CAM = 1e-12  # of the lift: nearer to the cam the follower is on it, unless it lands next


class Rest(NamedTuple):
    """A rest of `span` rad from theta (rad)."""

    theta: float
    span: float


def segments(
    machine: Machine, events: Mapping, q: float, v: float, turns: int
) -> Iterator[tuple[Rest | Flight, str]]:
    """Rests and flights of `turns` turns from (q, v) at the first strobe; what each begins with.

    events: columns of events.csv. A rest ends with a detachment, or with an impact on an upward
    kink; it begins with a chatter, or with an impact after which nothing bounces.
    """
    rows = zip(*(events[x].tolist() for x in EVENT), strict=True)
    inside = [row for row in rows if 0 <= row[1] < turns]
    (c,), (c1,), _ = machine.cam(machine.strobe)
    place, theta, gap, u, begin = 0.0, machine.strobe, q - c, v - c1, "strobe"
    size = np.diff(machine.lift.range)[0]
    rests = abs(gap) < ON_CAM * size and abs(u) < ON_CAM * size * machine.omega
    for event, period, degrees, _, after in inside:
        at = TURN * period + (degrees * RAD - machine.strobe) % TURN
        rest = event == "detachment" or (rests and event == "impact")
        yield (Rest(theta, at - place) if rest else Flight(theta, at - place, gap, u)), begin
        place, theta, gap, u, begin = at, degrees * RAD, 0.0, 0.0, event
        if event == "impact":
            u = after
        elif event == "detachment":  # thrown off at a downward kink, or let go
            slopes = machine.cam(theta, -1)[1, 0], machine.cam(theta, 1)[1, 0]
            u = max(slopes[0] - slopes[1], 0.0) if machine.is_edge(theta) else 0.0
        rests = event == "chatter" or (event == "impact" and u == 0.0 < machine.force(theta)[0])
    last = theta, TURN * turns - place
    yield (Rest(*last) if rests else Flight(*last, gap, u)), begin


def loads(machine: Machine, events: Mapping, q: float, v: float, turns: int) -> dict[str, float]:
    """The columns of loads of a motion, from its events; NaN where one does not apply.

    q (m), v (m/s): the state where the record of `turns` begins.
    """
    parts = list(segments(machine, events, q, v, turns))
    flights = [part for part, _ in parts if isinstance(part, Flight)]
    rests = {Rest(part.theta, min(part.span, TURN)) for part, _ in parts if isinstance(part, Rest)}
    sampled = [machine.gap_of(flight)(samples(flight.span)).max() for flight in flights]
    order = np.argsort(sampled)[::-1][:6]  # samples may take one of equals for the highest
    near = [flights[k] for k in order if sampled[k] >= sampled[order[0]] * (1.0 - 1e-4)]
    forces = [
        machine.extreme_force(rest.theta, rest.theta + rest.span, sign)[0]
        for rest in rests
        for sign in (-1, 1)
        if rest.span > 1e-9
    ]
    own = (events["period"] >= 0) & (events["period"] < turns)
    hits = own & (events["event"] == "impact")
    theta, speed = events["theta_deg"][hits], -events["u_minus_m_per_s"][hits]
    low, top = machine.lift.range
    lifts = machine.lift.at(theta * RAD)[0] - low
    hardest = int(speed.argmax()) if len(speed) else None
    lost, regained = [], []  # rad after the strobe
    before = None
    for part, begin in parts:
        since = (part.theta - machine.strobe) % TURN
        if isinstance(before, Rest) and begin in ("detachment", "impact"):
            lost.append(since)
        if isinstance(part, Rest) and begin in ("chatter", "impact"):
            regained.append(since)
        before = part
    return {
        "max_gap_m": max((machine.highest_gap(flight) for flight in near), default=0.0),
        "airborne_fraction": sum(f.span for f in flights) / (TURN * turns),
        "max_impact_m_per_s": speed.max(initial=0.0),
        "min_contact_force_n": max(min(forces), 0.0) if forces else nan,
        "max_contact_force_n": max(forces) if forces else nan,
        "contact_lost_deg": machine.phase_deg(min(lost)) if lost else nan,
        "contact_regained_deg": machine.phase_deg(max(regained)) if regained else nan,
        "landing_deg": nan if hardest is None else theta[hardest],
        "landing_lift_m": nan if hardest is None else lifts[hardest],
        "shut_bounces_per_turn": np.sum(
            (lifts <= SHUT * (top - low)) & (speed >= BOUNCE * speed.max(initial=0.0))
        ) / turns,
    }  # fmt: skip


def samples(span: float) -> np.ndarray:
    """Places of a flight that show which of several is the highest."""
    return np.linspace(0.0, span, 400 + int(200 * span))
