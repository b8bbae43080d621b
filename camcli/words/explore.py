"""What the page of `cam explore` says beside its pictures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from camcli.analysis.labels import APERIODIC, CONTACT
from camcli.errors import plural
from camcli.quantities import Q, V, labelled
from camcli.words.in_print import label_text

if TYPE_CHECKING:
    from camcli.scene import Scene
    from camcli.system import System

BASINS, MAP = "Basins of attraction", "Map of motions"
BASIN_AXES = [
    labelled("position q at the strobe", Q.unit),
    labelled("velocity v at the strobe", V.unit),
]
NO_MOTION = "no whole turn of any motion was recorded: there is no page to show"


IN_CONTACT, CHATTER, CHAOS, TWO_MOTIONS = "Contact", "Chatter", "Chaos", "Two motions"
DOUBLING = "Period doubling"
LARGEST_VALVE = 0.03  # m, lift of a valve at most


def is_valve(scene: Scene, system: System) -> bool:
    """Whether a machine is told in the words of engines: a preloaded spring, a lift of some mm."""
    lifts = [stretch.start_c for stretch in system.cam.stretches]
    small = max(lifts) - min(lifts) < LARGEST_VALVE
    return small and scene.follower.preload > 0.0 and scene.follower.stiffness > 0.0


def angle(degrees: float) -> str:
    """An angle of the cam that has no letter."""
    return f"{degrees:.4g}°"


def lift_off(place: str) -> str:
    """The name of a stop at which contact is lost; place: a corner's letter or an angle."""
    return f"Lift-off at {place}"


def corner_impact(corner: str) -> str:
    """The name of a stop with an impact on a corner."""
    return f"Impact at corner {corner}"


def _called(label: str) -> str:
    """A motion in a sentence."""
    plain = {APERIODIC: "chaos", CONTACT: "always on the cam"}
    return plain.get(label, label_text(label))


@dataclass(frozen=True)
class Machine:
    """What a machine does, one sentence each: stops of the page."""

    follower: str
    pull: str  # what holds it on the cam
    restitution: float
    valve: bool

    @classmethod
    def of(cls, scene: Scene, system: System) -> Machine:
        """The machine of a scene."""
        valve = is_valve(scene, system)
        f = scene.follower
        pull = "the spring" if f.stiffness > 0.0 else "its weight"
        return cls("valve train" if valve else "follower", pull, f.restitution, valve)

    def contact(self, rpm: float) -> str:
        """A motion that never leaves the cam."""
        return (
            f"At {rpm:.4g} rpm {self.pull} keeps the {self.follower} on the cam all the way round: "
            "the push of the contact never comes to an end."
        )

    def lift_off(self, rpm: float, first: float, place: str) -> str:
        """A motion that leaves the cam; first: the speed at which contact is first lost."""
        leaves = f"the {self.follower} leaves it at {place}"
        if self.valve:
            leaves = f"the valve floats from {place} on"
        return (
            f"Above {first:.6g} rpm the cam turns away faster than {self.pull} can push: at "
            f"{rpm:.4g} rpm {leaves}; the contact arrow goes."
        )

    def chatter(self, rpm: float) -> str:
        """A motion with a complete chatter."""
        bounce = " (valve bounce)" if self.valve else ""
        return (
            f"At {rpm:.4g} rpm the {self.follower} lands and bounces{bounce}, each time "
            f"{self.restitution:g} times as fast: infinitely often in a finite time, then it rests."
        )

    def corner_impact(self, rpm: float, label: str, corner: str) -> str:
        """An orbit whose impact falls on a corner of the cam."""
        return (
            f"At {rpm:.7g} rpm the impact of {label_text(label)} falls on corner {corner}, where "
            "the cam's curvature jumps: there the motion changes at once, not little by little."
        )

    def doubling(self, rpm: float, label: str, doubled: str, doubled_rpm: float) -> str:
        """An orbit that gives way to one of twice its period; rpm: where it does so."""
        return (
            f"At {rpm:.7g} rpm {label_text(label)} becomes unstable and its period doubles: at "
            f"{doubled_rpm:.6g} rpm it is {label_text(doubled)}, each turn unlike the one before."
        )

    def chaos(self, rpm: float) -> str:
        """A motion that never repeats."""
        return (
            f"At {rpm:.6g} rpm the motion never repeats, though nothing is left to chance: two "
            "starts a hair apart soon have nothing in common."
        )

    def two_motions(self, rpm: float, one: str, other: str) -> str:
        """Two motions that the same machine can have."""
        ways = f"{_called(one)} or {_called(other)}"
        return (
            f"At {rpm:.6g} rpm the same machine runs in two ways, {ways}: "
            "how it was started settles which; the buttons below switch."
        )


def basin_shares(rpm: float, shares: Iterable[tuple[str, float]]) -> str:
    """How much of the window each attractor takes; shares: (label, fraction)."""
    parts = [f"{label} takes {100.0 * share:.3g} %" for label, share in shares]
    return f"At {rpm:.10g} rpm: {', '.join(parts)} of the starts."


def page_line(motions: int, speeds: int, bifurcations: int, written: bool) -> str:
    """What is on the page, and how to look at it."""
    shown = f"{plural(motions, 'motion')} at {plural(speeds, 'speed')}"
    solved = f"{plural(bifurcations, 'bifurcation')} of solved branches"
    return f"{shown}, {solved}" + ("; open explore.html in a browser" if written else "")
