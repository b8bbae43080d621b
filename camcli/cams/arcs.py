"""`kind: arcs`: base circle, flank circle and nose circle tangent to each other, top dwell.

Polar radius of a knife-edge follower minus the offset, x from a (end of the base circle),
y from the nearer end of the top dwell:
    flank  c = -kappa1 cos x + sqrt(rho1^2 - kappa1^2 sin^2 x) - offset
    nose   c =  kappa2 cos y + sqrt(rho2^2 - kappa2^2 sin^2 y) - offset
with kappa1 = flank_center, rho1 = flank_radius and kappa2, rho2 = nose_center, nose_radius. The
circles close only where rho1 = base_radius + kappa1, which three doubles seldom fulfil (0.4 + 0.45
is 5.6e-17 more than 0.85): the cam has this sum for rho1, whatever the last digit of flank_radius.
The lobe is symmetric about 180 deg.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated, Any, Literal

from flint import arb
from pydantic import Field, model_validator

from camcli.cams.balls import acos, lasts, number, precision, radians
from camcli.cams.compile import DIGITS, Part
from camcli.cams.lash import LashedCam

Length = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]
CLOSURE = 1e-9  # largest gap between circles that should touch, relative to the flank radius


class ArcsCam(LashedCam):
    """Three tangent circles; lengths in m, angles in deg.

    Examples
    --------
    >>> import camcli
    >>> from camcli.cams import ArcsCam
    >>> cam = ArcsCam(
    ...     kind="arcs", base_radius=0.4, flank_center=0.45, flank_radius=0.85,
    ...     nose_center=0.4, nose_radius=0.15, top_dwell_deg=40.0,
    ... )
    >>> system = camcli.System.build(camcli.Follower(mass=1.2, stiffness=1430.8), cam)
    >>> [round(c, 12) for c in system.lift_range]
    [0.4, 0.55]
    """

    kind: Literal["arcs"]
    base_radius: Length = Field(description="base circle radius, m")
    flank_center: Length = Field(description="distance of the flank circle's centre, m")
    flank_radius: Length = Field(description="flank circle radius, m")
    nose_center: Length = Field(description="distance of the nose circle's centre, m")
    nose_radius: Length = Field(description="nose circle radius, m")
    top_dwell_deg: float = Field(ge=0, lt=360, allow_inf_nan=False, description="top dwell, deg")
    offset: float = Field(
        default=0.0, ge=-1e6, le=1e6, allow_inf_nan=False, description="subtracted from radius, m"
    )

    @model_validator(mode="after")
    def _closes(self) -> ArcsCam:
        """Refuse circles that do not touch one another smoothly, or that take more than a turn."""
        gap = self.flank_radius - self.flank_center - self.base_radius
        reach = self.flank_radius - self.nose_radius
        apart = reach - self.flank_center - self.nose_center
        inside = abs(self.flank_center - self.nose_center) - reach
        for wrong, message in (
            (abs(gap) > CLOSURE * self.flank_radius,
             f"the flank circle misses the base circle by {gap:.6g} m: "
             "flank_radius must equal flank_center + base_radius"),
            (reach <= 0, f"nose_radius is {-reach:.6g} m too large: "
             "it must be smaller than flank_radius"),
            (apart >= 0, f"flank and nose circle do not touch, they miss by {apart:.6g} m: "
             "flank_center + nose_center must exceed flank_radius - nose_radius"),
            (inside >= 0, f"flank and nose circle do not touch, they overlap by {inside:.6g} m: "
             "|flank_center - nose_center| must be below flank_radius - nose_radius"),
            (self.nose_center + self.nose_radius <= self.base_radius,
             "the nose does not rise above the base circle: no lift"),
        ):  # fmt: skip
            if wrong:
                raise ValueError(message)
        with precision(DIGITS):
            lobe = float(360 * self._angles()[0] / arb.pi()) + self.top_dwell_deg
        if lobe > 360:
            raise ValueError(
                f"flanks, noses and top dwell take {lobe:.6g} deg, {lobe - 360:.6g} deg too much"
            )
        return self

    @property
    def flank_excess(self) -> float:
        """m by which the flank circle that closes is larger than flank_radius."""
        closed = Fraction(self.base_radius) + Fraction(self.flank_center)
        return float(closed - Fraction(self.flank_radius))

    def _angles(self) -> tuple[Any, Any]:
        """(angle a-O-c, angle a-O-b) in rad, from the triangle O1 O O2.

        |O1 O2| = flank_radius - nose_radius (internal tangency), |O O1| = flank_center on the far
        side of a, |O O2| = nose_center towards c; b lies on the line O1 O2 beyond O2.
        """
        k1, k2 = number(self.flank_center), number(self.nose_center)
        rho1 = k1 + number(self.base_radius)  # closed exactly on the base circle
        side = rho1 - number(self.nose_radius)
        rise = arb.pi() - acos((k1 * k1 + k2 * k2 - side * side) / (2 * k1 * k2))
        sine, cosine = rise.sin_cos()
        # O at 0, a along x: O1 = (-k1, 0), O2 = k2 (cos rise, sin rise), b = O1 + rho1 unit
        across = rho1 * k2 * sine / side
        along = rho1 * (k2 * cosine + k1) / side - k1
        return rise, acos(along / (across * across + along * along).sqrt())

    @property
    def base_level(self) -> Any:
        """c on the base circle, m."""
        return number(self.base_radius) - number(self.offset)

    def lobe(self) -> list[Part]:
        """The smooth parts of one turn from 0 to 2 pi."""
        rise, flank = self._angles()
        turn = 2 * arb.pi()
        # the corners a to f, in their order
        c = arb.pi() - radians(self.top_dwell_deg) / 2
        a = c - rise
        b = c - rise + flank
        d = turn - c
        e = turn - b
        f = turn - a
        k1 = number(self.flank_center)
        k2 = number(self.nose_center)
        offset = number(self.offset)
        rho1 = k1 + number(self.base_radius)
        rho2 = number(self.nose_radius)
        base = number(self.base_radius) - offset
        top = k2 + rho2 - offset

        def circle(low: Any, high: Any, sign: int, kappa: Any, rho: Any, zero: Any) -> Part:
            """The part from low to high, on a circle of radius rho, its centre kappa off the axis.

            With x = theta - zero the centre is across = sign kappa sin x beside the line from the
            axis to the follower, and along = sign kappa cos x up this line. The circle meets the
            line h above the centre, h^2 = rho^2 - across^2, so c = along + h - offset.
            """
            center = sign * kappa
            square = rho * rho

            def radius(theta: Any) -> Any:
                sine, cosine = (theta - zero).sin_cos()
                inside = rho * rho - kappa * kappa * sine * sine
                return sign * kappa * cosine + inside.sqrt() - offset

            def slopes(theta: Any) -> list[Any]:
                """[c, c', c'', c'''] at theta, from the derivatives of h^2 = rho^2 - across^2."""
                sine, cosine = (theta - zero).sin_cos()
                across = center * sine
                along = center * cosine
                h = (square - across * across).sqrt()
                product = across * along
                h1 = -product / h  # of (h^2)' = -2 across along, and so on
                h2 = (across * across - along * along - h1 * h1) / h
                h3 = (4 * product - 3 * h1 * h2) / h
                return [along + h - offset, h1 - across, h2 - along, h3 + across]

            return Part(low, high, radius, slopes=slopes)

        parts = [
            Part(arb(0), a, None, base),
            circle(a, b, -1, k1, rho1, a),
            circle(b, c, 1, k2, rho2, c),
            Part(c, d, None, top),
            circle(d, e, 1, k2, rho2, d),
            circle(e, f, -1, k1, rho1, f),
            Part(f, turn, None, base),
        ]
        return [part for part in parts if lasts(part.start, part.end)]
