"""`kind: arcs`: base circle, flank circle and nose circle tangent to each other, top dwell.

Polar radius of a knife-edge follower minus the offset, x from a (end of the base circle),
y from the nearer end of the top dwell:
    flank  c = -kappa1 cos x + sqrt(rho1^2 - kappa1^2 sin^2 x) - offset
    nose   c =  kappa2 cos y + sqrt(rho2^2 - kappa2^2 sin^2 y) - offset
with kappa1, rho1 = flank_center, flank_radius and kappa2, rho2 = nose_center, nose_radius.
The lobe is symmetric about 180 deg.
"""

from __future__ import annotations

from decimal import Decimal, localcontext
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from camcli.cams import decimals
from camcli.cams.compile import Part
from camcli.cams.decimals import DIGITS, Numbers, pi

Length = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]
CLOSURE = 1e-9  # largest gap between circles that should touch, relative to the flank radius


class ArcsCam(BaseModel):
    """Three tangent circles; lengths in m, angles in deg."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

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
        lobe = 2 * float(self._angles()[0]) * 180 / float(pi()) + self.top_dwell_deg
        if lobe > 360:
            raise ValueError(
                f"flanks, noses and top dwell take {lobe:.6g} deg, {lobe - 360:.6g} deg too much"
            )
        return self

    def _angles(self, numbers: Numbers = decimals) -> tuple[Any, Any]:
        """(angle a-O-c, angle a-O-b) in rad, from the triangle O1 O O2.

        |O1 O2| = flank_radius - nose_radius (internal tangency), |O O1| = flank_center on the far
        side of a, |O O2| = nose_center towards c; b lies on the line O1 O2 beyond O2.
        """
        with localcontext() as context:
            context.prec = DIGITS
            k1, k2 = numbers.number(self.flank_center), numbers.number(self.nose_center)
            rho1 = k1 + numbers.number(self.base_radius)  # closed exactly on the base circle
            side = rho1 - numbers.number(self.nose_radius)
            cosine = (k1 * k1 + k2 * k2 - side * side) / (2 * k1 * k2)
            rise = numbers.pi() - numbers.acos(cosine)
            sine, cosine = numbers.sincos(rise)
            # O at 0, a along x: O1 = (-k1, 0), O2 = k2 (cos rise, sin rise), b = O1 + rho1 unit
            across = rho1 * k2 * sine / side
            along = rho1 * (k2 * cosine + k1) / side - k1
            radius = (across * across + along * along).sqrt()
            return rise, numbers.acos(along / radius)

    def parts(self, numbers: Numbers = decimals) -> list[Part]:
        """The smooth parts of one turn from 0 to 2 pi."""
        number = numbers.number
        rise, flank = self._angles(numbers)
        with localcontext() as context:
            context.prec = DIGITS
            half = numbers.radians(Decimal(self.top_dwell_deg)) / 2
            c = numbers.pi() - half
            turn, a, b = 2 * numbers.pi(), c - rise, c - rise + flank
            d, e, f = turn - c, turn - b, turn - a
            offset = number(self.offset)
            base = number(self.base_radius) - offset
            top = number(self.nose_center) + number(self.nose_radius) - offset
        k1, k2 = number(self.flank_center), number(self.nose_center)
        rho1, rho2 = k1 + number(self.base_radius), number(self.nose_radius)

        def circle(low: Any, high: Any, sign: int, kappa: Any, rho: Any, zero: Any) -> Part:
            """c = b + h - offset: a = sign kappa sin x, b = a', h^2 = rho^2 - a^2; x from zero."""
            center, square = sign * kappa, rho * rho

            def radius(theta: Any) -> Any:
                sine, cosine = numbers.sincos(theta - zero)
                inside = rho * rho - kappa * kappa * sine * sine
                return sign * kappa * cosine + inside.sqrt() - offset

            def slopes(theta: Any) -> list[Any]:
                sine, cosine = numbers.sincos(theta - zero)
                a, b = center * sine, center * cosine
                h, ab = (square - a * a).sqrt(), a * b
                h1 = -ab / h  # of (h^2)' = -2 a b, and so on
                h2 = (a * a - b * b - h1 * h1) / h
                h3 = (4 * ab - 3 * h1 * h2) / h
                return [b + h - offset, h1 - a, h2 - b, h3 + a]

            return Part(low, high, radius, slopes=slopes)

        parts = [
            Part(number(0), a, None, base),
            circle(a, b, -1, k1, rho1, a),
            circle(b, c, 1, k2, rho2, c),
            Part(c, d, None, top),
            circle(d, e, 1, k2, rho2, d),
            circle(e, f, -1, k1, rho1, f),
            Part(f, turn, None, base),
        ]
        return [part for part in parts if part.end > part.start]
