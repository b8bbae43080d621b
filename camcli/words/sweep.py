"""What `cam sweep` says of the motions it could not tell, or decided beyond rounding."""

from camcli.analysis.sweep import Map, Sweep
from camcli.errors import plural
from camcli.words.after_rest import decided_notes
from camcli.words.speeds import at_speed


def sweep_notes(found: Sweep) -> list[str]:
    """How many motions were decided in ball arithmetic, and how many are not known, drawn grey."""
    notes = decided_notes((speed.holds_for for speed in found.bare), "speeds")
    count = sum(not speed.known for speed in found.bare)
    if count:
        notes.append(
            f"{count} of {len(found.speeds)} undecided: after a rest rounding decides, and the "
            "true motion could not be told; grey in the picture"
        )
    return notes


def map_notes(found: Map, followed: bool) -> list[str]:
    """The same of a map; followed: whether what rounding decides was followed beyond it."""
    speeds = list(found.speeds)
    notes = decided_notes((speed.holds_for for speed in speeds), "points")
    count = sum(not speed.known for speed in speeds)
    if not count:
        return notes
    text = f"{count} of {len(speeds)} points undecided, grey: rounding decides after a rest"
    cure = "; sweep.decide (--decide) follows each beyond rounding, some seconds for one"
    return [text + ("" if followed else cure), *notes]


def sweep_title(found: Sweep, ranges: int) -> str:
    """The title of the ranges in which all motions have one label."""
    what = "speed" if found.key == "rpm" else "value"
    title = plural(len(found.speeds), what) + at_speed([found.key], found.bare[0].rpm)
    return f"{title}, {plural(ranges, 'range')} of one label"


def map_title(found: Map) -> str:
    """The title of the labels of a map."""
    points = sum(map(len, found.lines))
    title = f"{' x '.join(found.keys)}: {points} points"
    return title + at_speed(found.keys, found.lines[0][0].rpm)
