"""Rows of `cam bench stability` are measured again, with some of what they see another.

`Replayed` makes what a row asks for once; the functions below it change results.
"""

import subprocess
from collections import Counter
from functools import partial, reduce
from types import SimpleNamespace

import numpy as np

from camcli.analysis.bench import stability
from camcli.analysis.bench.machine import LoggedEvent, events, reference
from camcli.analysis.bench.stability import ROWS, measure
from camcli.api.bench import machines
from camcli.errors import Status
from camcli.kernel.orbit_loop import EventKind


class Replayed:
    """What a row asks for is made once; asked again, some of it is another.

    others: changes of results, by what is asked for (a name in `stability`, or `command`) and which
    of them it is, from 0. asked: of each run, how its follower differs from the example's, the
    speed, and what else is wanted; of a comparison its tolerance.
    """

    def __init__(self, patch):
        self.made, self.count, self.others, self.asked = {}, Counter(), {}, []
        keys = {
            "run": lambda machine, rpm, **wanted: (
                machine.follower, machine.strobe, rpm, *sorted(wanted.items())
            ),
            "run_core": lambda *asked: "one run",
            "compare": None,
            "orbit": None,
        }  # fmt: skip
        for name, key in keys.items():
            again = partial(self.again, name, getattr(stability, name), key)
            patch.setattr(stability, name, again)
        command = partial(self.again, "command", subprocess.run, lambda words, **_: tuple(words))
        patch.setattr(stability.subprocess, "run", command)

    def again(self, name, make, key, *asked, **wanted):
        """What was made for the same before, or is made now, with its change."""
        if name in ("run", "orbit"):
            machine, rpm, *record = asked
            positional = {"record": record[0]} if record else {}
            self.asked.append((differs(machine.follower), rpm, positional | wanted))
        elif name in ("run_core", "compare"):
            self.asked.append((name, asked[-1]))
        what = name, key and key(*asked, **wanted)
        if key is None or what not in self.made:
            self.made[what] = make(*asked, **wanted)
        change = self.others.get((name, self.count[name]), lambda result: result)
        self.count[name] += 1
        return change(self.made[what])

    def measure(self, number, others=()):
        self.count, self.others, self.asked = Counter(), dict(others), []
        return measure(ROWS[number], machines())


def differs(follower):
    """The constants that the example's follower has not."""
    example = reference("stability")["follower"]
    return {name: x for name, x in vars(follower).items() if x not in (None, example.get(name))}


NUMBERS = {kind.text: int(kind) for kind in EventKind}


def logged(edit):
    """Of a record: its list of events is edited; `turn` is the record's own."""

    def change(record):
        rows = [event._replace(kind=NUMBERS[event.kind]) for event in edit(events(record))]
        columns = zip(*rows, strict=True) if rows else [[]] * 5
        kind, period, theta, q, u = map(np.array, columns)
        return record._replace(kind=kind, period=period, theta=theta, q=q, u=u)

    return change


def event(k, **cells):
    """Of a record: event k is another. A cell is its value, or a function of what it was."""

    def edit(rows):
        old = rows[k]
        new = {n: v(getattr(old, n)) if callable(v) else v for n, v in cells.items()}
        rows[k] = old._replace(**new)
        return rows

    return logged(edit)


def only(*kept):
    """Of a record: these events alone."""
    return logged(lambda rows: [rows[k] for k in kept])


def more(*added):
    """Of a record: one event more; its kind, turn, theta and u."""
    kind, turn, theta, u = added
    return logged(lambda rows: [*rows, LoggedEvent(kind, turn, theta, 0.1, u)])


def column(**cells):
    """Of a record: other columns or numbers, each a value or a function of what it was."""

    def change(record):
        new = {n: v(getattr(record, n)) if callable(v) else v for n, v in cells.items()}
        return record._replace(**new)

    return change


def cost(**counts):
    return column(cost=lambda cost: cost._replace(**counts))


def both(*changes):
    """One change after the other."""
    return lambda result: reduce(lambda made, change: change(made), changes, result)


def entry(k, value):
    """Of a column: entry k is another; a value or a function of what it was."""

    def change(column):
        column = list(column)
        column[k] = value(column[k]) if callable(value) else value
        return np.array(column)

    return change


def ended(**cells):
    """Of a command: another code, or other messages."""
    return lambda done: SimpleNamespace(**{**vars(done), **cells})


def followed(record=lambda record: record, q=lambda q: q):
    """Of an orbit: another record, or another height at its end."""

    def change(orbit):
        return SimpleNamespace(
            run=lambda: record(orbit.run()), position=lambda: (q(orbit.position()[0]), 0.0)
        )

    return change


def plus(x):
    return lambda was: was + x


def times(x):
    return lambda was: was * x


NOT_OK = column(status=Status.NO_RETURN)
OUT = column(status=Status.IMPACT_BUDGET)
SILENT = ended(stderr="")
FAULT = ended(returncode=1)


def runs(which, *changes):
    """Each change alone of each of these runs."""
    which = [which] if isinstance(which, int) else which
    return [{("run", k): change} for k in which for change in changes]


def told(k, *changes):
    return [{("command", k): change} for change in changes]
