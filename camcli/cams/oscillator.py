"""`kind: oscillator`: a forced, damped oscillator that hits a stop, as its literature writes it.

    mass x'' + damping x' + stiffness x = amplitude cos(frequency t),    x <= clearance,
    x' -> -restitution x' where x = clearance

Without the stop the oscillator would move as p(t) = a cos(frequency t - phi) for ever, with
a cos phi = amplitude (k - m w^2)/D, a sin phi = amplitude b w/D, D = (k - m w^2)^2 + (b w)^2.
The difference q = p - x is a free oscillation, and the stop is a cam under it that turns once in
a period of the force:

    m q'' + b q' + k q = 0,    q >= c(theta) = a cos(theta - phi) - clearance,    theta = w t

So q - c = clearance - x is the distance to the stop, an impact is one of the follower with the cam,
and x = p - q. At theta = 0 the force is at its largest. The cam depends on every number of the
oscillator, and so does its speed: the follower and `run.rpm` are made from them.

Sources: S. W. Shaw and P. J. Holmes, J. Sound Vib. 90 (1983) 129; C. J. Budd and F. Dux, Phil.
Trans. R. Soc. A 347 (1994) 365.
"""

from __future__ import annotations

from math import sqrt
from typing import Annotated, Any, Literal

from flint import arb
from pydantic import BaseModel, ConfigDict, Field, model_validator

from camcli.cams.balls import number
from camcli.cams.compile import Part

Finite = Annotated[float, Field(allow_inf_nan=False)]
FARTHEST = 1e6  # m: as high as any cam may be
RESONANCE = "without damping the oscillator has no steady motion where frequency^2 = stiffness/mass"


class OscillatorCam(BaseModel):
    """A forced oscillator with a stop; in SI units, or dimensionless with mass and stiffness 1.

    Examples
    --------
    Without damping the free oscillation has the amplitude F/(k - m omega^2), here 1/(1 - 1/4):

    >>> import camcli
    >>> from camcli.cams import OscillatorCam
    >>> cam = OscillatorCam(kind="oscillator", frequency=0.5, clearance=0.0)
    >>> system = camcli.System.build(camcli.Follower(mass=1.0, stiffness=1.0), cam)
    >>> [round(c, 12) for c in system.lift_range]
    [-1.333333333333, 1.333333333333]
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    kind: Literal["oscillator"]
    mass: Finite = Field(1.0, ge=1e-15, le=1e16, description="mass, kg")
    stiffness: Finite = Field(1.0, ge=0, le=1e16, description="stiffness of its spring, N/m")
    damping: Finite | None = Field(None, ge=0, le=1e16, description="damping of its spring, N s/m")
    damping_ratio: Finite | None = Field(
        None, ge=0, le=1e8, description="damping over 2 sqrt(stiffness mass), instead of damping, -"
    )
    amplitude: Finite = Field(1.0, gt=0, le=1e16, description="amplitude of the force, N")
    frequency: Finite = Field(ge=1e-9, le=1e8, description="circular frequency of the force, rad/s")
    clearance: Finite = Field(
        ge=-FARTHEST, le=FARTHEST,
        description="from the spring's rest to the stop, m; negative: the stop presses",
    )  # fmt: skip

    @model_validator(mode="after")
    def _has_a_steady_motion(self) -> OscillatorCam:
        """Refuse an oscillator whose motion without the stop grows without end, or past 1e6 m."""
        if self.damping is not None and self.damping_ratio is not None:
            raise ValueError("found damping and damping_ratio: leave one of them out")
        along, across = self._motion()
        size = (along * along + across * across).sqrt()
        if not size.is_finite():
            raise ValueError(RESONANCE)
        if not size < FARTHEST:
            high = float(size.mid())
            raise ValueError(f"its motion without the stop is {high:.4g} m high: at most 1e6 m")
        return self

    @property
    def follower_damping(self) -> Any:
        """The damping of the follower that is this oscillator, N s/m.

        It is a ball, or a series, where the numbers that it follows from are (`cams.varied`).
        """
        if self.damping_ratio is None:
            return self.damping or 0.0
        ratio = self.damping_ratio
        product = self.stiffness * self.mass
        if isinstance(ratio, float) and isinstance(product, float):
            return 2.0 * ratio * sqrt(product)
        return number(ratio) * number(product).sqrt() * 2

    def _motion(self) -> tuple[Any, Any]:
        """(a cos phi, a sin phi) of the steady motion without the stop, m."""
        omega = number(self.frequency)
        spring = number(self.stiffness) - number(self.mass) * omega * omega
        damper = number(self.follower_damping) * omega
        share = number(self.amplitude) / (spring * spring + damper * damper)
        return spring * share, damper * share

    def parts(self) -> list[Part]:
        """The smooth parts of one turn from 0 to 2 pi: one."""
        along, across = self._motion()
        clearance = number(self.clearance)

        def height(theta: Any) -> Any:
            return along * theta.cos() + across * theta.sin() - clearance

        wave = (-clearance, along, across)
        return [Part(arb(0), 2 * arb.pi(), height, wave=wave)]
