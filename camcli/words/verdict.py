"""The answer before any table, a sentence a line: up to where contact holds, and what then."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import degrees, inf, isnan, radians
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict

import camcli.analysis.contact_loss.detachment as loss
from camcli.analysis.surge import own_frequency
from camcli.kernel.cam_table import lift_at, stretch_at
from camcli.quantities import Units
from camcli.scene.made_up import made_up
from camcli.system import decimals, units_of
from camcli.words.in_print import written_out
from camcli.words.loads import Struck, struck
from camcli.words.machine import crank_of
from camcli.words.speeds import number_range, range_words, spacing
from camcli.words.surge import NOT_SIMULATED, UNIT
from camcli.words.tolerance import deviations, number_name, share_words

if TYPE_CHECKING:
    import numpy as np

    from camcli.analysis.contact_loss.hold import Hold

NOTHING = 1e-3  # of the lift: a height below is told as none
AS_HEAVY = ", if it is as heavy as the present spring"
VAGUE = 0.5  # of a velocity: a wider range by the table says little
FOOT = 0.1  # of the lift: below it a spring presses with its preload rather than its rate
WITH_A_BASE = ("arcs", "law", "table")  # kinds of cams that have a base circle


class Answer(NamedTuple):
    """The answer that a result begins with: its sentences, and more of them for who asks."""

    lines: list[str]
    details: list[str]


def verdict(
    result: Any, contact: loss.Detachment | None, lift_table: Mapping[str, Any] | None
) -> Answer:
    """The answer of a `Result`.

    contact: where it is lost, None where the answer is about one motion; lift_table: what run.json
    says of the error of a measured cam, None of another cam.
    """
    lines = [*_made_up(result), *_answer(result, contact, lift_table)]
    return Answer(lines, [f"{capital(detail)}." for detail in _details(result, contact)])


def _made_up(result: Any) -> Iterator[str]:
    """A warning where numbers of the machine are still those of cam init."""
    keys = made_up(result.scene)
    if keys:
        yield f"This is of a made-up machine: cam init made up {', '.join(keys)}."


def _answer(
    result: Any, contact: loss.Detachment | None, lift_table: Mapping[str, Any] | None
) -> list[str]:
    """The sentences of the answer; for the arguments see `verdict`."""
    crank = crank_of(result.scene)
    if result.scene.cam.kind == "oscillator":
        # up to which speed contact holds is no question about an oscillator
        return [_of_an_oscillator(result)] if contact is None else []
    if contact is None:
        return [_at_one_speed(result, crank)]
    if contact.always:
        loss_at_any_speed = contact.always[0]
        why = "the spring does not press even at standstill"
        if loss_at_any_speed.reason is loss.Reason.KINK:
            why = "the cam's slope drops"
        at = f"{degrees(loss_at_any_speed.theta):.4g} deg"
        return [f"Contact is lost at every speed: {why} at {at}."]
    if contact.first is None:
        return ["Contact holds at every speed."]
    first = contact.first
    low, high = lift_table["first_detachment_rpm"] if lift_table else (None, None)
    sentences = [f"Contact holds up to {_speed(first.rpm, low, high, crank)}"]
    if result.command == "detach":
        sentences.append(_first_to_give(result, first))
    sentences += _past_the_loss(result, first.rpm)
    if result.command == "detach":
        sentences += _at_work(result, crank)
        sentences += _springs(result, first.rpm)
        sentences += _tolerances(result)
    return [f"{sentence}." for sentence in sentences]


def _details(result: Any, contact: loss.Detachment | None) -> Iterator[str]:
    """What more there is to say, as clauses: nothing where no speed marks a loss of contact."""
    if contact is None or contact.first is None or contact.always:
        return
    if result.command == "detach":
        yield from _on_surge(result, contact.first)
    yield from _on_landings(result, contact.first.rpm)
    if result.command == "detach":
        yield from _on_working_seat(result)
        yield from _on_springs(result)
        yield from _on_tolerances(result)


def _speed(rpm: float, low: float | None, high: float | None, crank: float) -> str:
    """3352 rpm of the cam (6704 of the crank); its table leaves 3333 to 3378 rpm.

    As many digits as the data deserve. low, high: the speeds that the error of a measured cam
    leaves, rpm; low is None of another cam, high is None where contact may never be lost. crank:
    turns of the crank in one of the cam, 0 without one.
    """
    places: int | None = None  # decimals, where the width of the range says how many
    range_by_table = ""
    if low is not None:
        if high is not None:
            places = decimals(high - low)
        range_by_table = f"; its table leaves {range_words(low, inf if high is None else high)}"

    def speed_text(value: float) -> str:
        """The speed with its digits."""
        return written_out(value, 6) if places is None else f"{value:.{places}f}"

    of_crank = f" ({speed_text(crank * rpm)} of the crank)" if crank else ""
    return f"{speed_text(rpm)} rpm of the cam{of_crank}{range_by_table}"


class _StrongHarmonic(TypedDict):
    """A harmonic of the cam that meets the spring's own frequency, as run.json has it."""

    harmonic: int
    rpm: float  # of the cam, at which it does
    factor: float  # the harmonic-resonance factor, see `analysis.surge`


