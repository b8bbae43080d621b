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
    if resting == turns:
        return "bounces to rest every turn"
    if resting:
        return f"rests in {resting} of {turns} turns"
    impacts = plural(int(sum(symbols)), "impact")
    return f"{impacts} every turn" if turns == 1 else f"{impacts} in {turns} turns"
