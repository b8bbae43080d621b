"""Write the guide's page of validation: published numbers beside those that the commands compute.

    python tests/support/validation.py

Published: chapter 3 of a thesis on impacting systems, in which the machine is simulated by an
adaptive Runge-Kutta pair at 1e-12 with event location.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import camcli

PAGE = Path(__file__).parents[2] / "camcli" / "guide" / "explanation" / "validation.md"
HEAD = """# Published numbers

The default machine is the cam-follower example of the literature. These are its numbers as
published, as the commands compute them, and the difference in units of the last published digit.
Published values come from simulations with an adaptive Runge-Kutta pair at 1e-12, some of them to
first order; [proofs](proofs.md) has twenty digits of most of them.

| quantity | published | computed | off, in last digits | command |
|---|---|---|---|---|
"""
TAIL = """
Where the two differ by more than a few digits, the published value is a first-order estimate
(accumulation at c and d), or was taken a little beside the event: the trace before the corner
impact of P(2;1:1) is steep there. The determinant at the corner impact of P(1;1) was published as
0.8, which is the modulus of its multipliers; their product is 0.64. The trace of P(2;1:1) behind
its corner impact was published as -3.80875; two independent computations, one in 40 digits, give
-4.09107.
"""
PUBLISHED = (  # quantity, as published, command, row of the table
    ("first loss of contact, rpm", "114.979", "detach", ("first_detachment", "A2")),
    ("contact is lost all over A2, rpm", "134.873", "detach", ("fills", "A2")),
    ("chatter accumulates at c, rpm", "119.72", "detach", ("accumulation_at_corner", "c")),
    ("chatter accumulates at d, rpm", "136.38", "detach", ("accumulation_at_corner", "d")),
    ("chatter is complete no longer, rpm", "198.56", "detach", ("completion_loss", "A2")),
    ("impact 1 lands on c, rpm", "124.998", "hits", (1, "c")),
    ("impact 2 lands on c, rpm", "122.699", "hits", (2, "c")),
    ("impact 3 lands on c, rpm", "121.686", "hits", (3, "c")),
    ("impact 4 lands on c, rpm", "121.107", "hits", (4, "c")),
    ("impact 5 lands on c, rpm", "120.7356", "hits", (5, "c")),
    ("impact 6 lands on c, rpm", "120.481", "hits", (6, "c")),
    ("corner impact of P(1;1) at b, rpm", "673.234445", "orbits", ("corner-impact", "b", "rpm")),
    ("its trace on the side of A1", "1.6419", "orbits", ("corner-impact", "b", "trace_left")),
    ("its trace on the side of A2", "1.37142", "orbits", ("corner-impact", "b", "trace_right")),
    ("period doubling of P(1;1), rpm", "739.3197803", "orbits", ("period-doubling", "", "rpm")),
    ("corner impact of P(2;1:1) at c, rpm", "739.37793", "orbits", ("corner-impact", "c", "rpm")),
    ("its trace before", "1.381624791", "orbits", ("corner-impact", "c", "trace_left")),
)
COMMANDS = {
    "detach": "cam detach",
    "hits": "cam detach",
    "orbits": "cam orbits --rpm 665:745",
}


def lookups() -> dict[str, Callable[[tuple], float]]:
    """For each table of the page a function that looks a row's number up in what we compute."""
    detach = camcli.detach().tables
    scene = camcli.load_scene(None, {"orbits.rpm.start": 665.0, "orbits.rpm.stop": 745.0})
    events = camcli.orbits(scene).tables["bifurcations"]

    def of_detach(row: tuple) -> float:
        table = detach["detach"]
        chosen = (table["quantity"] == row[0]) & (table["region"] == row[1])
        return float(table["rpm"][chosen][0])

    def of_hits(row: tuple) -> float:
        table = detach["corner_hits"]
        return float(table["rpm"][(table["impact"] == row[0]) & (table["corner"] == row[1])][0])

    def of_orbits(row: tuple) -> float:
        chosen = np.flatnonzero((events["kind"] == row[0]) & (events["corner"] == row[1]))
        return float(events[row[2]][chosen[0]])

    return {"detach": of_detach, "hits": of_hits, "orbits": of_orbits}


def rows() -> Iterator[tuple[str, str, str, float, str]]:
    """Quantity, published, computed, difference in published last digits, command."""
    found = lookups()
    for quantity, published, table, row in PUBLISHED:
        value = found[table](row)
        digits = len(published.partition(".")[2])
        off = abs(value - float(published)) * 10.0**digits
        yield quantity, published, f"{value:.{max(digits + 3, 9)}f}", off, COMMANDS[table]


def page() -> str:
    """The page as it should be."""
    lines = [
        f"| {quantity} | {published} | {computed} | {off:.1f} | `{command}` |\n"
        for quantity, published, computed, off, command in rows()
    ]
    return HEAD + "".join(lines) + TAIL


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
