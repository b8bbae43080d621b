"""What `cam detach` found, as sentences and as the `result` of run.json."""

from collections.abc import Sequence
from itertools import groupby, pairwise
from math import inf
from typing import Any

from camcli.analysis.contact_loss.accumulation import CornerHit
from camcli.analysis.contact_loss.bursts import LiftOff, LiftOffKind, Settled
from camcli.analysis.contact_loss.detachment import AlwaysLost, CriticalSpeed, Quantity, Reason
from camcli.analysis.contact_loss.hold import ABSURD, Hold, HoldStatus, Obstacle
from camcli.analysis.contact_loss.study import ContactLoss
from camcli.cams import cam_name
from camcli.cams.compile import lift_range
from camcli.errors import Status
from camcli.system import decimals, units_of


def sentences(result: ContactLoss) -> list[str]:
    """What no number says: everything."""
    return [*plainly(result), *theory(result)]


def plainly(result: ContactLoss) -> list[str]:
    """What everybody should know."""
    found, rpms = result.detachment, [speed.rpm for speed in result.speeds]
    first = found.first
    said = [_always(place) for place in found.always]
    if found.never:
        said.append("contact is never lost: the contact force stays positive at every speed")
    if first is not None:
        if first.rpm > max(rpms):
            said.append(f"contact is held at every speed up to {max(rpms):.10g} rpm, all asked for")
        elif first.rpm < min(rpms):
            beyond = " and above" if len(rpms) > 1 else ""
            said.append(f"contact is lost at every speed asked for, {min(rpms):.10g} rpm{beyond}")
    told = [h for h in result.holds if h.status is not HoldStatus.OK]
    return said + [f"{way(h)}: {spring(h)}" for h in told]


def theory(result: ContactLoss) -> list[str]:
    """How contact is lost and chatter changes."""
    losses = result.detachment.losses
    never = [loss.region.name for loss in losses if loss.opens.rpm == inf]
    places = {loss.region.name: loss.opens.theta_deg for loss in losses}
    said = []
    if never and result.detachment.first is not None:
        said.append(f"contact is never lost in {', '.join(never)}, at any speed")
    said += [
        f"at {f.rpm:.10g} rpm, a little above the opening of {f.region}: "
        + _lift_off(f, places[f.region])
        for f in result.lift_offs
    ]
    for hit in result.ended:
        before, after = hit.ends_deg or (inf, inf)
        said.append(
            f"impact {hit.impact} of the burst from {hit.burst} ends at {hit.rpm:.10g} rpm before "
            f"it lands on {hit.corner}: it was at {before:.6g} deg, the next contact is at "
            f"{after:.6g} deg"
        )
    return said + [
        f"at {c.rpm:.10g} rpm the end of the burst from {c.burst} jumps over {c.region}"
        for c in result.jumps
    ]


def _always(place: AlwaysLost) -> str:
    at = f"{place.theta_deg:.10g} deg"
    if place.reason is Reason.KINK:
        drop = f"the cam's slope drops by {place.value:.6g} m/rad at {at}"
        return f"contact is lost at every speed: {drop} and throws the follower off"
    force, cure = f"{place.value:.6g} N", "more preload or weight"
    if place.value == 0.0:
        force, cure = "zero", "a preload, weight or a spring"
    return (
        f"contact is not held even at standstill: the contact force is {force} at {at}; give it "
        f"{cure}"
    )


def _lift_off(seen: LiftOff, place: float) -> str:
    """place: the phase (deg) at which the region opens."""
    lands = "not within two turns"
    if seen.landing_deg < inf:
        lands = f"{seen.landing_deg - place:.3g} deg after"
    if seen.rest_deg < inf:
        lands += f", at rest again {seen.rest_deg - place:.3g} deg after it"
    released = f"released {place - seen.release_deg:.3g} deg before"
    return {
        LiftOffKind.FLIES_OFF: f"flies off at {seen.corner}: the force drops there; lands {lands}",
        LiftOffKind.CAUGHT: f"{released} {seen.corner}, where the force fades; caught {lands}",
        LiftOffKind.WITHIN: f"{released} the weakest phase, lands {lands}",
        LiftOffKind.UNSEEN: "no lift-off was seen: contact is lost at no phase after a rest",
    }[seen.kind]


def way(hold: Hold) -> str:
    """What is done about the present spring."""
    if hold.quantity is Quantity.HOLD_STIFFNESS:
        return f"a {'stiffer' if hold.more else 'softer'} spring with the same preload"
    if hold.quantity is Quantity.HOLD_BOTH:
        return "another spring"
    if hold.status is HoldStatus.NOT_NEEDED:
        return "the same spring without preload"
    return f"{'more' if hold.more else 'less'} preload on the same spring"


