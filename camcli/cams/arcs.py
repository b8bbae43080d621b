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
from typing import Annotated, Any, Literal, NamedTuple

from flint import arb
from pydantic import Field, model_validator

from camcli.cams.balls import acos, lasts, number, precision, radians
from camcli.cams.compile import DIGITS, Part
from camcli.cams.lash import LashedCam

Length = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]
CLOSURE = 1e-9  # largest gap between circles that should touch, relative to the flank radius


class Circle(NamedTuple):
    """A circle of the outline, in m: balls, or series where the cam's numbers vary.

    center: how far its centre lies from the cam's axis of rotation, negative on the far side.
    radius: its own. offset: what is subtracted from the polar radius.
    """

    center: Any
    radius: Any
    offset: Any

    def part(self, start: Any, end: Any, axis: Any) -> Part:
        """The part of the cam from start to end on the circle, whose centre lies at angle `axis`.

        With x = theta - axis the centre is across = center sin x beside the line from the cam's
        axis to the follower, and along = center cos x up this line. The circle meets the line h
        above the centre, h^2 = radius^2 - across^2, so c = along + h - offset. Angles in rad.
        """
        center, rho, offset = self
        square = rho * rho

        def lift(theta: Any) -> Any:
            sine, cosine = (theta - axis).sin_cos()
            h_squared = square - center * center * sine * sine
            return center * cosine + h_squared.sqrt() - offset

        def slopes(theta: Any) -> list[Any]:
            """[c, c', c'', c'''] at theta, from the derivatives of h^2 = rho^2 - across^2."""
            sine, cosine = (theta - axis).sin_cos()
            across = center * sine
            along = center * cosine
            h = (square - across * across).sqrt()
            product = across * along
            h1 = -product / h  # of (h^2)' = -2 across along, and so on
            h2 = (across * across - along * along - h1 * h1) / h
            h3 = (4 * product - 3 * h1 * h2) / h
            return [along + h - offset, h1 - across, h2 - along, h3 + across]

        return Part(start, end, lift, slopes=slopes)


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
        fault = self._fault_of_circles()
        if fault:
            raise ValueError(fault)
        with precision(DIGITS):
            to_top, _ = self._angles()
            lobe = float(360 * to_top / arb.pi()) + self.top_dwell_deg  # rise and fall are alike
        if lobe > 360:
            raise ValueError(
                f"flanks, noses and top dwell take {lobe:.6g} deg, {lobe - 360:.6g} deg too much"
            )
        return self

    def _fault_of_circles(self) -> str:
        """Why the circles do not make a cam, with the amount in m; '' where they do.

        The nose circle touches the flank circle from within: their centres O1 and O2 are
        flank_radius - nose_radius apart, on either side of the axis O. Such a triangle O1 O O2
        exists where this is less than the sum of its other sides, flank_center and nose_center,
        and more than their difference.
        """
        gap = self.flank_radius - self.flank_center - self.base_radius
        if abs(gap) > CLOSURE * self.flank_radius:
            return (
                f"the flank circle misses the base circle by {gap:.6g} m: "
                "flank_radius must equal flank_center + base_radius"
            )
        between_centres = self.flank_radius - self.nose_radius
        if between_centres <= 0:
            return (
                f"nose_radius is {self.nose_radius - self.flank_radius:.6g} m too large: "
                "it must be smaller than flank_radius"
            )
        apart = between_centres - self.flank_center - self.nose_center
        if apart >= 0:
            return (
                f"flank and nose circle do not touch, they miss by {apart:.6g} m: "
                "flank_center + nose_center must exceed flank_radius - nose_radius"
            )
        inside = abs(self.flank_center - self.nose_center) - between_centres
        if inside >= 0:
            return (
                f"flank and nose circle do not touch, they overlap by {inside:.6g} m: "
                "|flank_center - nose_center| must be below flank_radius - nose_radius"
            )
        if self.nose_center + self.nose_radius <= self.base_radius:
            return "the nose does not rise above the base circle: no lift"
        return ""

    @property
    def flank_excess(self) -> float:
        """m by which the flank circle that closes is larger than flank_radius."""
        closed = Fraction(self.base_radius) + Fraction(self.flank_center)
        return float(closed - Fraction(self.flank_radius))

    def _angles(self) -> tuple[Any, Any]:
        """(angle a-O-c of flank and nose together, angle a-O-b of the flank), rad.

        Both are from the triangle O1 O O2 of the centres of flank, cam and nose: |O1 O2| =
        flank_radius - nose_radius (internal tangency), |O O1| = flank_center on the far side of a,
        |O O2| = nose_center towards c; b lies on the line O1 O2 beyond O2.
        """
        k1 = number(self.flank_center)
        k2 = number(self.nose_center)
        rho1 = k1 + number(self.base_radius)  # closed exactly on the base circle
        side = rho1 - number(self.nose_radius)
        to_top = arb.pi() - acos((k1 * k1 + k2 * k2 - side * side) / (2 * k1 * k2))
        sine, cosine = to_top.sin_cos()
        # O at 0, a along x: O1 = (-k1, 0), O2 = k2 (cos to_top, sin to_top);
        # b = (along, across) = O1 + rho1 (O2 - O1)/side
        across = rho1 * k2 * sine / side
        along = rho1 * (k2 * cosine + k1) / side - k1
        to_nose = acos(along / (across * across + along * along).sqrt())
        return to_top, to_nose

    @property
    def base_level(self) -> Any:
        """c on the base circle, m."""
        return number(self.base_radius) - number(self.offset)

    def lobe(self) -> list[Part]:
        """The smooth parts of one turn from 0 to 2 pi."""
        to_top, to_nose = self._angles()
        turn = 2 * arb.pi()
        # the corners a to f, in their order; the lobe is symmetric about half a turn
        c = arb.pi() - radians(self.top_dwell_deg) / 2
        a = c - to_top
        b = c - to_top + to_nose
        d = turn - c
        e = turn - b
        f = turn - a
        flank_center = number(self.flank_center)
        nose_center = number(self.nose_center)
        nose_radius = number(self.nose_radius)
        base_radius = number(self.base_radius)
        offset = number(self.offset)
        flank = Circle(-flank_center, flank_center + base_radius, offset)
        nose = Circle(nose_center, nose_radius, offset)
        base = base_radius - offset
        top = nose_center + nose_radius - offset
        parts = [
            Part(arb(0), a, None, base),
            flank.part(a, b, axis=a),
            nose.part(b, c, axis=c),
            Part(c, d, None, top),
            nose.part(d, e, axis=d),
            flank.part(e, f, axis=f),
            Part(f, turn, None, base),
        ]
        return [part for part in parts if lasts(part.start, part.end)]
