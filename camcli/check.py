"""Check the statements of a proof.json of `cam orbits --prove`: python check.py proof.json

This file needs Python 3.11 and python-flint, and nothing of camcli: copy it wherever you like. It
was written from the theorem, which stands in the guide (`cam guide proofs`), not from the program
that finds the proofs: it has equations, derivatives and cams of its own. Numbers are balls
(python-flint's `arb`), so that a comparison is true only where it holds for all that they may be.

Exit code 0: every statement is confirmed; 1: one is not; 2: the file is no certificate.

Terms of this file. The unknowns z of an orbit are theta_1, v_1, ..., theta_n, v_n, p: the phase of
each impact (rad within the turn), the relative rate at which it leaves the cam (m/rad), and the
parameter, a constant of the machine, or (cam.NAME) a number of the cam. A box holds the points
z = middle + tangent eta + e with |eta| <= half and |e| <= error; the unknown `fixed` has the
tangent 1 and the error 0, so that eta is how far it differs from its middle. Rates and
accelerations are those by the angle of the cam.
"""

import json
import re
import sys
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from itertools import combinations_with_replacement, pairwise
from itertools import product as every_choice
from types import SimpleNamespace

from flint import arb, arb_mat, arb_series, ctx

BITS = 256  # of every ball
BITS_OF_COVER = 64  # of the balls of a cover, whose boxes are wide
LARGEST_FILE = 400_000_000  # bytes
CLOSURE = Fraction("1e-9")  # deg: by so much a rounded fall may end behind the turn
ROUNDED_SLOPE = 1e-9  # m/rad: by less the slopes of a fit's pieces differ where they meet
CONSTANTS = ("rpm", "mass", "stiffness", "damping", "gravity", "preload", "restitution")
VARIED = {
    "arcs": (
        "base_radius",
        "flank_center",
        "nose_center",
        "nose_radius",
        "top_dwell_deg",
        "offset",
    ),
    "eccentric": ("base", "lift"),
    "law": ("base", "lift"),
    "oscillator": ("mass", "stiffness", "damping", "amplitude", "frequency", "clearance"),
}
ANY_SIGN = ("gravity", "preload", "base", "offset", "clearance")
TREE = re.compile(r"[.o1-9]{1,20000000}")
NUMBER = re.compile(r"-?[0-9]{1,400}(\.[0-9]{1,1200})?(e-?[0-9]{1,3})?")
DIGITS_OF_ANGLE = 7  # of the angle by which a corner of the cam is named, deg
DIGITS_OF_SIZE = 3  # of the size of an ellipse, rounded down
SHOWN = 30  # digits of a number in what is printed
MOST_AT_STROBE = 6  # impacts of one orbit that may lie on either side of the strobe
LAWS = {"constant-velocity": {1: 1}, "3-4-5": {3: 10, 4: -15, 5: 6},
        "4-5-6-7": {4: 35, 5: -84, 6: 70, 7: -20}}  # fmt: skip
SCCA = {"constant-acceleration": (0, 0), "harmonic": (0, 1), "modified-trapezoid": (0.25, 0.25),
        "modified-sine": (0.25, 0.75), "cycloidal": (0.5, 0.5)}  # fmt: skip


class RefusedError(Exception):
    """A statement was not confirmed; the text says why."""


class NoCertificateError(Exception):
    """The file is not of the form that a certificate has; the text says where."""


def need(holds, why):
    """Refuse the statement unless a comparison certainly holds."""
    if not holds:
        raise RefusedError(why)


# -- reading: every value has its form, and no key is left over


def take(value, where, **forms):
    """The entries of an object, each read by its form; exactly these keys."""
    if not isinstance(value, dict) or set(value) != set(forms):
        raise NoCertificateError(f"{where}: expected an object with the keys {', '.join(forms)}")
    return SimpleNamespace(
        **{key: form(value[key], f"{where}.{key}") for key, form in forms.items()}
    )


def many(form, most=1_000_000):
    """The form of a list of values of one form."""

    def read(value, where):
        if not isinstance(value, list) or len(value) > most:
            raise NoCertificateError(f"{where}: expected a list of at most {most}")
        return [form(one, f"{where}[{k}]") for k, one in enumerate(value)]

    return read


def fraction(value, where):
    """An exact number, written as text; a parameter that stands in its place stays as it is."""
    if isinstance(value, arb | Jet):
        return value
    if not isinstance(value, str) or not NUMBER.fullmatch(value):
        raise NoCertificateError(f'{where}: expected a number as text, like "0.85"')
    return Fraction(value)


def ball(value, where):
    """An exact number as a ball."""
    return arb_of(fraction(value, where))


def arb_of(exact):
    """The ball of a fraction."""
    return arb(exact.numerator) / exact.denominator if isinstance(exact, Fraction) else exact


def whole(low, high):
    """The form of a whole number within bounds."""

    def read(value, where):
        if type(value) is not int or not low <= value <= high:
            raise NoCertificateError(f"{where}: expected a whole number from {low} to {high}")
        return value

    return read


def truth(value, where):
    """True or false."""
    if type(value) is not bool:
        raise NoCertificateError(f"{where}: expected true or false")
    return value


def choice(*words):
    """The form of one of these words."""

    def read(value, where):
        if not isinstance(value, str) or value not in words:
            raise NoCertificateError(f"{where}: expected one of {', '.join(words)}")
        return value

    return read


def text(value, where):
    """A short text of one line: what is printed of a file must not look like another line."""
    if not isinstance(value, str) or len(value) > 400 or not value.isprintable():
        raise NoCertificateError(f"{where}: expected a short text in one line")
    return value


def nothing_or(form):
    """The form of a value that may be null."""
    return lambda value, where: None if value is None else form(value, where)


# -- numbers with their partial derivatives


class Jet:
    """A ball, and the balls of its derivatives by some unknowns; all may be series in an angle."""

    __slots__ = ("slopes", "value")

    def __init__(self, value, slopes):
        self.value, self.slopes = value, slopes

    def through(self, value, slope):
        """A function of this number that has this value and this slope here."""
        return Jet(value, [slope * d for d in self.slopes])

    def __add__(self, other):
        if not isinstance(other, Jet):
            return Jet(self.value + other, self.slopes)
        sums = [a + b for a, b in zip(self.slopes, other.slopes, strict=True)]
        return Jet(self.value + other.value, sums)

    def __mul__(self, other):
        if not isinstance(other, Jet):
            return self.through(self.value * other, other)
        pairs = zip(self.slopes, other.slopes, strict=True)
        products = [a * other.value + self.value * b for a, b in pairs]
        return Jet(self.value * other.value, products)

    def __truediv__(self, other):
        return self * inverse(other)

    def __neg__(self):
        return self * -1

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __rtruediv__(self, other):
        return inverse(self) * other

    __radd__, __rmul__ = __add__, __mul__


def inverse(x):
    """1/x."""
    if not isinstance(x, Jet):
        return 1 / arb(x)
    return x.through(1 / x.value, -1 / (x.value * x.value))


def root(x):
    """The square root."""
    if isinstance(x, Jet):
        return x.through(root(x.value), 1 / (2 * root(x.value)))
    return series_root(x) if isinstance(x, arb_series) else x.sqrt()


def angle_of(y, x):
    """The angle of the vector (x, y)."""
    if not isinstance(x, Jet) and not isinstance(y, Jet):
        return arb.atan2(y, x)
    a, b = plain(x), plain(y)
    square = a * a + b * b
    turned = y * (a / square) - x * (b / square)  # with its derivatives those of the angle
    return Jet(arb.atan2(b, a), turned.slopes)


def exp(x):
    """The exponential function."""
    return x.through(x.value.exp(), x.value.exp()) if isinstance(x, Jet) else x.exp()


def sin_cos(x):
    """Sine and cosine."""
    if not isinstance(x, Jet):
        return x.sin_cos()
    sine, cosine = x.value.sin_cos()
    return x.through(sine, cosine), x.through(cosine, -sine)


def series(x, k):
    """The sum of x^j/(j + k)! over all j, for k = 1 or 2."""
    if not isinstance(x, Jet):
        return x.hypgeom_1f1(1, k + 1) / k
    return x.through(series(x.value, k), x.value.hypgeom_1f1(2, k + 2) / (4 * k - 2))


def plain(x):
    """The ball of a number without its derivatives."""
    return x.value if isinstance(x, Jet) else arb(x)


def slopes_of(x):
    """The derivatives of a number by one unknown: zero of one that depends on nothing."""
    return x.slopes if isinstance(x, Jet) else [arb(0)]


# -- the cam: its smooth stretches, from its definition


class Stretch:
    """The cam between two angles (rad), c = lift(theta) in m, analytic a little beyond them."""

    def __init__(self, start, end, lift):
        self.start, self.end, self.lift = start, end, lift

    def derivatives(self, theta, order):
        """c and its derivatives by theta, as many as `order`, for all angles of a ball."""
        lift = self.lift(arb_series([theta, 1], order + 1))
        factor, found = 1, []
        for k in range(order + 1):
            factor *= max(k, 1)
            if isinstance(lift, Jet):
                slopes = [term(d, k) * factor for d in lift.slopes]
                found.append(Jet(term(lift.value, k) * factor, slopes))
            else:
                found.append(lift[k] * factor)
        return found

    def at(self, theta, order):
        """The same for a number with derivatives."""
        if not isinstance(theta, Jet):
            return self.derivatives(theta, order)
        pairs = pairwise(self.derivatives(theta.value, order + 1))
        return [a + theta.through(0, plain(b)) for a, b in pairs]


def term(x, k):
    """Term k of a series; a ball is one that goes no further."""
    return x[k] if isinstance(x, arb_series) else x if k == 0 else arb(0)


def series_root(x):
    """The square root of a series, term by term, which is sharper than python-flint's own."""
    terms = [x[0].sqrt()]
    for k in range(1, x.prec):
        mixed = sum((terms[i] * terms[k - i] for i in range(1, k)), arb(0))
        terms.append((x[k] - mixed) / (2 * terms[0]))
    return arb_series(terms, x.prec)


def level(c):
    """The lift of a dwell."""
    return lambda theta: theta * 0 + c


def polynomial(coefficients, center=0):
    """The sum of a_j (theta - center)^j."""

    def lift(theta):
        total = theta * 0
        for a in reversed(coefficients):
            total = total * (theta - center) + a
        return total

    return lift


def radians(degrees):
    """Degrees, a fraction or a ball, to rad."""
    return (arb_of(degrees) if isinstance(degrees, Fraction) else degrees) * arb.pi() / 180


