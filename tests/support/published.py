"""Independent values of the numbers of `cam bench validation`: mpmath and closed forms alone.

Nothing of the package under test is used. Each function says in its docstring what it solves.
"""

from __future__ import annotations

from typing import NamedTuple

from mpmath import acos, atan2, cos, cosh, exp, findroot, mpf, pi, sin, sinh, sqrt


class Flow(NamedTuple):
    """x'' + 2 z x' + k x = 0 in closed form: x(t) and x'(t) from x(0) and x'(0)."""

    k: mpf
    z: mpf

    def at(self, x, v, t):
        inside = self.k - self.z**2
        decay = exp(-self.z * t)
        s = sqrt(abs(inside))
        if inside > 0:
            c, sn = cos(s * t), sin(s * t) / s
        elif inside < 0:
            c, sn = cosh(s * t), sinh(s * t) / s
        else:
            c, sn = mpf(1), t
        slope = (v + self.z * x) * sn
        position = decay * (x * c + slope)
        velocity = decay * (v * c - (self.k * x + self.z * v) * sn)
        return position, velocity


class Forced(NamedTuple):
    """x'' + damping x' + stiffness x = amplitude cos(w t), x <= clearance, x' -> -r x'."""

    stiffness: mpf
    damping: mpf
    amplitude: mpf
    w: mpf
    clearance: mpf
    r: mpf

    @classmethod
    def of(cls, *numbers) -> Forced:
        return cls(*map(mpf, numbers))

    def steady(self, t):
        """The motion without the stop, and its velocity."""
        spring, damper = self.stiffness - self.w**2, self.damping * self.w
        share = self.amplitude / (spring**2 + damper**2)
        along, across = spring * share, damper * share
        c, s = cos(self.w * t), sin(self.w * t)
        return along * c + across * s, self.w * (across * c - along * s)

    def flight(self, t0, v0, t):
        """(x, x') a time t after x = clearance, x' = v0 at the time t0."""
        p, p_dot = self.steady(t0)
        y, y_dot = Flow(self.stiffness, self.damping / 2).at(self.clearance - p, v0 - p_dot, t)
        p, p_dot = self.steady(t0 + t)
        return y + p, y_dot + p_dot

    def orbit(self, turns: int, guess) -> tuple[mpf, mpf]:
        """(time, velocity before) of the only impact in so many periods of the force."""
        time = 2 * pi * turns / self.w

        def closed(t0, v):
            x, x_dot = self.flight(t0, -self.r * v, time)
            return [x - self.clearance, x_dot - v]

        return tuple(findroot(closed, tuple(map(mpf, guess)), tol=mpf(10) ** -45))


def ball_fold(r, turns: int):
    """Gamma at which one impact in so many turns becomes possible.

    The ball meets the table, of velocity w, at w - V and leaves at w + r V. It is back in the air's
    time n T at the same height: g n T = 2 (w + r V), and its velocity is then w + r V - g n T =
    w - V, so V = g n T/(1 + r) and w = g n T (1 - r)/(2 (1 + r)). That is at most a omega.
    """
    return pi * turns * (1 - mpf(r)) / (1 + mpf(r))


def ball_doubling(r, turns: int):
    """Gamma at which its multiplier is -1, from the derivative of the map from impact to impact."""
    r = mpf(r)
    return sqrt(ball_fold(r, turns) ** 2 + (2 * (1 + r * r) / (1 + r) ** 2) ** 2)


def ball_impacts(g, r, count: int, height=None, speed=None) -> list[tuple[mpf, mpf]]:
    """(time, velocity after it) of each impact on a floor, dropped, or thrown at it from it."""
    g, r = mpf(g), mpf(r)
    time, after = mpf(0), r * mpf(speed or 0)
    if height is not None:
        time, after = sqrt(2 * mpf(height) / g), r * sqrt(2 * g * mpf(height))
    found = []
    for _ in range(count):
        found.append((time, after))
        time, after = time + 2 * after / g, r * after
    return found


def floor_impacts(mass, stiffness, g, r, count: int, height) -> list[tuple[mpf, mpf]]:
    """The same of a mass on a spring, let go at a height; the spring is relaxed at the floor.

    After the first a hop lasts (2 pi - 2 phase)/w, with tan(phase) = v/(w depth) about the rest of
    mass and weight, which lies that depth below the floor.
    """
    w = sqrt(mpf(stiffness) / mpf(mass))
    depth = mpf(g) * mpf(mass) / mpf(stiffness)
    far = mpf(height) + depth
    time = acos(depth / far) / w
    speed = w * sqrt(far**2 - depth**2)
    found = []
    for _ in range(count):
        speed *= mpf(r)
        found.append((time, speed))
        time += 2 * acos(depth / sqrt(depth**2 + (speed / w) ** 2)) / w
    return found


def one_n_velocities(w, r, clearance, turns: int) -> list[mpf]:
    """Both velocities of x'' + x = cos(w t) with one impact in so many periods; none if complex."""
    w, r, s = mpf(w), mpf(r), mpf(clearance)
    size, time = 1 / (1 - w * w), 2 * pi * turns / w
    k = (1 + r) * sin(time) / (1 - cos(time))
    a, b = k * k / 4 + ((1 - r) / (2 * w)) ** 2, s * k
    inside = b * b - 4 * a * (s * s - size * size)
    if inside < 0:
        return []
    return sorted(((-b - sqrt(inside)) / (2 * a), (-b + sqrt(inside)) / (2 * a)))


def one_n_fold(w, r, turns: int) -> mpf:
    """Clearance at which both are one: the discriminant of the quadratic is zero."""
    w, r = mpf(w), mpf(r)
    time = 2 * pi * turns / w
    k = (1 + r) * sin(time) / (1 - cos(time))
    a = k * k / 4 + ((1 - r) / (2 * w)) ** 2
    return sqrt(a / (a - k * k / 4)) / abs(1 - w * w)


