"""The machine in words: its numbers, and what of it is probably a wrong unit or sign."""

from collections.abc import Iterator
from math import inf
from typing import Any

from camcli.analysis.throw import Throw
from camcli.cams import cam_name
from camcli.cams.compile import lift_range
from camcli.quantities import FOLLOWER, MM, SHAFTS
from camcli.scene.speeds import CRANK
from camcli.system import units_of
from camcli.words.in_print import with_minus_signs

RADII = 0.05  # of the largest lift: a smallest lift above it is that of a radius
LARGE_LIFT, LARGE_MASS = 0.1, 1.0  # m, kg: no follower so light moves so far
LARGE_RADIUS = 1.0  # m
LARGE_WIDTH = 0.5  # m, of the line on which a cam is pressed
FLAT = 0.01  # of the preload: a spring that adds less over the lift is none that is wound
WEIGHT = 9.81  # m/s2
ABSURD = 1000.0  # times the lift: the height of a flight


def crank_of(scene: Any) -> float:
    """Turns of the crank in a turn of the cam; 0 where there is no crank."""
    is_there = scene.run.crank or getattr(scene.cam, "angle", "") == CRANK
    return 1.0 / SHAFTS[CRANK] if is_there else 0.0


def digits_of(scene: Any) -> int:
    """Significant digits of what follows from the cam alone: a measured one deserves fewer."""
    return 4 if scene.cam.kind == "table" else 6


def machine(result: Any) -> list[list[str]]:
    """The machine in rows of a name and a value, for the page of a report."""
    follower = result.system.follower
    cam = result.scene.cam
    units = units_of(result.system)
    low, high = lift_range(result.system.cam)  # with a lash, of the follower
    lash = result.system.lash if result.system.has_seat else 0.0
    rows = [
        ["mass", f"{follower.mass:.4g} {FOLLOWER['mass'].unit}"],
        ["spring", units.stiffnesses(follower.stiffness)],
        ["force at lowest lift", f"{follower.preload + follower.stiffness * low:.4g} N"],
        ["force at full lift", f"{follower.preload + follower.stiffness * high:.4g} N"],
        ["damping", f"{follower.damping:.4g} {FOLLOWER['damping'].unit}"],
        ["restitution", f"{follower.restitution:.3g}"],
        ["cam", cam_name(cam)],
        ["lift", units.lengths(high - low + lash, 4)],
    ]
    ratio = result.system.rocker_ratio
    if ratio != 1.0:
        rows.append(["rocker ratio", f"{ratio:.6g}"])
        if cam.kind == "table":
            rows.append(["table of the", cam.measured_at])
    if result.system.has_seat:
        on_seat = follower.seat_restitution
        if on_seat is None:
            on_seat = follower.restitution
        rows.append(["lash", units.lengths(lash, 4)])
        if lash:
            rows.append(["lift less lash", units.lengths(high - low, 4)])
        rows.append(["restitution, seat", f"{on_seat:.3g}"])
    rows = [["machine", ""], *rows, *_parts(result)]
    return [[name, with_minus_signs(value)] for name, value in rows]


def _parts(result: Any) -> list[list[str]]:
    """Rows of the parts that surge and Hertz pressure are worked out for: spring and lobe."""
    spring = result.scene.spring
    contact = result.scene.contact
    units = units_of(result.system)
    rows = []
    if spring is not None and spring.mass is not None:
        rows.append(["mass of the spring", f"{spring.mass:.4g} {FOLLOWER['mass'].unit}"])
    if contact is not None:
        radius = contact.follower_radius
        face = contact.face or ("flat" if radius is None else "roller")
        roller = "" if radius is None else f" of {units.lengths(radius, 4)}"
        rows.append(["on the lobe", f"{face}{roller}"])
        if contact.base_radius is not None:
            rows.append(["base radius", units.lengths(contact.base_radius, 4)])
        if contact.width is not None:
            rows.append(["width of contact", units.lengths(contact.width, 4)])
    return rows


def report_title(cam: Any) -> str:
    """The title of the page for print."""
    return f"Contact of cam and follower: {cam_name(cam)}"


