"""The results at the speeds of a sweep as plain values in a file, and back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from camcli.analysis.after_rest import HoldsFor
from camcli.analysis.integrate import Cost, Start
from camcli.analysis.labels import from_plain, to_plain
from camcli.analysis.loads import Loads
from camcli.analysis.speeds import Speed
from camcli.errors import Status
from camcli.parallel import Codec, stored
from camcli.piece_faults import PieceFault

REAL_OR_NONE = stored.optional(stored.real)
START = {"q": REAL_OR_NONE, "v": REAL_OR_NONE, "theta": stored.real, "place": stored.text}
CHECKS: dict[str, Callable[[Any], Any]] = {  # of what `_store` makes of a speed
    "value": stored.real,
    "rpm": stored.real,
    "label": from_plain,
    "impact_count": stored.whole,
    "status": stored.one_of(*map(int, Status)),
    "impacts": stored.optional(stored.columns(1, 3)),
    "strobe": stored.optional(stored.columns(2, 2)),
    "cost": lambda value: Cost(**stored.fields(value, dict.fromkeys(Cost._fields, stored.whole))),
    "exponent": stored.optional(stored.extended),
    "exponent_error": stored.optional(stored.extended),
    "end": stored.optional(lambda value: Start(**stored.fields(value, START))),
    "loads": lambda value: Loads(*stored.items(REAL_OR_NONE, len(Loads._fields))(value)),
    "known": stored.flag,
    "holds_for": stored.optional(stored.one_of(*map(str, HoldsFor))),
    "watched": stored.optional(stored.whole),
}


def _store(speed: Speed) -> dict[str, Any]:
    """What a file keeps of a speed without a fault."""
    values = speed._asdict()
    del values["fault"]
    if speed.impacts is not None:
        period, *reals = speed.impacts
        values["impacts"] = (np.array([period]), np.array(reals))
    if speed.strobe is not None:
        _, q, v, impacts, chatter = speed.strobe  # the periods are 0, 1, 2, ...
        values["strobe"] = (np.array([impacts, chatter]), np.array([q, v]))
    return values | {
        "label": to_plain(speed.label),
        "cost": speed.cost._asdict(),
        "end": speed.end and vars(speed.end),
    }


def _load(values: Any) -> Speed:
    """The speed that `_store` made these values of; ValueError where they are none."""
    checked = stored.fields(values, CHECKS)
    return Speed(**{**checked, "strobe": _strobe(checked["strobe"])})


def load_section(name: str, values: Any) -> Any:
    """A section of a stored speed, impacts or strobe; ValueError where it is none."""
    columns = CHECKS[name](values[name])
    return _strobe(columns) if name == "strobe" else columns


def _strobe(columns: tuple | None) -> tuple | None:
    """A strobe section as `Speed` has it, of the columns that are kept."""
    if columns is None:
        return None
    impacts, chatter, q, v = columns
    return (range(len(q)), q, v, impacts, chatter)


def faults_of(speeds: Sequence[Speed]) -> list[PieceFault]:
    """The faults that cost single speeds."""
    return [speed.fault for speed in speeds if speed.fault is not None]


# Of a piece of work that is a value, and of one that is a value and a start.
OF_VALUES = Codec(
    _store, _load, lambda speed, value: speed.value == value, lambda speed: faults_of([speed])
)
OF_STARTS = OF_VALUES._replace(fits=lambda speed, piece: speed.value == piece[0])


def of_lines(values: Sequence[float]) -> Codec:
    """The codec of lines of a map, a list of speeds each, over these values of its first number."""
    return Codec(
        lambda line: [_store(speed) for speed in line],
        lambda stored_line: stored.items(_load)(stored_line),
        lambda line, _: [speed.value for speed in line] == list(values),
        faults_of,
    )
