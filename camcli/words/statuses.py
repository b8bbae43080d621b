"""What a status says: its cause, what to do about it, and where it was met."""

from collections.abc import Iterable, Sequence

from camcli.errors import Status, plural

NAMED = 5  # values that a note names; of more it says only how many they are
CAUSES = {
    Status.LOG_FULL: "the event log was too small",
    Status.IMPACT_BUDGET: "one turn had as many impacts as run.impact_budget allows",
    Status.NO_RETURN: "the follower left the cam and nothing brings it back",
    Status.UNRESOLVED: "a contact is closer to grazing than double precision can tell",
    Status.PAUSED: "the work was interrupted",
    Status.WORK_BUDGET: "the budget of work was used up, and the rest is left out",
    Status.FAULT: "an exception that nobody foresaw cost this piece alone",
}
CURES = {
    Status.LOG_FULL: "this is a fault of the program",
    Status.IMPACT_BUDGET: (
        "raise run.impact_budget, raise run.chatter_tolerance, or lower restitution"
    ),
    Status.NO_RETURN: "give the follower a spring, gravity or a preload",
    Status.UNRESOLVED: ("move the speed by a relative 1e-12, or treat both outcomes as possible"),
    Status.PAUSED: "run the same command again",
    Status.WORK_BUDGET: "raise run.work_budget",
    Status.FAULT: "this is a fault of camcli, please report it with run.json",
}


def trouble(code: int, where: str = "") -> list[str]:
    """A sentence on a status: what happened and what to do; none where all is well.

    where: what the status belongs to, such as ` at 2 speeds`.
    """
    status = Status(code)
    if status == Status.OK:
        return []
    return [f"{status.text}{where}: {CAUSES[status]}; {CURES[status]}"]


def counted(values: Sequence[float], key: str) -> str:
    """So many values of what is varied, the first of them named: `2 speeds (358, 359 rpm)`."""
    named = ", ".join(f"{value:.10g}" for value in values[:NAMED])
    if len(values) > NAMED:
        named += ", ..."
    if key == "rpm":
        return f"{plural(len(values), 'speed')} ({named} rpm)"
    return f"{plural(len(values), 'value')} of {key} ({named})"


def status_notes(troubled: Iterable[tuple[float, int]], key: str = "rpm") -> list[str]:
    """A sentence for each kind of trouble; troubled: (value of what is varied, status)."""
    by_status: dict[int, list[float]] = {}
    for value, code in troubled:
        by_status.setdefault(code, []).append(value)
    sentences = []
    for code, values in sorted(by_status.items()):
        sentences += trouble(code, f" at {counted(values, key)}")
    return sentences