class _SurgeSummary(TypedDict):
    """What the summary of a `Result` says of surge, as far as it is told here."""

    mass_kg: float  # of the spring
    frequency_hz: float
    limit: float
    strong: list[_StrongHarmonic]  # at any speed, with a factor over the limit


def _first_to_give(result: Any, first: loss.CriticalSpeed) -> str:
    """What gives way first: the contact force or, below that speed, perhaps the spring by surge.

    first: where contact is first lost.
    """
    strong = _strong_below(result, first.rpm)
    if strong:
        worst = max(strong, key=lambda harmonic: harmonic["factor"])
        at = f"harmonic {worst['harmonic']} at {written_out(worst['rpm'], 4)} rpm"
        return f"What gives first may be surge, which is not simulated: {at}"
    follower = result.scene.follower
    presses = "the spring" if follower.stiffness or follower.preload else "the weight"
    return f"What gives first is {presses}: {_where_it_gives(first)}"


def _where_it_gives(first: loss.CriticalSpeed) -> str:
    """Where the spring, or the weight, presses too little, as a clause."""
    return f"at {degrees(first.theta):.4g} deg it presses too little"


def _strong_below(result: Any, rpm: float) -> list[_StrongHarmonic]:
    """The strong harmonics that meet the spring below a speed, the slowest first."""
    surge: _SurgeSummary | None = result.summary.get("surge")
    if surge is None:
        return []
    strong = [harmonic for harmonic in surge["strong"] if harmonic["rpm"] <= rpm]
    return sorted(strong, key=lambda harmonic: harmonic["rpm"])


def _on_working_seat(result: Any) -> Iterator[str]:
    """A clause on how hard a valve with a measured cam seats at the working speed."""
    work = result.summary.get("working") or {}
    velocity = work.get("seat_velocity_m_per_s")
    if velocity and "seating" in result.summary:
        yield f"at the working speed it seats with {_with_range(result, velocity)}"


def _on_surge(result: Any, first: loss.CriticalSpeed) -> Iterator[str]:
    """Clauses on the surge of the spring; none where its mass is not known.

    first: where contact is first lost.
    """
    surge: _SurgeSummary | None = result.summary.get("surge")
    if surge is None:
        return
    strong = _strong_below(result, first.rpm)
    if strong:
        yield _meetings(surge, strong)
        place = _where_it_gives(first)
        yield f"surge is not simulated, and {UNIT}; without surge the spring gives: {place}"
        return
    yield (
        f"no harmonic of the cam over {surge['limit']:g} meets the spring's "
        f"{written_out(surge['frequency_hz'], 3)} Hz below that speed; {NOT_SIMULATED}, and {UNIT}"
    )


