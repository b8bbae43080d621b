"""cam simulate --profile-only"""

from __future__ import annotations

from functools import partial
from math import isfinite
from time import perf_counter
from typing import Any

from camcli.analysis.cam_profile import Extreme, Profile, profile
from camcli.analysis.integrate import Cost
from camcli.cli.exit_codes import DONE, note
from camcli.cli.options import Request
from camcli.cli.report import finish, table
from camcli.cli.setup import Setup
from camcli.errors import Fault, SceneError
from camcli.output.cam_profile import profile_csv
from camcli.output.run_folder import RunFolder, run_folder

NAME = "simulate"
NOTHING = 1e-18  # m, rounding of a lift
UNITS = {"c": "m", "c_theta": "m/rad", "c_thetatheta": "m/rad2"}


def run_profile(request: Request, setup: Setup) -> int:
    """Write and draw the cam of a scene; returns the exit code."""
    base = _base_radius(request, setup)
    if request.dry_run:
        points = setup.scene.simulate.samples
        table("cam simulate --profile-only, planned", ["what", "how much"], [["rows", str(points)]])
        return DONE
    with run_folder(request.folder(NAME)) as store:
        began = perf_counter()
        result = profile(setup.system, setup.scene.run.rpm, setup.scene.simulate.samples, base)
        seconds = perf_counter() - began
        store.write_text("profile.csv", profile_csv(setup.system, result))
        _draw(request, setup, store, result)
        if not request.json:
            _show(result)
        finish(NAME, request, setup, store, Cost(), seconds, _summary(result), False)
    if not request.quiet and result.curvature.undercut:
        least = result.curvature.flat_least
        note(
            f"warning: a flat-faced follower undercuts this cam: the radius of curvature would be "
            f"{least.value:.4g} m at {least.theta_deg:.5g} deg; the base radius must exceed "
            f"{result.curvature.least_base_radius:.4g} m (knife edge and roller have other limits)"
        )
    return DONE


def _base_radius(request: Request, setup: Setup) -> float | None:
    given = request.extra.get("base_radius")
    if given is None:
        return getattr(setup.scene.cam, "base_radius", None)
    if not (isfinite(given) and 0.0 < given <= 1e6):
        found, expected = f"found {given}", "expected a radius greater than 0, at most 1e6"
        raise SceneError(Fault("--base-radius", "", found, expected, "give it in m"))
    return given


def _draw(request: Request, setup: Setup, store: RunFolder, result: Profile) -> None:
    if request.no_plot:
        return
    from camcli.output.pictures import write_png
    from camcli.plots.cam_profile import Measured, draw_profile

    cam, measured = setup.scene.cam, None
    if cam.kind == "table":
        turn, words = cam.measured, f"error below {cam.accuracy.bound:.2g} m/rad²"
        rows = [k for k, line in enumerate(turn.line) if line]
        lift = [cam.base + turn.lift[k] for k in rows]
        measured = Measured([turn.theta[k] for k in rows], lift, cam.errors.bounds, words)
    figure = draw_profile(result, measured, setup.scene.simulate.profile_panels)
    store.write("profile.png", partial(write_png, figure))


def _extreme(extreme: Extreme | None) -> dict[str, float] | None:
    return None if extreme is None else {"value": extreme.value, "theta_deg": extreme.theta_deg}


def _summary(result: Profile) -> dict[str, Any]:
    bent, first = result.curvature, result.first
    return {
        "rpm": result.force.rpm,
        "corners_deg": result.corners,
        "ranges": {
            f"{name} ({UNITS[name]})": [_extreme(low), _extreme(high)]
            for name, (low, high) in result.ranges.items()
        },
        "least_force_n": {"value": result.force.lowest_n, "theta_deg": result.force.lowest_deg},
        "first_detachment_rpm": first.rpm if first is not None and first.finite else None,
        "base_radius_m": bent.base_radius,
        "flat_faced": {
            "least_radius_m": _extreme(bent.flat_least) if bent.base_radius else None,
            "undercut": bent.undercut if bent.base_radius else None,
            "least_base_radius_m": bent.least_base_radius,
        },
        "largest_roller_radius_m": _extreme(bent.roller),
        "assumed": "the follower moves along a line through the axis, at base_radius + c - least c",
    }


def _show(result: Profile) -> None:
    rows = []
    for name, (low, high) in result.ranges.items():
        for word, extreme in (("least", low), ("largest", high)):
            place = f"{extreme.theta_deg:.6g}"
            value = extreme.value if abs(extreme.value) > NOTHING else 0.0
            rows.append([f"{word} {name} ({UNITS[name]})", f"{value:.7g}", place])
    force, bent = result.force, result.curvature
    rows.append(
        [f"least contact force at {force.rpm:.10g} rpm (N)", f"{force.lowest_n:.7g}",
         f"{force.lowest_deg:.6g}"]
    )  # fmt: skip
    if result.first is not None and result.first.finite:
        first = result.first
        rows.append(["first detachment (rpm)", f"{first.rpm:.10g}", f"{first.theta_deg:.6g}"])
    if bent.base_radius is not None:
        least = bent.flat_least
        words = "least radius of curvature, flat face (m)"
        rows.append([words, f"{least.value:.5g}", f"{least.theta_deg:.6g}"])
    rows.append(["base radius a flat face needs (m)", f"{bent.least_base_radius:.5g}", ""])
    if bent.roller is not None:
        place = f"{bent.roller.theta_deg:.6g}"
        rows.append(["largest roller radius (m)", f"{bent.roller.value:.5g}", place])
    corners = ", ".join(f"{name} {theta:.8g}" for name, theta in result.corners.items())
    table(f"Cam, corners (deg): {corners or 'none'}", ["what", "value", "theta (deg)"], rows)