def spring(hold: Hold) -> str:
    """A spring that holds, or why none does."""
    alone = hold.quantity is Quantity.HOLD_STIFFNESS
    if hold.obstacle is Obstacle.KINK:
        return "impossible: at a downward kink the cam throws the follower off at any speed"
    if hold.obstacle is Obstacle.SOLID:
        deep = f"{(hold.missing_n or 0.0) * 1e3:.3g} mm before the highest lift"
        return f"impossible: compressed so far the spring is solid {deep}"
    if hold.obstacle is not None:
        lacking = f"{hold.missing_n:.6g} N are missing"
        what = lacking if hold.obstacle is Obstacle.LIFT else "the spring would pull"
        where = f"{what} at {hold.theta_deg:.10g} deg, where c"
        if alone:
            return f"impossible with stiffness alone: {where} <= 0 and a spring does not press"
        return f"impossible: {where} + precompression <= 0; raise detach.precompression_m"
    if hold.status is HoldStatus.NOT_NEEDED:
        what = hold.quantity.removeprefix("hold_").replace("both", "spring")
        return f"no {what} is needed"
    if hold.status is HoldStatus.ABSURD:
        return (
            f"absurd: {hold.nose_n:.4g} N at the highest lift, over {ABSURD:g} times the present "
            "spring's; is the speed of --hold-to right?"
        )
    stiffness, preload = f"stiffness {hold.stiffness:.10g} N/m", f"preload {hold.preload:.10g} N"
    if hold.quantity is Quantity.HOLD_PRELOAD:
        return f"{preload}, stiffness as it is"
    return f"{stiffness}, preload as it is" if alone else f"{stiffness} and {preload}"


def bursts_text(speed: Settled) -> str:
    """A2 complete, A4 complete; none where the follower stays on the cam; or a status."""
    if speed.status != Status.OK:
        return Status(speed.status).text
    said = [
        f"{b.region} {'complete' if b.end_deg is not None else 'incomplete'}".strip()
        for b in speed.bursts
    ]
    return ", ".join(dict.fromkeys(said)) or "none"


def burst_ranges(result: ContactLoss) -> list[tuple[str, float, float, int]]:
    """(bursts in words, from rpm, to rpm, speeds) of neighbouring speeds that behave alike."""
    rows = ((text, list(group)) for text, group in groupby(result.speeds, bursts_text))
    return [(text, speeds[0].rpm, speeds[-1].rpm, len(speeds)) for text, speeds in rows]


def summary(result: ContactLoss) -> dict[str, Any]:
    """The result of run.json; a speed that does not exist is infinite.

    low_rpm and high_rpm are the speeds between which a critical speed lies, null where that is not
    known; of a measured cam they are what the error of its table leaves.
    """
    return {
        "words": sentences(result),
        "critical_speeds": [_critical(c) for c in result.critical_speeds],
        "just_above_opening": [vars(f) for f in result.lift_offs],
        "corner_hits": [_hit(hit) for hit in result.hits],
        "corner_hits_ended": [_hit(hit) for hit in result.ended],
        "accumulation_jumps": [_critical(c) for c in result.jumps],
        "bursts": [
            {"bursts": text, "from_rpm": a, "to_rpm": b, "speeds": n}
            for text, a, b, n in burst_ranges(result)
        ],
        "least_force": [
            {"rpm": f.rpm, "force_n": f.lowest_n, "theta_deg": f.lowest_deg} for f in result.forces
        ],
        "hold": [{**vars(h), "words": spring(h)} for h in result.holds],
        "hold_margin_n": result.margin if result.holds else None,
    }


def _critical(c: CriticalSpeed) -> dict[str, Any]:
    values = {"theta_deg": c.theta_deg if c.finite else None, "rpm": c.rpm}
    ends = {"low_rpm": c.low, "high_rpm": c.high, "status": c.status}
    burst = {"burst": c.burst} if c.burst else {}
    return {"quantity": c.quantity, "region": c.region, **values, **ends, **burst}


def _hit(hit: CornerHit) -> dict[str, Any]:
    row = {"impact": hit.impact, "corner": hit.corner, "rpm": hit.rpm, "burst": hit.burst}
    ends = {"low_rpm": hit.low, "high_rpm": hit.high, "status": hit.status}
    phases = dict(zip(("before_deg", "after_deg"), hit.ends_deg or (), strict=False))
    return {**row, **ends, **phases}


# -- for print ---------------------------------------------------------------------------------

ROUNDING = 1e-9  # N


