"""What is shown of the gap of a flight, and what is refused: gaps that are given polynomials.

The cam has stretches up to 1, 2, 3 and 4 rad. On each of those that the flight passes its gap is a
polynomial of s, the angle of flight, whose zeros are known.
"""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from flint import arb, arb_poly

from camcli.cams.balls import UndecidedError
from camcli.exact.machine import Place
from camcli.exact.shooting import FlightToShow, NotProvedError, ProofStep

ENDS = (1.0, 2.0, 3.0, 4.0)
S = arb_poly([0, 1])
FREE, REFUTED, UNDECIDED = "free", "refuted", "undecided"


class Flight:
    """The first flight of an orbit of two impacts, from theta to theta + length."""

    n = 2
    stretches = tuple(SimpleNamespace(end=arb(end)) for end in ENDS)

    def __init__(self, theta: float, length: float, start: int, last: int, gaps: dict):
        self.hull = [arb(theta), arb(1), arb(theta + length), arb(1), arb(700)]
        self.length = arb(length)
        self.places = [Place(start, 0), Place(last, 0)]
        self.gaps = dict.fromkeys(range(len(ENDS)), S * (self.length - S)) | gaps

    def span(self, hull, k):
        return self.length

    def landing(self, k):
        return self.places[1]

    def gap(self, machine, hull, k, place):
        value = self.gaps[place.stretch]
        slope = value.derivative()
        return lambda s: [value(arb(s)), slope(arb(s)), slope.derivative()(arb(s))]

    def place(self, theta, turn, machine):
        return Place(next(k for k, end in enumerate(ENDS) if theta < end), turn)

    def shown(self, touch=None, fading=None) -> str:
        flight = FlightToShow(self, self, self.hull, 0, fading)
        try:
            flight.stays_off_the_cam(touch)
        except UndecidedError:
            return UNDECIDED
        except NotProvedError as refusal:
            is_contact = refusal.refuted and refusal.step is ProofStep.CONTACT
            return REFUTED if is_contact else repr(refusal)
        return FREE


def dip(low, high):
    """Negative between two places."""
    return (S - arb(low)) * (S - arb(high))


END = 2.0 - S  # zero at the end of a flight of 2 rad


@pytest.mark.parametrize(
    ("gaps", "said"),
    [  # from 0.5 to 2.5 rad: 0.5 rad on the first stretch, 1 on the second, 0.5 on the third
        ({}, FREE),
        ({0: S * dip(0.25, 0.3)}, REFUTED),
        ({0: S * dip(0.49, 0.51)}, REFUTED),
        ({0: S * dip(0.51, 0.6)}, FREE),  # beyond the stretch
        ({0: S * dip(0.001, 0.0011)}, REFUTED),
        ({0: -S * END}, UNDECIDED),
        ({1: dip(0.6, 0.61)}, REFUTED),
        ({1: dip(0.501, 0.51)}, REFUTED),
        ({1: dip(0.4, 0.49)}, FREE),
        ({1: dip(1.4, 1.6)}, REFUTED),
        ({1: dip(1.51, 1.6)}, FREE),
        ({1: dip(0.9, 0.9) + 1e-6}, FREE),
        ({1: dip(0.9, 0.9)}, UNDECIDED),
        ({2: END * dip(1.7, 1.8)}, REFUTED),
        ({2: END * dip(1.501, 1.51)}, REFUTED),
        ({2: END * dip(1.3, 1.49)}, FREE),
        ({2: END * dip(1.99, 1.999)}, REFUTED),
        ({2: -S * END}, UNDECIDED),
        ({3: dip(0.5, 2.0)}, FREE),  # a stretch that the flight does not pass
    ],
)
def test_a_flight_meets_the_cam_only_on_a_stretch_that_it_passes(gaps, said):
    assert Flight(0.5, 2.0, 0, 2, gaps).shown() == said


@pytest.mark.parametrize(
    ("gaps", "said"),
    [({}, FREE), ({0: -S}, UNDECIDED), ({1: -S}, UNDECIDED), ({1: S * dip(0.3, 0.4)}, REFUTED),
     ({0: S * dip(0.3, 0.4)}, FREE)],
)  # fmt: skip
def test_a_flight_from_between_two_stretches_rises_off_both(gaps, said):
    """It starts where the first one ends, so that its gap to that one matters at its start only."""
    assert Flight(1.0, 1.5, 0, 2, gaps).shown() == said


@pytest.mark.parametrize(
    ("gaps", "said"),
    [({}, FREE), ({2: S - 1.5}, UNDECIDED), ({1: 1.5 * S * S}, UNDECIDED),
     ({2: (1.5 - S) * (1.5 - S)}, UNDECIDED),
     ({1: (1.5 - S) * dip(0.9, 1.0)}, REFUTED), ({2: (1.5 - S) * dip(0.9, 1.0)}, FREE),
     ({1: (1.5 - S) * dip(1.49, 1.499)}, REFUTED)],
)  # fmt: skip
def test_a_flight_onto_the_start_of_a_stretch_falls_to_both(gaps, said):
    """From 0.5 to 2 rad, where the third stretch starts."""
    assert Flight(0.5, 1.5, 0, 2, gaps).shown() == said


@pytest.mark.parametrize(
    ("gap", "said"),
    [
        (dip(1.0, 1.0), FREE),
        (dip(1.0, 1.0) * dip(0.7, 0.75), REFUTED),
        (dip(1.0, 1.0) * dip(1.3, 1.35), REFUTED),
        (dip(1.0, 1.0) * dip(0.95, 0.96), REFUTED),
        (-dip(1.0, 1.0), UNDECIDED),
    ],
)
def test_a_touch_is_passed_over_where_the_gap_is_convex(gap, said):
    """At 1 rad, on the second stretch; none of these flights is free without the touch."""
    flight = Flight(0.5, 2.0, 0, 2, {1: gap})
    assert flight.shown(touch=arb(1.0, 1e-12)) == said
    assert flight.shown() != FREE


@pytest.mark.parametrize(
    ("fading", "stretch", "gap", "said"),
    [
        (0, 0, S * S, FREE),
        (0, 0, -S * S, UNDECIDED),
        (0, 0, S * S * dip(0.25, 0.3), REFUTED),
        (1, 0, S * S, UNDECIDED),
        (None, 0, S * S, UNDECIDED),
        (1, 2, END * END, FREE),
        (1, 2, -END * END, UNDECIDED),
        (1, 2, END * END * dip(1.7, 1.8), REFUTED),
        (0, 2, END * END, UNDECIDED),
        (None, 2, END * END, UNDECIDED),
    ],
)
def test_without_a_rate_the_gap_of_a_flight_is_convex(fading, stretch, gap, said):
    """The first impact, at the flight's start, or the second one fades. The other has its rate."""
    gaps = {0: S * END * END + S, 2: END * (1.0 + S)} | {stretch: gap}
    if fading == 0 and stretch != 0:
        gaps[0] = S * S
    if fading == 1 and stretch != 2:
        gaps[2] = END * END
    assert Flight(0.5, 2.0, 0, 2, gaps).shown(fading=fading) == said
