"""Has a motion come to repeat itself? From its states at the strobe, in doubles."""

from __future__ import annotations

from collections.abc import Sequence

from camcli.analysis.labels import LONGEST_PERIOD

CLOSE = 1e-8  # relative distance of a state to the one a period before
SHRINKS = 0.95  # what a period leaves of that distance
NOTHING_LEFT = 1e-13  # a distance that need not shrink


def repeats(states: Sequence[tuple[float, float]], symbols: Sequence[float]) -> int:
    """Turns m <= LONGEST_PERIOD after which the end of a record repeats, or 0.

    The last three periods have the same symbols, and each is nearer to the one before than that one
    was, at last within CLOSE of the largest state.
    """
    n = len(states)
    size = [max((abs(state[j]) for state in states), default=0.0) or 1.0 for j in range(2)]

    def distance(k: int, m: int) -> float:
        return max(abs(states[k][j] - states[k - m][j]) / size[j] for j in range(2))

    for m in range(1, min(LONGEST_PERIOD, (n - 1) // 3) + 1):
        last = distance(n - 1, m)
        if last > CLOSE or list(symbols[n - 2 * m :]) != list(symbols[n - 3 * m : n - m]):
            continue
        apart = [distance(n - 1 - k * m, m) for k in (2, 1, 0)]
        if last <= NOTHING_LEFT or (
            apart[1] <= SHRINKS * apart[0] and apart[2] <= SHRINKS * apart[1]
        ):
            return m
    return 0
