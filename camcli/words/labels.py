"""The label of a motion in words."""

from math import inf

from camcli.analysis.labels import APERIODIC, CONTACT, Label
from camcli.errors import plural
from camcli.words.speeds import on_the_cam


def motion(label: str, kind: str = "") -> str:
    """A label in words; kind: of the cam."""
    if not isinstance(label, Label):
        words = {CONTACT: f"stays {on_the_cam(kind)}", APERIODIC: "never repeats"}
        return words.get(label, "not known")
    symbols = label.symbols
    turns = len(symbols)
    resting = symbols.count(inf)
    if resting == turns:
        return "bounces to rest every turn"
    if resting:
        return f"rests in {resting} of {turns} turns"
    impacts = plural(int(sum(symbols)), "impact")
    return f"{impacts} every turn" if turns == 1 else f"{impacts} in {turns} turns"
