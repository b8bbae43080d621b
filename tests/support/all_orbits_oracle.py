"""Periodic orbits of the example's machine by Newton's method from random phases, in plain doubles.

Only NumPy, and nothing of the package under test. Undamped and without load a flight from c(a) to
c(b), s rad later, is the harmonic motion through both: q = (c(a) sin W(b - x) + c(b) sin W(x - a))
/sin Ws. An orbit is the phases at which every impact's rates make out + r into = 0; it is a motion
where all of them have the right sign and no sample of a flight lies below the cam.
"""

import numpy as np

K1, K2, R2, BASE, OFFSET = 0.45, 0.40393320723821, 0.15, 0.4, 0.3
R1 = BASE + K1
RESTITUTION = 0.8
W0 = np.sqrt(1430.8 / 1.221)
TURN = 2 * np.pi
C = np.radians(160.0)
AOC = np.pi - np.arccos((K1**2 + K2**2 - (R1 - R2) ** 2) / (2 * K1 * K2))
A = C - AOC
B = A + np.arctan2(R1 / (R1 - R2) * K2 * np.sin(AOC),
                   R1 / (R1 - R2) * (K1 + K2 * np.cos(AOC)) - K1)  # fmt: skip
SAMPLES = np.linspace(0.0, 1.0, 401)[1:-1]


def lift(theta):
    """(c, slope) at angles of any turn."""
    x = np.mod(theta, TURN)
    side = np.where(x > np.pi, -1.0, 1.0)
    x = np.where(x > np.pi, TURN - x, x)

    def circle(k, rho, zero):
        y = x - zero
        root = np.sqrt(np.maximum(rho**2 - (k * np.sin(y)) ** 2, 1e-300))
        return k * np.cos(y) + root - OFFSET, -k * np.sin(y) - k * k * np.sin(y) * np.cos(y) / root

    parts = [circle(-K1, R1, A), circle(K2, R2, C)]
    low, high = BASE - OFFSET, K2 + R2 - OFFSET
    where = [x < A, x < B, x < C]
    c = np.select(where, [low, parts[0][0], parts[1][0]], high)
    slope = np.select(where, [0.0, parts[0][1], parts[1][1]], 0.0)
    return c, side * slope


def rates(x, turns, w):
    """(out, into) of the flights after each impact; x: phases, one row an orbit."""
    end = np.concatenate([x[:, 1:], x[:, :1] + TURN * turns], axis=1)
    (c, c1), (d, d1) = lift(x), lift(end)
    sine, cosine = np.sin(w * (end - x)), np.cos(w * (end - x))
    with np.errstate(divide="ignore", invalid="ignore"):
        return w * (d - c * cosine) / sine - c1, w * (d * cosine - c) / sine - d1


def equations(x, turns, w):
    out, into = rates(x, turns, w)
    return out + RESTITUTION * np.roll(into, 1, axis=1)


def is_flown(x, turns, w) -> bool:
    """Whether there are such flights: shorter than a half swing, from push to push, clear."""
    lengths = np.diff([*x, x[0] + TURN * turns])
    return bool(np.all((lengths > 0) & (lengths < np.pi / w))) and is_motion(x, turns, w)


def is_too_fast(x, turns, w) -> bool:
    """Whether an impact leaves faster than the energy of an orbit allows, by its highest values.

    An impact that leaves at u has come from one that left at u', with u <= r (u' + 2 S + w
    sqrt(max c^2 - min c^2)), S the steepest slope; the fastest one of an orbit has u' <= u.
    """
    c, slope = lift(np.linspace(0.0, TURN, 100_001))
    most = 2 * np.abs(slope).max() + w * np.sqrt(c.max() ** 2 - c.min() ** 2)
    fastest = RESTITUTION / (1 - RESTITUTION) * most
    return bool(rates(x[None], turns, w)[0].max() > fastest)


def is_motion(x, turns, w) -> bool:
    """Whether one orbit's impacts push, and its flights stay above the cam."""
    out, into = rates(x[None], turns, w)
    if not (np.all(out > 0) and np.all(into < 0)):
        return False
    for a, b in zip(x, [*x[1:], x[0] + TURN * turns], strict=True):
        at = a + (b - a) * SAMPLES
        q = lift(a)[0] * np.sin(w * (b - at)) + lift(b)[0] * np.sin(w * (at - a))
        if np.any(q / np.sin(w * (b - a)) < lift(at)[0]):
            return False
    return True


def orbits(rpm: float, impacts: int, turns: int, tries: int, seed: int = 1) -> set[tuple]:
    """The motions found: phases of all impacts within the turn in ascending order, 1e-4 deg."""
    w = W0 / (rpm * np.pi / 30)
    random = np.random.default_rng(seed)
    x = np.sort(random.uniform(0.0, TURN * turns, (tries, impacts)), axis=1)
    step = 1e-7
    for _ in range(40):
        value = equations(x, turns, w)
        slopes = np.empty((len(x), impacts, impacts))
        for k in range(impacts):
            moved = x.copy()
            moved[:, k] += step
            slopes[:, :, k] = (equations(moved, turns, w) - value) / step
        good = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(value).all(axis=1)
        good &= np.abs(np.linalg.det(np.where(good[:, None, None], slopes, 0.0))) > 1e-12
        x, value, slopes = x[good], value[good], slopes[good]
        dx = np.linalg.solve(slopes, value[..., None])[..., 0]
        size = np.abs(dx).max(axis=1, keepdims=True)
        x = x - dx * np.minimum(1.0, 0.3 / np.maximum(size, 1e-300))
    lengths = np.diff(np.concatenate([x, x[:, :1] + TURN * turns], axis=1), axis=1)
    solved = (np.abs(equations(x, turns, w)).max(axis=1) < 1e-9) & (lengths > 1e-6).all(axis=1)
    solved &= (lengths < np.pi / w).all(axis=1)
    return {
        tuple(sorted(float(v) for v in np.round(np.degrees(np.mod(one, TURN)), 4)))
        for one in x[solved]
        if is_motion(one, turns, w)
    }