def arcs(cam, where):
    """Three circles tangent to one another; the flank's radius is base_radius + flank_center.

    Returns the phases between which the smooth parts of a turn lie, 0 and 2 pi included, and the
    lift of each part as a function of the phase.
    """
    keys = "base_radius", "flank_center", "nose_center", "nose_radius", "top_dwell_deg", "offset"
    cam = take(cam, where, kind=text, **dict.fromkeys(keys, ball))
    pi, k1, k2, rho2 = arb.pi(), cam.flank_center, cam.nose_center, cam.nose_radius
    rho1 = cam.base_radius + k1
    # The centres O1 = (-k1, 0) and O2 are rho1 - rho2 apart, and O2 is k2 away from O = (0, 0).
    x2 = ((rho1 - rho2) * (rho1 - rho2) - k1 * k1 - k2 * k2) / (2 * k1)
    y2 = root(k2 * k2 - x2 * x2)
    rise = angle_of(y2, x2)  # the angle from the flank's begin to the top
    scale = rho1 / (rho1 - rho2)  # the circles touch on the line from O1 through O2
    flank = angle_of(y2 * scale, (x2 + k1) * scale - k1)
    top = pi - radians(cam.top_dwell_deg) / 2

    def circle(kappa, rho, zero):
        def lift(theta):
            sine, cosine = sin_cos(theta - zero)
            across = kappa * sine
            return kappa * cosine + root(rho * rho - across * across) - cam.offset

        return lift

    low, high = level(cam.base_radius - cam.offset), level(k2 + rho2 - cam.offset)
    edges = [0 * pi, top - rise, top - rise + flank, top]
    edges += [2 * pi - edge for edge in reversed(edges)]
    up = circle(-k1, rho1, edges[1]), circle(k2, rho2, edges[3])
    down = circle(k2, rho2, edges[4]), circle(-k1, rho1, edges[6])
    return edges, [low, *up, high, *down, low]


def eccentric(cam, where):
    """c = base + lift (1 - cos theta)/2."""
    cam = take(cam, where, kind=text, base=ball, lift=ball)
    return [arb(0), 2 * arb.pi()], [lambda theta: cam.base + cam.lift / 2 * (1 - theta.cos())]


def oscillator(cam, where):
    """The steady motion of a forced oscillator without its stop, less the clearance."""
    keys = "mass", "stiffness", "damping", "amplitude", "frequency", "clearance"
    cam = take(cam, where, kind=text, **dict.fromkeys(keys, ball))
    spring = cam.stiffness - cam.mass * (cam.frequency * cam.frequency)
    damper = cam.damping * cam.frequency
    share = cam.amplitude / (spring * spring + damper * damper)

    def lift(theta):
        return share * (spring * theta.cos() + damper * theta.sin()) - cam.clearance

    return [arb(0), 2 * arb.pi()], [lift]


def law(cam, where):
    """Base dwell, rise, top dwell and fall, of which every motion follows a law."""
    keys = "start_deg", "rise_deg", "top_dwell_deg", "fall_deg"
    cam = take(cam, where, kind=text, base=ball, lift=ball, rise_law=law_name, fall_law=law_name,
               **dict.fromkeys(keys, fraction))  # fmt: skip
    start = cam.start_deg % 360
    top = start + cam.rise_deg
    fall = top + cam.top_dwell_deg
    end = min(fall + cam.fall_deg, start + 360)
    if fall + cam.fall_deg - end > CLOSURE:
        raise NoCertificateError(f"{where}: its motions take more than one turn")
    high = cam.base + cam.lift
    parts = [
        *motion(cam.rise_law, start, top, cam.base, cam.lift),
        (top, fall, lambda origin: level(high)),
        *motion(cam.fall_law, fall, end, high, -cam.lift),
        (end, start + 360, lambda origin: level(cam.base)),
    ]
    turns = [(a - turn, b - turn, turn, lift) for turn in (0, 360) for a, b, lift in parts]
    turns = [(max(a, 0), min(b, 360), turn, lift) for a, b, turn, lift in turns]
    turns = sorted((one for one in turns if one[0] < one[1]), key=lambda one: one[:2])
    edges = [radians(Fraction(a)) for a, _, _, _ in turns]
    if not turns or any(a[1] != b[0] for a, b in pairwise([(0, 0), *turns, (360, 0)])):
        raise NoCertificateError(f"{where}: its motions do not fill one turn")
    return [*edges, 2 * arb.pi()], [lift(radians(Fraction(turn))) for _, _, turn, lift in turns]


def law_name(value, where):
    """A law by its name, or the two widths of the sine and the cosine of its acceleration."""
    if isinstance(value, str):
        return choice(*LAWS, *SCCA)(value, where)
    widths = take(value, where, b=fraction, d=fraction)
    return widths.b, widths.d


def motion(name, start, end, low, step):
    """The parts of c = low + step s(x), x from 0 at `start` to 1 at `end`, degrees.

    Each is (from, to, lift), where `lift` asks on which turn (rad) the function is wanted.
    """

    def part(x0, x1, height):
        def lift(turn):
            return lambda theta: (
                low + step * height((theta - radians(start) + turn) / radians(end - start))
            )

        return start + (end - start) * x0, start + (end - start) * x1, lift

    if name in LAWS:
        terms = LAWS[name]
        return [part(0, 1, polynomial([terms.get(k, 0) for k in range(max(terms) + 1)]))]
    sine, cosine = map(Fraction, SCCA[name] if isinstance(name, str) else name)
    pi, b, d = arb.pi(), arb_of(sine), arb_of(cosine)
    c = 1 - b - d
    # s'' is `most` times: sin(pi x/b), then 1, then cos(pi y/d), and the mirror image of these
    most = 4 * pi**2 / ((pi**2 - 8) * (b * b - d * d) - 2 * pi * (pi - 2) * b + pi**2)
    rest = b * b / 8 - (b / pi) ** 2

    def rising(x):
        return most * (b / pi * x - (b / pi) ** 2 * (pi / b * x).sin())

    def constant(x):
        return most * (x * x / 2 + b * (1 / pi - arb(1) / 2) * x + rest)

    def turning(x):
        wave = (d / pi) ** 2 * (1 - (pi / d * (x - (1 - d) / 2)).cos())
        return most * ((b / pi + c / 2) * x + wave + rest - (1 - d) ** 2 / 8)

    if sine == cosine == Fraction(1, 2):  # one sine throughout
        return [part(0, 1, rising)]
    edges = [Fraction(0), sine / 2, (1 - cosine) / 2, (1 + cosine) / 2, 1 - sine / 2, Fraction(1)]
    heights = (
        rising,
        constant,
        turning,
        lambda x: 1 - constant(1 - x),
        lambda x: 1 - rising(1 - x),
    )
    zones = zip(pairwise(edges), heights, strict=True)
    return [part(x0, x1, height) for (x0, x1), height in zones if x1 > x0]


def pieces(cam, where):
    """Polynomials on shares of the turn, as they are given: what the fit of a table is.

    Each is on `first` to `last` of `count` equal parts of the turn.
    """

    def piece(value, where):
        index = whole(0, 1_000_000)
        numbers = many(ball, 64)
        return take(value, where, first=index, last=index, center=ball, coefficients=numbers)

    cam = take(cam, where, kind=text, count=whole(1, 1_000_000), pieces=many(piece))
    ends = [(0, 0), *((one.first, one.last) for one in cam.pieces), (cam.count, 0)]
    if any(a[1] != b[0] for a, b in pairwise(ends)) or any(a >= b for a, b in ends[1:-1]):
        raise NoCertificateError(f"{where}: its pieces do not fill one turn")
    edges = [2 * arb.pi() * k / cam.count for k in [one.first for one in cam.pieces] + [cam.count]]
    return edges, [polynomial(one.coefficients, one.center) for one in cam.pieces]


CAMS = {
    "arcs": arcs,
    "eccentric": eccentric,
    "oscillator": oscillator,
    "law": law,
    "pieces": pieces,
}


def read_cam(value, where):
    """(kind, stretches) of a cam: those of no length are left out."""
    kind = value.get("kind") if isinstance(value, dict) else None
    if not isinstance(kind, str) or kind not in CAMS:
        raise NoCertificateError(f"{where}.kind: expected one of {', '.join(CAMS)}")
    stretches = stretches_of(kind, value, where)
    if kind != "pieces":  # whose steps are looked at in every flight
        closed(stretches, where)
    return kind, stretches


def stretches_of(kind, value, where):
    """The stretches of a cam, in which the parameter may stand in the place of a number."""
    edges, lifts = CAMS[kind](value, where)
    ends = list(pairwise(edges))
    lengths = [plain(b) - plain(a) for a, b in ends]
    if not all(size > 0 or abs(size) < arb(2) ** (64 - BITS) for size in lengths):
        raise NoCertificateError(f"{where}: these numbers make no cam")
    parts = zip(ends, lengths, lifts, strict=True)
    return [Stretch(a, b, lift) for (a, b), size, lift in parts if size > 0]


def closed(stretches, where):
    """See that each stretch begins at the height (m) at which the one before it ends.

    Balls that overlap show no step, and a wide ball would hide one: it may not be wide either.
    """
    for k, there in enumerate(stretches):
        here = stretches[k - 1]
        end, start = here.derivatives(here.end, 0)[0], there.derivatives(there.start, 0)[0]
        close = end.overlaps(start) and abs(end - start) < arb(2) ** (64 - BITS)
        if not close:
            raise NoCertificateError(f"{where}: these numbers make no cam, it has a step")


# -- the orbit: its equations, its box, its flights


class Flow:
    """A flight: q'' + 2 Z q' + W2 q + G = 0 by the angle of the cam."""

    def __init__(self, constants, p, stretches, speed):
        """The machine whose open constant has the value p: a ball, or one with derivatives.

        stretches: of the cam there; speed: in rpm, where it is not among the constants, else None.
        """
        self.stretches = stretches
        known = {key: p if value is None else arb_of(value) for key, value in constants.items()}
        known["rpm"] = known["rpm"] if speed is None else speed
        rpm, m, k, b, g, load, self.r = (known[key] for key in CONSTANTS)
        second = 30 / arb.pi() / rpm  # the time in which the cam turns by a radian
        self.W2, self.Z = k / m * (second * second), b / (2 * m) * second
        self.G = (g + load / m) * (second * second)
        square = 4 * (k * m) - b * b
        exact = [constants[key] for key in ("mass", "stiffness", "damping")]
        self.sprung = constants["stiffness"] != 0
        self.damped = constants["damping"] != 0
        self.critical = None not in exact and exact[2] ** 2 == 4 * exact[0] * exact[1]
        self.under = bool(plain(square) > 0)
        if not self.critical:
            need(self.under or plain(square) < 0, "whether the follower is overdamped is open")
            self.f = root(square if self.under else -square) / (2 * m) * second

    def parts(self, s):
        """(B, B', P) after s rad: B solves it for G = 0, B(0) = 0, B'(0) = 1; P is its integral."""
        if self.damped and not self.sprung:
            x = -(2 * (self.Z * s))
            return s * series(x, 1), exp(x), s * s * series(x, 2)
        decay = exp(-(self.Z * s)) if self.damped else 1
        if self.critical:
            b, c = decay * s, decay
        elif self.under:
            sine, cosine = sin_cos(self.f * s)
            b, c = decay * (sine / self.f), decay * cosine
        else:
            slow, fast = exp((self.f - self.Z) * s), exp(-((self.f + self.Z) * s))
            b, c = (slow - fast) / (2 * self.f), (slow + fast) / 2
        zb = self.Z * b
        return b, c - zb, (1 - c - zb) / self.W2 if self.sprung else s * s / 2

    def state(self, q, w, s):
        """(q, q', q'') after s rad of flight from (q, w)."""
        b, b1, p = self.parts(s)
        pull = self.G + self.W2 * q
        q, w = q + w * b - pull * p, w * b1 - pull * b
        return q, w, self.acceleration(q, w)

    def acceleration(self, q, w):
        """q'' at a place and a rate."""
        return -(self.G + self.W2 * q + 2 * (self.Z * w))


