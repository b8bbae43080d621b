"""Rows 15, 16 and 21 to 23: critical speeds, corners and the strobe."""

from __future__ import annotations

from itertools import pairwise
from math import nextafter, pi

from camcli.analysis.bench.machine import Bench, events, phases, reference, run
from camcli.analysis.bench.row import Row, need
from camcli.errors import OK

FIRST_DETACHMENT = 114.979326744  # rpm
INCOMPLETE = 198.5605  # rpm
WEAK = 1e-9  # relative error of speeds of 1e-9 m/s


def corner(bench: Bench, number: int) -> float:
    """Phase of a corner of the chapter's cam, counted from a = 0; rad."""
    return bench.chapter().corners_deg[number] * (pi / 180.0)


def first_detachment(bench: Bench) -> str:
    """1e-5 rpm below no event; as much above, the follower leaves exactly at b."""
    low, high = (run(bench.chapter(), FIRST_DETACHMENT + d, record=3) for d in (-1e-5, 1e-5))
    need(not events(low), f"{len(events(low))} events below")
    kind, turn, theta, _, _ = events(high)[0]
    off = abs(theta - corner(bench, 1))
    need((kind, turn) == ("detachment", 0) and off < 1e-15, f"{kind} at {theta!r} above")
    return "no event below; detachment at b above"


def weak_impacts(bench: Bench) -> str:
    """114.98 rpm: hops near b against the oracle's, each weaker than the one before."""
    stored = reference("stability")["weak"]
    rpm, wanted = stored["rpm"], stored["impacts"]
    rows = events(run(bench.chapter(), rpm, record=1))
    hits = [(x, u * rpm * pi / 30.0) for kind, _, x, _, u in rows if kind == "impact" and x < pi]
    need(len(hits) >= len(wanted), f"{len(hits)} impacts")
    need(all(b[1] > a[1] for a, b in pairwise(hits)), "a hop gains speed")
    off = max(abs(u / float(w) - 1.0) for (_, u), (_, w) in zip(hits, wanted, strict=False))
    need(off < WEAK, f"speeds off by {off:.1e}")
    return f"{len(hits)} impacts from {-hits[0][1]:.2e} m/s down; speeds right to {off:.1e}"


def on_a_corner(bench: Bench) -> str:
    """Speeds within 6 ulp of the one whose first impact is exactly on c: one impact there."""
    low, high, c = 124.99, 125.01, corner(bench, 2)
    while nextafter(low, high) < high:
        middle = 0.5 * (low + high)
        first = phases(run(bench.chapter(), middle, record=1))[0]
        low, high = (middle, high) if first < c else (low, middle)
    speeds = [low]
    for _ in range(6):
        speeds = [nextafter(speeds[0], 0.0), *speeds, nextafter(speeds[-1], 999.0)]
    for rpm in speeds:
        rows = events(run(bench.chapter(), rpm, record=1, tolerance=1e-16))
        here = [kind for kind, _, theta, _, _ in rows if abs(theta - c) < 1e-12]
        hops = [e for e in rows if e[0] == "impact" and c + 1e-12 < e[2] < 3.2]
        need(here == ["impact"] and len(hops) > 20, f"{here} and {len(hops)} hops at {rpm!r} rpm")
    return f"one impact on c at {len(speeds)} speeds around {low:.9f} rpm; its hops follow"


def on_the_strobe(bench: Bench) -> str:
    """The strobe a few ulp around the impact of P(1;1): each impact in exactly one period."""
    phase = phases(run(bench.chapter(), 700.0, record=1, transient=2000))[0] * 180.0 / pi
    strobes = [phase]
    for _ in range(8):
        strobes = [nextafter(strobes[0], 0.0), *strobes, nextafter(strobes[-1], 360.0)]
    for strobe in strobes:
        tape = run(bench.chapter(strobe), 700.0, record=50, transient=2000)
        total, logged = int(sum(tape.impacts)), len(phases(tape))
        fits = tape.status == OK and total == logged and 49 <= total <= 51
        need(fits, f"{total} counted; {logged} logged")
    rows = events(run(bench.chapter(), 190.0, record=1, theta_deg=0.0, v=-3.0))
    need(rows[0][:3] == ("impact", 0, 0.0), f"first event {rows[0][:3]}")
    return f"counted once for {len(strobes)} strobes within 8 ulp; a start on it too"


def completion(bench: Bench) -> str:
    """From rest, the chatter of the first turn ends in the second before b, or not at all."""
    complete = [
        bool(run(bench.chapter(), INCOMPLETE - 0.01 + 0.001 * k, record=2).chatter[1])
        for k in range(21)
    ]
    once = complete == sorted(complete, reverse=True) and complete[0] and not complete[-1]
    need(once, f"complete: {complete}")
    last = INCOMPLETE - 0.01 + 0.001 * (sum(complete) - 1)
    return f"complete up to {last:.4f} rpm; incomplete from {last + 0.001:.4f} rpm"


ROWS = (
    Row(
        "15: 114.979326744 rpm +- 1e-5", "no impact below; detachment at b above", first_detachment
    ),
    Row("16: 114.98 rpm", "impacts of about 1e-7 m/s resolved", weak_impacts),
    Row("21: impact exactly on a corner", "once", on_a_corner),
    Row("22: event exactly at the strobe", "counted in exactly one period", on_the_strobe),
    Row("23: 198.5605 +- 0.01 rpm", "complete to incomplete chatter once", completion),
)
