"""The follower's flight in decimals, in the equations and units of `kernel.flight`.

The numbers of a scene are taken as the doubles they are; omega = rpm pi/30 in full.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal

from camcli.cams.decimals import pi, sincos
from camcli.system import Follower

DIGITS = 100  # of the working context


@dataclass(frozen=True)
class Drive:
    """Constants at one speed, per rad of cam angle: W^2, Z, D = Z^2 - W^2, G (m/rad^2), and r."""

    W2: Decimal
    Z: Decimal
    D: Decimal
    G: Decimal
    r: Decimal

    @classmethod
    def of(cls, follower: Follower, rpm: float, share: Decimal = Decimal(0)) -> Drive:
        """W^2 = k/(m omega^2), Z = b/(2 m omega), G = (g + F0/m)/omega^2 at rpm (1 + share)."""
        f = follower
        mass, omega = Decimal(f.mass), Decimal(rpm) * (1 + share) * pi(DIGITS) / 30
        W2 = Decimal(f.stiffness) / mass / (omega * omega)
        Z = Decimal(f.damping) / (2 * mass) / omega
        G = (Decimal(f.gravity) + Decimal(f.preload) / mass) / (omega * omega)
        return cls(W2, Z, Z * Z - W2, G, Decimal(f.restitution))

    def flow(self, s: Decimal) -> tuple[Decimal, Decimal, Decimal]:
        """(B, B', P) after s rad of flight.

        With e = exp(-Z s) and f^2 = |D|: B = e sin(f s)/f, C = e cos(f s) below critical damping,
        B = e s, C = e at it, B = (e1 - e2)/(2 f), C = (e1 + e2)/2 above, e1,2 = exp((+-f - Z) s).
        B' = C - Z B, P = (1 - C - Z B)/W^2; P = (s - B)/(2 Z), or s^2/2, without a spring.
        """
        zs = self.Z * s
        if self.D > 0:
            f = self.D.sqrt()
            e1, e2 = (f * s - zs).exp(), (-f * s - zs).exp()
            b, c = (e1 - e2) / (2 * f), (e1 + e2) / 2
        else:
            e = (-zs).exp()
            f = (-self.D).sqrt()
            sine, cosine = sincos(f * s) if f else (s, Decimal(1))
            b, c = e * (sine / f if f else s), e * cosine
        if self.W2:
            p = (1 - c - self.Z * b) / self.W2
        else:
            p = (s - b) / (2 * self.Z) if self.Z else s * s / 2
        return b, c - self.Z * b, p

    def move(self, q: Decimal, w: Decimal, s: Decimal) -> tuple[Decimal, Decimal]:
        """(q, dq/dtheta) after s rad of flight from (q, w); m, m/rad."""
        b, b1, p = self.flow(s)
        force = self.G + self.W2 * q
        return q + w * b - force * p, w * b1 - force * b

    def contact(self, c: Decimal, c1: Decimal, c2: Decimal) -> Decimal:
        """Relative acceleration on the cam at rest, m/rad^2; the contact force is minus it."""
        return -(self.G + self.W2 * c + 2 * self.Z * c1) - c2
