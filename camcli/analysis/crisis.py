"""Why a chaotic attractor changes size at once, or is lost, between two speeds.

Tried are a corner first reached, a new contact, and a crisis (Grebogi, Ott & Yorke, Physica D 7
(1983) 181): the attractor, closure of the unstable manifold W^u of an orbit B in it, meets the
stable manifold W^s of a saddle p one side of which leads out. With t along W^u(B), x_n the state
n turns on and eta across W^s, min over t of eta(x_n(t; rpm)) = 0 is solved for rpm, n so large that
W^s is straight at x_n; the minimum is a fold, smooth or the image of an impact at a corner. Folds
not sampled may touch a little earlier. The chapter's machine: 740.1065 rpm, P(7;1:1:1:1:1:1:1) of
multiplier 12.6, corner c; 361.1673, P(3;3:3:2), 35.9, smooth; 682.2046, P(1;1) on A1, 1.176, corner
b, chaos is lost; runs of 3 or 4 million turns agree. States are (q m, dq/dtheta m/rad).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, exp, inf, log

import numpy as np

from camcli.analysis.detach_regions import corner_list
from camcli.analysis.detach_search import lowest
from camcli.analysis.engine import IMPACT, Orbit, Settings, Start, with_turns
from camcli.analysis.labels import label
from camcli.analysis.orbits.find import primitive, same_orbit
from camcli.analysis.orbits.identify import newton_from
from camcli.analysis.orbits.orbit import PeriodicOrbit, from_root
from camcli.analysis.orbits.shooter import Shooter
from camcli.errors import SceneError
from camcli.kernel.flight import move
from camcli.kernel.profile import TURN, lift, stretch_at
from camcli.system import System, omega_of

MARGIN, LEAST, HALVINGS = 0.05, 16, 16  # of the box; turns outside that count; of the bracket
SETTLE, CALM, FOLDS, REFINED, SEARCHES, SECANTS = 1000, 0.8, 6, 60, 5, 150
LONGEST, TRIES, RETURN = 8, 40, 0.05  # of saddles: turns, close returns, their relative distance
FIRST, NEAR, STRAIGHT = 1e-4, 0.05, 1e-5  # relative: start on W^u; beside p; where W^s is straight
MANIFOLD, AFTER, WINDOW = 4000, 55, 12  # starts on W^u; turns after its growth; samples of a fold
TOUCH, CLOSE, STEP = 1e-6, 1e-9, 1e-9  # in eta; of rpm: solved; of rpm: first step of a secant
AT_CORNER, REACHED, SLACK, FLIGHTS, POINTS = 1e-6, 1e-3, 0.1, 400, 48  # rad; shares; for low gaps


@dataclass(frozen=True)
class Crisis:
    """bracket: last run without and first with it; evidence: (what, before, nearer or after)."""

    kind: str  # interior-crisis, boundary-crisis, corner-impact, grazing or unexplained
    rpm: float
    error: float
    bracket: tuple[float, float]
    orbit: PeriodicOrbit | None = None  # the saddle met
    corner: str = ""  # reached first, or whose image touches W^s
    phase: float | None = None  # of the corner, rad
    evidence: tuple[tuple[str, float, float], ...] = ()
    words: tuple[str, ...] = ()


def find_crisis(system: System, settings: Settings, low, high, end="lower", turns=200_000):
    """The `Crisis` between low and high (rpm) of the attractor carried from the `end` given."""
    study = _Study(system, settings, *((low, high) if end == "lower" else (high, low)), turns)
    if not study.bisect():
        words = (f"Runs of {turns} turns stay, or it is not chaotic, at {study.near!r} rpm.",)
        return Crisis("unexplained", study.far, inf, study.bracket, words=words)
    (kind, rpm, corner, phase), facts = approach(study)
    touch, words = contact(study)
    error, orbit = max(abs(rpm - speed) for speed in study.bracket), None
    if touch is not None:
        fold, (rpm, n, t, error) = touch
        _, b, p = fold.at(rpm)
        theta, orbit = _impacts(study.run(rpm, True, b.leaf(t), n))[0], p.orbit
        at = [c for c in corner_list(system.cam) if np.abs(theta - c.theta).min() < AT_CORNER]
        corner, phase = (at[0].name, at[0].theta) if at else ("", None)
        tail = _states(study.run(rpm, False, p.leaf(0.0, -1e-6 * fold.side), turns))[turns // 2 :]
        kind = ("boundary-crisis", "interior-crisis")[len(tail) - study.outside(tail) > LEAST]
        sides = [fold.low(rpm + k * STEP * rpm * study.ahead, n, t, 1e-4)[0] for k in (-1.0, 1.0)]
        facts = (("eta of the fold, a little before and after", *sides), *facts)
        words.append(f"The image of corner {corner} touches W^s." if at else "The fold is smooth.")
    words.append(f"{kind} at {rpm:.10g} rpm; measured before, and nearer or after: {facts}.")
    return Crisis(kind, rpm, error, study.bracket, orbit, corner, phase, facts, tuple(words))


def _states(tape):
    return np.column_stack((tape.strobe_q, tape.strobe_w)).astype(float)


def _impacts(tape):  # (theta rad, u m/rad, period), arrays
    kept = (np.asarray(tape.kind) == IMPACT) & (np.asarray(tape.period) >= 0)
    return tuple(np.asarray(column)[kept] for column in (tape.theta, tape.u, tape.period))


class _Study:  # the attractor carried from `near` towards `far`: runs, its box, the bracket
    def __init__(self, system: System, settings: Settings, near: float, far: float, turns: int):
        self.system, self.settings, self.turns = system, settings, turns
        self.near, self.far, self.bracket, self.ahead = near, far, (near, far), 1 - 2 * (far < near)
        orbit = Orbit(system, near, with_turns(settings, max(settings.transient, SETTLE), 1))
        orbit.run()
        self.start = orbit.here()
        ends = [_states(self.run(rpm)) for rpm in (near, far)]
        self.size = np.ptp(np.concatenate(ends), axis=0) + 1e-300
        self.box = [ends[0].min(0) - MARGIN * self.size, ends[0].max(0) + MARGIN * self.size]

    def run(self, rpm: float, events: bool = False, x=None, turns: int = 0):
        """The tape of a motion from the state x at the strobe, None for the attractor's."""
        start, settings = self.start, with_turns(self.settings, 0, (turns or self.turns - 1) + 1)
        if x is not None:  # begins an ulp before the strobe, never behind it
            deg = degrees(self.system.strobe) * (1.0 - 4e-16)
            start = Start(float(x[0]), float(x[1]) * omega_of(rpm), deg)
        return Orbit(self.system, rpm, settings, start).run(events=events)

    def outside(self, points) -> int:
        """How many of the states lie beside the attractor of the near end."""
        return int(((points < self.box[0]) | (points > self.box[1])).any(1).sum())

    def way(self, found) -> float:
        return abs(found[0] - self.near) if found else inf

    def bisect(self) -> bool:
        """Narrow the bracket of the speed at which runs leave; False if they never do."""
        near, far = self.run(self.near), self.run(self.far)
        if label(near) != "aperiodic" or self.outside(_states(far)) < LEAST:
            return False
        for _ in range(HALVINGS):
            (last, first), middle = self.bracket, 0.5 * sum(self.bracket)
            left = self.outside(_states(self.run(middle))) >= LEAST
            self.bracket = (last, middle) if left else (middle, first)
        return True


