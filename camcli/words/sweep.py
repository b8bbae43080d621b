"""What `cam sweep` says of the motions it could not tell, or decided beyond rounding."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from camcli.analysis.integrate import Settings, Start
from camcli.analysis.sweep import BOTH, FIXED, Sweep, status_name
from camcli.analysis.sweep_map import Map
from camcli.errors import Status, is_or_are, plural
from camcli.words.after_rest import decided_notes
from camcli.words.in_print import label_text, name_and_unit, number_text, one_of, range_of, valued
from camcli.words.speeds import at_speed, on_the_cam

if TYPE_CHECKING:
    from camcli.analysis.orbits.atlas import Atlas


def sweep_notes(found: Sweep) -> list[str]:
    """How many motions were decided in ball arithmetic, and how many are not known, drawn grey."""
    notes = decided_notes((speed.holds_for for speed in found.bare), "speed")
    count = sum(not speed.known for speed in found.bare)
    if count:
        notes.append(
            f"{count} of {plural(len(found.speeds), 'motion')} {is_or_are(count)} undecided: the "
            "follower comes to rest, rounding decides what follows, and ball arithmetic could not "
            "tell (cam guide labels)"
        )
    return notes


def map_notes(found: Map, followed: bool) -> list[str]:
    """What stayed undecided in a map, in sentences.

    followed: whether motions that rounding decides were followed beyond it.
    """
    speeds = list(found.speeds)
    notes = decided_notes((speed.holds_for for speed in speeds), "point")
    count = sum(not speed.known for speed in speeds)
    if not count:
        return notes
    which = f"{count} of {plural(len(speeds), 'point')} {is_or_are(count)}"
    text = f"{which} undecided: after a rest, rounding decides"
    cure = "; sweep.decide (--decide) follows each beyond rounding, which takes some seconds"
    return [text + ("" if followed else cure), *notes]


def sweep_title(found: Sweep, ranges: int, kind: str = "") -> str:
    """The title of the ranges in which all motions have one label; kind: of the cam."""
    count = len(found.speeds)
    values = plural(count, "speed")
    if found.key != "rpm":
        values = f"{plural(count, 'value')} of {found.key}"
    at = at_speed([found.key], found.bare[0].rpm, kind)
    return f"{values}{at}, {plural(ranges, 'range')} of one label"


def map_title(found: Map, kind: str = "") -> str:
    """The title of the labels of a map; kind: of the cam."""
    points = sum(map(len, found.lines))
    title = f"{' x '.join(found.keys)}: {plural(points, 'point')}"
    return title + at_speed(found.keys, found.lines[0][0].rpm, kind)


# --- beside the pictures

NO_STROBE = "the stroboscopic position is always the same, and is not drawn"


def diagram_title(sweep: Sweep, values: Sequence[float], kind: str) -> str:
    """The title of a diagram; values: of what is varied, at which something was computed.

    kind: of the cam.
    """
    if not len(values):
        return "Bifurcation diagram"
    ends = range_of(min(values), max(values))
    rpm = sweep.bare[0].rpm if sweep.bare else None
    return f"Bifurcation diagram, {valued(sweep.key, ends, rpm, kind)}"


def shown_cam(key: str, cam: object) -> str:
    """At which value the scene's cam is drawn, where one of its numbers is varied; else empty."""
    section, _, name = key.partition(".")
    if section != "cam":
        return ""
    value = getattr(cam, name, None)
    if not isinstance(value, int | float):
        return "cam of the scene"
    return f"cam at {valued(key, number_text(value))}"


def start_words(sweep: Sweep, settings: Settings, kind: str = "") -> str:
    """How the orbits of a sweep were started: from which states, carried or not.

    kind: of the cam.
    """
    turns = f"{plural(settings.transient, 'turn')} of transient"
    states = ", and ".join(_place(start, kind) for start in (settings.start, *sweep.also))
    if sweep.direction == FIXED or not sweep.speeds:
        return f"each {one_of(sweep.key)} started {states}, {turns}"
    turns += f" at each {one_of(sweep.key)}"
    if sweep.direction == BOTH:
        return f"carried up, then down, started {states}; {turns}"
    first = valued(sweep.key, f"{sweep.speeds[0].value:g}")
    return f"carried {sweep.direction} from {first}, started there {states}; {turns}"