def _meetings(surge: _SurgeSummary, strong: list[_StrongHarmonic]) -> str:
    """The strong harmonics that meet the spring, as a clause: the slowest and the strongest.

    strong: at least one, the slowest first.
    """
    worst = max(strong, key=lambda harmonic: harmonic["factor"])
    spring = f"the spring's {written_out(surge['frequency_hz'], 3)} Hz"
    at = f"at {written_out(worst['rpm'], 4)} rpm with a factor of {worst['factor']:.2g}"
    if len(strong) > 1:
        return (
            f"{len(strong)} harmonics of the cam over the usual {surge['limit']:g} meet {spring} "
            f"below that speed, from {written_out(strong[0]['rpm'], 4)} rpm; the strongest is "
            f"{worst['harmonic']}, {at}"
        )
    return f"harmonic {worst['harmonic']} meets {spring} {at}, over the usual {surge['limit']:g}"


def _at_one_speed(result: Any, crank: float) -> str:
    """The sentence on one motion: whether contact holds, and how hard the follower lands.

    crank: turns of the crank in one of the cam, 0 where there is none.
    """
    speed = _speed(result.scene.run.rpm, None, None, crank)
    if "events" not in result.tables:
        return f"This is the cam alone, with the contact force at {speed}."
    if result.system.has_seat and result.system.lash > 0.0:
        return _on_the_seat(result, speed)
    landing = _hardest_landing(result)
    if landing == 0.0:
        flies = "flight" in result.tables["trajectory"]["contact"]
        state = "is lost: the follower does not land" if flies else "holds"
        return f"At {speed} contact {state} in the turns recorded."
    on_seat = ""
    if result.system.has_seat:
        hardest = _hardest_on_seat(result)
        on_seat = f", on its seat at up to {written_out(hardest, 2)} m/s"
        if hardest == 0.0:
            on_seat = ", and never on its seat"
    return (
        f"At {speed} contact is lost: the follower lands at up to {written_out(landing, 2)} m/s"
        f"{on_seat}."
    )


def _of_an_oscillator(result: Any) -> str:
    """The sentence on one motion of a forced mass before a stop.

    Up to which speed contact holds is no question about it: it has one speed, its frequency.
    """
    if "events" not in result.tables:
        return "This is the stop alone, seen from the steady motion that the mass has without it."
    hardest = _hardest_landing(result)
    if hardest > 0.0:
        return f"The mass hits the stop at up to {written_out(hardest, 2)} m/s."
    flies = "flight" in result.tables["trajectory"]["contact"]
    does = "does not hit the stop" if flies else "stays at the stop"
    return f"The mass {does} in the turns recorded."


def _hardest_landing(result: Any) -> float:
    """The velocity (m/s) of the hardest recorded impact; 0 without one."""
    incoming = result.tables["events"]["u_minus_m_per_s"]  # negative where the gap closes
    return max((-u for u in incoming if u < 0.0), default=0.0)


def _hardest_on_seat(result: Any) -> float:
    """The velocity (m/s) of the hardest recorded impact on the seat; 0 without one."""
    events = result.tables["events"]
    hardest = 0.0
    for theta_deg, u in zip(events["theta_deg"], events["u_minus_m_per_s"], strict=True):
        if u < 0.0 and result.system.is_seat(radians(theta_deg)):
            hardest = max(hardest, -u)
    return hardest


def _on_the_seat(result: Any, speed: str) -> str:
    """The sentence on a follower with a seat: whether it leaves the lobe, and how hard it seats."""
    events = result.tables["events"]
    hardest_on_seat = 0.0  # m/s
    hardest_on_lobe = 0.0
    rests_on_lobe = False  # after a chatter, or an impact from which it does not bounce
    for kind, theta_deg, u_minus, u_plus in zip(
        events["event"],
        events["theta_deg"],
        events["u_minus_m_per_s"],
        events["u_plus_m_per_s"],
        strict=True,
    ):
        is_impact = kind == "impact"
        if result.system.is_seat(radians(theta_deg)):
            if is_impact:
                hardest_on_seat = max(hardest_on_seat, -u_minus)
        elif is_impact:
            hardest_on_lobe = max(hardest_on_lobe, -u_minus)
            rests_on_lobe = rests_on_lobe or u_plus == 0.0
        elif kind == "chatter":
            rests_on_lobe = True
    if hardest_on_seat == hardest_on_lobe == 0.0:
        return f"At {speed} the follower lands neither on lobe nor seat in the turns recorded."
    on_lobe = "bounces on the lobe and never rests on it"
    if "detachment" in events["event"]:
        on_lobe = "leaves the lobe"
    elif rests_on_lobe:
        on_lobe = "keeps to the lobe once that has hit it"
    seats = f"comes to its seat with up to {written_out(hardest_on_seat, 2)} m/s"
    if hardest_on_seat == 0.0:
        seats = "does not come to its seat"
    return (
        f"At {speed} the follower {on_lobe}: the lobe hits it with up to "
        f"{written_out(hardest_on_lobe, 2)} m/s, and it {seats}."
    )