def one_n_count(w, r, clearance, turns: int) -> int:
    """How many of them impact upwards and stay below the stop between their impacts, sampled."""
    forced = Forced.of(1, 0, 1, w, clearance, r)
    size = 1 / (1 - forced.w**2)
    time = 2 * pi * turns / forced.w
    k = (1 + forced.r) * sin(time) / (1 - cos(time))
    count = 0
    for v in one_n_velocities(w, r, clearance, turns):
        along = (forced.clearance + k * v / 2) / size
        across = -(1 - forced.r) * v / (2 * forced.w) / size
        start = atan2(across, along) / forced.w
        samples = (forced.flight(start, -forced.r * v, time * j / 400)[0] for j in range(1, 400))
        count += v > 0 and max(samples) < forced.clearance
    return count


def doubling_frequency(r, guess):
    """Frequency at which the (1, 1) orbit at clearance 0 has the multiplier -1."""
    r = mpf(r)

    def off(w):
        v = one_n_velocities(w, r, 0, 1)[1]
        time = 2 * pi / w
        k = (1 + r) * sin(time) / (1 - cos(time))
        pull = k * v / 2 * (1 - w * w)
        return 1 + r * r - 2 * r * cos(time) + sin(time) * (1 + r) * pull / v

    return findroot(off, mpf(guess))


class Lobe(NamedTuple):
    """The example's cam after corner b: the nose circle up to c at 160 deg, then the top dwell."""

    nose: mpf = mpf(0.40393320723821)
    radius: mpf = mpf(0.15)
    offset: mpf = mpf(0.3)
    b: mpf = mpf(0)
    c: mpf = mpf(0)
    c_dwell: mpf = mpf(0)  # from here on the lift is that of the dwell

    @classmethod
    def example(cls) -> Lobe:
        """Corner b is where flank and nose circle touch: the triangle of the three centres."""
        nose, flank, gap = mpf(0.40393320723821), mpf(0.45), mpf(0.4) + mpf(0.45) - mpf(0.15)
        # The flank's centre stands at 90 - 180 deg from the axis, the nose's at c = 160 deg.
        c = pi * 160 / 180
        # Law of cosines: the angle at the flank's centre between axis and nose centre.
        angle = acos((flank**2 + gap**2 - nose**2) / (2 * flank * gap))
        rho = mpf(0.4) + mpf(0.45)
        # The point b on the line of the centres, at rho from the flank's centre.
        x, y = -flank + rho * cos(angle), rho * sin(angle)
        b = pi / 2 + acos(x / sqrt(x * x + y * y))
        return cls(b=b, c=c, c_dwell=c)

    def lift(self, theta):
        """(c, c_theta, c_thetatheta)."""
        if theta >= self.c_dwell:
            return self.nose + self.radius - self.offset, mpf(0), mpf(0)
        y = theta - self.c
        k, rho = self.nose, self.radius
        root = sqrt(rho**2 - (k * sin(y)) ** 2)
        first = -(k**2) * sin(y) * cos(y) / root
        second = -(k**2) * (cos(y) ** 2 - sin(y) ** 2) / root
        second -= (k**2 * sin(y) * cos(y)) ** 2 / root**3
        return k * cos(y) + root - self.offset, -k * sin(y) + first, -k * cos(y) + second


def accumulation_phase(lobe: Lobe, rpm, mass, stiffness, r, least):
    """Phase at which the bounces after lift-off at b end, followed one by one.

    The rest of the series after a bounce of `least` m/rad is its first-order sum, 2 p/((1 - r) |a|)
    with the outgoing velocity p and the acceleration a, which errs by order of least^2.
    """
    ratio = sqrt(mpf(stiffness) / mpf(mass)) / (mpf(rpm) * pi / 30)
    theta = lobe.b
    q, slope, _ = lobe.lift(theta)
    v = slope
    step = mpf("0.002")
    while True:

        def state(t, q=q, v=v):
            c, s = cos(ratio * t), sin(ratio * t)
            return q * c + v / ratio * s, v * c - q * ratio * s

        def gap(t, theta=theta):
            return state(t)[0] - lobe.lift(theta + t)[0]

        t = step
        while gap(t) > 0:
            t += step
        low, high = t - step if t > step else step / 50, t
        while gap(low) <= 0:
            low /= 2
        t = findroot(gap, (low, high), solver="anderson", tol=mpf(10) ** -70, verify=False)
        _, v_in = state(t)
        theta += t
        level, slope, second = lobe.lift(theta)
        out = mpf(r) * (slope - v_in)
        q, v = level, slope + out
        pull = ratio**2 * level + second
        if out < least:
            return theta + 2 * out / ((1 - mpf(r)) * pull)
        step = min(step, out / pull / 4)


def accumulation_rpm(corner_deg, guess, mass=1.221, stiffness=1430.8, r=0.8):
    """Speed at which the bounces after lift-off at b end exactly on a corner: one secant step.

    guess: right to some 10 digits, so that the step leaves an error of its square.
    """
    lobe = Lobe.example()
    corner = pi * corner_deg / 180
    if corner_deg == 160:  # the nose circle goes on there, so that nothing jumps beside the root
        lobe = lobe._replace(c_dwell=lobe.c + 1)
    x0, x1 = mpf(guess), mpf(guess) * (1 + mpf(10) ** -10)
    y0, y1 = (
        accumulation_phase(lobe, x, mass, stiffness, r, mpf(10) ** -12) - corner for x in (x0, x1)
    )
    return x1 - y1 * (x1 - x0) / (y1 - y0)
