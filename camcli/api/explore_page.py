"""The page of `cam explore`: what it shows as plain data, and the text of explore.html."""

import json
from base64 import b64encode
from collections.abc import Mapping
from importlib.resources import files
from itertools import pairwise
from math import degrees, radians
from typing import Any

import numpy as np

from camcli.analysis.cam_profile import profile
from camcli.analysis.contact_loss.detachment import detachment
from camcli.analysis.labels import UNDECIDED, Label, period_of
from camcli.analysis.simulate import STICKING, Happening, Simulation
from camcli.api.explore_motions import Explored, PageMotion, labels_of_codes, symbols_of
from camcli.api.lift_table import lost_between
from camcli.api.machine import Machine
from camcli.api.result import Result
from camcli.kernel.cam_table import TURN, lift_at, stretch_at
from camcli.output.run_record import as_json
from camcli.plots import style
from camcli.plots.mechanism import Outline
from camcli.plots.sweep_map import cell_edges
from camcli.quantities import FOLLOWER, drawn, headed
from camcli.system import omega_of, turns_per_second, units_of
from camcli.words.events import event_words
from camcli.words.explore import BASIN_AXES, BASINS, MAP, basin_shares, crank_turns, is_valve
from camcli.words.in_print import name_and_unit
from camcli.words.lift_table import smoothed_cam

PROFILE_ROWS = 720
SMALLEST_HOP = 0.002  # of a chatter, in shares of the hardest impact: less than a pixel
KINDS = ("impact", "chatter", "detachment")


def machine_data(machine: Machine) -> dict[str, Any]:
    """The follower, and the cam as a body and as a function of the cam angle."""
    scene = machine.scene
    system = machine.system
    base = getattr(scene.cam, "base_radius", None)
    body = Outline.of_lift(system, base, scene.cam)
    x, y = body.body
    turn = profile(system, scene.run.rpm, PROFILE_ROWS, None, drawn=False)
    theta, c, c1, c2 = np.array([turn.theta, turn.c, turn.c1, turn.c2])
    follower = scene.follower.model_dump(exclude_none=True)
    return {
        "kind": scene.cam.kind,
        "follower": follower,
        "units": {key: drawn(FOLLOWER[key].unit) for key in follower},
        "strobe_deg": scene.run.strobe_deg,
        "corners": {name: degrees(theta) for name, theta in turn.corners.items()},
        "speeds": [scene.sweep.rpm.start, scene.sweep.rpm.stop, scene.sweep.rpm.num],
        "outline": {
            "x": x[:-1:2], "y": y[:-1:2], "ratio": body.ratio,
            "rise": float(body.radius.min() - c.min() / body.ratio),
            "told": not body.guessed, "flat": body.flat,
        },
        "cam": {
            "theta_deg": np.degrees(theta), "c": c, "c1": c1, "c2": c2,
        },
        "measured": _measured(machine), "valve": is_valve(scene, system),
        "crank": crank_turns(scene, system),
        "seat": system.has_seat, "lash": getattr(scene.cam, "lash", None),
    }  # fmt: skip


def _measured(machine: Machine) -> str:
    """What the error of a measured cam leaves open; empty of a law."""
    between = lost_between(machine.system)
    if between is None:
        return ""
    cam: Any = machine.scene.cam
    accuracy = cam.accuracy
    units = units_of(machine.system)
    first = detachment(machine.system).first
    return smoothed_cam(accuracy, units, between, None if first is None else first.rpm)


def _labels_of_branches(solved: Result) -> set[str]:
    """The labels of all orbits in the table of branches."""
    found = solved.values
    points = (orbit for branch in found.branches for orbit in branch.points)
    return {orbit.label for orbit in (*found.orbits, *points)}


def colour_name(label: str) -> str:
    """The colour of the motion with a label, as the page names it (COLOURS)."""
    return NAMES_OF_KINDS[style.kind_of_label(label)]


