"""The answer in a sentence or two, before any table: does contact hold, up to where, what then."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import ceil, floor, isfinite, log10
from typing import Any

import camcli.analysis.contact_loss.detachment as loss
from camcli.analysis.contact_loss.hold import HoldStatus

MM = 1e3  # per m; also N/m per N/mm
RADII = 0.05  # of the largest lift: a smallest lift above it is that of a radius
LARGE_LIFT, LARGE_MASS = 0.1, 1.0  # m, kg: no follower so light moves so far
LARGE_RADIUS = 1.0  # m


def verdict(result: Any, lift_table: Mapping[str, Any] | None) -> str:
    """Sentences on a `Result`; `lift_table`: what run.json says of the error of a measured cam."""
    crank = 2.0 if getattr(result.scene.cam, "angle", "") == "crank" else 0.0
    if result.command == "simulate":
        return _at_one_speed(result, crank)
    found = loss.detachment(result.system)
    if found.always:
        kink = found.always[0].reason is loss.Reason.KINK
        why = "the cam's slope drops" if kink else "the spring does not press even at standstill"
        return f"Contact is lost at every speed: {why} at {found.always[0].theta_deg:.4g} deg."
    if found.first is None:
        return "Contact holds at every speed."
    low, high = lift_table["first_detachment_rpm"] if lift_table else (None, None)
    said = f"Contact holds up to {_speed(found.first.rpm, low, high, crank)}"
    return ". ".join([said + "".join(_past(result)), *_springs(result)]) + "."


def _speed(rpm: float, low: float | None, high: float | None, crank: float) -> str:
    """3347 +- 36 rpm of the cam (6693 of the crank); as many digits as the data deserve."""
    number, error, digits = f"{rpm:.6g}", "", 2
    if low is not None and high is not None:
        width = max(high - rpm, rpm - low)
        digits = max(0, 1 - floor(log10(width))) if width > 0.0 else 6
        number, error = f"{rpm:.{digits}f}", f" +- {ceil(width * 10**digits) / 10**digits:g}"
    elif low is not None:
        error = f" (from {low:.4g} on, or never)"
    return f"{number}{error} rpm of the cam" + f" ({crank * rpm:.{digits}f} of the crank)" * bool(
        crank
    )


def _at_one_speed(result: Any, crank: float) -> str:
    """What one motion did."""
    speed = _speed(result.scene.run.rpm, None, None, crank)
    if "events" not in result.tables:
        return f"The cam, and the force on it at {speed}."
    landing = max((-u for u in result.tables["events"]["u_minus_m_per_s"] if u < 0.0), default=0.0)
    if landing == 0.0:
        return f"At {speed} contact holds in the turns recorded."
    return f"At {speed} contact is lost: the follower lands at up to {landing:.2g} m/s."


def _past(result: Any) -> Iterator[str]:
    """What a sweep saw past the loss of contact."""
    speeds = result.tables.get("speeds")
    if speeds is None or not {"rpm", "max_impact_m_per_s"} <= set(speeds.columns):
        return
    rows = zip(speeds["max_impact_m_per_s"], speeds["max_gap_m"], speeds["rpm"], strict=True)
    landings = [(u, gap, rpm) for u, gap, rpm in rows if isfinite(u) and u > 0.0]
    if landings:
        u, gap = max(row[0] for row in landings), max(row[1] for row in landings)
        top = max(row[2] for row in landings)
        yield f"; past it, up to {top:.6g} rpm, the follower lands at up to {u:.2g} m/s"
        yield f" and flies up to {gap * MM:.2g} mm off the cam"


def _springs(result: Any) -> Iterator[str]:
    """The springs of --hold-to."""
    holds = getattr(result.values, "holds", ())
    ways = {
        loss.Quantity.HOLD_STIFFNESS: "a stiffer spring with the same preload: {k} N/mm",
        loss.Quantity.HOLD_PRELOAD: "more preload on the same spring: {f} N",
        loss.Quantity.HOLD_BOTH: "another spring: {k} N/mm with {f} N of preload",
    }
    springs = [
        ways[hold.quantity].format(k=f"{hold.stiffness / MM:.4g}", f=f"{hold.preload:.4g}")
        for hold in holds
        if hold.status is HoldStatus.OK
    ]
    if holds:
        rpm, margin = result.scene.detach.hold_to, result.scene.detach.margin_n
        what = (
            "; or ".join(springs) if springs else "the spring as it is, or none at all: see below"
        )
        yield f"To hold up to {rpm:g} rpm of the cam with {margin:g} N to spare: {what}"


def doubts(scene: Any) -> Iterator[str]:
    """What of a machine is probably a wrong unit or sign."""
    follower, cam = scene.follower, scene.cam
    lift = getattr(cam, "lift", None)
    if cam.kind == "table":
        lift = float(max(cam.measured.lift))
        least = float(min(cam.measured.lift))
        if least > RADII * lift:
            yield (
                f"warning: the smallest lift of the table is {least * MM:.4g} mm; if these are "
                f"radii, write base: {-least:.6g}"
            )
    if isinstance(lift, float) and lift > LARGE_LIFT and follower.mass < LARGE_MASS:
        yield f"warning: a lift of {lift * MM:.4g} mm; is it in m, or cam.lift the file's unit?"
    radius = getattr(cam, "base_radius", None)
    if radius is not None and radius > LARGE_RADIUS:
        yield f"warning: a base radius of {radius:.4g} m; is it in m?"
    if follower.preload < 0.0:
        yield (
            f"warning: a preload of {follower.preload:.4g} N pulls the follower off the cam at "
            "q = 0; positive presses"
        )
