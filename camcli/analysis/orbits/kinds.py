"""What can happen to a periodic orbit as a parameter varies, and how sure its place is."""

from enum import StrEnum


class Kind(StrEnum):
    """An event on a branch, or what ends a branch or a curve; its name stands in every table."""

    PERIOD_DOUBLING = "period-doubling"
    FOLD = "fold"
    CORNER_IMPACT = "corner-impact"
    GRAZING = "grazing"
    # of orbits that rest on the cam
    CHATTER_COMPLETION = "chatter-completion"
    DETACHMENT = "detachment"
    DEPARTURE = "departure"
    ITINERARY = "itinerary"
    # ends that are no events
    END_OF_RANGE = "end-of-range"
    NO_MACHINE = "no-machine"  # beyond it the number makes no cam, or one with other parts
    CLOSED = "closed"
    LOST = "lost"
    WORK_BUDGET = "work-budget"  # see integrate.Budget
    FAULT = "fault"  # an exception that nobody foresaw, see piece_faults
    # ends of a curve in two parameters
    ANOTHER_CORNER = "another-corner"  # an impact reaches a corner
    NO_MOTION = "no-motion"
    SHORTER_ORBIT = "shorter-orbit"  # the orbit becomes one of fewer turns


class Bracket(StrEnum):
    """Whether the test function of an event differs in sign at the ends of its bracket."""

    OK = "ok"
    UNRESOLVED = "unresolved"