class Orbit:
    """The equations of the orbits of one statement."""

    def __init__(self, kind, stretches, said, numbers=None):
        self.cam, self.stretches, self.said = kind, stretches, said
        self.numbers = numbers  # of the cam, as they stand in the file
        self.in_cam = said.parameter.removeprefix("cam.") if "." in said.parameter else None
        self.n, self.turns = len(said.impacts), said.turns
        need(self.n > 0, "an orbit without impacts is not checked here")
        need(0 <= getattr(said, "strobe", 0) < 360, "the strobe lies outside the turn")
        need(
            all(one.stretch < len(stretches) for one in said.impacts), "the cam has no such stretch"
        )
        self.places = [one.stretch for one in said.impacts]
        self.at_turn = [one.turn for one in said.impacts]
        # a period begins at the strobe, so that it may end a turn later than at the angle zero
        need(all(turn <= self.turns for turn in self.at_turn), "an impact lies beyond the period")
        wanted = {key for key, value in said.constants.items() if value is None}
        need(wanted == self.left_open(), "exactly the parameter has to be left open")
        known = {key: value for key, value in said.constants.items() if value is not None}
        need(all(known.get(key, 1) > 0 for key in ("rpm", "mass")), "speed or mass is not positive")
        need(
            known.get("stiffness", 0) >= 0 and known.get("damping", 0) >= 0,
            "a constant is negative",
        )
        need(0 < known.get("restitution", 1) <= 1, "the restitution lies outside 0 to 1")

    def left_open(self):
        """The constants of the machine that follow from the parameter.

        An oscillator turns as fast as its force, and its mass, stiffness and damping are those of
        its cam too; they stand in both where they are not the parameter.
        """
        if self.in_cam is None:
            return {self.said.parameter}
        known = isinstance(self.numbers, dict) and self.in_cam in self.numbers
        need(known and self.in_cam in VARIED.get(self.cam, ()), "the cam has no such number")
        if self.cam != "oscillator":
            return set()
        shared = ("mass", "stiffness", "damping")
        for key in shared:
            same = self.said.constants[key] == fraction(self.numbers[key], "cam")
            need(key == self.in_cam or same, "the oscillator has other constants than its cam")
        return {"rpm", *({self.in_cam} & set(shared))}

    def flow(self, p):
        """The flight at a value of the parameter, which has to be possible."""
        parameter = self.in_cam or self.said.parameter
        need(plain(p) > 0 or parameter in ANY_SIGN, "the parameter is no such constant")
        need(plain(p) <= 1 or parameter != "restitution", "the restitution exceeds 1")
        speed = None
        if self.in_cam is not None and self.cam == "oscillator":
            frequency = self.numbers["frequency"]
            speed = p if parameter == "frequency" else arb_of(fraction(frequency, "cam"))
            need(plain(speed) > 0, "the frequency is not positive")
            speed = speed * 30 / arb.pi()
        return Flow(self.said.constants, p, self.stretches_at(p), speed)

    def stretches_at(self, p):
        """The cam at a value of the parameter: a ball, or one with derivatives."""
        if self.in_cam is None:
            return self.stretches
        found = stretches_of(self.cam, {**self.numbers, self.in_cam: p}, "cam")
        need(len(found) == len(self.stretches), "the cam has other parts there")
        return found

    def turned(self, k):
        """The turns between impact k and the next one, rad."""
        after = (k + 1) % self.n
        turns = self.at_turn[after] - self.at_turn[k] + (self.turns if after == 0 else 0)
        return 2 * arb.pi() * turns

    def flight(self, flow, z, k, end=None):
        """Where flight k meets the cam again, and the slopes of that by its start.

        (gap, its rate, its acceleration, slopes of the gap, slopes of the rate): m and rad; slopes
        by theta and v of impact k. Moved with its impact, a flight starts by v dtheta lower, and
        by (c'' - q'') dtheta + dv faster. end: the phase in the turn of the next impact, or that.
        """
        after = (k + 1) % self.n
        end = z[2 * after] if end is None else end
        c, c1, c2 = flow.stretches[self.places[k]].at(z[2 * k], 2)
        end_c, end_c1, end_c2 = flow.stretches[self.places[after]].at(end, 2)
        v, s = z[2 * k + 1], end - z[2 * k] + self.turned(k)
        q, w, a = flow.state(c, c1 + v, s)
        b, b1, p = flow.parts(s)
        lag = c2 - flow.acceleration(c, c1 + v)
        gaps = lag * b - v * (1 - flow.W2 * p), b
        rates = lag * b1 + v * (flow.W2 * b), b1
        return q - end_c, w - end_c1, a - end_c2, gaps, rates

    def map(self, flow, z, k):
        """[[e, f], [g, h]]: how (dtheta, dv) of impact k moves those of the next."""
        _, rate, accel, gaps, rates = self.flight(flow, z, k)
        e, f = (-(gap / rate) for gap in gaps)  # of the next phase
        g, h = (-(flow.r * (x + accel * y)) for x, y in zip(rates, (e, f), strict=True))
        return e, f, g, h

    def equations(self, z, sloped):
        """(E, E') as matrices; E' only where `sloped`.

        Flight k gives E1, the gap where it ends, and E2 = r rate + v of the impact there.
        """
        n, rows, values = self.n, [], []
        flow = self.flow(Jet(z[-1], [1]) if sloped else z[-1])
        for k in range(n):
            gap, rate, accel, gaps, rates = self.flight(flow, z, k)
            after = 2 * ((k + 1) % n)
            bounce = flow.r * rate + z[after + 1]
            values += [[plain(gap)], [plain(bounce)]]
            if sloped:
                r = plain(flow.r)
                fall, lift = ([arb(0)] * (2 * n) + slopes_of(x) for x in (gap, bounce))
                for i in (0, 1):
                    fall[2 * k + i] += plain(gaps[i])
                    lift[2 * k + i] += r * plain(rates[i])
                fall[after] += plain(rate)
                lift[after] += r * plain(accel)
                lift[after + 1] += 1
                rows += [fall, lift]
        return arb_mat(values), arb_mat(rows) if sloped else None

    def trace_det(self, z):
        """Trace and determinant of the map of one period: a matrix of (dtheta, dv) a flight."""
        flow = self.flow(z[-1])
        a, b, c, d = 1, 0, 0, 1  # the product [[a, b], [c, d]] so far
        for k in range(self.n):
            e, f, g, h = self.map(flow, z, k)
            a, b, c, d = e * a + f * c, e * b + f * d, g * a + h * c, g * b + h * d
        det = exp(-(4 * arb.pi() * self.turns * flow.Z))
        for _ in range(2 * self.n):
            det = det * flow.r
        return a + d, det

    def krawczyk(self, box):
        """Show that the box holds exactly one orbit for each eta; sets its hull and derivatives.

        With Y near the inverse of E' by the free unknowns, e is mapped by an orbit's equations to
        -Y E(middle) + (1 - Y E') e - Y E' tangent eta, which has to lie inside the box.
        """
        size = 2 * self.n
        lengths = {len(x) for x in (box.middle, box.tangent, box.error)}
        need(
            lengths == {size + 1} and box.fixed <= size, "a box has not one entry for each unknown"
        )
        shape = [len(row) for row in box.inverse]
        need(shape == [size] * size, "a matrix has not one row and column for each free unknown")
        need(box.half >= 0 and all(e >= 0 for e in box.error), "a box has a negative width")
        need(
            box.tangent[box.fixed] == 1 and box.error[box.fixed] == 0,
            "a box does not lean along its unknown",
        )
        free = [k for k in range(size + 1) if k != box.fixed]
        eta = around(0, box.half)
        error = [around(0, e) for e in box.error]
        wide = [m + t * eta + e for m, t, e in zip(box.middle, box.tangent, error, strict=True)]
        value, _ = self.equations(box.middle, False)
        _, slopes = self.equations(wide, True)
        y = arb_mat(box.inverse)
        by_free = y * arb_mat([[slopes[i, k] for k in free] for i in range(size)])
        leaning = y * (slopes * arb_mat([[t] for t in box.tangent])) * eta
        one = arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])
        off = arb_mat([[error[k]] for k in free])
        image = (one - by_free) * off - y * value - leaning
        for _ in range(3):  # of the orbit at eta = 0
            off = (one - by_free) * off - y * value
        box.reach, box.center, box.hull = error, list(box.middle), list(box.middle)
        for row, k in enumerate(free):
            need(
                error[k].contains_interior(image[row, 0]),
                "no box was shown to hold exactly one orbit",
            )
            box.center[k] += off[row, 0]
            box.hull[k] += image[row, 0]
        box.hull = [z + t * eta for z, t in zip(box.hull, box.tangent, strict=True)]
        self.without_steps(box)
        by_fixed = y * arb_mat([[slopes[i, box.fixed]] for i in range(size)])
        try:
            slope = by_free.solve(by_fixed)
        except ZeroDivisionError:
            raise RefusedError("the slopes of a branch are not enclosed") from None
        box.slope = [arb(1)] * (size + 1)
        for row, k in enumerate(free):
            box.slope[k] = -slope[row, 0]

    def without_steps(self, box):
        """Show that the cam has no step at any value that the parameter has in a box.

        The heights at which two stretches meet are analytic in the parameter, and equal by the
        formulas of their cam, on either side of the places where a root in them is zero. They are
        equal at the middle, and slopes that are finite exclude such places.
        """
        if self.in_cam is None:
            return
        closed(self.stretches_at(box.middle[-1]), "cam")
        ends = [
            (one, end) for one in self.stretches_at(box.hull[-1]) for end in (one.start, one.end)
        ]
        slopes = [one.derivatives(end, 1)[1] for one, end in ends]
        need(all(slope.is_finite() for slope in slopes), "the cam may have a step")

    def motion(self, box, corner=None):
        """Show that every orbit of a box is a motion; the impact `corner` may leave its stretch."""
        need(len(box.flights) == self.n, "not every impact has its flight")
        stretches = self.stretches_at(box.hull[-1])
        for k, index in enumerate(self.places):
            place = stretches[index]
            theta, v = box.hull[2 * k : 2 * k + 2]
            inside = k == corner or (place.start < theta and theta < place.end)
            need(inside, f"impact {k + 1} may lie outside its stretch of the cam")
            need(v > 0, f"impact {k + 1} may not bounce")
            self.clear(box, k)

    def clear(self, box, k, lifts=False):
        """Show that the gap is above zero in flight k: it rises first, and falls at last.

        lifts: it begins without a rate, so that on the first part the slope of the gap rises.
        """
        j, flight, theta = (k + 1) % self.n, box.flights[k].passages, box.hull[2 * k]
        need(box.hull[2 * j] + self.turned(k) > theta, f"flight {k + 1} ends before it begins")
        last = self.said.impacts[j].stretch, self.at_turn[j] + (self.turns if j == 0 else 0)
        at = [(one.stretch, one.turn) for one in flight]
        ends = [(self.said.impacts[k].stretch, self.at_turn[k]), last]
        count = len(self.stretches)
        steps = [b[0] + count * b[1] - a[0] - count * a[1] for a, b in pairwise(at)]
        right = at and [at[0], at[-1]] == ends and all(step == 1 for step in steps)
        need(right, f"flight {k + 1} does not pass stretch after stretch from impact to impact")
        need(all(stretch < count for stretch, _ in at), "the cam has no such stretch")
        flow = self.flow(box.hull[-1])
        c, c1 = flow.stretches[self.places[k]].derivatives(theta, 1)
        w = c1 + box.hull[2 * k + 1]
        # (passage, stretch, turn of it in rad, first phase, last phase), in the turn of impact k
        parts = []
        lands = box.hull[2 * j] + self.turned(k)
        for i, one in enumerate(flight):
            stretch, turn = flow.stretches[one.stretch], 2 * arb.pi() * (one.turn - at[0][1])
            end = lands if i == len(flight) - 1 else stretch.end + turn
            start = theta if i == 0 else stretch.start + turn
            points = [start, *(cut + turn for cut in one.cuts), end]
            parts += [(i, stretch, turn, a, b) for a, b in pairwise(points)]
        rise, fall = box.flights[k].rise, len(parts) - box.flights[k].fall
        need(0 < rise <= fall < len(parts), f"flight {k + 1} does not rise first and fall last")
        gains = []  # of the gap, over each part
        for m, (_, stretch, turn, a, b) in enumerate(parts):
            phase = a.union(b)
            middle = phase.mid()
            h = phase - middle
            q, q1, _ = flow.state(c, w, middle - theta)
            q2 = flow.state(c, w, phase - theta)[2]
            lift, lift1 = stretch.derivatives(middle - turn, 1)
            bend = q2 - stretch.derivatives(phase - turn, 2)[2]
            slope = q1 - lift1 + h * bend
            gains.append(slope * (b - a))
            if m == 0 and lifts:
                holds = bend > 0
            elif m < rise:
                holds = slope > 0
            elif m >= fall:
                holds = slope < 0
            else:
                holds = q - lift + h * (q1 - lift1 + h * bend / 2) > 0
            need(holds, f"flight {k + 1} may meet the cam on its way")
        if self.cam == "pieces":  # whose edges do not meet exactly
            for run, sign in ((range(rise), 1), (range(len(parts) - 1, fall - 1, -1), -1)):
                gap = arb(0)
                for m, after in pairwise(run):
                    gap += sign * gains[m]
                    one, other = parts[m][1], parts[after][1]
                    if parts[m][0] != parts[after][0]:
                        here, there = one.end, other.start
                        if sign < 0:
                            here, there = one.start, other.end
                        gap += one.derivatives(here, 0)[0] - other.derivatives(there, 0)[0]
                        need(gap > 0, f"flight {k + 1} may meet an edge of the cam")

    def along(self, box, function):
        """(ball at the middle of a box, slope along it) of a function of the unknowns."""
        jets = [Jet(z, [d]) for z, d in zip(box.hull, box.slope, strict=True)]
        there, sloped = function(box.center), function(jets)
        slopes = [b.slopes[0] if isinstance(b, Jet) else arb(0) for b in sloped]
        return [(plain(a), slope) for a, slope in zip(there, slopes, strict=True)]

    def multipliers(self, box):
        """(trace, det) of all orbits of a box."""
        eta = around(0, box.half)
        return [a + slope * eta for a, slope in self.along(box, self.trace_det)]

    def steady(self, box, stable):
        """Show that both multipliers lie inside the unit circle, or one outside: Jury."""
        trace, det = self.multipliers(box)
        if stable:
            need(det < 1 and abs(trace) < 1 + det, "a multiplier may lie outside the unit circle")
        else:
            need(det > 1 or abs(trace) > 1 + det, "both multipliers may lie inside the unit circle")

    def test(self, event):
        """The function of z that is zero at an event."""

        def function(z):
            if event.event == "corner-impact":
                place = self.stretches_at(z[-1])[self.places[event.impact]]
                return [z[2 * event.impact] - (place.end if event.side > 0 else place.start)]
            trace, det = self.trace_det(z)
            if event.event == "multipliers-meet":
                return [trace * trace - 4 * det]
            return [1 + det + (trace if event.event == "period-doubling" else -trace)]

        return function

    def crosses(self, box, event):
        """Show that the event's function has one zero in a box, with a slope; returns the slope."""
        ((value, slope),) = self.along(box, self.test(event))
        need(abs(value) < abs(slope) * box.half, "the function of an event may have no zero")
        return slope

    def corner_of(self, event):
        """The impact that may lie beyond its stretch, or None."""
        if event is None or event.event != "corner-impact":
            return None
        need(event.impact < self.n and event.side != 0, "a corner impact names its impact and side")
        return event.impact

    def kink(self, k, side, p):
        """Whether the cam's slope jumps at the end (side 1) or the start of impact k's stretch.

        The pieces of a fit meet but for roundings.
        """
        stretches = self.stretches_at(p)
        here = stretches[self.places[k]]
        there = stretches[(self.said.impacts[k].stretch + side) % len(stretches)]
        ends = (here.end, there.start) if side > 0 else (here.start, there.end)
        one, other = (x.derivatives(end, 1)[1] for x, end in zip((here, there), ends, strict=True))
        if self.cam == "pieces":
            return not abs(one - other) < ROUNDED_SLOPE
        return not one.overlaps(other)

    def labels(self, box):
        """The labels that the orbits of a box may have: the impacts of each turn after the strobe.

        One that may lie on either side of the strobe is counted on both.
        """
        strobe = radians(self.said.strobe)
        sides = []  # of each impact: whether it lies before the strobe
        for theta in box.hull[: 2 * self.n : 2]:
            if theta < strobe:
                sides.append([True])
            elif theta >= strobe:
                sides.append([False])
            else:
                sides.append([True, False])
        open_sides = sum(len(one) > 1 for one in sides)
        need(open_sides <= MOST_AT_STROBE, "impacts may lie on either side of the strobe")
        names = set()
        for chosen in every_choice(*sides):
            counts = [0] * self.turns
            for turn, before in zip(self.at_turn, chosen, strict=True):
                counts[(turn - before) % self.turns] += 1
            turned = max(counts[k:] + counts[:k] for k in range(self.turns))
            names.add(f"P({self.turns};{':'.join(map(str, turned))})")
        return names

    def counted(self, box):
        """Show that the label is that of all orbits of a box."""
        names = sorted(self.labels(box))
        need(names == [self.said.label], f"its label is {' or '.join(names)}")

    def named(self, box):
        """Show that the label is that of a box's orbits, and that none has a shorter period."""
        self.counted(box)
        for d in range(1, self.turns):
            if self.turns % d == 0 and self.n % (self.turns // d) == 0:
                step = self.n * d // self.turns
                pairs = [(a, (a + 2 * step) % (2 * self.n)) for a in range(2 * self.n)]
                apart = any(not box.hull[a].overlaps(box.hull[b]) for a, b in pairs)
                need(apart, f"it may be an orbit of {d} turns gone through several times")


def around(middle, radius):
    """The ball about a point that holds all within a radius."""
    return middle + arb(0, 1) * radius


def joins(box, point):
    """Show that the orbits of a small box are those of a larger one that lie there."""
    eta = point.hull[box.fixed] - box.middle[box.fixed]
    need(abs(eta) <= box.half, "neighbouring boxes do not overlap")
    for k, z in enumerate(point.hull):
        off = z - box.middle[k] - box.tangent[k] * eta
        need(k == box.fixed or box.reach[k].contains(off), "neighbouring boxes do not overlap")


# -- all orbits: boxes of phases that hold no orbit, or one that is known


class Cell:
    """A part of one stretch of the cam in one of its turns: balls of the phase and of the lift.

    index: of the stretch, counted on from turn to turn; x: the phases, rad; c, c1, c2: the lift
    and its derivatives on all of them; middle: phase, lift and slope at one point, h: x less that.
    """

    def __init__(self, stretches, index, x):
        """x: phases within the turn, of the stretch or a little beyond it."""
        turn, stretch = index // len(stretches), stretches[index % len(stretches)]
        shift, middle = 2 * arb.pi() * turn, x.mid()
        self.index, self.own, self.h, self.stretch = index, x, x - middle, stretch
        at, at1 = stretch.derivatives(middle, 1)
        self.c, self.c1, self.c2 = stretch.derivatives(x, 2)
        self.c1 = meet(self.c1, at1 + self.c2 * self.h)
        self.c = meet(self.c, at + self.c1 * self.h)
        self.x, self.middle = x + shift, (middle + shift, at, at1)


def meet(x, y):
    """A ball that holds what lies in two balls that have a number in common."""
    return x.intersection(y)


class Cover:
    """The flights between phases of the cam, by the two phases alone.

    From c(a) to c(b), s = b - a rad later, exactly one solution of the flight's equation leads
    where B(s) > 0: it starts at the rate w = (c(b) - c(a) + (G + W2 c(a)) P)/B. So an orbit is its
    phases: those at which each impact's rates, `out` = w - c'(a) and `into` = w' - c'(b) of the
    flight before, make out + r into = 0.
    """

    STEPS = 8  # a flight is compared with the cam at the ends of so many equal parts
    SHORT = 0.6  # rad: of so short a flight its acceleration is looked at too

    def __init__(self, stretches, flow):
        self.stretches, self.flow, self.cells, self.flights = stretches, flow, {}, {}
        smooth(stretches)
        ctx.prec = BITS_OF_COVER
        parts = [self.cell((k, 5, i)) for k in range(len(stretches)) for i in range(32)]
        self.longest, self.least = None, arb(0)  # of a flight, rad; of B, where it falls again
        if flow.sprung and not flow.critical and flow.under:
            rest = [one.c + flow.G / flow.W2 for one in parts]
            low, high = arb(min(x.lower() for x in rest)), arb(max(x.upper() for x in rest))
            steepest = arb(max(abs(one.c1).upper() for one in parts))
            need(low > 0, "the follower may come to rest in flight, and flights may be long")
            self.longest = arb.pi() / flow.f
            if flow.r < 1:
                fastest = 2 * steepest + (flow.W2 * (high * high - low * low)).sqrt()
                self.least = low / (fastest * flow.r / (1 - flow.r) + steepest)

    def cell(self, key):
        """Part i of the 2^depth equal parts of a stretch, by (index, depth, i)."""
        if key not in self.cells:
            index, depth, i = key
            one = self.stretches[index % len(self.stretches)]
            ends = [one.start + (one.end - one.start) * k / 2**depth for k in (i, i + 1)]
            self.cells[key] = Cell(self.stretches, index, ends[0].union(ends[1]))
        return self.cells[key]

    def known(self, a, b):
        """`flight` of two cells by their keys."""
        if (a, b) not in self.flights:
            self.flights[a, b] = self.flight(self.cell(a), self.cell(b))
        return self.flights[a, b]

    def flight(self, a, b):
        """What the flights from one cell to another have in common; None where there is none.

        out, into: the rates at which they leave and meet the cam, None where nothing is known.
        slopes: of out by both phases, then of into, None where they are not known; middle: both
        between the cells' middles.
        """
        flow, s = self.flow, b.x - a.x
        nothing = SimpleNamespace(out=None, into=None, slopes=None, middle=None)
        if s <= 0 or (self.longest is not None and s >= self.longest):
            return None
        short = self.short(a, b, s) if b.index - a.index <= 1 else nothing
        if short is None or not s > 0:
            return short
        big, rate, p = flow.parts(s)
        keeps = 1 - flow.W2 * p  # of the height above the spring's rest
        if keeps < 0 and big < self.least:
            return None
        if not big > 0:
            return short
        decay = exp(-(2 * (flow.Z * s)))
        w = (b.c - a.c * keeps + flow.G * p) / big
        w_end = (b.c * rate - a.c * decay + flow.G * (p * rate - big * big)) / big
        out, into = w - a.c1, w_end - b.c1
        if short.out is not None:
            out, into = meet(out, short.out), meet(into, short.into)
        (start, c, c1), (end, end_c, end_c1) = a.middle, b.middle
        b0, b1, p0 = flow.parts(end - start)
        at = (end_c - c * (1 - flow.W2 * p0) + flow.G * p0) / b0
        at_end = at * b1 - (flow.G + flow.W2 * c) * b0
        middle = at - c1, at_end - end_c1
        for _ in range(2):
            leaves = a.c2 - flow.acceleration(a.c, a.c1 + out)
            lands = flow.acceleration(b.c, b.c1 + into) - b.c2
            slopes = (out * keeps / big - leaves, -into / big,
                      out * decay / big, lands - into * rate / big)  # fmt: skip
            out = meet(out, middle[0] + slopes[0] * a.h + slopes[1] * b.h)
            into = meet(into, middle[1] + slopes[2] * a.h + slopes[3] * b.h)
        if out <= 0 or into >= 0:
            return None
        for k in range(1, self.STEPS):
            phase = (start + (end - start) * k / self.STEPS).mid()
            lift = self.lift(phase)
            if lift is None or not (a.x < phase and phase < b.x):
                continue
            first, _, p1 = flow.parts(phase - start)
            q = c + at * first - (flow.G + flow.W2 * c) * p1
            since = phase - a.x
            higher = -into * flow.parts(since)[0] / big
            lower = -out * flow.parts(b.x - phase)[0] * exp(-(2 * (flow.Z * since))) / big
            if q + lower * a.h + higher * b.h < lift:
                return None
        return SimpleNamespace(out=out, into=into, slopes=slopes, middle=middle)

    def short(self, a, b, s):
        """The rates of flights on one stretch, or from one to the next; None if there are none.

        The gap is zero at both ends, so that out is -s/2 times a mean of its acceleration, and
        into s/2 times another; and where that is nowhere negative the gap is nowhere positive.
        """
        flow, nothing = self.flow, SimpleNamespace(out=None, into=None, slopes=None, middle=None)
        most = s.upper()
        if most > self.SHORT or not (self.longest is None or most < self.longest):
            return nothing
        big, rate, _ = flow.parts(most)
        if not (big > 0 and rate > 0):
            return nothing
        if a.index == b.index:
            _, c1, c2 = a.stretch.derivatives(a.own.union(b.own), 2)
        else:
            _, c1, c2 = a.stretch.derivatives(a.own.union(a.stretch.end), 2)
            _, d1, d2 = b.stretch.derivatives(b.own.union(b.stretch.start), 2)
            c1, c2 = c1.union(d1), c2.union(d2)
        time = arb(0).union(most)
        pull = flow.G + flow.W2 * a.c
        w = c1 * arb(1).union(most / big) + pull * time  # B is concave here: s/2 < P/B < s
        bend = flow.state(a.c, w, time)[2] - c2
        if bend >= 0:
            return None
        half = s / 2 if s > 0 else time / 2
        return SimpleNamespace(out=-half * bend, into=half * bend, slopes=None, middle=None)

    def lift(self, phase):
        """c at a phase; None beside a corner."""
        phase = phase - 2 * arb.pi() * (phase / (2 * arb.pi())).floor()
        for one in self.stretches:
            if phase > one.start and phase < one.end:
                return one.derivatives(phase, 0)[0]
        return None

    def newton(self, flights, cells):
        """(E at the cells' middles, its derivatives on all of them) as matrices."""
        n = len(cells)
        values, slopes = arb_mat(n, 1), arb_mat(n, n)
        for k, (here, before) in enumerate(zip(flights, flights[-1:] + flights[:-1], strict=True)):
            r = self.flow.r
            values[k, 0] = here.middle[0] + r * before.middle[1]
            slopes[k, (k - 1) % n] += r * before.slopes[2]
            slopes[k, k] += r * before.slopes[3] + here.slopes[0]
            slopes[k, (k + 1) % n] += here.slopes[1]
        return values, slopes

    def later(self, key, turns):
        """The same cell some turns later."""
        return key[0] + turns * len(self.stretches), *key[1:]

    def empty(self, keys, turns):
        """Whether no orbit of so many turns has its impacts in these cells, one after the other.

        Of its flights the first one is the longest, or one of these.
        """
        n, cells = len(keys), [self.cell(key) for key in [*keys, self.later(keys[0], turns)]]
        if n > 1:
            lengths = [b.x - a.x for a, b in pairwise(cells)]
            if any(one > lengths[0] for one in lengths) or n * lengths[0] < 2 * turns * arb.pi():
                return True
        flights = []
        for a, b in pairwise([*keys, self.later(keys[0], turns)]):
            flights.append(self.known(a, b))
            if flights[-1] is None:
                return True
        for here, before in zip(flights, flights[-1:] + flights[:-1], strict=True):
            known = here.out is not None and before.into is not None
            if known and not (here.out + self.flow.r * before.into).contains(0):
                return True
        if any(one.slopes is None for one in flights):
            return False
        values, slopes = self.newton(flights, cells[:-1])
        off = arb_mat([[one.h] for one in cells[:-1]])
        if not all(x.contains(0) for x in (values + slopes * off).entries()):
            return True
        try:
            inverse = slopes.mid().inv().mid()
        except ZeroDivisionError:
            return False
        one = arb_mat(n, n, [int(i == j) for i in range(n) for j in range(n)])
        image = (one - inverse * slopes) * off - inverse * values
        pairs = zip(image.entries(), off.entries(), strict=True)
        return not all(x.overlaps(y) for x, y in pairs)

    def alone(self, keys, turns, orbit):
        """Whether the orbit's impacts are the only zero of E near cells, which it lies in or near.

        orbit: (index of the stretch, phases) of each of its impacts.
        """
        if [key[0] for key in keys] != [index for index, _ in orbit]:
            return False
        wide = [
            Cell(self.stretches, key[0], self.cell(key).own.union(theta))
            for key, (_, theta) in zip(keys, orbit, strict=True)
        ]
        index = self.later(keys[0], turns)[0]
        flights = [self.flight(a, b) for a, b in
                   pairwise([*wide, Cell(self.stretches, index, wide[0].own)])]  # fmt: skip
        if any(one is None or one.slopes is None for one in flights):
            return False
        _, slopes = self.newton(flights, wide)
        n = len(keys)
        try:
            off = slopes.mid().inv().mid() * slopes
        except ZeroDivisionError:
            return False
        rows = [sum(abs(off[i, j] - int(i == j)) for j in range(n)) for i in range(n)]
        return all(row < 1 for row in rows)


# -- the statements


def place(value, where):
    """Stretch and turn of an impact."""
    return take(value, where, stretch=whole(0, 1_000_000), turn=whole(0, 1000))


def passage(value, where):
    """A part of a flight over one stretch, and the phases (rad) at which it is cut."""
    index, turns = whole(0, 1_000_000), whole(0, 2000)
    return take(value, where, stretch=index, turn=turns, cuts=many(ball, 100_000))


def flight(value, where):
    """A flight in parts: the gap rises on the first, falls on the last, is positive between."""
    index = whole(0, 1_000_000)
    return take(value, where, rise=index, fall=index, passages=many(passage, 100_000))


BOX = {"middle": many(ball, 200), "tangent": many(ball, 200), "error": many(ball, 200),
       "fixed": whole(0, 200), "half": ball, "inverse": many(many(ball, 200), 200)}  # fmt: skip


def point_box(value, where):
    """A box without its flights."""
    return take(value, where, **BOX)


def full_box(value, where):
    """A box with its flights."""
    return take(value, where, **BOX, flights=many(flight, 200))


def event_of(*kinds):
    """An event: its kind; which impact is at a corner, the end of its stretch (1) or not."""

    def read(value, where):
        return take(value, where, event=choice(*kinds), impact=whole(0, 200), side=whole(-1, 1))

    return read


ENDS = "period-doubling", "fold", "corner-impact"  # events at which a branch may end


def parameter(value, where):
    """A constant of the machine, or with cam. before it the name of a number of the cam."""
    if isinstance(value, str) and value.startswith("cam."):
        return "cam." + choice(*{key for keys in VARIED.values() for key in keys})(value[4:], where)
    return choice(*CONSTANTS)(value, where)


def cell_flight(value, where):
    """The flights from a cell of a box, and the phases between which they land."""
    index = whole(0, 1_000_000)
    return take(value, where, low=ball, high=ball, rise=index, fall=index,
                passages=many(passage, 100_000))  # fmt: skip


def section_box(value, where):
    """A box of impacts, middle + M (x, y) with M = [[a, b], [c, d]] and |x|, |y| <= 1.

    lands: the stretch that its flights land on, and how many turns later; cells: along x and y.
    """
    return take(value, where, stretch=whole(0, 1_000_000), middle=many(ball, 2),
                axes=many(ball, 4), lands=place, cells=many(whole(1, 1000), 2),
                flights=many(cell_flight, 100_000))  # fmt: skip


def landing(value, where):
    """Stretch and turn of an impact, and the phases between which it is."""
    return take(value, where, stretch=whole(0, 1_000_000), turn=whole(0, 1000), low=ball, high=ball)


def constants(value, where):
    """The constants of the machine; null for the parameter."""
    return vars(take(value, where, **dict.fromkeys(CONSTANTS, nothing_or(fraction))))


COMMON = {"kind": text, "label": text, "parameter": parameter, "constants": constants,
          "turns": whole(1, 1000), "strobe": fraction, "impacts": many(place, 100)}  # fmt: skip
FORMS = {
    "orbit": {"stable": truth, "low": fraction, "high": fraction, "box": full_box},
    "attractor": {"low": fraction, "high": fraction, "box": full_box,
                  "axes": many(many(ball, 4), 100)},
    "event": {"event": event_of(*ENDS, "multipliers-meet"), "signs": many(whole(-1, 1), 2),
              "low": fraction, "high": fraction, "box": full_box},
    "chaos": {"kind": text, "parameter": choice(*CONSTANTS), "constants": constants,
              "low": fraction, "high": fraction, "boxes": many(section_box, 200),
              "coverings": many(many(whole(0, 199), 2), 10_000), "growth": fraction,
              "weights": many(fraction, 200)},
    "first-detachment": {"kind": text, "constants": constants, "low": fraction, "high": fraction,
                         "stretch": whole(0, 1_000_000), "at_end": truth,
                         "cuts": many(many(ball, 100_000), 1000)},
    "corner-hit": {"kind": text, "constants": constants, "low": fraction, "high": fraction,
                   "start": whole(0, 1_000_000), "impacts": many(landing, 100), "corner": place,
                   "flights": many(flight, 101)},
    "branch": {"stable": truth, "low": many(fraction, 2), "high": many(fraction, 2),
               "ends": many(nothing_or(event_of(*ENDS)), 2), "boxes": many(full_box),
               "joints": many(point_box)},
}  # fmt: skip

ALONE = ("chaos", "first-detachment", "corner-hit")  # kinds that are about no one orbit


def statement(value, where):
    """A statement by its kind."""
    kind = value.get("kind") if isinstance(value, dict) else None
    if kind == "all-orbits":
        return all_of(value, where)
    if not isinstance(kind, str) or kind not in FORMS:
        known = ", ".join([*FORMS, "all-orbits"])
        raise NoCertificateError(f"{where}.kind: expected one of {known}")
    common = {} if kind in ALONE else COMMON
    return take(value, where, **common, **FORMS[kind])


def enclose(orbit, said):
    """Show that for every value of the parameter from low to high a box holds exactly one orbit."""
    box = said.box
    need(box.fixed == 2 * orbit.n, "the box of an orbit leans along the parameter")
    orbit.krawczyk(box)
    middle = box.middle[-1]
    need(said.low <= said.high, "its range is empty")
    low, high = arb_of(said.low), arb_of(said.high)
    covered = middle - box.half <= low and high <= middle + box.half
    need(covered, "its box does not cover the range of the parameter")


def check_orbit(orbit, said):
    """The only orbit in the box is a motion, and is stable or unstable."""
    enclose(orbit, said)
    orbit.motion(said.box)
    orbit.steady(said.box, said.stable)
    orbit.named(said.box)


def check_attractor(orbit, said):
    """Every motion with an impact in an ellipse about one of the orbit's tends to the orbit.

    The ellipse of impact k holds (theta, v) + M u, |u| <= 1, with M = [[a, b], [c, d]]. From each
    of its points the cam is met next within the next ellipse, and u is shorter there.
    """
    enclose(orbit, said)
    box, axes = said.box, said.axes
    whole = len(axes) == orbit.n and all(len(one) == 4 for one in axes)
    need(whole, "not every impact has an ellipse")
    size = [(length(a, b), length(c, d)) for a, b, c, d in axes]
    wide = SimpleNamespace(hull=list(box.hull), flights=box.flights)
    for k, (by_theta, by_v) in enumerate(size):
        wide.hull[2 * k] += around(0, by_theta)
        wide.hull[2 * k + 1] += around(0, by_v)
    orbit.motion(wide)
    orbit.named(box)
    flow = orbit.flow(box.hull[-1])
    for k, (a, b, c, d) in enumerate(axes):
        after = (k + 1) % orbit.n
        for side in (-1, 1):  # the gap is positive before the next ellipse, negative behind it
            end = box.hull[2 * after] + side * size[after][0]
            gap = orbit.flight(flow, box.hull, k, end)[0]
            by_theta, by_v = orbit.flight(flow, wide.hull, k, end)[3]
            spread = length(by_theta * a + by_v * c, by_theta * b + by_v * d)
            need(-side * gap > spread, f"flight {k + 1} may land outside the next ellipse")
        e, f, g, h = orbit.map(flow, wide.hull, k)
        step = arb_mat([[e, f], [g, h]]) * arb_mat([[a, b], [c, d]])
        a, b, c, d = axes[after]
        area = a * d - b * c
        need(area > 0 or area < 0, "an ellipse is flat")
        step = arb_mat([[d / area, -b / area], [-c / area, a / area]]) * step
        left = arb_mat([[1, 0], [0, 1]]) - step.transpose() * step
        shrinks = left[0, 0] > 0 and left.det() > 0
        need(shrinks, f"flight {k + 1} may not come nearer to the orbit")


def length(x, y):
    """That of a vector."""
    return (x * x + y * y).sqrt()


def lies(x, low, high):
    """Whether a ball lies between two fractions."""
    return arb_of(low) <= x and x <= arb_of(high)


def check_event(orbit, said):
    """The parameter of an event lies from low to high, and the event's function crosses zero."""
    box, event = said.box, said.event
    orbit.krawczyk(box)
    corner = orbit.corner_of(event)
    orbit.motion(box, corner)
    orbit.crosses(box, event)
    orbit.named(box)
    need(lies(box.hull[-1], said.low, said.high), "its parameter may lie elsewhere")
    if corner is None:
        need(
            event.impact == event.side == 0 and said.signs == [], "it has more than its kind needs"
        )
        if event.event != "multipliers-meet":
            trace, det = orbit.multipliers(box)
            other = trace if event.event == "fold" else -trace
            need(det < 1 and other > -(1 + det), "another multiplier may lie on the unit circle")
        return
    if orbit.kink(corner, event.side, box.hull[-1]):
        need(said.signs == [], "where the slope of the cam jumps a corner impact has no signs")
        return
    need(len(said.signs) == 2, "a corner impact has two signs")
    products = [1, 1]
    index = said.impacts[corner].stretch
    for side in (0, event.side):
        orbit.places[corner] = (index + side) % len(orbit.stretches)
        shift = 2 * arb.pi() * ((index + side) // len(orbit.stretches))
        z = list(box.hull)
        z[2 * corner] -= shift
        orbit.at_turn[corner] = said.impacts[corner].turn + (index + side) // len(orbit.stretches)
        trace, det = orbit.trace_det(z)
        products = [products[0] * (1 - trace + det), products[1] * (1 + trace + det)]
    for product, sign in zip(products, said.signs, strict=True):
        need(sign != 0 and product * sign > 0, "a sign of a corner impact is another, or open")


def check_branch(orbit, said):
    """A curve of orbits whose parameter takes every value between its two ends.

    Each box shares an orbit with the one before and the one after, a joint; the first and the last
    joint are the ends. At an end that is an event the function of the event has a slope in all of
    the box beside it, so that it has one sign between the event and the next joint.
    """
    boxes, joints, ends = said.boxes, said.joints, said.ends
    whole_branch = len(joints) == len(boxes) + 1 >= 2 and len(ends) == 2
    need(whole_branch, "a branch has one joint more than boxes, and two ends")
    for one in (*boxes, *joints):
        orbit.krawczyk(one)
    for k, box in enumerate(boxes):
        joins(box, joints[k])
        joins(box, joints[k + 1])
    orbit.named(joints[len(joints) // 2])
    for claim, joint in ((said.low, joints[0]), (said.high, joints[-1])):
        need(
            len(claim) == 2 and lies(joint.hull[-1], *claim),
            "an end of the branch may lie elsewhere",
        )
    need(said.low[1] <= said.high[0], "its range is empty")
    need(len(boxes) > 1 or None in ends, "one box can have one event only")
    beside = {0: (ends[0], 0, 1), len(boxes) - 1: (ends[1], -1, -2)} if len(boxes) > 1 else {}
    if len(boxes) == 1:
        beside = {0: (ends[0], 0, 1) if ends[0] else (ends[1], -1, -2)}
    for k, box in enumerate(boxes):
        event, at, after = beside.get(k, (None, 0, 0))
        corner = orbit.corner_of(event)
        orbit.motion(box, corner)
        orbit.counted(box)
        if event is None:
            orbit.steady(box, said.stable)
            continue
        orbit.crosses(joints[at], event)
        ((_, slope),) = orbit.along(box, orbit.test(event))
        inner = slope * (joints[after].hull[box.fixed] - joints[at].hull[box.fixed])
        if corner is not None:
            need(inner * event.side < 0, "the branch goes to the wrong side of a corner")
            orbit.steady(box, said.stable)
            continue
        need(event.impact == event.side == 0, "an event has more than its kind needs")
        trace, det = orbit.multipliers(box)
        other = trace if event.event == "fold" else -trace
        need(det < 1 and other > -(1 + det), "another multiplier may cross the unit circle")
        need(inner > 0 if said.stable else inner < 0, "the stability beside an event is another")


def tree(value, where):
    """Boxes cut in half again and again, as text: see `check_all`."""
    if not isinstance(value, str) or not TREE.fullmatch(value):
        raise NoCertificateError(f"{where}: expected the letters of a cover")
    return value


def known_orbit(value, where):
    """A statement on an orbit, within another statement."""
    if not isinstance(value, dict) or value.get("kind") != "orbit":
        raise NoCertificateError(f"{where}.kind: expected orbit")
    return statement(value, where)


def cover_of(value, where):
    """The cover of all orbits of so many impacts and turns; orbits: the known one of each `o`."""
    index = whole(0, 1000)
    return take(value, where, impacts=whole(1, 9), turns=whole(1, 9), boxes=tree,
                orbits=many(index))  # fmt: skip


def all_of(value, where):
    """The statement that some orbits are all, up to so many impacts and turns."""
    return take(value, where, kind=text, constants=constants, strobe=fraction,
                impacts=whole(1, 9), turns=whole(1, 9), orbits=many(known_orbit, 1000),
                covers=many(cover_of, 81))  # fmt: skip


def check_all(kind, stretches, said, cam):
    """The known orbits are all that there are with so few impacts in so few turns.

    A cover has a tree of boxes of phases for each sequence of stretches: a letter for each box,
    before those of its two halves. The figure k: it is cut in half along phase k; a point: it holds
    no orbit; o: it holds none but a known one, the next in the list.
    """
    fixed = said.constants
    need(kind != "pieces", "the pieces of a fitted cam do not meet exactly")
    need(None not in fixed.values(), "a constant is left open")
    possible = fixed["rpm"] > 0 and fixed["mass"] > 0 and 0 < fixed["restitution"] <= 1
    need(possible, "a constant is none of a machine")
    need(min(fixed["stiffness"], fixed["damping"]) >= 0, "a constant is negative")
    for k, one in enumerate(said.orbits):
        check_orbit(Orbit(kind, stretches, one, cam), one)
        same = {**fixed, "rpm": None} == one.constants and one.strobe == said.strobe
        same = same and one.parameter == "rpm"
        need(same, "an orbit is one of another machine")
        need(one.low <= fixed["rpm"] <= one.high, "an orbit is one of another speed")
        small = len(one.impacts) <= said.impacts and one.turns <= said.turns
        need(small, "an orbit is larger than those that are covered")
        need(not any(may_be_one(one, other) for other in said.orbits[:k]),
             "an orbit may stand there twice")  # fmt: skip
    sizes = [(n, m) for m in range(1, said.turns + 1) for n in range(1, said.impacts + 1)]
    need([(one.impacts, one.turns) for one in said.covers] == sizes, "a cover is missing")
    try:
        space = Cover(stretches, Flow(fixed, None, stretches, None))
        for one in said.covers:
            covered(space, one, said.orbits)
    finally:
        ctx.prec = BITS


def may_be_one(one, other):
    """Whether two statements may be about one orbit."""
    if len(one.impacts) != len(other.impacts) or one.turns != other.turns:
        return False
    here, there = one.box.hull[:-1], other.box.hull[:-1]
    turned = [there[2 * k :] + there[: 2 * k] for k in range(len(one.impacts))]
    return any(all(x.overlaps(y) for x, y in zip(here, z, strict=True)) for z in turned)


def covered(space, said, orbits):
    """Show that the boxes of a cover, which are all, hold no orbit but those known."""
    n, turns, count = said.impacts, said.turns, len(space.stretches)
    letters, known = iter(said.boxes), iter(said.orbits)
    for first in range(count):
        later = range(first, first + turns * count + 1)
        for rest in combinations_with_replacement(later, n - 1):
            boxes = [[(index, 0, 0) for index in (first, *rest)]]
            while boxes:
                box = boxes.pop()
                letter = next(letters, None)
                if letter is None:
                    raise RefusedError("boxes are missing in a cover")
                if letter == ".":
                    need(space.empty(box, turns), "a box of a cover may hold an orbit")
                elif letter == "o":
                    index = next(known, -1)
                    need(0 <= index < len(orbits), "a box names an orbit that is not there")
                    holds = any(space.alone(box, turns, x)
                                for x in ways(orbits[index], n, turns, count))  # fmt: skip
                    need(holds, "a box may hold another orbit than the one it names")
                else:
                    k = int(letter) - 1
                    need(k < n, "a box is cut along a phase that it has not")
                    index, depth, i = box[k]
                    need(depth < 60, "a box is too small")
                    boxes += [[*box[:k], (index, depth + 1, half), *box[k + 1 :]]
                              for half in (2 * i + 1, 2 * i)]  # fmt: skip
    need(next(letters, None) is None and next(known, None) is None, "a cover has too many boxes")


def ways(said, n, turns, count):
    """An orbit as one of n impacts in so many turns, from each of its impacts on.

    Each is a list of (stretch, counted on from turn to turn, phase within the turn, rad).
    """
    times = turns // said.turns
    if times * said.turns != turns or times * len(said.impacts) != n:
        return
    own = [(one.stretch, one.turn, theta)
           for one, theta in zip(said.impacts, said.box.hull[::2], strict=False)]  # fmt: skip
    for k in range(len(own)):
        begun = own[k][1]
        onward = [*own[k:], *((place, turn + said.turns, x) for place, turn, x in own[:k])]
        yield [(place + count * (turn - begun + again * said.turns), x)
               for again in range(times) for place, turn, x in onward]  # fmt: skip


# -- chaos: boxes of impacts, of which each is mapped over others


def check_chaos(cam, said):
    """Every sequence of boxes along the coverings is that of a motion's impacts.

    The box of an impact holds the (theta, v) of middle + M (x, y), |x|, |y| <= 1. It covers another
    one if all of its flights land at |y| < 1 there, those from x = -1 on one side of it, x < -1 or
    x > 1, and those from x = 1 on the other side.
    """
    boxes, sizes = said.boxes, {len(box.middle) + len(box.axes) for box in said.boxes}
    need(sizes == {6}, "a box has not two numbers and four of its axes")
    need(said.low <= said.high, "its range is empty")
    for k, one in enumerate(boxes):
        a, b, c, d = one.axes
        need(a * d - b * c > 0 or a * d - b * c < 0, f"box {k + 1} is flat")
    for j, one in enumerate(boxes):
        for k, other in enumerate(boxes[:j]):
            apart = one.stretch != other.stretch or beside(one, other) or beside(other, one)
            need(apart, f"boxes {k + 1} and {j + 1} may overlap")
    pairs = {tuple(pair) for pair in said.coverings}
    well = all(len(pair) == 2 and max(pair) < len(boxes) for pair in pairs)
    need(well and len(pairs) == len(said.coverings), "its coverings are no pairs of boxes")
    for k in range(len(boxes)):
        over = [j for i, j in sorted(pairs) if i == k]
        covers(cam, said, k, over)
    weights = said.weights
    need(len(weights) == len(boxes) and min(weights) >= 0 < max(weights), "it has not its weights")
    need(said.growth > 1, "the number of sequences does not grow")
    for k, weight in enumerate(weights):
        grown = sum(weights[j] for i, j in pairs if i == k)
        need(grown >= said.growth * weight, "the number of sequences may grow more slowly")


def beside(one, other):
    """Whether a box lies on one side of another one, along one of its axes."""
    places = within(one, other.middle)
    reach = to_axes(one) * axes_of(other)
    return any(abs(places[k, 0]) > 1 + abs(reach[k, 0]) + abs(reach[k, 1]) for k in (0, 1))


def axes_of(box):
    """The matrix M of a box."""
    a, b, c, d = box.axes
    return arb_mat([[a, b], [c, d]])


def to_axes(box):
    """The inverse of M."""
    a, b, c, d = box.axes
    area = a * d - b * c
    return arb_mat([[d / area, -b / area], [-c / area, a / area]])


def within(box, point):
    """(x, y) of a point (theta, v) about a box."""
    return to_axes(box) * arb_mat([[point[k] - box.middle[k]] for k in (0, 1)])


def covers(cam, said, k, over):
    """Show that box k covers those whose numbers are in `over`, by its cells.

    With the matrix D of the slopes of the impact map on a cell, a point of it lands at the image of
    the cell's middle + D times its distance from there.
    """
    one, lands = said.boxes[k], said.boxes[k].lands
    need(all(said.boxes[j].stretch == lands.stretch for j in over), "a flight lands on another box")
    places = [SimpleNamespace(stretch=one.stretch, turn=0), lands]
    trip = SimpleNamespace(**vars(said), impacts=places, turns=lands.turn + 1)
    orbit = Orbit(cam[0], cam[1], trip)
    sides: dict[int, set[bool]] = {j: set() for j in over}
    p = arb_of(said.low).union(arb_of(said.high))
    for edges, image, slopes, off in cells(orbit, one, p):
        for j in over:
            at = within(said.boxes[j], image)
            turned = to_axes(said.boxes[j]) * slopes
            y = at[1, 0] + turned[1, 0] * off[0] + turned[1, 1] * off[1]
            need(abs(y) < 1, f"box {k + 1} may be mapped beside box {j + 1}")
            for edge in edges:
                x = at[0, 0] + turned[0, 0] * edge + turned[0, 1] * off[1]
                need(x < -1 or x > 1, f"an end of box {k + 1} may be mapped into box {j + 1}")
                sides[j].add((x > 0) == (edge > 0))
    for j in over:
        need(len(sides[j]) == 1, f"box {k + 1} is not mapped across box {j + 1}")


def cells(orbit, one, p):
    """The cells of a box: (edges, image, slopes, distances), each with its flights checked.

    edges: x of the ends of the box, from the cell's middle, where it is at an end; image: of that
    middle; slopes: by (x, y), of the landings of all of the cell; distances: what (x, y) may be.
    """
    flow, axes = orbit.flow(p), axes_of(one)
    need(len(one.cells) == 2, "a box is divided along both of its axes")
    across, along = one.cells
    need(len(one.flights) == across * along, "not every cell of a box has its flights")
    off = [around(0, 1 / arb(across)), around(0, 1 / arb(along))]
    spread = axes * arb_mat([[x] for x in off])
    for number, flight in enumerate(one.flights):
        i, j = divmod(number, along)
        at = axes * arb_mat([[arb(2 * i + 1) / across - 1], [arb(2 * j + 1) / along - 1]])
        middle = [one.middle[n] + at[n, 0] for n in (0, 1)]
        there = flight.low.union(flight.high)
        wide = [middle[0] + spread[0, 0], middle[1] + spread[1, 0], there, arb(1), p]
        for phase, index in zip((wide[0], there), orbit.places, strict=True):
            stretch = orbit.stretches[index]
            inside = stretch.start < phase and phase < stretch.end
            need(inside, "a flight may begin or land outside its stretch of the cam")
        need(wide[1] > 0, "an impact may not bounce")
        orbit.clear(SimpleNamespace(hull=wide, flights=[flight]), 0)
        for end, side in ((flight.low, 1), (flight.high, -1)):
            gap = orbit.flight(flow, middle, 0, end)[0]
            by_theta, by_v = orbit.flight(flow, wide, 0, end)[3]
            gap += by_theta * spread[0, 0] + by_v * spread[1, 0]
            need(side * gap > 0, "a flight may not land between the phases that are given")
        lands = there.mid()
        for _ in range(10):  # towards the landing of the middle
            gap, rate = orbit.flight(flow, middle, 0, lands)[:2]
            lands = (lands - gap / rate).mid()
        need(there.contains(lands), "no landing was found")
        gap = orbit.flight(flow, middle, 0, lands)[0]
        lands = lands - gap / orbit.flight(flow, middle, 0, there)[1]
        speed = -(flow.r * orbit.flight(flow, middle, 0, lands)[1])
        by_theta, by_v, _, _ = orbit.map(flow, wide, 0)
        wide[2] = lands + by_theta * spread[0, 0] + by_v * spread[1, 0]
        e, f, g, h = orbit.map(flow, wide, 0)
        ends = [end for end, at_end in ((-1, i == 0), (1, i == across - 1)) if at_end]
        edges = [arb(end) / across for end in ends]
        yield edges, (lands, speed), arb_mat([[e, f], [g, h]]) * axes, off


# -- loss of contact: where the force ends, and where the impacts after it land


def check_detachment(cam, said):
    """A follower that rests on the cam stays there at all speeds up to `low`, and not at `high`.

    The force N = k c + m g + F0 + omega b c' + omega^2 m c'' is above zero all over the cam.
    """
    stretches, known = resting(cam, said)
    need(0 < said.low < said.high, "its range is empty")
    need(len(said.cuts) == len(stretches), "not every stretch has its cuts")
    low, high = (arb_of(x) * arb.pi() / 30 for x in (said.low, said.high))

    def force(omega, c):
        """The force, N, by the lift and its derivatives."""
        k, b, m = known["stiffness"], known["damping"], known["mass"]
        level = m * known["gravity"] + known["preload"]
        return k * c[0] + level + omega * (b * c[1] + omega * m * c[2])

    for one, cuts in zip(stretches, said.cuts, strict=True):
        for a, b in pairwise([one.start, *cuts, one.end]):
            need(a < b, "the cuts of a stretch do not follow one another")
            phase = a.union(b)
            c = one.derivatives(phase, 3)
            rising = force(low, c[1:]) - known["mass"] * known["gravity"] - known["preload"]
            begin, end = (force(low, one.derivatives(x, 2)) for x in (a, b))
            holds = (begin > 0 and rising > 0) or (end > 0 and rising < 0)
            holds = holds or begin + (phase - a) * rising > 0
            need(holds, "the force may end at a lower speed")
            # Between standstill and `low` it is least at one of both, or else above zero.
            least = known["damping"] == 0 or c[2] < 0 or force(arb(0).union(low), c) > 0
            need(least and force(arb(0), c) > 0, "the force may end at a lower speed")
    need(said.stretch < len(stretches), "the cam has no such stretch")
    there = stretches[said.stretch]
    phase = there.end if said.at_end else there.start
    need(force(high, there.derivatives(phase, 2)) < 0, "the force may not end")


def resting(cam, said):
    """(stretches, constants as balls) of a machine whose follower can rest all over the cam."""
    kind, stretches = cam
    need(kind != "pieces", "the pieces of a fitted cam do not meet exactly")
    smooth(stretches)
    fixed = said.constants
    need([key for key, x in fixed.items() if x is None] == ["rpm"], "the speed has to be left open")
    possible = fixed["mass"] > 0 and min(fixed["stiffness"], fixed["damping"]) >= 0
    need(possible and 0 < fixed["restitution"] <= 1, "a constant is none of a machine")
    return stretches, {key: None if x is None else arb_of(x) for key, x in fixed.items()}


def smooth(stretches):
    """Show that the slope of the cam does not jump."""
    for k, there in enumerate(stretches):
        here = stretches[k - 1]
        one, other = here.derivatives(here.end, 1)[1], there.derivatives(there.start, 1)[1]
        same = one.overlaps(other) and abs(one - other) < arb(2) ** (64 - BITS)
        need(same, "the slope of the cam jumps")


def check_corner_hit(cam, said):
    """Which impact after lift-off lands on a corner at one speed between `low` and `high`.

    A follower that rests on the cam leaves it at the start of the stretch `start`. The flight after
    its last impact in `impacts` is followed to the end of the stretch `corner`, where the gap has
    one sign at `low`, the other at `high`, and a slope by the speed between them.
    """
    stretches, _ = resting(cam, said)
    need(0 < said.low < said.high, "its range is empty")
    need(len(said.flights) == len(said.impacts) + 1, "not every impact has its flight")
    count = len(stretches)
    need(max(said.start, said.corner.stretch) < count, "the cam has no such stretch")
    start = SimpleNamespace(stretch=said.start, turn=0)
    places = [start, *said.impacts, said.corner]
    turns = 1 + max(one.turn for one in places)
    trip = SimpleNamespace(constants=said.constants, parameter="rpm", impacts=places, turns=turns)
    orbit = Orbit(cam[0], cam[1], trip)
    low, high = arb_of(said.low), arb_of(said.high)
    theta = stretches[said.start].start
    flow = orbit.flow(low.union(high))
    for one, at, sign in (
        (stretches[said.start - 1], stretches[said.start - 1].end, -1),
        (stretches[said.start], theta, 1),
    ):
        c, c1, c2 = one.derivatives(at, 2)
        need(sign * (flow.acceleration(c, c1) - c2) > 0, "the follower may not leave there")
    _, _, gaps = flown(orbit, said, low)
    _, _, later = flown(orbit, said, high)
    hull, spans, between = flown(orbit, said, low.union(high))
    for k in range(orbit.n - 1):
        at = list(hull)
        at[2 * k + 2] = spans[k]
        if k > 0:
            place = stretches[places[k].stretch]
            inside = place.start < spans[k - 1] and spans[k - 1] < place.end
            need(inside, f"impact {k} may lie outside its stretch of the cam")
            need(hull[2 * k + 1] > 0, f"impact {k} may not bounce")
        box = SimpleNamespace(hull=[*at, low.union(high)], flights=said.flights)
        orbit.clear(box, k, lifts=k == 0)
    one, other = plain(gaps), plain(later)
    need((one > 0 and other < 0) or (one < 0 and other > 0), "the corner may not be met")
    slope = between.slopes[0]
    need(slope > 0 or slope < 0, "the corner may be met at several speeds")


def flown(orbit, said, speed):
    """Unknowns of all impacts from lift-off on, the last phase of each flight, the last gap.

    At all speeds of a ball; the gap, at the corner, has its derivative by the speed.
    """
    flow = orbit.flow(Jet(speed, [arb(1)]))
    none = [arb(0)]
    z = [Jet(orbit.stretches[said.start].start, none), Jet(arb(0), none)]
    spans = []
    for k, one in enumerate(said.impacts):
        spans.append(one.low.union(one.high))
        for end, sign in ((one.low, 1), (one.high, -1)):
            gap = plain(orbit.flight(flow, z, k, end)[0])
            need(sign * gap > 0, f"impact {k + 1} may lie elsewhere")
        rate = plain(orbit.flight(flow, z, k, spans[-1])[1])
        lands = spans[-1].mid()
        for _ in range(10):  # towards the landing of the middle
            gap = plain(orbit.flight(flow, z, k, lands)[0])
            lands = (lands - gap / rate).mid()
        gap = plain(orbit.flight(flow, z, k, lands)[0])
        phase = lands - gap / rate  # Newton's interval
        need(spans[-1].contains(phase), f"impact {k + 1} may lie elsewhere")
        gap, rate = orbit.flight(flow, z, k, phase)[:2]
        theta = Jet(phase, [-(gap.slopes[0] / plain(rate))])
        z += [theta, -(flow.r * orbit.flight(flow, z, k, theta)[1])]
    corner = orbit.stretches[said.corner.stretch].end
    gap = orbit.flight(flow, z, orbit.n - 2, corner)[0]
    return [plain(x) for x in z] + [corner, arb(0)], [*spans, corner], gap


CHECKS = {
    "orbit": check_orbit,
    "attractor": check_attractor,
    "event": check_event,
    "branch": check_branch,
}
OF_THE_CAM = {
    "chaos": check_chaos,
    "first-detachment": check_detachment,
    "corner-hit": check_corner_hit,
}


def title(said, stretches):
    """What a statement says, in words; stretches: those of the cam."""
    if said.kind == "all-orbits":
        names = [f"{x.label}, {'stable' if x.stable else 'unstable'}" for x in said.orbits]
        rpm = "open" if said.constants["rpm"] is None else in_full(said.constants["rpm"])
        size = f"{up_to(said.impacts, 'impact')} in {up_to(said.turns, 'turn')}"
        return (f"at rpm = {rpm} the orbits without rest that have {size} are {len(names)}: "
                f"{'; '.join(names) or 'none'}")  # fmt: skip
    if said.kind in ("first-detachment", "corner-hit"):
        low, high = shown(said.low, ROUND_FLOOR), shown(said.high, ROUND_CEILING)
        if said.kind == "first-detachment":
            return (f"a follower that rests on the cam stays there at every rpm up to {low}, "
                    f"and leaves it at {high}")  # fmt: skip
        leaves = corner_name(stretches, said.start, "start")
        lands = corner_name(stretches, said.corner.stretch, "end")
        impact = len(said.impacts) + 1
        return (f"a follower that rests on the cam leaves it at {leaves}, and its impact {impact} "
                f"is at {lands}, for exactly one rpm from {low} to {high}")  # fmt: skip
    name = said.parameter
    state = "stable" if getattr(said, "stable", False) else "unstable"
    if said.kind == "event":
        event = said.event.event
        low, high = shown(said.low, ROUND_FLOOR), shown(said.high, ROUND_CEILING)
        return f"{event} of {said.label}, {name} from {low} to {high}"
    if said.kind == "orbit":
        return f"{said.label}, {state}, for every {name} {span(said)}: exactly one in its box"
    if said.kind == "chaos":
        turns = max([1, *(box.lands.turn for box in said.boxes)])
        return (f"chaos for every {name} {span(said)}: "
                f"{len(said.boxes)} boxes of impacts with {len(said.coverings)} coverings, so "
                "infinitely many periodic orbits and an entropy of the impact map of at least "
                f"log({shown(said.growth, ROUND_FLOOR)}); from one impact to the next at most "
                f"{turns} {'turn passes' if turns == 1 else 'turns pass'}")  # fmt: skip
    if said.kind == "attractor":
        size = ""
        if said.axes and len(said.axes[0]) == 4:
            a, b, c, d = said.axes[0]
            sides = [at_least(length(a, b) * 180 / arb.pi()), at_least(length(c, d))]
            size = f", {sides[0]} deg and {sides[1]} m/rad to either side,"
        return (f"every motion with an impact in an ellipse about impact 1 of {said.label}{size} "
                f"tends to it, for every {name} {span(said)}")  # fmt: skip
    ends = [shown(x, ROUND_CEILING) for x in said.low[-1:]]
    ends += [shown(x, ROUND_FLOOR) for x in said.high[:1]]
    return f"{said.label} exists and is {state} for all {name} between {' and '.join(ends)}"


def corner_name(stretches, index, end):
    """The `start` or the `end` of a stretch by its angle, deg, and its number in the file."""
    named = f"the {end} of stretch {index}"
    if index >= len(stretches):
        return named
    angle = plain(getattr(stretches[index], end)) * 180 / arb.pi()
    return f"{float(angle.mid()):.{DIGITS_OF_ANGLE}g} deg ({named})"


def at_least(x):
    """A number to few digits that is no larger than any in a ball."""
    mantissa, exponent = x.lower().man_exp()
    exact = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return shown(exact, ROUND_FLOOR, DIGITS_OF_SIZE)


def up_to(most, what):
    """So many of something, from one on, in words."""
    return f"1 {what}" if most == 1 else f"1 to {most} {what}s"


def shown(x, way, digits=SHOWN):
    """A fraction to so many digits, rounded down or up, so that no more is said than was shown."""
    return str(
        Context(prec=digits, rounding=way).divide(Decimal(x.numerator), Decimal(x.denominator))
    )


def in_full(x):
    """A fraction whose decimals end, with all of them."""
    return str(Context(prec=3000).divide(Decimal(x.numerator), Decimal(x.denominator)))


def span(said):
    """From where to where a statement holds: rounded inwards, or in full where that leaves none."""
    low, high = shown(said.low, ROUND_CEILING), shown(said.high, ROUND_FLOOR)
    if Decimal(low) > Decimal(high):
        low, high = in_full(said.low), in_full(said.high)
    return f"from {low} to {high}"


def checked(path):
    """Read a certificate, check statement by statement and say so; the exit code."""
    with open(path, "rb") as file:
        data = file.read(LARGEST_FILE + 1)
    if len(data) > LARGEST_FILE:
        raise NoCertificateError("the file is too large")
    value = json.loads(
        data.decode("utf-8"), object_pairs_hook=without_doubles, parse_constant=no_number
    )
    found = take(
        value,
        "the file",
        format=choice("camcli-proof-1"),
        cam=nothing_or(read_cam),
        statements=many(statement),
        uncovered=many(text),
    )
    if not found.statements or found.cam is None:
        raise NoCertificateError("it holds no statement")
    refused = 0
    kind, stretches = found.cam
    for said in found.statements:
        try:
            if said.kind == "all-orbits":
                check_all(kind, stretches, said, value["cam"])
            elif said.kind in OF_THE_CAM:
                OF_THE_CAM[said.kind](found.cam, said)
            else:
                CHECKS[said.kind](Orbit(kind, stretches, said, value["cam"]), said)
        except (RefusedError, NoCertificateError) as failed:
            refused += 1
            print(f"not confirmed: {title(said, stretches)}: {failed}")
        else:
            print(f"confirmed: {title(said, stretches)}")
    print(f"{len(found.statements) - refused} of {len(found.statements)} statements are confirmed")
    for name in found.uncovered:
        print(f"without a certificate: {name}")
    return 1 if refused else 0


def without_doubles(pairs):
    """The entries of an object; refuse a key that stands there twice."""
    if len({key for key, _ in pairs}) < len(pairs):
        raise NoCertificateError("a key stands twice in an object")
    return dict(pairs)


def no_number(name):
    """Refuse NaN and the infinities."""
    raise NoCertificateError(f"found {name}")


def main(arguments):
    """The command: one file; prints one line for each statement and returns the exit code."""
    if len(arguments) != 1 or arguments[0].startswith("-"):
        print(__doc__)
        return 0 if arguments in (["-h"], ["--help"]) else 2
    ctx.prec = BITS
    try:
        return checked(arguments[0])
    except NoCertificateError as error:
        fault = str(error)
    except OSError as error:
        fault = (
            f"cannot be read ({error.strerror}); `cam orbits --prove` writes out/orbits/proof.json"
        )
    except (ValueError, ArithmeticError, RecursionError, MemoryError) as error:
        fault = f"{type(error).__name__}: {error}"[:300]
    print(f"{arguments[0]}: no certificate: {fault}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