def _rows(
    motion: PageMotion, simulation: Simulation, happened: list[Happening], last: float
) -> list[np.ndarray]:
    """The columns t (turns), q, v and rest of a motion, without rows that say nothing.

    happened: its events. last: the time at which it ends, turns.
    """
    seconds, _, q, v, _, _, contact = map(np.array, zip(*simulation.trajectory, strict=True))
    time = seconds * turns_per_second(motion.rpm)
    columns = [column[time <= last] for column in (time, q, v, contact == STICKING)]
    t, _, _, resting = columns
    rest = resting > 0
    kept = np.ones(len(t), bool)
    kept[1:-1] = ~(rest[:-2] & rest[1:-1] & rest[2:])  # there the follower is where the cam is
    hops = _hops(motion, happened)
    for start, end, _ in hops:
        kept &= (t <= start) | (t >= end)  # samples too far apart for hops
    found = np.array([column[kept] for column in columns])
    added = [row for _, _, rows in hops for row in rows]
    if added:
        found = np.hstack((found, np.array(added).T))
        found = found[:, np.argsort(found[0], kind="stable")]
    return list(found)


def _hops(
    motion: PageMotion, happened: list[Happening]
) -> list[tuple[float, float, list[tuple[float, float, float, float]]]]:
    """The hops between the last impact of each chatter and its end, which no event tells.

    Of each chatter: both times (turns), and two rows (t, q, v, rest) an impact, before and after
    it. Each hop is as much shorter and slower than the one before it as the restitution says;
    those slower than SMALLEST_HOP of the hardest impact are left out.
    """
    cam = motion.system.cam
    per_second = turns_per_second(motion.rpm)
    omega = omega_of(motion.rpm)
    hardest = max((abs(one.u_before) for one in happened), default=0.0)
    found = []
    for before, after in pairwise(happened):
        if (before.kind, after.kind) != ("impact", "chatter") or before.turn != after.turn:
            continue
        restitution = motion.system.restitution(stretch_at(cam, radians(before.phase)))
        start = before.seconds * per_second
        end = after.seconds * per_second
        u = -restitution * before.u_before
        rows = []
        left = end - start
        while u > SMALLEST_HOP * hardest:
            left *= restitution
            theta = (motion.system.strobe + TURN * (end - left)) % TURN
            c, slope, _ = lift_at(cam, stretch_at(cam, theta), theta)
            rows += [(end - left, c, slope * omega - u, 0.0)]
            u *= restitution
            rows += [(end - left, c, slope * omega + u, 0.0)]
        found.append((start, end, rows))
    return found


def motion_data(found: Explored) -> dict[str, Any]:
    """The motions one after the other, each with its number of rows, events and points."""
    rows = []
    events = []
    motions = []
    for motion, simulation in zip(found.motions, found.simulations, strict=True):
        per_second = turns_per_second(motion.rpm)
        last = motion.turns * (1.0 + 1e-12)
        happened = [one for one in simulation.events if one.seconds * per_second <= last]
        rows.append(_rows(motion, simulation, happened, last))
        events += [
            (one.seconds * per_second, KINDS.index(one.kind), one.u_before) for one in happened
        ]
        motions.append(
            {
                "rpm": motion.rpm, "label": motion.label, "symbols": symbols_of(motion.label),
                "colour": colour_name(motion.label), "origin": motion.origin,
                "q": motion.q, "v": motion.v, "turns": motion.turns, "loops": motion.loops,
                "period": period_of(motion.label), "stable": motion.stable,
                "exponent": motion.exponent, "place": motion.place, "sets": motion.sets,
                "rows": len(rows[-1][0]), "events": len(happened),
                "impacts": len(motion.impacts[0]), "strobes": len(motion.strobes[0]),
            }
        )  # fmt: skip
    t, q, v, rest = map(np.concatenate, zip(*rows, strict=True))
    at, kind, u = zip(*events, strict=True) if events else ((), (), ())
    theta, speed, positions, velocities = map(
        np.concatenate, zip(*((*m.impacts, *m.strobes) for m in found.motions), strict=True)
    )
    return {
        "motions": motions,
        "rows": {"t": t, "q": q, "v": v, "rest": rest},
        "events": {"t": np.array(at), "kind": np.array(kind, np.uint8), "u": np.array(u)},
        "points": {
            "theta_deg": theta, "u": speed, "q": positions, "v": velocities,
        },
        "branches": _branches(found.parts["orbits"]) if "orbits" in found.parts else [],
        "bifurcations": _bifurcations(found.parts["orbits"]) if "orbits" in found.parts else [],
        "planes": [data(found.parts[name]) for name, data in PLANES.items() if name in found.parts],
    }  # fmt: skip


