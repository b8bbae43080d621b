"""Events of periodic orbits in any number of a machine, in 40 digits and more.

Only mpmath and the oracles beside it are used, nothing of the package under test. The unknowns are
those of `orbit_oracle` and the number p: follower, speed and the pieces of the cam are functions of
p, and one condition more makes the event.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from mpmath import mp, mpf

from tests.support.oracle import ArcsCam, Follower, _num
from tests.support.orbit_oracle import Family, newton

DIGITS = 40


class Wave(NamedTuple):
    """A harmonic cam: c = middle + along cos theta + across sin theta."""

    middle: Any
    along: Any
    across: Any = mpf(0)
    origin: Any = mpf(0)

    def laws(self, lib, x):
        """Lift c and its first two derivatives in the angle."""
        wave = self.along * lib.cos(x) + self.across * lib.sin(x)
        return self.middle + wave, -self.along * lib.sin(x) + self.across * lib.cos(x), -wave


class Scca(NamedTuple):
    """A rise whose acceleration is a sine, constant, a cosine, and the same again upside down.

    The shares of the sine, constant and cosine parts are b, c and d. The law is integrated from its
    middle, where s = 1/2, and from its end, where it is at rest; s(1/2) gives its scale.
    zone: of the impact, "cosine" about the middle or "sine" at the end. Lengths in m and rad.
    """

    base: Any
    lift: Any
    origin: Any
    length: Any
    widths: tuple[Any, Any, Any]
    zone: str

    def scale(self) -> mpf:
        """The largest s'', from 1/2 = s(1/2), the integral of (1/2 - t) s''(t) over half of it."""
        b, c, d = self.widths
        half, start, end = mpf(1) / 2, b / 2, (b + c) / 2
        sine = half * b / mp.pi - (b / mp.pi) ** 2
        constant = half * (end - start) - (end**2 - start**2) / 2
        cosine = (d / mp.pi) ** 2
        return half / (sine + constant + cosine)

    def laws(self, lib, x):
        """Lift c and its first two derivatives in the angle, x measured from the rise's start."""
        b, c, d = self.widths
        scale = self.scale()
        t = x / self.length
        if self.zone == "cosine":
            y = mp.pi * (t - mpf(1) / 2) / d
            speed = b / mp.pi + c / 2 + d / mp.pi * mp.cos(y)
            way = (b / mp.pi + c / 2) * (t - mpf(1) / 2) + (d / mp.pi) ** 2 * mp.sin(y)
            s = mpf(1) / 2 + scale * way, scale * speed, -scale * mp.sin(y)
        else:
            y = mp.pi * (1 - t) / b
            way = b / mp.pi * (1 - t) - (b / mp.pi) ** 2 * mp.sin(y)
            s = 1 - scale * way, scale * b / mp.pi * (1 - mp.cos(y)), -scale * mp.sin(y)
        per = self.lift / self.length
        return self.base + self.lift * s[0], per * s[1], per / self.length * s[2]


@dataclass(frozen=True)
class Machines:
    """A machine at every value of a number: its constants, its speed and the cam's pieces.

    pieces: by the impact, each a law of the angle that goes on beyond its ends.
    """

    constants: Callable[[Any], dict[str, Any]]
    rpm: Callable[[Any], Any]
    pieces: Callable[[Any], list[Any]]

    def at(self, p, turns: int) -> tuple[Family, mpf]:
        """The equations at a value, and the speed in rad/s."""
        values = {"restitution": 0.8, **self.constants(p)}
        r = _num(values.pop("restitution"))
        pieces = self.pieces(p)
        family = Family(Follower.make(**values), r, turns, [""] * len(pieces), pieces)
        return family, _num(self.rpm(p)) * mp.pi / 30


Condition = Callable[[Family, mpf, list, mpf], mpf]


def doubling(family, omega, x, p):
    """A multiplier is -1."""
    trace, det = family.trace_det(omega, x)
    return 1 + trace + det


def fold(family, omega, x, p):
    """A multiplier is 1."""
    trace, det = family.trace_det(omega, x)
    return 1 - trace + det


def fading(k: int) -> Condition:
    """The incoming velocity of impact k is zero."""
    return lambda family, omega, x, p: family.u_minus(omega, x)[k] / omega


def at_corner(k: int, corner: Callable[[Any], Any]) -> Condition:
    """Impact k is at a corner, wherever the cam has it."""
    return lambda family, omega, x, p: x[k] - corner(p)


def event(machines: Machines, condition: Condition, guess, turns: int, p) -> tuple[mpf, list]:
    """The value of the number at an event, and the phases (rad) of the orbit.

    guess: (theta rad, outgoing velocity m/s) of every impact, and p, near the event.
    """
    with mp.workdps(DIGITS + 20):
        z = [_num(theta) for theta, _ in guess] + [_num(v) for _, v in guess] + [_num(p)]

        def equations(z: list) -> list:
            family, omega = machines.at(z[-1], turns)
            x = z[:-1]
            return [*family.residual(omega, x), condition(family, omega, x, z[-1])]

        z = newton(equations, z)
        return z[-1], z[: len(guess)]


def arcs(**changes: Callable[[Any], Any]) -> Callable[[Any], ArcsCam]:
    """The cam of arcs of the example at a value; its flank circle touches its base circle."""

    def cam(p) -> ArcsCam:
        """Base and flank circle are closed: the base radius is not used otherwise."""
        values = {name: _num(of(p)) for name, of in changes.items()}
        base, center = (values.pop(name, None) for name in ("base_radius", "flank_center"))
        base = mpf(0.4) if base is None else base
        center = mpf(0.45) if center is None else center
        return ArcsCam(base_radius=base, flank_center=center, flank_radius=base + center, **values)

    return cam


def meeting(
    machines: Callable[[Any], Machines],
    conditions: Callable[[Any, Any], list],
    guess,
    turns: int,
    numbers,
    more=(),
) -> tuple[mpf, mpf]:
    """Both numbers of a machine at which two conditions of an orbit hold.

    machines: at a value of the first number, those of the second; conditions: at both, as
    `orbit_oracle` has them; guess: (unrolled phase rad, outgoing velocity m/s) of every impact;
    numbers: both, near the point; more: further unknowns of the conditions.
    """
    with mp.workdps(DIGITS + 20):
        n = len(guess)
        z = [_num(theta) for theta, _ in guess] + [_num(v) for _, v in guess]
        z += [_num(x) for x in (*numbers, *more)]

        def equations(z: list) -> list:
            first, second, *others = z[2 * n :]
            family, omega = machines(first).at(second, turns)
            x = z[: 2 * n]
            out = list(family.residual(omega, x))
            for condition in conditions(first, second):
                out += condition(family, omega, x, others)
            return out

        z = newton(equations, z)
        return z[2 * n], z[2 * n + 1]