class _Landing(NamedTuple):
    """Columns of speeds.csv, of a speed at which the follower lands.

    The hardest landing is the largest of these tuples: the velocity comes first.
    """

    max_impact_m_per_s: float
    landing_deg: float
    landing_lift_m: float
    max_gap_m: float
    rpm: float
    shut_bounces_per_turn: float


class _Landings(NamedTuple):
    """The speeds at which the follower lands past a loss of contact, and all of the run, in rpm.

    columns: those of `_Landing` by their names, in its order, with an entry for each landing.
    """

    columns: Mapping[str, np.ndarray]
    speeds: np.ndarray

    @property
    def hardest(self) -> _Landing:
        """The landing with the largest velocity."""
        return max(_Landing(*map(float, row)) for row in zip(*self.columns.values(), strict=True))

    @property
    def rpm(self) -> np.ndarray:
        """The speeds of the landings."""
        return self.columns["rpm"]

    def most(self, column: str) -> float:
        """The largest value of a column of `_Landing`."""
        return float(max(self.columns[column]))


def _landings(result: Any, first: float) -> _Landings | None:
    """The landings of a run past the loss of contact at `first` (rpm).

    None where the run has no table of speeds with these columns.
    """
    table = result.tables.get("speeds")
    if table is None or not {"rpm", "max_impact_m_per_s"} <= set(table.columns):
        return None
    columns = table.arrays(*_Landing._fields)
    chosen = (columns["max_impact_m_per_s"] > 0.0) & (columns["rpm"] > first)
    landings = {name: column[chosen] for name, column in columns.items()}
    return _Landings(landings, columns["rpm"])


def _past_the_loss(result: Any, first: float) -> Iterator[str]:
    """What was seen past the loss of contact at `first` (rpm), none where nothing was.

    A follower with a seat strikes lobe and seat at slower speeds too, where contact holds: there
    only its seating is told.
    """
    of_run = _landings(result, first)
    if of_run is None:
        return
    if not of_run.rpm.size:
        if result.system.has_seat and of_run.speeds.size:
            yield _seated(result, 0.0)
        return
    slowest = float(of_run.rpm.min())
    fastest = float(of_run.rpm.max())
    where = f"at {written_out(fastest, 6)} rpm"
    if slowest < fastest:
        places = decimals(spacing(of_run.speeds))
        where = f"from {number_range(round(slowest, places), round(fastest, places))} rpm"
    velocity = of_run.most("max_impact_m_per_s")
    hardest = f"{velocity:.0f}" if velocity >= 10.0 else written_out(velocity, 2)
    gap = of_run.most("max_gap_m")
    low_c, high_c = result.system.lift_range
    flies = "hardly flies"
    if gap > NOTHING * (high_c - low_c):
        flies = f"flies {units_of(result.system).lengths(gap)}"
    yield f"Past it, {where}, it {flies} and lands at {hardest} m/s at most"
    if result.system.has_seat:
        yield _seated(result, first)