class _Saddle:  # an orbit at one speed; the axes of its map along W^u and W^s, of relative size 1
    def __init__(self, study: _Study, rpm: float, orbit: PeriodicOrbit):
        old, shooter = orbit.root, Shooter(study.system, rpm)
        root = shooter.at_value(old.x, old.whole, old.turns, rpm)
        self.orbit = root and from_root(study.system, root, shooter.verdict(root)[0])
        if root is None or not self.orbit.admissible:
            raise LookupError(f"lost at {rpm:.9g} rpm")
        self.x, size = np.array(self.orbit.states[0]), np.abs(self.orbit.states).max(0)
        jumps = 1e-7 * np.vstack((np.diag(size), -np.diag(size)))
        ends = [_states(study.run(rpm, False, self.x + d, old.turns))[old.turns] for d in jumps]
        values, axes = np.linalg.eig((np.subtract(ends[:2], ends[2:]) / (2e-7 * size[:, None])).T)
        order = np.argsort(-np.abs(values))
        self.mu, self.axes = float(values.real[order[0]]), axes.real[:, order]
        self.axes /= np.linalg.norm(self.axes / size[:, None], axis=0)
        self.to = np.linalg.inv(self.axes).T

    def leaf(self, t: float, first: float = FIRST):
        return self.x + first * exp(t) * self.axes[:, 0]


