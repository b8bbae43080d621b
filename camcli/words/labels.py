"""The label of a motion in words."""

from math import inf

from camcli.analysis.labels import APERIODIC, CONTACT, Label
from camcli.errors import plural


def motion(label: str) -> str:
    """A label in words."""
    if not isinstance(label, Label):
        words = {CONTACT: "stays on the cam", APERIODIC: "never repeats"}
        return words.get(label, "not known")
    symbols = label.symbols
    turns, resting = len(symbols), symbols.count(inf)
    repeats = "every turn alike" if turns == 1 else f"repeats every {turns} turns"
    if resting:
        in_turns = "" if resting == turns else f" in {resting} of them"
        return f"{repeats}, bounces to rest{in_turns}"
    return f"{repeats}, {plural(int(sum(symbols)), 'impact')}"