def _on_landings(result: Any, first: float) -> Iterator[str]:
    """Clauses on the landings past the loss of contact at `first` (rpm): hardest one, and bounces.

    A bounce on the shut cam is one where the lift is next to nothing.
    """
    of_run = _landings(result, first)
    if of_run is None:
        return
    lands = of_run.rpm.size > 0
    if lands:
        hardest = of_run.hardest
        place = _place(result, hardest.landing_deg, hardest.landing_lift_m)
        yield f"the hardest landing is at {place}"
        bounces = of_run.most("shut_bounces_per_turn")
        if bounces and not result.system.has_seat:
            yield f"it bounces on the shut cam, {bounces:.2g} times a turn at most"
    if result.system.has_seat:
        bounce = _most_on_seat(result, "seat_bounce_height_m", first if lands else 0.0)
        if bounce > 0.0:
            yield f"on its seat it bounces up to {units_of(result.system).lengths(bounce)}"


def _most_on_seat(result: Any, column: str, past: float) -> float:
    """The largest value of a column of the seat past a speed (rpm), 0 where there is none."""
    columns = result.tables["speeds"].arrays("rpm", column)
    values = columns[column][columns["rpm"] > past]
    # NaN at a speed at which the follower never comes to its seat
    return max((value for value in values if not isnan(value)), default=0.0)


def _seated(result: Any, past: float) -> str:
    """How hard the follower comes to its seat past a speed (rpm)."""
    velocity = _most_on_seat(result, "seat_velocity_m_per_s", past)
    if velocity == 0.0:
        if result.system.lash == 0.0:
            return "It never lands on its seat: without lash the lobe sets it down"
        return "It never lands on its seat"
    velocity_text = _with_range(result, velocity)
    if result.system.lash > 0.0:
        by_ramp = _most_on_seat(result, "seat_ramp_velocity_m_per_s", past)
        velocity_text += f" (the ramp alone: {written_out(by_ramp, 2)})"
    return f"It seats with up to {velocity_text}"


def _with_range(result: Any, velocity: float) -> str:
    """A seating velocity (m/s), with what the error of the table leaves of it where that is known.

    `8.38 m/s, 8.33 to 8.43 by its table`; where the range is wide the text says so.
    """
    for seating in result.summary.get("seating", ()):
        if seating["seat_velocity_m_per_s"] == velocity:
            low = seating["seat_velocity_low_m_per_s"]
            high = seating["seat_velocity_high_m_per_s"]
            width = high - low
            places = max(decimals(width) - 1, 1)
            ends = f"{low:.{places}f} to {high:.{places}f}"
            if width > VAGUE * velocity:
                return f"{velocity:.{places}f} m/s, which its table hardly tells: {ends}"
            return f"{velocity:.{places}f} m/s, {ends} by its table"
    return f"{written_out(velocity, 2)} m/s"


def _place(result: Any, theta_deg: float, lift: float) -> str:
    """Where the follower lands: phase, and lift above the lowest (m); seat or opening blow by name.

    At the opening blow the follower does not land, the lobe comes to it.
    """
    hit = struck(result.system, radians(theta_deg))  # None without a lash
    where = height(result, lift)
    if hit is Struck.SEAT:
        where = "on its seat"
    elif hit is not None:
        where = "the opening blow of the lobe"
    return f"{theta_deg:.4g} deg, {where}"


def height(result: Any, lift: float) -> str:
    """A lift above the lowest (m) in words; on the base circle where it is next to nothing."""
    low, high = result.system.lift_range
    if lift > NOTHING * (high - low):
        return f"{units_of(result.system).lengths(lift)} above its lowest"
    if result.system.has_seat:
        return "just above its seat"
    return "on the base circle" if result.scene.cam.kind in WITH_A_BASE else "at its lowest"


def _at_work(result: Any, crank: float) -> Iterator[str]:
    """What happens at the speed of the run, where the scene gives one."""
    work = result.summary.get("working")
    if work is None:
        return
    speed = f"At the working speed, {_speed(work['rpm'], None, None, crank)},"
    if work["open"]:
        least = f"{written_out(work['least_force_n'], 3)} N at {work['theta_deg']:.4g} deg"
        yield (
            f"{speed} the error of the table leaves open whether contact holds: on the fitted cam "
            f"the least force is {least}{_seating(work)}"
        )
    elif work["max_impact_m_per_s"] is None:
        least = f"{written_out(work['least_force_n'], 3)} N at {work['theta_deg']:.4g} deg"
        yield f"{speed} contact holds: the cam is pressed with at least {least}{_seating(work)}"
    else:
        on_seat = struck(result.system, radians(work["landing_deg"])) is Struck.SEAT
        seating = "" if on_seat else _seating(work)
        yield f"{speed} contact is lost: {_landing_at(result, work)}{seating}"