def _branches(solved: Result) -> list[dict[str, Any]]:
    """The branches as columns; one of impact `k` in `theta_deg[k]` and `u[k]`, NaN without it."""
    table = dict(solved.tables["branch"])
    colours = {label: colour_name(label) for label in _labels_of_branches(solved)}
    columns = {
        name: [table[column] for column in table if column.startswith(prefix)]
        for name, prefix in (("theta_deg", "theta_deg_"), ("u", "u_minus_m_per_s_"))
    }
    for theta, u in zip(columns["theta_deg"], columns["u"], strict=True):
        theta[np.isnan(u)] = np.nan  # of a departure, not of an impact
    found = []
    for number in np.unique(table["branch"]).tolist():
        own = table["branch"] == number
        found.append(
            {
                "rpm": table["rpm"][own].tolist(), "stable": table["stable"][own],
                "label": table["label"][own].tolist(),
                "colour": colours[str(table["label"][own][0])],
                "q": [table["q_m"][own]], "v": [table["v_m_per_s"][own]],
                **{name: [column[own] for column in own_] for name, own_ in columns.items()},
            }
        )  # fmt: skip
    return found


def _bifurcations(solved: Result) -> list[dict[str, Any]]:
    """The events of the branches, one that several share once."""
    found: dict[tuple, dict[str, Any]] = {}
    for b in solved.values.bifurcations:
        q, w = b.orbit.states[0]
        key = (b.kind, b.label, f"{b.value:.10g}")
        found.setdefault(key, {
            "kind": b.kind, "label": b.label, "rpm": b.value, "rpm_error": b.error,
            "corner": b.corner, "classification": b.classification, "words": event_words(b),
            "theta_deg": [degrees(theta) for theta in b.orbit.theta[: len(b.orbit.rates)]],
            "u": [u * omega_of(b.value) for u in b.orbit.rates],
            "q": [q], "v": [w * omega_of(b.value)],
        })  # fmt: skip
    return sorted(found.values(), key=lambda event: event["rpm"])


def _basins_data(landed: Result) -> dict[str, Any]:
    """The window with the attractor of every cell."""
    section = landed.scene.basins
    attractors = landed.tables["attractors"]
    columns = (attractors[name].tolist() for name in ("attractor", "label", "fraction"))
    named = list(zip(*columns, strict=True))
    labels = labels_of_codes(landed)
    place = {number: k for k, (number, _, _) in enumerate(named)}  # 255: below the cam
    codes = [place.get(n, 255) for n in landed.tables["basins"]["attractor"].tolist()]
    shares = [(label, share) for n, label, share in named if n > 0]
    return {
        "of": "start", "name": BASINS, "cells": section.cells,
        "x": section.q, "y": section.v,
        "names": BASIN_AXES,
        "labels": [label for _, label, _ in named],
        "colours": [colour_name(labels.get(number, UNDECIDED)) for number, _, _ in named],
        "codes": np.array(codes, np.uint8),
        "words": basin_shares(section.rpm.start, shares),
    }  # fmt: skip


def kind_of(label: str) -> tuple[int, str, str]:
    """What a map shows of a motion: its period (0: none, or rests), its kind, and the colour."""
    kind = style.kind_of_label(label)
    if kind == style.RESTS:
        return 0, kind, colour_name(label)
    name = f"period {period_of(label)}" if isinstance(label, Label) else kind
    return period_of(label), name, colour_name(label)