class _Fold:  # the folds of W^u(B) over W^s(p): the lowest ones, and where they touch
    def __init__(self, study: _Study, base: PeriodicOrbit, saddle: PeriodicOrbit, side: float):
        self.study, self.base, self.saddle, self.side = study, base, saddle, side

    def at(self, rpm: float):
        """((eta, xi) across and along W^s after 0, ..., n turns as a function of t and n, B, p)."""
        b, p = (_Saddle(self.study, rpm, orbit) for orbit in (self.base, self.saddle))

        def place(t: float, n: int):
            x = _states(self.study.run(rpm, False, b.leaf(t), n))[: n + 1]
            return (x - p.x) @ p.to * (self.side, 1.0)

        return place, b, p

    def sample(self, rpm: float, shift: float) -> list[tuple[float, int, float, float]]:
        """Minima (eta, n, t, half spacing) over starts along W^u(B), the lowest first."""
        place, b, _ = self.at(rpm)
        gap = log(abs(b.mu)) * (1 if b.mu > 0.0 else 2) / MANIFOLD
        t = gap * (np.arange(MANIFOLD) + shift)
        n = AFTER + int(self.base.turns * log(1.0 / FIRST) / log(abs(b.mu)))
        xs = np.array([place(x, n) for x in t])
        e = np.where((np.abs(xs) < NEAR).all(2), xs[..., 0], inf)
        low = (e[1:-1] < inf) & (e[1:-1] <= e[:-2]) & (e[1:-1] <= e[2:])
        at = sorted((e[k + 1, n], n, t[k + 1]) for k, n in np.argwhere(low))
        tips = [(*self.low(rpm, n, x, gap, 2)[:2], n) for _, n, x in at[:REFINED]]
        return sorted((v, n, x, 0.5 * gap) for v, x, n in tips if abs(v) < NEAR)

    def low(self, rpm: float, n: int, t: float, half: float, samples: int = WINDOW):
        """(eta, t, xi) of the minimum within t +- half after n turns."""
        place = self.at(rpm)[0]
        value, x = lowest(lambda y: place(t + half * y, n)[n, 0], -1.0, 1.0, samples)
        return float(value), t + half * x, float(place(t + half * x, n)[n, 1])

    def touch(self, rpm: float, n: int, t: float, half: float):
        """(rpm, n, t, change by the last period) where a fold touches W^s: secants; or None."""
        slope, solved, step, (value, t, xi) = 0.0, None, inf, self.low(rpm, n, t, half)
        for _ in range(SECANTS):
            step = step if abs(step) < inf else STEP * rpm * self.study.ahead
            rpm, before = rpm + step, (value, t)
            value, t, xi = self.low(rpm, n, t + slope * step, half)
            out = abs(value) > NEAR or (rpm - self.study.near) * (rpm - self.study.far) > 0.0
            if out or value == before[0]:
                break
            slope = (t - before[1]) / step if abs(step) >= STEP * rpm else slope
            most, step = 5.0 * abs(step), -value * step / (value - before[0])
            step = min(max(step, -most), most)
            if abs(value) <= TOUCH and abs(step) <= CLOSE * rpm:
                change = CLOSE * rpm if solved is None else abs(rpm - solved)
                if abs(xi) <= STRAIGHT or (solved and change <= CLOSE * rpm):
                    return rpm, n, t, change
                solved, n, step = rpm, n + self.saddle.turns, inf
                half /= max(abs(self.saddle.multipliers[0]), 1.5)
                value, t, xi = self.low(rpm, n, t, half)
        return None

    def first(self, rpm: float):
        """The earliest tangency seen from the near end; None where no fold comes near p."""
        best = None
        for k in range(SEARCHES):
            tips = [x for x in self.sample(rpm, k / SEARCHES) if not best or x[0] < -0.1 * TOUCH]
            found = [self.touch(rpm, *tip[1:]) for tip in tips[:FOLDS]]
            new = min(found, key=self.study.way, default=None)
            if self.study.way(new) >= self.study.way(best):
                break
            off = [abs(x[0] - new[0]) for x in found if x and abs(x[0] - new[0]) > CLOSE * rpm]
            best, rpm = (*new[:3], max(new[3], min(off, default=0.0))), new[0]
        return best


