"""Laws of motion from their accelerations alone, integrated zone by zone with mpmath.

Nothing here comes from the package, nor from the closed forms it uses: a zone is A sin(w x + p),
a constant, or a polynomial; velocity and height are its antiderivatives, chained from rest at
x = 0 and scaled to s(1) = 1.
"""

from mpmath import mpf, pi, sin


class Wave:
    """An acceleration sin(w x + p), and its derivatives and antiderivatives."""

    def __init__(self, w, p):
        self.w, self.p = mpf(w), mpf(p)

    def at(self, x, order):
        """Derivative of that order; -1 and -2 are antiderivatives."""
        return self.w**order * sin(self.w * x + self.p + order * pi / 2)


class Power:
    """An acceleration sum terms[n] x^n."""

    def __init__(self, terms):
        self.terms = {n: mpf(a) for n, a in terms.items()}

    def at(self, x, order):
        """Derivative of that order; -1 and -2 are antiderivatives."""
        total = mpf(0)
        for n, a in self.terms.items():
            for k in range(max(order, 0)):
                a *= n - k
            for k in range(-order):
                a /= n + k + 1
            if a:
                total += a * mpf(x) ** (n - order)
        return total


class Law:
    """s(x) from zones [(end, acceleration), ...] that start at x = 0 with s = s' = 0."""

    def __init__(self, zones):
        """A law of motion from zones: (end, wave) each, waves as second derivatives of the lift.

        Each zone begins with the height and the rate at which the one before it ends. The whole is
        scaled to a lift of 1.
        """
        self.zones, start, height, rate = [], mpf(0), mpf(0), mpf(0)
        for end, zone in zones:
            self.zones.append((start, mpf(end), zone, height, rate))
            _, height, rate = self._at(self.zones[-1], mpf(end))
            start = mpf(end)
        self.scale = 1 / height

    @property
    def joints(self):
        """Where one zone ends and the next begins, both ends included."""
        return [zone[0] for zone in self.zones] + [mpf(1)]

    def derivative(self, x, order, side=1):
        """The order-th derivative of s; at a joint from the right (1) or the left (-1)."""
        inside = (z for z in self.zones if (x < z[1] if side > 0 else x <= z[1]))
        zone = next(inside, self.zones[-1])
        if order >= 2:
            return self.scale * zone[2].at(x, order - 2)
        return self.scale * self._at(zone, x)[2 if order else 1]

    @staticmethod
    def _at(zone, x):
        """(None, height, rate) at x in a zone: the wave integrated twice, and once."""
        start, _, wave, height, rate = zone
        gained = wave.at(x, -1) - wave.at(start, -1)
        moved = wave.at(x, -2) - wave.at(start, -2) - wave.at(start, -1) * (x - start)
        return None, height + rate * (x - start) + moved, rate + gained


def sine_constant_cosine(b, c, d):
    """The SCCA acceleration: half a b, half a c, d, half a c, half a b."""
    b, c, d = mpf(b), mpf(c), mpf(d)
    zones = []
    if b:
        zones.append((b / 2, Wave(pi / b, 0)))
    if c:
        zones.append(((b + c) / 2, Power({0: 1})))
    if d:
        zones.append(((1 + d) / 2, Wave(pi / d, pi / 2 - pi / d * (1 - d) / 2)))
    if c:
        zones.append((1 - b / 2, Power({0: -1})))
    if b:
        zones.append((mpf(1), Wave(pi / b, -pi / b)))
    return Law(zones)


class Ramp:
    """Constant velocity: s = x."""

    joints = (mpf(0), mpf(1))

    @staticmethod
    def derivative(x, order, side=1):
        """x, 1, 0, 0, ..."""
        return mpf(x) if order == 0 else mpf(order == 1)


LAWS = {
    "constant-velocity": Ramp(),
    "constant-acceleration": sine_constant_cosine(0, 1, 0),
    "harmonic": Law([(1, Wave(pi, pi / 2))]),
    "cycloidal": Law([(1, Wave(2 * pi, 0))]),
    "3-4-5": Law([(1, Power({1: 60, 2: -180, 3: 120}))]),
    "4-5-6-7": Law([(1, Power({2: 420, 3: -1680, 4: 2100, 5: -840}))]),
    "modified-trapezoid": sine_constant_cosine("0.25", "0.5", "0.25"),
    "modified-sine": sine_constant_cosine("0.25", 0, "0.75"),
}
OWN = {"b": 0.3, "c": 0.15, "d": 0.55}
OWN_LAW = sine_constant_cosine("0.3", "0.15", "0.55")
