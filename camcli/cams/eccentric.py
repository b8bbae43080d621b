"""`kind: eccentric`: a circle turning about a point beside its centre, under a flat follower.

    c = base + lift (1 - cos theta)/2

The eccentricity is lift/2. Smooth everywhere: no corners. It is also the table of a shaker, and
with base = -sigma - lift/2 the moving stop of the impact oscillator.
"""

from typing import Annotated, Any, Literal

from flint import arb
from pydantic import Field

from camcli.cams.balls import number
from camcli.cams.compile import Part
from camcli.cams.lash import LashedCam

Height = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False)]
Lift = Annotated[float, Field(gt=0, le=1e6, allow_inf_nan=False)]


class EccentricCam(LashedCam):
    """A harmonic cam; lengths in m.

    Examples
    --------
    >>> import camcli
    >>> from camcli.cams import EccentricCam
    >>> cam = EccentricCam(kind="eccentric", base=0.0, lift=0.02)
    >>> camcli.System.build(camcli.Follower(mass=1.2, stiffness=1430.8), cam).lift_range
    (0.0, 0.02)
    """

    kind: Literal["eccentric"]
    base: Height = Field(description="lowest c, at theta = 0, any sign, m")
    lift: Lift = Field(description="highest minus lowest c, twice the eccentricity, m")

    @property
    def base_level(self) -> Any:
        """c on the base circle, m."""
        return number(self.base)

    def lobe(self) -> list[Part]:
        """The smooth parts of one turn from 0 to 2 pi: one."""

        base = number(self.base)
        half = number(self.lift) / 2

        def height(theta: Any) -> Any:
            return base + half * (1 - theta.cos())

        # `height` as its mean and the factors of cos theta and sin theta, which compiles faster;
        # the function itself is for balls, and for pieces where a term of this may be rounding
        wave = (base + half, -half, arb(0))
        return [Part(arb(0), 2 * arb.pi(), height, wave=wave)]
