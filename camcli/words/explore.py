"""What the page of `cam explore` says beside its pictures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from camcli.analysis.labels import APERIODIC, CONTACT
from camcli.errors import plural
from camcli.quantities import SHAFTS, Q, V, labelled
from camcli.scene.speeds import CRANK
from camcli.words.in_print import label_text
from camcli.words.machine import crank_of

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
LASH, ONCE_A_TURN, HARD_LANDING = "Lash", "Once a turn", "Hard landing"
LARGEST_VALVE = 0.03  # m, lift of a valve at most


def is_valve(scene: Scene, system: System) -> bool:
    """Whether a machine is told in the words of engines: a preloaded spring, a lift of some mm."""
    lifts = [stretch.start_c for stretch in system.cam.stretches]
    small = max(lifts) - min(lifts) < LARGEST_VALVE
    return small and scene.follower.preload > 0.0 and scene.follower.stiffness > 0.0


def crank_turns(scene: Scene, system: System) -> float:
    """Turns of the crank in a turn of the cam; 0 where there is none. A valve train has one."""
    if is_valve(scene, system):
        return 1.0 / SHAFTS[CRANK]
    return crank_of(scene)


def angle(degrees: float) -> str:
    """An angle of the cam that has no letter."""
    return f"{degrees:.4g}°"


def lift_off(place: str) -> str:
    """The name of a stop at which contact is lost; place: a corner's letter or an angle."""
    return f"Lift-off at {place}"


def corner_impact(corner: str) -> str:
    """The name of a stop with an impact on a corner."""
    return f"Impact at corner {corner}"


def _called(label: str, cam: str) -> str:
    """A motion in a sentence; cam: what the cam of the machine is called."""
    plain = {APERIODIC: "chaos", CONTACT: f"always on the {cam}"}
    return plain.get(label, label_text(label))


@dataclass(frozen=True)
class Machine:
    """What a machine does, one sentence each: stops of the page."""

    follower: str
    pull: str  # what holds it on the cam
    restitution: float
    valve: bool
    cam: str = "cam"
    crank: float = 0.0  # its turns in a turn of the cam, 0 where there is none

    @classmethod
    def of(cls, scene: Scene, system: System) -> Machine:
        """The machine of a scene."""
        valve = is_valve(scene, system)
        f = scene.follower
        has_spring = f.stiffness > 0.0
        is_ball = scene.cam.kind == "eccentric" and not has_spring
        follower = "ball" if is_ball else "follower"
        pull = "its weight"
        if has_spring:
            pull = "the spring"
        elif f.preload and not f.gravity:
            pull = "the preload"
        return cls(
            follower="valve train" if valve else follower,
            pull=pull,
            restitution=f.restitution,
            valve=valve,
            cam="table" if is_ball else "cam",
            crank=crank_turns(scene, system),
        )

    def _at(self, rpm: float, digits: int) -> str:
        """A speed of so many digits; where there is a crank, that of both shafts."""
        told = float(f"{rpm:.{digits}g}")
        beside = f" ({self.crank * told:.10g} of the crank)" if self.crank else ""
        return f"{told:.10g} rpm{beside}"

    def contact(self, rpm: float) -> str:
        """A motion that never leaves the cam."""
        return (
            f"At {self._at(rpm, 4)} {self.pull} keeps the {self.follower} on the {self.cam} all "
            "the way round: the push of the contact never comes to an end."
        )

    def lift_off(self, rpm: float, first: float, place: str) -> str:
        """A motion that leaves the cam; first: the speed at which contact is first lost."""
        leaves = f"the {self.follower} leaves it at {place}"
        if self.valve:
            leaves = f"the valve floats from {place} on"
        parts = f"the cam turns away faster than {self.pull} can push"
        if self.cam == "table":
            parts = f"the table drops away faster than the {self.follower} falls"
        return (
            f"Above {self._at(first, 6)} {parts}: at {rpm:.4g} rpm {leaves}; "
            "the contact arrow goes."
        )

    def chatter(self, rpm: float) -> str:
        """A motion with a complete chatter."""
        bounce = " (valve bounce)" if self.valve else ""
        return (
            f"At {self._at(rpm, 4)} the {self.follower} lands and bounces{bounce}, each time "
            f"{self.restitution:g} times as fast: infinitely often in a finite time, then it rests."
        )

    def corner_impact(self, rpm: float, label: str, corner: str) -> str:
        """An orbit whose impact falls on a corner of the cam."""
        return (
            f"At {self._at(rpm, 7)} the impact of {label_text(label)} falls on corner "
            f"{corner}, where the cam's curvature jumps: there the motion changes at once, not "
            "little by little."
        )

    def once_a_turn(self, rpm: float, label: str) -> str:
        """An orbit with one impact a turn, of a follower that never stays on the cam."""
        return (
            f"At {self._at(rpm, 6)} the {self.follower} bounces once a turn, each turn like the "
            f"one before: {label_text(label)}, a period of one turn with one impact."
        )

    def doubling(self, rpm: float, label: str, doubled: str, doubled_rpm: float) -> str:
        """An orbit that gives way to one of twice its period; rpm: where it does so."""
        return (
            f"At {self._at(rpm, 7)} {label_text(label)} becomes unstable and its period doubles: "
            f"at {doubled_rpm:.6g} rpm it is {label_text(doubled)}, each turn unlike the one "
            "before."
        )

    def chaos(self, rpm: float) -> str:
        """A motion that never repeats."""
        return (
            f"At {self._at(rpm, 6)} the motion never repeats, though nothing is left to chance: "
            "two starts a hair apart soon have nothing in common."
        )

    def two_motions(self, rpm: float, one: str, other: str) -> str:
        """Two motions that the same machine can have."""
        ways = f"{_called(one, self.cam)} or {_called(other, self.cam)}"
        return (
            f"At {self._at(rpm, 6)} the same machine runs in two ways, {ways}: "
            "how it was started settles which; the buttons below switch."
        )

    def lash(self, rpm: float, lash: float, opens: float, shuts: float) -> str:
        """A cam with lash; lash: m. opens, shuts: how fast the valve train is struck, m/s."""
        return (
            f"At {self._at(rpm, 6)} the cam takes up the lash of {1e3 * lash:.4g} mm and strikes "
            f"the valve train at {opens:.3g} m/s; as it shuts, that strikes the seat at "
            f"{shuts:.3g} m/s."
        )

    def hard_landing(self, rpm: float, speed: float) -> str:
        """The hardest impact of all speeds; speed: m/s."""
        return (
            f"At {self._at(rpm, 6)} the {self.follower} lands hardest, at {speed:.3g} m/s: "
            "such blows wear out the cam and all that runs on it."
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