def crank_of(scene: Any) -> float:
    """Turns of the crank in a turn of the cam; 0 where there is no crank."""
    return 2.0 if getattr(scene.cam, "angle", "") == "crank" else 0.0


def digits_of(scene: Any) -> int:
    """Significant digits of what follows from the cam alone: a measured one deserves fewer."""
    return 4 if scene.cam.kind == "table" else 6


def spacing(speeds: Sequence[float]) -> float:
    """The least between neighbouring speeds, rpm."""
    return min((b - a for a, b in pairwise(sorted(set(speeds)))), default=0.1)


def answers(result: Any) -> list[tuple[str, list[str], list[list[str]]]]:
    """Tables (title, heads, rows): past the loss of contact; contact force; springs that hold."""
    found, units = result.values, units_of(result.system)
    crank = crank_of(result.scene)
    names = ["cam (rpm)", "crank (rpm)"] if crank else ["cam (rpm)"]
    exact, seen = digits_of(result.scene), decimals(spacing([s.rpm for s in found.past]))

    def speed(rpm: float, form: str) -> list[str]:
        return [f"{x * rpm:{form}}" for x in (1.0, crank) if x]

    def between(low: float | None, high: float | None) -> str:
        return "" if low is None or high is None else f"{_zero(low):.4g} to {high:.4g}"

    past = [
        [*speed(s.rpm, f".{seen}f"), _cell(x.max_gap_m, units.per_m), _cell(x.max_impact_m_per_s),
         _cell(x.landing_deg, digits=4), _cell(x.landing_lift_m, units.per_m),
         _cell(x.shut_bounces_per_turn), between(x.min_contact_force_n, x.max_contact_force_n)]
        for s in found.past
        for x in (s.loads,)
    ]  # fmt: skip
    columns = f"loft ({units.length}), lands (m/s), at (deg), at lift ({units.length})"
    columns += ", bounces, force (N)"
    forces = [
        [*speed(f.rpm, f".{exact}g"), _cell(_zero(f.lowest_n), digits=4),
         _cell(f.lowest_deg, digits=4), _cell(f.highest(f.force_n)[0], digits=4),
         *([_cell(f.highest(f.pressure_pa)[0], 1e-6)] if f.pressure_pa else [])]
        for f in found.forces
    ]  # fmt: skip
    pressed = ", Hertz (MPa)" if found.forces and found.forces[0].pressure_pa else ""
    ratio = result.system.rocker_ratio
    where = "" if ratio == 1.0 else f", at the valve; on the lobe {ratio:.6g} times as large"
    springs = [
        [way(h), _cell(h.stiffness, 1.0 / units.per_m, 4), _cell(h.preload, digits=4),
         _cell(h.nose_n, digits=4),
         "never" if h.detaches_rpm == inf else _cell(h.detaches_rpm, digits=exact), h.status]
        for h in found.holds
        if h.stiffness is not None
    ]  # fmt: skip
    tables = [
        ("Past the loss of contact", [*names, *columns.split(", ")], past),
        (f"Contact force if the follower is kept on the cam{where}",
         [*names, *f"least (N), at (deg), largest (N){pressed}".split(", ")], forces),
        ("Springs that hold contact",
         ["spring", *f"rate ({units.stiffness}), preload (N), at full lift (N), holds to (rpm), "
          "status".split(", ")], springs),
    ]  # fmt: skip
    return [(title, heads, rows) for title, heads, rows in tables if rows]


def machine(result: Any) -> list[list[str]]:
    """The machine in rows of a name and a value."""
    f, cam, units = result.system.follower, result.scene.cam, units_of(result.system)
    lift = lift_range(result.system.cam)
    rows = [
        ["mass", f"{f.mass:.4g} kg"],
        ["spring", units.stiffnesses(f.stiffness)],
        ["force at lowest lift", f"{f.preload + f.stiffness * lift[0]:.4g} N"],
        ["force at full lift", f"{f.preload + f.stiffness * lift[1]:.4g} N"],
        ["damping", f"{f.damping:.4g} N s/m"],
        ["restitution", f"{f.restitution:.3g}"],
        ["cam", cam_name(cam)],
        ["lift", units.lengths(lift[1] - lift[0], 4)],
    ]
    if (ratio := result.system.rocker_ratio) != 1.0:
        rows.append(["rocker ratio", f"{ratio:.6g}"])
    return [["machine", ""], *rows]


def _cell(value: float | None, scale: float = 1.0, digits: int = 3) -> str:
    return "" if value is None else f"{value * scale:.{digits}g}"


def _zero(force: float) -> float:
    """A force that is zero up to rounding is printed as zero."""
    return force if abs(force) > ROUNDING else 0.0
