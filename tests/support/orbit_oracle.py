"""High-precision reference for periodic orbits of a follower bouncing on a cam of circular arcs.

Only the standard library, mpmath and `tests.support.oracle` are used, nothing of the package
under test.
Lengths in m, SI units, angles in rad, speeds in rpm.  The unknowns of an orbit of n impacts are the
phases theta_k and the outgoing relative velocities p_k; flight k lasts (theta_k+1 - theta_k)/omega,
the flight after the last impact ends at theta_0 + 2 pi turns, and at its end

    q = c(theta_k+1),      p_k+1 = -r u-,      u- = v - omega c_theta(theta_k+1).

Every impact keeps to one smooth piece of the cam, "A1" = (a,b) to "A6" = (f,a), whose closed form
goes on beyond its ends: Newton's method then meets no corner, and at a corner the piece chooses the
side of c_thetatheta.

The monodromy is that of (q, v) from theta = 0 on over `turns` turns, the product of the flow
matrices and, at each impact, of the jump matrix in the time t.  A perturbation (dq, dv) just before
the impact moves it by dt = -dq/u-.  The jump v+ = (1+r) omega c_theta - r v- at that moment, taken
back to the unperturbed one with the velocities and accelerations v-, a- before and v+, a+ after:

    dq+ = dq + (v- - v+) dt = -r dq                                  since v- - v+ = (1+r) u-
    dv+ = -r dv + ((1+r) omega^2 c_thetatheta - r a- - a+) dt
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from mpmath import mp, mpf

from tests.support.oracle import Arc, ArcsCam, Flight, Follower, Oracle, _num

DIGITS = 60
SAME = mpf(10) ** -30  # angles and flight times closer than this are equal


class Machine(NamedTuple):
    """The follower; numbers are taken as IEEE doubles unless they are mpf."""

    mass: Any
    stiffness: Any
    restitution: Any
    damping: Any = 0
    gravity: Any = 0
    preload: Any = 0

    def follower(self) -> Follower:
        """Its equation of motion, at the working precision."""
        m = self
        return Follower.make(m.mass, m.stiffness, m.damping, m.gravity, m.preload)


class Orbit(NamedTuple):
    """A periodic orbit; `matrix` is the monodromy over `turns` turns from theta = 0."""

    turns: int
    thetas: list[mpf]
    u_minus: list[mpf]
    u_plus: list[mpf]
    pieces: list[str]
    matrix: Any
    trace: mpf
    det: mpf
    multipliers: tuple[Any, Any]

    @property
    def impacts(self) -> list[tuple[mpf, mpf]]:
        """The orbit as a guess for another one."""
        return list(zip(self.thetas, self.u_plus, strict=True))


class Critical(NamedTuple):
    """A speed and the orbit there."""

    rpm: mpf
    orbit: Orbit


class CornerImpact(NamedTuple):
    """The speed of an impact at a corner, the orbit with c_thetatheta from either side."""

    rpm: mpf
    left: Orbit
    right: Orbit


class GapGraze(NamedTuple):
    """The speed at which a flight touches the cam at theta, and the orbit without that contact."""

    rpm: mpf
    theta: mpf
    orbit: Orbit


class Leg(NamedTuple):
    """One flight: from angle, position and velocity after an impact to those before the next one.

    `laws` are those of the cam at the end, on the piece of the impact there.
    """

    theta: mpf
    q0: mpf
    v0: mpf
    t: mpf
    q1: mpf
    v1: mpf
    laws: tuple[mpf, mpf, mpf]


def _omega(rpm) -> mpf:
    return _num(rpm) * mp.pi / 30


def piece_at(cam: ArcsCam, theta, side: int = 1) -> str:
    """The piece at an unrolled angle; side=+1 the one after a corner, -1 the one before."""
    with mp.workdps(DIGITS):
        x = theta - 2 * mp.pi * mp.floor(theta / (2 * mp.pi)) + side * SAME
        return f"A{sum(bp <= x for bp in cam.breakpoints) or 6}"


def _arc(cam: ArcsCam, piece: str, theta) -> Arc:
    """A piece in the turn of an unrolled angle."""
    arc = cam.arcs[int(piece[1:]) - 1]
    return arc._replace(origin=arc.origin + 2 * mp.pi * mp.floor(theta / (2 * mp.pi)))


def newton(f: Callable[[list], list], x: list) -> list:
    """Zero of f, real: Newton's method with differences of half the digits and step halving."""
    half = mpf(10) ** (-mp.dps // 2)
    fx = f(x)
    for _ in range(80 if _real(fx) else 0):
        columns = []
        for i, xi in enumerate(x):
            h = half * max(1, abs(xi))
            there = f([*x[:i], xi + h, *x[i + 1 :]])
            columns.append([(a - b) / h for a, b in zip(there, fx, strict=True)])
        step = mp.lu_solve(mp.matrix(columns).T, -mp.matrix(fx))
        if not _real(step):
            break
        size = max(abs(s) / max(1, abs(a)) for s, a in zip(step, x, strict=True))
        for halvings in range(40):
            y = [a + mp.ldexp(s, -halvings) for a, s in zip(x, step, strict=True)]
            fy = f(y)
            if _real(fy) and (size < half or _norm(fy) < _norm(fx)):
                break
        else:
            break
        x, fx = y, fy
        if size < half:
            return x
    raise ArithmeticError("no orbit near the guess")


def _real(values) -> bool:
    """False beyond the reach of a circle."""
    return not any(isinstance(value, mp.mpc) for value in values)


def _norm(values: list[mpf]) -> mpf:
    return max(abs(value) for value in values)


@dataclass(frozen=True)
class Family:
    """The candidates for an orbit: x = (theta_0, .., p_0, ..), the piece of each impact given."""

    follower: Follower
    r: mpf
    turns: int
    pieces: list[str]
    arcs: list[Arc]

    def legs(self, omega, x) -> list[Leg]:
        """The flights, whether or not they end on the cam."""
        n, out = len(self.arcs), []
        thetas, speeds = [*x[:n], x[0] + 2 * mp.pi * self.turns], x[n : 2 * n]
        laws = [a.laws(mp, th - a.origin) for a, th in zip(self.arcs, x, strict=False)]
        for k, (c, c1, _) in enumerate(laws):
            t, v0 = (thetas[k + 1] - thetas[k]) / omega, omega * c1 + speeds[k]
            arrival = self.follower.flow(t, c, v0)
            out.append(Leg(thetas[k], c, v0, t, *arrival, laws[(k + 1) % n]))
        return out

    def residual(self, omega, x) -> list[mpf]:
        """Zero for an orbit: the contacts and the impact laws."""
        n, out = len(self.arcs), []
        for k, leg in enumerate(self.legs(omega, x)):
            c, c1, _ = leg.laws
            after = x[n + (k + 1) % n]
            out += [leg.q1 - c, (after + self.r * (leg.v1 - omega * c1)) / omega]
        return out

    def flow_matrix(self, t):
        """Derivative of the state after t in the state: the flow without its load."""
        free = self.follower._replace(load=mpf(0))
        (a, c), (b, d) = free.flow(t, mpf(1), mpf(0)), free.flow(t, mpf(0), mpf(1))
        return mp.matrix([[a, b], [c, d]])

    def jump_matrix(self, omega, leg: Leg):
        """Derivative of the state after the impact that ends a flight in the state before it."""
        f, r, (_, c1, c2) = self.follower, self.r, leg.laws
        before = leg.v1
        u = before - omega * c1
        after = omega * c1 - r * u
        pull = -f.w2 * leg.q1 - f.load
        a_before, a_after = pull - 2 * f.zeta * before, pull - 2 * f.zeta * after
        bend = ((1 + r) * omega**2 * c2 - r * a_before - a_after) / u
        return mp.matrix([[-r, 0], [-bend, -r]])

    def monodromy(self, omega, x):
        """Product of the flow and jump matrices over `turns` turns from theta = 0."""
        legs, period = self.legs(omega, x), 2 * mp.pi * self.turns
        ends = [leg.theta + omega * leg.t for leg in legs]
        phases = [end - period * mp.floor(end / period) for end in ends]
        M, now = mp.eye(2), mpf(0)
        for phase, leg in sorted(zip(phases, legs, strict=True)):
            M = self.jump_matrix(omega, leg) * self.flow_matrix((phase - now) / omega) * M
            now = phase
        return self.flow_matrix((period - now) / omega) * M

    def trace_det(self, omega, x) -> tuple[mpf, mpf]:
        """Trace and determinant of the monodromy matrix."""
        M = self.monodromy(omega, x)
        return M[0, 0] + M[1, 1], M[0, 0] * M[1, 1] - M[0, 1] * M[1, 0]

    def u_minus(self, omega, x) -> list[mpf]:
        """The velocities before the impacts."""
        us = [leg.v1 - omega * leg.laws[1] for leg in self.legs(omega, x)]
        return us[-1:] + us[:-1]

    def orbit(self, omega, x) -> Orbit:
        """The solution as an orbit, its determinant checked against r^(2n) exp(-b m^-1 T)."""
        n, T = len(self.arcs), 2 * mp.pi * self.turns / omega
        M, (trace, det) = self.monodromy(omega, x), self.trace_det(omega, x)
        expected = self.r ** (2 * n) * mp.exp(-2 * self.follower.zeta * T)
        assert abs(det - expected) < mpf(10) ** -40 * (1 + mp.mnorm(M) ** 2), (det, expected)
        root = mp.sqrt(trace**2 / 4 - det)
        pair = trace / 2 + root, trace / 2 - root
        velocities = self.u_minus(omega, x), list(x[n : 2 * n])
        return Orbit(self.turns, list(x[:n]), *velocities, self.pieces, M, trace, det, pair)


def _family(cam: ArcsCam, machine: Machine, turns: int, pieces, thetas) -> Family:
    names = [p or piece_at(cam, th) for p, th in zip(pieces, thetas, strict=True)]
    arcs = [_arc(cam, p, th) for p, th in zip(names, thetas, strict=True)]
    return Family(machine.follower(), _num(machine.restitution), turns, names, arcs)


def _settle(cam, machine, impacts, turns, pieces, more, equations) -> tuple[Family, list]:
    """Zero of `equations(family, z)`, z being the orbit and the unknowns after it.

    A piece that is None is the one of the guess, and of the solution if that is another one.
    """
    n = len(impacts)
    pieces = pieces or [None] * n
    z = [_num(x[0]) for x in impacts] + [_num(x[1]) for x in impacts] + more
    for _ in range(6):
        family = _family(cam, machine, turns, pieces, z[:n])
        z = newton(lambda z, family=family: equations(family, z), z)
        if not all(a < b for a, b in zip(z[:n], [*z[1:n], z[0] + 2 * mp.pi * turns], strict=True)):
            raise ArithmeticError("impacts out of order")
        if family.pieces == _family(cam, machine, turns, pieces, z[:n]).pieces:
            return family, z
    raise ArithmeticError("an impact that finds no orbit on either side of a corner")


def solve(cam, machine, rpm, impacts, turns, pieces=None) -> Orbit:
    """Periodic orbit from approximate impacts [(unrolled angle, outgoing relative velocity), ...].

    `pieces` names the piece of each impact, None one that follows from the angle.  A named piece
    goes on beyond its ends; whether the orbit is one of the cam, `admissible` tells.
    """
    with mp.workdps(DIGITS):
        omega = _omega(rpm)
        family, x = _settle(
            cam, machine, impacts, turns, pieces, [], lambda f, x: f.residual(omega, x)
        )
        return family.orbit(omega, x)


def _flights(cam: ArcsCam, machine: Machine, omega, orbit: Orbit) -> list[tuple[Flight, mpf]]:
    """The flights of an orbit on the cam itself, and their durations."""
    follower, out = machine.follower(), []
    ends = [*orbit.thetas[1:], orbit.thetas[0] + 2 * mp.pi * orbit.turns]
    for theta, u, end in zip(orbit.thetas, orbit.u_plus, ends, strict=True):
        c, c1, _ = cam.laws(theta)
        flight = Flight(cam, follower, omega, theta, c, omega * c1 + u)
        out.append((flight, (end - theta) / omega))
    return out


def admissible(cam, machine, rpm, orbit: Orbit) -> bool:
    """Whether every impact is on its piece with u- < 0 and every flight clear of the cam."""
    with mp.workdps(DIGITS):
        for theta, u, piece in zip(orbit.thetas, orbit.u_minus, orbit.pieces, strict=True):
            if u >= 0 or piece not in (piece_at(cam, theta, side) for side in (1, -1)):
                return False
        for flight, t in _flights(cam, machine, _omega(rpm), orbit):
            hit = flight.first_contact(t * (1 + mpf("1e-6")), contact=True)
            if hit is None or abs(hit.t - t) > SAME:
                return False
        return True


def strobe_state(cam, machine, rpm, orbit: Orbit) -> tuple[mpf, mpf]:
    """Position and velocity at theta = 0, the start of the first of the `turns` turns."""
    with mp.workdps(DIGITS):
        omega, period = _omega(rpm), 2 * mp.pi * orbit.turns
        flights = [flight for flight, _ in _flights(cam, machine, omega, orbit)]
        waits = [-f.psi - period * mp.floor(-f.psi / period) for f in flights]
        wait, last = min(zip(waits, flights, strict=True), key=lambda pair: pair[0])
        return last.follower.flow(wait / omega, last.q, last.v)


def finite_difference_monodromy(cam, machine, rpm, orbit: Orbit, step="1e-20"):
    """The monodromy by central differences of simulated runs from theta = 0."""
    q, v = strobe_state(cam, machine, rpm, orbit)
    oracle = Oracle(cam, **machine._asdict(), rpm=rpm)
    with mp.workdps(oracle.work):
        h, omega, period = mpf(step), _omega(rpm), 2 * mp.pi * orbit.turns

        def strobe(q, v):
            """The state a whole number of turns after (q, v) at the strobe."""
            events = oracle.run(q=q, v=v, turns=orbit.turns)
            if [e.kind for e in events] != ["impact"] * len(orbit.thetas):
                raise ArithmeticError("the run has other events than the orbit")
            last = events[-1]
            psi = 2 * mp.pi * last.turn + last.theta
            return oracle.flow((period - psi) / omega, last.q, omega * cam.c1(psi) + last.u_plus)

        ends = [strobe(*x) for x in ((q + h, v), (q - h, v), (q, v + h), (q, v - h))]
        columns = [
            [(a - b) / (2 * h) for a, b in zip(*pair, strict=True)] for pair in (ends[:2], ends[2:])
        ]
        return mp.matrix(columns).T


def _critical(cam, machine, impacts, turns, rpm, pieces, condition) -> Critical:
    """The speed at which an orbit obeys `condition(family, omega, x)` = 0, by Newton's method."""
    n = len(impacts)

    def equations(family, z):
        omega, x = z[2 * n], z[: 2 * n]
        return [*family.residual(omega, x), condition(family, omega, x)]

    family, z = _settle(cam, machine, impacts, turns, pieces, [_omega(rpm)], equations)
    return Critical(z[2 * n] * 30 / mp.pi, family.orbit(z[2 * n], z[: 2 * n]))


def _multiplier(sign: int):
    """A condition of (family, omega, x) that is zero where `sign` (1 or -1) is a multiplier."""

    def condition(family, omega, x):
        trace, det = family.trace_det(omega, x)
        return 1 - sign * trace + det

    return condition


def period_doubling_rpm(
    cam, machine, impacts, turns, rpm_low, rpm_high, pieces=None, steps=8
) -> Critical:
    """First speed with a multiplier -1 as the orbit, guessed at rpm_low, is followed upwards."""
    with mp.workdps(DIGITS):
        low, high = _num(rpm_low), _num(rpm_high)
        before = None
        for i in range(steps + 1):
            rpm = low + (high - low) * i / steps
            orbit = solve(cam, machine, rpm, impacts, turns, pieces)
            value, impacts = orbit.trace + 1 + orbit.det, orbit.impacts
            if before is not None and value * before <= 0:
                found = _critical(cam, machine, impacts, turns, rpm, pieces, _multiplier(-1))
                if not low <= found.rpm <= high:
                    raise ArithmeticError("the period doubling is outside the range")
                return found
            before = value
        raise ArithmeticError("no period doubling in the range")


def fold_rpm(cam, machine, impacts, turns, rpm, pieces=None) -> Critical:
    """Speed with a multiplier +1 near a guess of the speed and of the orbit."""
    with mp.workdps(DIGITS):
        return _critical(cam, machine, impacts, turns, rpm, pieces, _multiplier(1))


def corner_rpm(cam, machine, impacts, turns, k, corner_theta, rpm, pieces=None) -> CornerImpact:
    """Speed at which impact k is at a corner, in the turn of the guess, near a guess."""
    with mp.workdps(DIGITS):
        whole = mp.nint((_num(impacts[k][0]) - corner_theta) / (2 * mp.pi))
        corner = corner_theta + 2 * mp.pi * whole
        impacts = [*impacts[:k], (corner, impacts[k][1]), *impacts[k + 1 :]]
        sides = []
        for side in (-1, 1):
            names = list(pieces or [None] * len(impacts))
            names[k] = piece_at(cam, corner, side)
            at = _critical(
                cam, machine, impacts, turns, rpm, names, lambda f, omega, x: x[k] - corner
            )
            sides.append(at)
        left, right = sides
        assert abs(left.rpm - right.rpm) < SAME
        return CornerImpact(left.rpm, left.orbit, right.orbit)


def gap_graze_rpm(cam, machine, impacts, turns, k, rpm, theta) -> GapGraze:
    """Speed at which the gap of flight k touches zero near the unrolled angle `theta`."""
    with mp.workdps(DIGITS):
        n, touch = len(impacts), _num(theta)
        arc = _arc(cam, piece_at(cam, touch), touch)

        def equations(family, z):
            """The orbit's equations, and gap and its rate where the flight grazes: all zero."""
            x, omega, psi = z[: 2 * n], z[2 * n], z[2 * n + 1]
            leg, (c, c1, _) = family.legs(omega, x)[k], arc.laws(mp, psi - arc.origin)
            q, v = family.follower.flow((psi - leg.theta) / omega, leg.q0, leg.v0)
            return [*family.residual(omega, x), q - c, v / omega - c1]

        more = [_omega(rpm), touch]
        family, z = _settle(cam, machine, impacts, turns, None, more, equations)
        omega, x, psi = z[2 * n], z[: 2 * n], z[2 * n + 1]
        assert piece_at(cam, psi) == piece_at(cam, touch)
        return GapGraze(omega * 30 / mp.pi, psi, family.orbit(omega, x))


def _rad(*degrees):
    with mp.workdps(DIGITS):
        return [mp.radians(mpf(x)) for x in degrees]


# Orbits of the example, near enough for `solve`.
CAM = ArcsCam()
CHAPTER = Machine(mass=1.221, stiffness=146 * 9.8, restitution=0.8)
B, C = CAM.breakpoints[1:3]
STABLE, UNSTABLE = ([(_rad(x)[0], u)] for x, u in ((155, 70), (104, 30)))
DOUBLED = list(zip(_rad(155.6, 519.3), (41.9, 41.9), strict=True))
TWICE = list(zip(_rad(151, 333), (36.7, 37.3), strict=True))  # P(1;2) at 358.5 rpm
GRAZE = _rad(155.4)[0]  # where the flight of UNSTABLE touches the nose
THRICE = list(  # P(3;3:3:2) at 358.5 rpm
    zip(
        _rad(71.3, 141.8, 301.4, 466.1, 633.8, 795.9, 906.3, 1009.8),
        [5.75, 7.27, 13.42, 12.49, 11.87, 9.49, 4.1, 7.18],
        strict=True,
    )
)


# --- points of codimension two


class Sine(NamedTuple):
    """A cam that goes up and down as a cosine; every piece of it is the whole."""

    base: Any
    lift: Any
    origin: Any = mpf(0)

    def laws(self, lib, x):
        """Lift c and its first two derivatives in the angle."""
        half = _num(self.lift) / 2
        return _num(self.base) + half * (1 - lib.cos(x)), half * lib.sin(x), half * lib.cos(x)


class TwoConditions(NamedTuple):
    """A point at which an orbit obeys two conditions: both parameters, and the orbit."""

    rpm: mpf
    second: mpf
    orbit: Orbit


def at_corner(k: int, corner):
    """The condition that impact k, of an unrolled phase, is at a corner."""
    return lambda family, omega, x, more: [x[k] - corner]


def with_multiplier(sign: int):
    """The condition that `sign` (1 or -1) is a multiplier."""
    condition = _multiplier(sign)
    return lambda family, omega, x, more: [condition(family, omega, x)]


def touching(k: int, arc):
    """The condition that flight k touches the cam, at the unrolled phase more[0]: two equations."""

    def condition(family, omega, x, more):
        psi = more[0]
        leg, (c, c1, _) = family.legs(omega, x)[k], arc.laws(mp, psi - arc.origin)
        q, v = family.follower.flow((psi - leg.theta) / omega, leg.q0, leg.v0)
        return [q - c, v / omega - c1]

    return condition


def two_conditions(
    arcs, machine: Machine, name: str, impacts, turns, rpm, conditions, more=()
) -> TwoConditions:
    """Both parameters, the speed and the constant `name`, at which two conditions hold.

    arcs: of each impact, in its turn; the machine's constant and rpm are guesses, as impacts are.
    """
    with mp.workdps(DIGITS):
        n = len(impacts)

        def at(z):
            """(family, omega, orbit's unknowns) at z."""
            changed = machine._replace(**{name: z[2 * n + 1]})
            r = _num(changed.restitution)
            family = Family(changed.follower(), r, turns, ["?"] * n, list(arcs))
            return family, z[2 * n], z[: 2 * n]

        def equations(z):
            family, omega, x = at(z)
            out = family.residual(omega, x)
            for condition in conditions:
                out += condition(family, omega, x, z[2 * n + 2 :])
            return out

        z = [_num(x[0]) for x in impacts] + [_num(x[1]) for x in impacts]
        z += [_omega(rpm), _num(getattr(machine, name)), *map(_num, more)]
        z = newton(equations, z)
        family, omega, x = at(z)
        return TwoConditions(omega * 30 / mp.pi, z[2 * n + 1], family.orbit(omega, x))