def _place(start: Start, kind: str) -> str:
    """Where a start is, in words; position or velocity that it leaves open is that of the cam.

    kind: of the cam.
    """
    if start.q is None and start.v is None:
        return f"at rest {on_the_cam(kind)}"
    q = on_the_cam(kind) if start.q is None else f"at q = {start.q:g} m"
    v = "the cam's v" if start.v is None else f"v = {start.v:g} m/s"
    return f"{q}, {v}"


def diagram_words(
    sweep: Sweep,
    settings: Settings,
    values: Sequence[float],
    statuses: Sequence[int],
    unknown: int,
    kind: str = "",
) -> str:
    """How the orbits were started, how many values there are, and what is not known of some.

    values: of what is varied, of each orbit; statuses: of each orbit; unknown: how many are
    undecided; kind: of the cam.
    """
    different = len(set(values))
    clauses = [start_words(sweep, settings, kind), plural(different, one_of(sweep.key))]
    troubles = Counter(status_name(int(code)) for code in statuses if code != Status.OK)
    if troubles:
        kinds = ", ".join(f"{name} {count}" for name, count in sorted(troubles.items()))
        clauses.append(f"{troubles.total()} not ok, marked at the bottom edge ({kinds})")
    if unknown:
        clauses.append(f"{unknown} undecided after rests, grey")
    clauses.append("darker where more points fall")
    return "; ".join(clauses)


def map_heading(found: Map, kind: str) -> tuple[str, str]:
    """The title of a map, and what stands below it; kind: of the cam."""
    first_key, second_key = found.keys
    ends = [
        valued(first_key, range_of(min(found.first), max(found.first))),
        valued(second_key, range_of(min(found.second), max(found.second))),
    ]
    words = f"{len(found.first)} × {len(found.second)} points"
    words += at_speed(found.keys, found.lines[0][0].rpm, kind)
    if found.direction != FIXED:
        along, _ = name_and_unit(first_key)
        words += f", the state carried {found.direction} along the {along}"
    return f"Map of motions, {', '.join(ends)}", words


def curve_words(kind: str, label: str, corner: str) -> str:
    """A bifurcation in two numbers: corner impact at b of P(1;1)."""
    at = f" at {corner}" if corner else ""
    of = f" of {label_text(label, 22)}" if label else ""
    return f"{kind.replace('-', ' ')}{at}{of}"


def atlas_words(atlas: Atlas, most_turns: int, flank_excess: float) -> list[str]:
    """What was found on a map: each curve with what ends it, each point of codimension two.

    Where proofs were asked for, what is proved of them; most_turns: of orbits whose curves are
    tried; flank_excess: by how much (m) the flank circle of the proofs is larger than the scene's.
    """
    from camcli.words.codim2 import point_line  # it imports ball arithmetic
    from camcli.words.orbits import points_at_ends, why_it_ends

    if not atlas.curves:
        return ["no bifurcation of an orbit that bounces meets the edges of the map"]
    sentences = []
    kinds_at_ends = points_at_ends(atlas.curves, atlas.points)
    for number, (curve, kinds) in enumerate(zip(atlas.curves, kinds_at_ends, strict=True), 1):
        ends = dict.fromkeys(why_it_ends(curve, kinds))  # an end that is met twice stands once
        words = curve_words(curve.kind, curve.label, curve.corner)
        sentences.append(f"curve {number}, {words}, ends: {'; '.join(ends)}")
    sentences += [point_line(point, atlas.plane.names) for point in atlas.points]
    if atlas.ranges is not None:
        sentences += _proved_curves(atlas, most_turns, flank_excess)
    return sentences


def _proved_curves(atlas: Atlas, most_turns: int, flank_excess: float) -> list[str]:
    """Which parts of the curves on a map are proved, and the reason why the others are not."""
    from camcli.words.proofs import along_curves, closed_flank

    sentences = [closed_flank(flank_excess)] if flank_excess else []
    sentences += along_curves(atlas.ranges or (), atlas.plane.names)
    by_turns: dict[int, list[int]] = {}
    for number in atlas.not_tried:
        turns = atlas.curves[number - 1].points[0].orbit.turns
        by_turns.setdefault(turns, []).append(number)
    for turns, numbers in sorted(by_turns.items()):
        which = ", ".join(str(number) for number in numbers)
        what = "curve" if len(numbers) == 1 else "curves"
        sentences.append(
            f"not tried: a proof of {what} {which}, whose orbits have {plural(turns, 'turn')}: "
            f"sweep.prove_turns is {most_turns}"
        )
    return sentences