def _seating(work: Mapping[str, Any]) -> str:
    """How hard the follower comes to its seat at the working speed; nothing without a seat."""
    speed = work.get("seat_velocity_m_per_s")
    if not speed:
        return ""
    return f"; the follower comes to its seat with {written_out(speed, 2)} m/s"


def _landing_at(result: Any, work: Mapping[str, Any]) -> str:
    """How hard and where the follower lands at one speed."""
    where = _place(result, work["landing_deg"], work["landing_lift_m"])
    hardest = written_out(work["max_impact_m_per_s"], 2)
    return f"the follower lands at up to {hardest} m/s ({where})"


def _springs(result: Any, first: float) -> Iterator[str]:
    """Sentences on the springs that --hold-to asked for; first: rpm to which the present holds."""
    holds = getattr(result.values, "holds", ())
    if not holds:
        return
    rpm = result.scene.detach.hold_to
    margin = written_out(result.values.margin, 3)
    speed = _speed(rpm, None, None, crank_of(result.scene))
    asked = f"up to {speed} with {margin} N to spare"
    if _present_holds(holds):
        yield f"The present spring holds {asked}"
        return
    if first > rpm:
        text = (
            f"the present spring holds beyond {written_out(rpm, 6)} rpm, but not with "
            f"{margin} N to spare"
        )
        if result.scene.cam.kind == "table":
            yield (
                f"On the fitted cam {text} whatever the error of its table: "
                "margin and error ask for another"
            )
        else:
            yield f"{capital(text)}: that margin asks for another"
    found = _springs_found(result)
    if found:
        units = units_of(result.system)
        *others, last = (spring_words(hold, units) for hold in found)
        springs = f"{', '.join(others)} or {last}" if others else last
        yield f"To hold {asked} it takes {springs}"
    else:
        yield f"To hold {asked}, no spring can be named, see below"
    yield from _at_the_foot(result, found)


def _springs_found(result: Any) -> list[Hold]:
    """The springs that hold contact up to the speed asked for."""
    from camcli.analysis.contact_loss.hold import HoldStatus

    holds = getattr(result.values, "holds", ())
    return [hold for hold in holds if hold.status is HoldStatus.OK]


def _on_springs(result: Any) -> Iterator[str]:
    """Clauses on the springs that --hold-to asked for, unless the present one does."""
    holds = getattr(result.values, "holds", ())
    if not holds:
        return
    if not _present_holds(holds):
        yield from _for_the_table(result, _springs_found(result))
        yield from _surge_of_springs(result, _springs_found(result))
    if result.scene.spring is not None and result.scene.spring.solid_at is not None:
        yield "where a spring of another rate is solid is not known: solid_at is the present one's"


def _present_holds(holds: Sequence[Hold]) -> bool:
    """Whether the present spring holds with the margin: then less preload would do."""
    by_preload = loss.CriticalQuantity.HOLD_PRELOAD
    return any(hold.quantity is by_preload and not hold.more for hold in holds)


def _at_the_foot(result: Any, found: list[Hold]) -> Iterator[str]:
    """A sentence where the rate of a stiffer spring is set by a phase at which rate hardly presses.

    found: the springs that hold.
    """
    low, high = result.system.lift_range
    for hold in found:
        if hold.quantity is not loss.CriticalQuantity.HOLD_STIFFNESS or hold.theta is None:
            continue
        cam = result.system.cam
        c, _, _ = lift_at(cam, stretch_at(cam, hold.theta), hold.theta)
        lift = c - low
        if lift < FOOT * (high - low):
            yield (
                f"The rate of the spring with the same preload is asked for at "
                f"{degrees(hold.theta):.4g} deg, {units_of(result.system).lengths(lift)} above the "
                "lowest: there preload presses, and rate hardly does"
            )