def saddles(study: _Study, rpm: float, tape) -> list[PeriodicOrbit]:
    """Unstable orbits of up to LONGEST turns at rpm, by Newton's method from close returns."""
    found, shooter = [], Shooter(study.system, rpm)
    at, (theta, u, period) = _states(tape) / study.size, _impacts(tape)
    for m in range(1, LONGEST + 1):
        far = np.abs(at[m:] - at[:-m]).max(1)
        order = np.argsort(far)
        order = order[(far[order] < RETURN) & (far[order] > CLOSE)]
        first = np.sort(np.unique(at[order] * 64 // 1, axis=0, return_index=True)[1])
        for k in order[first[:TRIES]]:
            window = slice(*np.searchsorted(period, (k, k + m)))
            events = list(zip(*(c[window].tolist() for c in (period, theta, u)), strict=True))
            root = newton_from(study.system, shooter, events, m)
            orbit = root and from_root(study.system, root, shooter.verdict(root)[0])
            if orbit and orbit.admissible and not orbit.stable and primitive(orbit):
                found += [orbit] * (not any(same_orbit(orbit, other) for other in found))
    return sorted(found, key=lambda orbit: (orbit.turns, abs(orbit.multipliers[0])))


def inner_side(study: _Study, rpm: float, orbit: PeriodicOrbit) -> float:
    """+-1: the side of p whose branch of W^u(p) stays where the other leads out; 0 for neither."""
    p, out = _Saddle(study, rpm, orbit), []
    turns = AFTER + int(orbit.turns * log(1e6) / log(p.mu))
    for first in (1e-6, -1e-6):
        leaves = [p.leaf(k / 60.0 * log(p.mu), first) for k in range(60)]
        out.append(sum(study.outside(_states(study.run(rpm, False, x, turns))) for x in leaves))
    return 0.0 if max(out) <= max(LEAST, 10 * min(out)) else 1.0 if out[0] < out[1] else -1.0


def contact(study: _Study):
    """((fold, tangency) of the saddle met first or None, sentences on what was tried)."""
    calm = study.near + CALM * (study.bracket[0] - study.near)
    inside, beyond = (saddles(study, calm, study.run(x, True)) for x in (calm, study.bracket[1]))
    bases = [orbit for orbit in inside if orbit.multipliers[0].real < -1.0] or inside
    words, best = [f"Saddles seen: {len(inside)} in the attractor, {len(beyond)} beyond."], None
    for orbit in inside + [o for o in beyond if not any(same_orbit(o, i) for i in inside)]:
        mu = orbit.multipliers[0]
        if mu.imag or mu.real < 1.0 or not bases:
            continue
        try:
            fold = _Fold(study, bases[0], orbit, inner_side(study, calm, orbit))
            found = fold.side and (fold.first(calm) or fold.first(study.bracket[0]))
        except (LookupError, SceneError) as trouble:
            words.append(f"{orbit.label} was not followed: {trouble}")
            continue
        name = f"{orbit.label}, multiplier {mu.real:.5g}"
        words += [f"{name}, leads out: met at {found and found[0]} rpm."] * bool(fold.side)
        best = (fold, found) if study.way(found) < study.way(best and best[1]) else best
    return best, words


def approach(study: _Study):
    """((kind, rpm, corner, phase) of what is first reached, if anything; distances to it all)."""
    way, best, rows = study.bracket[0] - study.near, ("unexplained", study.bracket[1], "", None), []
    speeds, corners = [study.near + k * way for k in (0.5, 0.9)], corner_list(study.system.cam)
    for rpm in speeds:
        tape = study.run(rpm, True)
        off = [np.abs((_impacts(tape)[0] - c.theta + TURN / 2) % TURN - TURN / 2) for c in corners]
        rows.append([*[float(x.min()) for x in off], low_gap(study, rpm, tape)])
    causes = [("corner-impact", c.name, c.theta, REACHED) for c in corners]
    causes += [("grazing", "", None, REACHED * study.size[0])]
    for (kind, name, phase, least), a, b in zip(causes, *rows, strict=True):
        zero = speeds[1] + b * (speeds[1] - speeds[0]) / (a - b) if inf > a > b > least else inf
        if min(abs(zero - speed) for speed in study.bracket) < SLACK * abs(way):
            best = kind, zero, name, phase
    names = [f"distance to {kind} {name}".strip() + ", rad or m" for kind, name, *_ in causes]
    return best, tuple(zip(names, *rows, strict=True))


def low_gap(study: _Study, rpm: float, tape) -> float:
    """The lowest gap inside a flight (m), 0 where impacts already fade; inf without a minimum."""
    cam, lane, strobe = study.system.cam, study.system.lane(rpm, 1e-9, 1), study.system.strobe
    theta, u, period = (column[: FLIGHTS + 1] for column in _impacts(tape))
    at = (theta - strobe) % TURN + TURN * period + strobe
    lows = [inf if min(abs(u)) > REACHED * max(abs(u)) else 0.0]
    for k, span in enumerate(np.diff(at).tolist()):
        places = [float(at[k]) + span * j / POINTS for j in range(POINTS)]
        lifts = [lift(cam, stretch_at(cam, x % TURN), x % TURN) for x in places]
        c, w = lifts[0][0], lifts[0][1] - lane.r * float(u[k])
        gap = [move(lane, c, w, span * j / POINTS)[0] - lifts[j][0] for j in range(POINTS)]
        lows += [y for x, y, z in zip(gap, gap[1:], gap[2:], strict=False) if x > y < z and y > 0.0]
    return min(lows)
