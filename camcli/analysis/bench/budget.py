"""How long `cam bench` may take: seconds of each part, by construction (`clock`).

In all 570 s, and 52 s where it is quick; what is missing to ten minutes and to one is for starting,
drawing, and the one piece by which a part may overrun.
"""

from __future__ import annotations

POINTS, FLIGHTS, ROWS, SCENES = "points", "flights", "stability", "scenes"
FULL = {POINTS: 360.0, FLIGHTS: 30.0, ROWS: 80.0, SCENES: 100.0}
QUICK = {POINTS: 26.0, FLIGHTS: 4.0, ROWS: 11.0, SCENES: 11.0}
PER_FLIGHT, PER_PEER_FLIGHT = 2.5e-3, 2e-3  # s, with brute force; estimates


def seconds_of(parts: tuple[str, ...], quick: bool) -> dict[str, float]:
    """Seconds of the parts wanted, in the order in which they run."""
    return {part: (QUICK if quick else FULL)[part] for part in parts}


def flying(count: int, with_peers: int) -> float:
    """Seconds that so many flights take, as an estimate; the peers fly the first of them."""
    return PER_FLIGHT * count + PER_PEER_FLIGHT * min(count, with_peers)