def doubts(scene: Any) -> Iterator[str]:
    """What of a machine is probably a wrong unit or sign."""
    follower = scene.follower
    cam = scene.cam
    if cam.kind == "table":
        yield from _doubt_of_radii(cam)
    lift, top = _lift_and_top(cam)
    if lift > LARGE_LIFT and follower.mass < LARGE_MASS:
        yield f"warning: a lift of {lift * MM:.4g} mm; is it in m, or is cam.lift the file's unit?"
    radius = getattr(cam, "base_radius", None)
    if radius is not None and radius > LARGE_RADIUS:
        yield f"warning: a base radius of {radius:.4g} m; is it in m?"
    solid = getattr(scene.spring, "solid_at", None)
    if solid is not None and solid < top:
        yield f"warning: the spring is solid at {solid * MM:.4g} mm, below the highest lift"
    if follower.preload < 0.0:
        yield (
            f"warning: a preload of {follower.preload:.4g} N pulls the follower off the cam at "
            "q = 0; a positive one presses"
        )
    yield from _doubts_of_sizes(scene, lift, top)


def _lift_and_top(cam: Any) -> tuple[float, float]:
    """The lift of a cam and its highest c, m; 0 where they are not known before it is compiled."""
    if cam.kind == "table":
        lift = float(max(cam.measured.lift))
        return lift, cam.base + lift
    if cam.kind == "arcs":
        top = cam.nose_center + cam.nose_radius - cam.offset
        bottom = cam.base_radius - cam.offset
        return top - bottom, top
    lift = getattr(cam, "lift", 0.0)
    return lift, getattr(cam, "base", 0.0) + lift


def _doubt_of_radii(cam: Any) -> Iterator[str]:
    """A warning where the lifts of a table are probably radii."""
    lift = float(max(cam.measured.lift))
    least = float(min(cam.measured.lift))
    if least > RADII * lift:
        in_file = float(f"{least / cam.metres + cam.subtract:.12g}")  # in the unit of the table
        yield (
            f"warning: the smallest lift of the table is {least * MM:.4g} mm; if these are "
            f"radii, write subtract: {in_file:.10g}"
        )


def _doubts_of_sizes(scene: Any, lift: float, top: float) -> Iterator[str]:
    """What of the spring, the masses and the contact is probably in another unit.

    lift, top: of the cam, m; 0 where it is not known before the cam is made.
    """
    follower = scene.follower
    spring = scene.spring
    added = follower.stiffness * lift
    if 0.0 < added < FLAT * follower.preload:
        yield (
            f"warning: a stiffness of {follower.stiffness:.4g} N/m adds {added:.2g} N over the "
            f"lift to a preload of {follower.preload:.4g} N; is it in N/m?"
        )
    force = follower.preload + follower.stiffness * top
    is_heavy = lift != 0.0 and follower.mass > LARGE_MASS and force > 0.0
    if is_heavy and force < WEIGHT * follower.mass:
        yield (
            f"warning: a mass of {follower.mass:.4g} kg weighs more than the {force:.4g} N of the "
            "spring at the highest lift; is it in kg?"
        )
    if spring is not None and spring.mass is not None:
        third = spring.mass / 3.0
        others = follower.mass - third
        yield f"note: moving mass: {others:.4g} + {third:.4g} kg, a third of the spring"
        if spring.mass > others:
            yield (
                f"warning: a spring of {spring.mass:.4g} kg is heavier than the {others:.4g} kg "
                "that it moves; is it in kg?"
            )
    width = getattr(scene.contact, "width", None)
    if width is not None and width > LARGE_WIDTH:
        yield f"warning: a contact width of {width:.4g} m; is it in m?"
    hold_to = scene.detach.hold_to
    crank = crank_of(scene)
    run_rpm = getattr(scene.run, "rpm", None) or 0.0
    if crank and hold_to is not None and hold_to == crank * run_rpm:
        yield (
            f"note: hold_to is {hold_to:.10g} rpm of the cam ({crank * hold_to:.10g} of the "
            "crank), twice run.rpm: was the crank meant?"
        )


def height_notes(throw: Throw) -> list[str]:
    """A warning where the cam throws the follower absurdly high."""
    if not ABSURD * throw.lift < throw.height < inf:
        return []
    return [
        f"warning: at {throw.rpm:.10g} rpm the cam throws the follower {throw.height:.3g} m up, "
        f"{throw.height / throw.lift:.3g} times its lift: a model of rigid bodies means little "
        "there"
    ]


def lossless_notes(scene: Any) -> list[str]:
    """A warning where the motion loses no energy."""
    if scene.follower.restitution == 1.0 and scene.follower.damping == 0.0:
        return [
            "warning: restitution 1 and no damping: nothing dissipates, so no orbit attracts "
            "another"
        ]
    return []
