"""camcli.classify: the motion at every speed by name, its exponents, and why they change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import degrees
from typing import TYPE_CHECKING, Any

from camcli.analysis.classify import ClassifiedMotion
from camcli.analysis.classify import classify as run
from camcli.analysis.integrate import Cost
from camcli.analysis.sweep import status_name
from camcli.analysis.throw import throw
from camcli.api.command import Command, Drawing, Size, fewer, sample
from camcli.api.explanation import corners_table, explained, explanation_of
from camcli.api.machine import Machine, check_explainable, machine_of, span_of
from camcli.api.result import Progress, Result, drawn_by, ticks
from camcli.api.rows import CORNERS
from camcli.errors import Status, worst_status
from camcli.kernel.backend import stopwatch
from camcli.output.tables import Table
from camcli.parallel import Work
from camcli.piece_faults import gather, gathering, piece
from camcli.quantities import (
    EXPONENT,
    EXPONENT_ERROR,
    HOLDS_FOR,
    LABEL,
    PERIOD,
    STABLE,
    STATUS,
    VARIED,
    WATCHED,
    Head,
    Quantity,
)
from camcli.scene import Scene
from camcli.words import plan
from camcli.words.classify import remarks
from camcli.words.machine import height_notes
from camcli.words.statuses import status_notes, trouble

if TYPE_CHECKING:
    from camcli.analysis.explain.changes import CriticalEvent, Explanation

CLASSIFY = Head(
    "classify",
    "an attractor found each",
    (
        VARIED, LABEL, PERIOD._replace(entries="0: it does not"),
        Quantity(
            "impacts", "", "impacts", "impacts in one period, else the mean in a turn",
            "inf with a complete chatter",
        ),
        Quantity(
            "chatter", "", "chatter", "whether impacts accumulate",
            "complete; incomplete: 8 impacts in a row, each weaker, that do not; none",
        ),
        STABLE._replace(entries="1, 0, empty where no orbit is solved"),
        EXPONENT, STATUS, HOLDS_FOR, WATCHED, EXPONENT_ERROR,
    ),
)  # fmt: skip


def classify(
    scene: Scene | None = None, progress: Progress | None = None, *, work: Work | None = None
) -> Result:
    """Name the motion at every speed of ``scene.classify.rpm`` and measure its exponents.

    A motion is called periodic when Newton's method solves its orbit and the motion approaches it,
    aperiodic when its largest Lyapunov exponent is positive by three standard errors and it neither
    settles nor rests in ``run.patience`` further turns, and undecided otherwise.

    Parameters
    ----------
    scene : Scene, optional
        The machine and the section ``classify``: ``rpm.start``, ``rpm.stop``, ``rpm.num``, or
        ``vary`` for another number (``key``, ``start``, ``stop``, ``num``), at the speed
        ``run.rpm``. The default scene if left out.
    progress : callable, optional
        Called as ``progress(what, done, total)``.
    work : Work, optional
        Its number of threads is used; it never changes a result.

    Returns
    -------
    Result
        Tables ``classify`` and, with ``explain``, ``corners``; their columns are in the guide
        (`cam guide classify`).

        holds_for: after a rest whose motion doubles forget before it settles, the label is where
        the scene's own start ends, decided in ball arithmetic, and this says for which machines.
        last-digit: proved for every speed that rounds to this one; exact-data: for these data as
        they are, others within the last digit may do otherwise; rounding: where this start ends
        could not be followed so far, and rounding chose the attractor of the label. Else empty.

    Raises
    ------
    SceneError
        If the start lies below the cam, or changes shall be explained of a single speed or of
        another number than the speed.

    Examples
    --------
    >>> import camcli
    >>> speeds = {"classify.rpm.start": 100, "classify.rpm.stop": 700, "classify.rpm.num": 2}
    >>> camcli.classify(camcli.load_scene(None, speeds)).tables["classify"]["label"].tolist()
    ['contact', 'P(1;1)']

    References
    ----------
    Derivative of the motion across impacts: R. I. Leine and H. Nijmeijer, Dynamics and Bifurcations
    of Non-Smooth Mechanical Systems (2004).
    """
    machine = machine_of(scene)
    section = machine.scene.classify
    if section.explain:
        check_explainable(section, "classify")
    key, values, setup = span_of(machine, section)
    with stopwatch() as watch, gathering() as faults:
        motions = run(
            machine.system,
            machine.settings,
            values,
            section.starts,
            section.seed,
            None if work is None else work.threads,
            ticks(progress, "speeds", len(values)),
            setup,
            key,
        )
        gather(motion.fault for motion in motions if motion.fault is not None)
        explanation = explanation_of(machine, motions, progress) if section.explain else None
        summary = piece("the summary", lambda: _summary(motions, explanation, key), {})
    result = _result(machine, key, motions, explanation, summary)
    return replace(result, seconds=watch.seconds, faults=tuple(faults))


def _result(
    machine: Machine,
    key: str,
    motions: list[ClassifiedMotion],
    explanation: Explanation | None,
    summary: dict[str, Any],
) -> Result:
    """The result of the classified motions, still without its time and its faults.

    key: what is varied; explanation: of the changes, None where it was not asked for.
    """
    cost = sum((motion.cost for motion in motions), Cost())
    statuses = [motion.status for motion in motions]
    events: Sequence[CriticalEvent] = ()
    why_cut_short: list[str] = []  # a note where the explanation is not complete
    if explanation is not None:
        cost += explanation.cost
        statuses.append(explanation.status)
        events = explanation.events
        why_cut_short = trouble(explanation.status)
    troubled = [(motion.value, motion.status) for motion in motions if motion.status != Status.OK]
    fastest = max((motion.rpm for motion in motions), default=0.0)
    heights = height_notes(throw(machine.system, fastest))
    return Result(
        command="classify",
        scene=machine.scene,
        system=machine.system,
        values=(motions, explanation),
        tables={
            "classify": Table.of_rows(CLASSIFY.names(key), lambda: map(_row, motions)),
            "corners": corners_table(explanation),
        },
        summary={**summary, "status": worst_status(statuses)},
        pictures={
            "classify": drawn_by("classify.draw_classify", motions, machine.system, events, key)
        },
        cost=cost,
        notes=(*heights, *status_notes(troubled, key), *why_cut_short),
        complete=not troubled and not why_cut_short,
    )


def _summary(
    motions: list[ClassifiedMotion], explanation: Explanation | None, key: str
) -> dict[str, Any]:
    """What run.json keeps: remarks in sentences, the motions, and with explain the changes."""
    return {
        "words": remarks(motions, key),
        "motions": [_motion_record(motion) for motion in motions],
        **(explained(explanation) if explanation else {}),
    }


def _row(motion: ClassifiedMotion) -> tuple:
    """A row of classify.csv, in the order of the columns of `CLASSIFY`."""
    exponents = motion.exponents
    return (
        motion.value,
        motion.label,
        motion.period,
        None if motion.fault is not None else motion.impacts,
        motion.chatter,
        None if motion.stable is None else int(motion.stable),
        None if exponents is None else exponents.largest,
        status_name(motion.status),
        motion.holds_for,
        motion.watched,
        None if exponents is None else exponents.spread,
    )


def _motion_record(motion: ClassifiedMotion) -> dict[str, Any]:
    """The entry of run.json for a motion; angles in degrees, numbers in SI."""
    start = motion.start
    record: dict[str, Any] = {
        "value": motion.value,
        "rpm": motion.rpm,
        "label": motion.label,
        "period": motion.period,
        "impacts": motion.impacts,
        "chatter": motion.chatter,
        "stable": motion.stable,
        "transient_turns": motion.transient,
        "status": status_name(motion.status),
        "start": {
            "q": start.q,
            "v": start.v,
            "theta_deg": degrees(start.theta),
            "place": start.place,
        },
        "holds_for": motion.holds_for,
        "watched_turns": motion.watched,
        "turns": motion.record.periods,
        "complete_chatters": motion.chatters,
        "multipliers": None if motion.orbit is None else motion.orbit.multipliers,
        "exponents": None,
    }
    exponents = motion.exponents
    if exponents is not None:
        record["exponents"] = {
            "largest": exponents.largest,
            "second": exponents.second,
            "standard_error": exponents.spread,
            "sum_rule": exponents.rule,
            "defect": exponents.defect,
        }
    return record


# --- the command


SAMPLED_STARTS = 5  # at each speed of a sample: more find hardly more attractors


def _size(scene: Scene) -> Size:
    """Each start at each speed is an orbit. Bytes are measured."""
    run = scene.run
    speeds = scene.classify.count
    starts = scene.classify.starts + 1  # with the scene's own
    orbits = speeds * starts
    return Size(
        what=plan.motions_at_speeds(speeds, starts, run.record),
        pieces=orbits,
        orbits=orbits,
        turns=orbits * (run.transient + run.record),
        rows=speeds,
        memory=45.0 * speeds * run.record,
        tables=160.0 * speeds,
        kept=0.0,
    )


def _sample(scene: Scene, n: int) -> Scene:
    """n speeds with few starts each, and no explanation."""
    section = scene.classify
    few = {"starts": min(SAMPLED_STARTS, section.starts), "explain": False}
    return sample(scene, "classify", **few, **fewer(section, n))


COMMAND = Command(
    run=classify,
    tables=(CLASSIFY, CORNERS),
    files=("classify.png",),
    size=_size,
    drawing=lambda scene: Drawing(file=130e3, memory=230e6, per_pixel=24.0),
    sample=_sample,
    not_foreseen=plan.classify,
)
