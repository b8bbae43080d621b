"""The stops of a page of `cam explore`: what a machine can do, each with a motion to show it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import degrees, inf, radians

from camcli.analysis.cam_profile import profile
from camcli.analysis.contact_loss.detachment import detachment
from camcli.analysis.integrate import Start, with_turns
from camcli.analysis.labels import APERIODIC, CONTACT, period_of
from camcli.analysis.simulate import Happening, Simulation, simulate
from camcli.api.explore_motions import Explored, PageMotion, rows_per_turn, start_of, symbols_of
from camcli.api.machine import Machine
from camcli.system import turns_per_second
from camcli.words import explore as words

STOP = "stop"  # origin of a motion that is only there for a stop
HOLDS, LEAVES = 0.9, 1.06  # of the speed at which contact is first lost
CHATTERS = (1.5, 1.3, 1.15)  # the first of these that has a complete chatter
SETTLING = 3  # turns from rest; a motion that rests once a turn is settled after the first
MOST_ROWS_OF_A_STOP = 4000  # per turn
SEEN_TURNS = 4.0  # a longer period is seen no better than chaos
BEFORE = 0.04  # turns before what a stop shows


@dataclass(frozen=True)
class Stop:
    """One thing that the machine does.

    name: on its button. words: one sentence. motion: its number on the page. t: where the page
    begins to play, in turns after the strobe. close: whether the cam fills the drawing, because
    what is to be seen happens at one of its corners.
    """

    name: str
    words: str
    motion: int
    t: float
    close: bool = False


def motions_of_stops(machine: Machine) -> list[PageMotion]:
    """Motions below and above the speed at which contact is first lost: at most three.

    They are there whatever speeds the page sweeps. None where contact is never lost, or always.
    """
    first = detachment(machine.system).first
    if first is None:
        return []
    held = _settled(machine, HOLDS * first.rpm)
    left = _settled(machine, LEAVES * first.rpm)
    found = []
    if held is not None and held.label == CONTACT:
        found.append(held)
    if left is not None and period_of(left.label) == 1:
        found.append(left)
    for factor in CHATTERS:
        motion = _settled(machine, factor * first.rpm)
        if motion is not None and inf in symbols_of(motion.label):
            return [*found, motion]
    return found


def _round(rpm: float) -> float:
    """A speed of a stop as it is told: of four digits."""
    return float(f"{rpm:.4g}")


def _settled(machine: Machine, rpm: float) -> PageMotion | None:
    """One turn of the motion that begins at rest on the cam; None where it takes many rows."""
    system = machine.system
    rpm = _round(rpm)
    if rows_per_turn(system.follower, rpm) > MOST_ROWS_OF_A_STOP:
        return None
    settings = with_turns(machine.settings, SETTLING, 2)
    settings = replace(settings, start=Start(None, None, system.strobe))
    simulation = simulate(system, rpm, settings, 1, follow=False)
    _, _, at_q, at_v, *_ = simulation.trajectory[0]
    q, v = start_of(machine, rpm, at_q, at_v)
    label = simulation.label
    return PageMotion(
        rpm=rpm,
        label=label,
        origin=STOP,
        q=q,
        v=v,
        turns=1,
        loops=period_of(label) == 1,
        stable=True,
        exponent=None,
        system=system,
    )


def stops_of(machine: Machine, found: Explored) -> list[Stop]:
    """The stops that this page has motions for, from standstill to chaos."""
    kinds = (
        _lash,
        _low_speeds,
        _once_a_turn,
        _corner_impact,
        _doubling,
        _chaos,
        _two_motions,
        _hard_landing,
    )
    return [stop for kind in kinds for stop in kind(machine, found)]


def _nearest_event(simulation: Simulation, turns: int, kind: str, theta: float) -> Happening | None:
    """The event of a kind, in so many turns, nearest to an angle (rad), or None."""

    def away(one: Happening) -> float:
        """How far a phase is from the angle, deg."""
        between = abs(one.phase - degrees(theta)) % 360.0
        return min(between, 360.0 - between)

    alike = [one for one in simulation.events if one.kind == kind and one.turn < turns]
    return min(alike, key=away, default=None)


def _shortly_before(event: Happening, rpm: float) -> float:
    """When a stop begins that shows an event, turns after the strobe."""
    return max(0.0, event.seconds * turns_per_second(rpm) - BEFORE)


def _lash(machine: Machine, found: Explored) -> Iterator[Stop]:
    """A valve that is struck as the lash is taken up, and strikes its seat: at the lowest speed."""
    lash = getattr(machine.scene.cam, "lash", None)
    motions = _of_sweeps(found)
    corners = profile(machine.system, machine.scene.run.rpm, 2, None, drawn=False).corners
    if not machine.system.has_seat or not lash or len(corners) != 2 or not motions:
        return
    k, motion = min(motions, key=lambda one: one[1].rpm)
    opens, shuts = sorted(corners.values())
    opening = _nearest_event(found.simulations[k], motion.turns, "impact", opens)
    shutting = _nearest_event(found.simulations[k], motion.turns, "impact", shuts)
    if opening is None or shutting is None:
        return
    says = words.Machine.of(machine.scene, machine.system)
    told = says.lash(motion.rpm, lash, -opening.u_before, -shutting.u_before)
    yield Stop(words.LASH, told, k, _shortly_before(opening, motion.rpm))


def _low_speeds(machine: Machine, found: Explored) -> Iterator[Stop]:
    """Contact, lift-off and chatter."""
    first = detachment(machine.system).first
    if first is None:
        return
    says = words.Machine.of(machine.scene, machine.system)
    stops = [(k, motion) for k, motion in enumerate(found.motions) if motion.origin == STOP]
    for k, motion in stops:
        event = _nearest_event(found.simulations[k], motion.turns, "detachment", first.theta)
        if motion.label == CONTACT:
            yield Stop(words.IN_CONTACT, says.contact(motion.rpm), k, 0.0)
        elif event is not None and motion.rpm == _round(LEAVES * first.rpm):
            place = _place(machine, radians(event.phase))
            told = says.lift_off(motion.rpm, first.rpm, place)
            yield Stop(words.lift_off(place), told, k, _shortly_before(event, motion.rpm))
        elif event is not None:
            t = _shortly_before(event, motion.rpm)
            yield Stop(words.CHATTER, says.chatter(motion.rpm), k, t)


def _place(machine: Machine, theta: float) -> str:
    """The letter of the cam's corner at an angle (rad), or the angle."""
    corners = profile(machine.system, machine.scene.run.rpm, 2, None).corners
    for letter, corner in corners.items():
        if abs(corner - theta) < 1e-9:
            return letter
    return words.angle(degrees(theta))


