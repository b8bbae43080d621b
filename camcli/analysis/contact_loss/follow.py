"""What the follower does just above the speed at which a region begins to lose contact."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from camcli.analysis.contact_loss.burst import Burst, Bursts
from camcli.analysis.contact_loss.detachment import Loss
from camcli.analysis.contact_loss.force import DEG

ABOVE = 1e-6  # relative distance of the speed simulated from the opening speed
SAME = 1e-12  # rad

FLIES_OFF, CAUGHT, WITHIN, STAYS = "flies-off", "released-and-caught", "within-region", "unseen"


@dataclass(frozen=True)
class Follow:
    """Release, first landing and end of the chatter of one burst (deg, unrolled; inf: not seen)."""

    region: str
    kind: str
    corner: str
    rpm: float
    release_deg: float
    landing_deg: float
    rest_deg: float
    words: str


def follow(bursts: Bursts, loss: Loss) -> Follow:
    """Simulate one burst just above loss.opens and say how it begins and where it is caught."""
    rpm = loss.opens.rpm * (1.0 + ABOVE)
    burst = bursts.at(rpm)
    kind, corner = _kind(loss, burst)
    landing = burst.impacts[0] if burst.impacts else burst.end
    values = [value * DEG for value in (burst.release, landing, burst.end)]
    words = _words(kind, corner, loss, *values)
    return Follow(loss.region.name, kind, corner, rpm, *values, words)


def _kind(loss: Loss, burst: Burst) -> tuple[str, str]:
    region, place = loss.region, loss.opens.theta
    if burst.release == inf:
        return STAYS, ""
    if region.begins and abs(place - region.start) < SAME:
        return FLIES_OFF, region.begins
    if region.ends and min(abs(place - region.end + turn) for turn in (0.0, 360.0 / DEG)) < SAME:
        return CAUGHT, region.ends
    return WITHIN, ""


def _words(kind: str, corner: str, loss: Loss, release: float, landing: float, rest: float) -> str:
    place = loss.opens.theta_deg
    calm = f", at rest again {rest - place:.3g} deg after it" if rest < inf else ""
    caught = f"{landing - place:.3g} deg after" if landing < inf else "not within two turns"
    if kind == FLIES_OFF:
        return f"flies off at {corner}: the force drops there; lands {caught}{calm}"
    if kind == CAUGHT:
        before = f"{place - release:.3g} deg before {corner}"
        return f"released {before}, where the force fades; caught {caught}{calm}"
    if kind == WITHIN:
        return f"released {place - release:.3g} deg before the weakest phase, lands {caught}{calm}"
    return "no lift-off was seen: contact is lost at no phase that rests before it"