def _for_the_table(result: Any, found: list[Hold]) -> Iterator[str]:
    """What of the springs' force covers the error of a measured cam."""
    if result.scene.cam.kind != "table":
        return
    quantities = {hold.quantity for hold in found}
    least_forces = []  # of the springs found, N
    for hold, curve in result.values.springs:
        if hold is not None and hold.quantity in quantities:  # None: the present spring
            least_forces.append(curve.lowest_n)
    if not least_forces or min(least_forces) <= result.values.margin:
        return
    least = min(least_forces)
    for_error = least - result.values.margin
    yield (
        "the springs hold for every cam that the table leaves: on the fitted one they press with "
        f"at least {written_out(least, 3)} N, {written_out(for_error, 2)} N of it for the error of "
        "the table"
    )


def _surge_of_springs(result: Any, found: list[Hold]) -> Iterator[str]:
    """Which strong harmonics meet the springs found up to the speed that they shall hold to.

    A clause for each spring.
    """
    surge: _SurgeSummary | None = result.summary.get("surge")
    if surge is None or not found:
        return
    from camcli.words.detach import short_way

    hold_to = result.scene.detach.hold_to
    strong = sorted((harmonic["harmonic"] for harmonic in surge["strong"]), reverse=True)
    over_limit = f"harmonics over {surge['limit']:g}"
    for hold in found:
        own_rpm = 60.0 * own_frequency(hold.stiffness or 0.0, surge["mass_kg"])  # harmonic 1's
        met = []
        for number in strong:
            rpm = own_rpm / number
            if rpm <= hold_to:
                met.append(f"{number} at {written_out(rpm, 4)} rpm")
        meets = f"no {over_limit} meet it"
        if met:
            meets = f"these {over_limit} meet it: {', '.join(met)}"
        yield f"{short_way(hold)}: up to {written_out(hold_to, 6)} rpm {meets}{AS_HEAVY}"


def capital(text: str) -> str:
    """The beginning of a sentence."""
    return text[:1].upper() + text[1:]


def _tolerances(result: Any) -> Iterator[str]:
    """To which speeds the machines within the tolerances hold."""
    summary = result.summary.get("tolerance")
    if summary is None:
        return
    median = written_out(summary["median_rpm"], 4)
    worst = written_out(summary["worst_rpm"], 4)
    yield f"Half of the machines in tolerance hold up to {median} rpm, the worst up to {worst}"


def _on_tolerances(result: Any) -> Iterator[str]:
    """Clauses on the tolerances, the worst machine, what matters most, and the springs."""
    summary = result.summary.get("tolerance")
    if summary is None:
        return
    from camcli.words.detach import way

    tolerances = [
        f"{tolerance.key} {tolerance.percent:g} %" for tolerance in result.scene.detach.tolerance
    ]
    if result.scene.cam.kind == "table":
        tolerances.append("the error of the table")
    yield f"the tolerances are {', '.join(tolerances)}"
    yield f"in the worst machine they are {deviations(summary['worst'])}"
    if summary["shares"]:
        key = max(summary["shares"], key=summary["shares"].get)
        share = share_words(summary["shares"][key], summary["machines"])
        yield f"what matters most is {number_name(key)}: {share}"
    for hold in _springs_found(result):
        spring = summary["springs"].get(hold.quantity)
        if spring is None:
            continue
        yield (
            f"with {way(hold)} {100.0 * spring['chance']:.3g} % of them hold up to "
            f"{written_out(result.scene.detach.hold_to, 6)} rpm, the worst up to "
            f"{written_out(spring['worst_rpm'], 4)} rpm"
        )


def spring_words(hold: Hold, units: Units) -> str:
    """Stiffness and preload of a spring, as far as they are not those of the present one."""
    stiffness = units.stiffnesses(hold.stiffness or 0.0)
    preload = f"{hold.preload:.4g} N of preload"
    if hold.quantity is loss.CriticalQuantity.HOLD_BOTH:
        return f"{stiffness} with {preload}"
    if hold.quantity is loss.CriticalQuantity.HOLD_PRELOAD:
        return preload
    return stiffness