def _corner_impact(machine: Machine, found: Explored) -> Iterator[Stop]:
    """The first corner impact that a motion of the page is near to."""
    if "orbits" not in found.parts:
        return
    span = machine.scene.sweep.rpm
    step = abs(span.stop - span.start) / max(1, span.num - 1)
    for event in found.parts["orbits"].values.bifurcations:
        if event.kind != "corner-impact":
            continue
        alike = [
            (motion.stable is False, abs(motion.rpm - event.value), k)
            for k, motion in enumerate(found.motions)
            if motion.label == event.label and motion.origin not in ("start", "map", STOP)
        ]
        near = [one for one in alike if one[1] <= 2.0 * step]
        if not near:
            continue
        *_, k = min(near)  # one that attracts, if there is any
        corners = profile(machine.system, machine.scene.run.rpm, 2, None).corners
        turns = found.motions[k].turns
        theta = corners[event.corner]
        impact = _nearest_event(found.simulations[k], turns, "impact", theta)
        if impact is None:
            continue
        says = words.Machine.of(machine.scene, machine.system)
        told = says.corner_impact(event.value, event.label, event.corner)
        t = _shortly_before(impact, found.motions[k].rpm)
        yield Stop(words.corner_impact(event.corner), told, k, t, close=True)
        return


def _of_sweeps(found: Explored) -> list[tuple[int, PageMotion]]:
    """The motions that sweeps have found, with their numbers."""
    own = ("fixed", "up", "down")
    return [(k, motion) for k, motion in enumerate(found.motions) if motion.origin in own]