def _map_data(result: Result) -> dict[str, Any]:
    """A map as the page draws it: of the motion at every point its period, or that it has none.

    codes: of every point, line after line, the place of its kind in `labels` and `colours`; both
    numbers rise, whatever the order in which they were run.
    """
    study = result.values[0]
    x, y = study.first, study.second
    kinds = [[kind_of(speed.label) for speed in line] for line in study.lines]
    every: set[tuple[int, str, str]] = set()
    for line in kinds:
        every.update(line)
    legend = sorted(every)
    place = {kind: k for k, kind in enumerate(legend)}
    codes = np.array([[place[kind] for kind in line] for line in kinds], np.uint8)
    rising = codes[np.argsort(y)][:, np.argsort(x)]
    return {
        "of": "map", "name": MAP, "cells": [len(x), len(y)],
        "x": cell_edges(x), "y": cell_edges(y),
        "names": [headed(*name_and_unit(key)) for key in study.keys],
        "labels": [name for _, name, _ in legend],
        "colours": [colour for _, _, colour in legend],
        "codes": rising.ravel(),
        "words": "",
    }  # fmt: skip


PLANES = {"basins": _basins_data, "map": _map_data}

# --- one page with the data in it, which needs no other file

COLOURS = {
    "flight": style.FLIGHT, "sticking": style.STICKING, "impact": style.IMPACT,
    "chatter": style.CHATTER, "detachment": style.DETACHMENT, "trouble": style.TROUBLE,
    "cam": style.CAM, "body": style.CAM_BODY, "guide": style.GUIDE, "force": style.FORCES[2],
    **{f"period{k}": colour for k, colour in enumerate(style.PERIODS, 1)},
    "longer": style.LONGER, "rests": style.STICKING, "aperiodic": style.APERIODIC,
    "undecided": style.UNDECIDED,
}  # fmt: skip
NAMES_OF_KINDS = {  # the names of the colours of motions
    **{kind: kind.replace(" ", "") for kind in style.KINDS},
    "longer periods": "longer",
    style.RESTS: "rests",
}
MOTIONS = ("longer", "rests", "aperiodic", "undecided", *(f"period{k}" for k in range(1, 5)))
COLOURS |= {f"area-{name}": style.AREAS[COLOURS[name]] for name in MOTIONS}  # in a map
COLOURS["area-contact"] = style.AREAS[style.CONTACT]

# in this order: a file may use at once what those before it hold, and later what any file holds
SCRIPTS = (
    "start", "numbers", "head", "motion", "words", "axes", "machine", "forces", "lens", "time",
    "phase", "now", "choice", "tour", "diagram", "view", "planes", "play", "share", "picture",
    "paper", "page",
)  # fmt: skip


def page(data: Mapping[str, Any]) -> str:
    """The page that shows the data: plain values, and NumPy arrays of numbers or flags.

    The folder `explore_page` of `camcli.output` holds the page without the data: `page.html`, its
    style and its scripts, which become one text here.
    """
    folder = files("camcli.output") / "explore_page"

    def read(name: str) -> str:
        return (folder / name).read_text(encoding="utf-8")

    colours = " ".join(f"--{name}: {colour};" for name, colour in COLOURS.items())
    text = json.dumps(as_json(data), separators=(",", ":"), allow_nan=False, default=_packed)
    filled = {
        "/*STYLE*/": read("style.css").strip().replace("/*COLOURS*/", colours),
        "/*SCRIPT*/": "\n".join(read(f"{name}.js") for name in SCRIPTS).strip(),
        "/*DATA*/": text.replace("<", "\\u003c"),  # last: it may hold any words
    }
    whole = read("page.html")
    for mark, part in filled.items():
        whole = whole.replace(mark, part)
    return whole


def _packed(array: np.ndarray) -> dict[str, str]:
    """An array as base64 of float32 or uint8."""
    kind = "f4" if array.dtype.kind == "f" else "u1"
    return {kind: b64encode(array.astype(f"<{kind}").tobytes()).decode()}