def _once_a_turn(machine: Machine, found: Explored) -> Iterator[Stop]:
    """Where contact is never lost, or always: the middle speed with one impact in every turn."""
    if detachment(machine.system).first is not None:
        return
    motions = [
        (k, motion) for k, motion in _of_sweeps(found) if [*symbols_of(motion.label)] == [1.0]
    ]
    if motions:
        motions.sort(key=lambda one: one[1].rpm)
        k, motion = motions[len(motions) // 2]
        says = words.Machine.of(machine.scene, machine.system)
        yield Stop(words.ONCE_A_TURN, says.once_a_turn(motion.rpm, motion.label), k, 0.0)


def _doubling(machine: Machine, found: Explored) -> Iterator[Stop]:
    """The first period doubling whose doubled orbit sweeps have found.

    Of their speeds up to the next bifurcation the middle one, at which it is seen to be doubled.
    """
    if "orbits" not in found.parts:
        return
    events = found.parts["orbits"].values.bifurcations
    for event in events:
        if event.kind != "period-doubling":
            continue
        period = 2 * period_of(event.label)
        impacts = 2 * sum(symbols_of(event.label))
        low = max((one.value for one in events if one.value < event.value), default=-inf)
        high = min((one.value for one in events if one.value > event.value), default=inf)
        doubled = [
            (motion.rpm, k, motion)
            for k, motion in _of_sweeps(found)
            if period_of(motion.label) == period
            and sum(symbols_of(motion.label)) == impacts
            and low < motion.rpm < high
        ]
        if not doubled:
            continue
        _, k, motion = sorted(doubled, key=lambda one: one[0])[len(doubled) // 2]
        says = words.Machine.of(machine.scene, machine.system)
        told = says.doubling(event.value, event.label, motion.label, motion.rpm)
        yield Stop(words.DOUBLING, told, k, 0.0)
        return


def _chaos(machine: Machine, found: Explored) -> Iterator[Stop]:
    """The middle one of the speeds at which a motion never repeats."""
    chaotic = [(k, motion) for k, motion in _of_sweeps(found) if motion.label == APERIODIC]
    if chaotic:
        k, motion = chaotic[len(chaotic) // 2]
        says = words.Machine.of(machine.scene, machine.system)
        yield Stop(words.CHAOS, says.chaos(motion.rpm), k, 0.0)


def _two_motions(machine: Machine, found: Explored) -> Iterator[Stop]:
    """A speed at which sweeps end on two motions, one of which repeats.

    Of all such speeds those with the shortest periods, and of these the middle one.
    """
    by_speed: dict[float, dict[str, int]] = {}
    for k, motion in _of_sweeps(found):
        if period_of(motion.label) or motion.label in (APERIODIC, CONTACT):
            by_speed.setdefault(motion.rpm, {})[motion.label] = k
    several = [rpm for rpm, labels in by_speed.items() if len(labels) > 1]
    if not several:
        return
    in_order = {rpm: sorted(by_speed[rpm], key=_length)[:2] for rpm in sorted(several)}
    lengths = {rpm: [_length(label) for label in labels] for rpm, labels in in_order.items()}
    shortest = [rpm for rpm in in_order if lengths[rpm] == min(lengths.values())]
    rpm = shortest[len(shortest) // 2]
    labels = in_order[rpm]
    says = words.Machine.of(machine.scene, machine.system)
    told = says.two_motions(rpm, labels[0], labels[1])
    yield Stop(words.TWO_MOTIONS, told, by_speed[rpm][labels[0]], 0.0)


def _hard_landing(machine: Machine, found: Explored) -> Iterator[Stop]:
    """The hardest impact of all speeds, of an engine's valve train."""
    says = words.Machine.of(machine.scene, machine.system)
    if not says.valve:
        return
    impacts = [
        (one, k, motion.rpm)
        for k, motion in _of_sweeps(found)
        for one in found.simulations[k].events
        if one.kind == "impact" and one.turn < motion.turns
    ]
    if not impacts:
        return
    hardest, k, rpm = min(impacts, key=lambda one: one[0].u_before)
    told = says.hard_landing(rpm, -hardest.u_before)
    yield Stop(words.HARD_LANDING, told, k, _shortly_before(hardest, rpm))


def _length(label: str) -> float:
    """How long a motion takes to repeat, in turns: of chaos as long as an eye follows a motion."""
    if label == CONTACT:
        return 1.0
    return float(period_of(label)) or SEEN_TURNS
