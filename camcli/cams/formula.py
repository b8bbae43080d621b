"""A cam as a certificate has it: its numbers, and the formulas of its stretches.

A stretch ends at the angle `end`, where the next one begins, and with x = theta - center it is
sum a_j x^j + A cos k x + B sin k x + kappa cos x + sqrt(rho^2 - kappa^2 sin^2 x), with a_j in
`polynomial`, (A, B, k) in `wave` and (kappa, rho) in `circle`. All of these are formulas, as text,
of the numbers of the cam, of pi and of formulas before them; so a checker needs to know no cam.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from flint import arb

from camcli.cams.balls import precision
from camcli.cams.compile import DIGITS, Part, Shape
from camcli.cams.decimals import exact, exactly
from camcli.cams.lash import LashedCam
from camcli.cams.law import POLYNOMIALS, SCCA, TURN, LawCam, SccaLaw, written

DIGITS_OF_EDGES = 80  # of the angles at which a cam passes its seat
ERROR_OF_EDGES = "1e-66"  # rad, more than their rounding
SAME_EDGE = 1e-30  # rad: so near to an end of a part of the cam they are that end
ARCS = {
    "rho1": "base_radius + flank_center",  # of the flank circle
    "x2": "((rho1 - nose_radius)*(rho1 - nose_radius) - flank_center*flank_center"
    " - nose_center*nose_center)/(2*flank_center)",  # of the nose circle's centre
    "y2": "sqrt(nose_center*nose_center - x2*x2)",
    "scale": "rho1/(rho1 - nose_radius)",  # the circles touch on the line through their centres
    "top": "pi - pi*top_dwell_deg/360",
    "b": "top - atan2(y2, x2)",
    "c": "b + atan2(y2*scale, (x2 + flank_center)*scale - flank_center)",
    "low": "base_radius - offset",
    "high": "nose_center + nose_radius - offset",
}
OSCILLATOR = {
    "spring": "stiffness - mass*frequency*frequency",
    "damper": "damping*frequency",
    "share": "amplitude/(spring*spring + damper*damper)",
}


def formula_of(shape: Any, seat_restitution: float | None = None) -> dict[str, Any] | None:
    """The formulas of a cam, or the polynomials of one that was fitted.

    None for one that was fitted and has lash: its polynomials are cut, and rounded anew, where they
    pass the seat. seat_restitution: that of the seat, None where it is that of the cam.
    """
    if getattr(shape, "lash", None) is None:
        return _as_drawn(shape)
    drawn = _as_drawn(shape.as_drawn())
    return None if drawn["kind"] == "pieces" else _seated(shape, drawn, seat_restitution)


def _seated(
    shape: LashedCam, drawn: dict[str, Any], seat_restitution: float | None
) -> dict[str, Any] | None:
    """The formulas of a cam with lash, from those of the cam as it is drawn.

    Its stretches are of two kinds: the lobe is the drawn cam less the lash, the seat is at the
    height of the base circle. The angle at which the cam passes its seat has no formula: it becomes
    one of the cam's numbers, with a bound of its error. seat_restitution: None where it is that of
    the cam. Returns None where the lobe has other stretches than there are formulas.
    """
    with precision(DIGITS_OF_EDGES):
        lobe = [part for part in shape.lobe() if part.end > part.start]
        if len(lobe) != len(drawn["stretches"]):
            return None
        formulas = list(zip(lobe, drawn["stretches"], strict=True))
        numbers = {**drawn["numbers"], "lash": exact(shape.lash or 0.0)}
        base_circle = "low" if drawn["kind"] == "arcs" else "base"
        stretches = []
        for part in shape.parts():
            end = _end_of(part, formulas)
            if end is None:
                end = f"edge{len(numbers)}"
                middle = part.end.mid().str(DIGITS_OF_EDGES - 10, radius=False)
                numbers[end] = f"{middle} +/- {ERROR_OF_EDGES}"
            if part.seat:
                stretches.append({**_stretch(end, [base_circle]), "seat": True})
                continue
            formula = _formula_around(part, formulas)
            level, *slopes = formula["polynomial"]
            lowered = [f"{level} - lash", *slopes]
            stretches.append({**formula, "end": end, "polynomial": lowered})
    restitution = None if seat_restitution is None else exact(seat_restitution)
    return {
        **drawn,
        "numbers": numbers,
        "stretches": stretches,
        "seat_restitution": restitution,
    }


def _end_of(part: Part, formulas: Sequence[tuple[Part, dict[str, Any]]]) -> str | None:
    """The formula of the angle at which a part ends; None where it is not an end of the lobe's."""
    for drawn, formula in formulas:
        if abs(drawn.end - part.end) < SAME_EDGE:
            return formula["end"]
    return None


def _formula_around(part: Part, formulas: Sequence[tuple[Part, dict[str, Any]]]) -> dict[str, Any]:
    """The formula of the part of the lobe in which the middle of a part lies."""
    middle = (part.start + part.end) / 2
    return next(formula for drawn, formula in formulas if drawn.end > middle)


def _as_drawn(shape: Any) -> dict[str, Any]:
    """The formulas of a cam without lash."""
    kind = getattr(shape, "kind", "")
    if kind == "arcs":
        return _arcs(shape)
    if kind == "eccentric":
        whole_turn = _stretch("2*pi", ["base + lift/2"], wave=("-lift/2", "0", "1"))
        return _cam(kind, _numbers(shape, ("base", "lift")), {}, [whole_turn])
    if kind == "oscillator":
        names = ("mass", "stiffness", "amplitude", "frequency", "clearance")
        numbers = {"damping": exact(shape.follower_damping), **_numbers(shape, names)}
        whole_turn = _stretch("2*pi", ["-clearance"], wave=("share*spring", "share*damper", "1"))
        return _cam(kind, numbers, OSCILLATOR, [whole_turn])
    return _law(shape) if isinstance(shape, LawCam) else _pieces(shape)


def _cam(
    kind: str, numbers: dict[str, str], formulas: dict[str, str], stretches: list[dict[str, Any]]
) -> dict[str, Any]:
    """A cam as a certificate has it; numbers and formulas by name, each as text."""
    return {
        "kind": kind,
        "numbers": numbers,
        "formulas": [{"name": name, "formula": formula} for name, formula in formulas.items()],
        "stretches": stretches,
        "seat_restitution": None,
    }


def _stretch(
    end: str,
    polynomial: Sequence[str],
    center: str = "0",
    wave: Sequence[str] = (),
    circle: Sequence[str] = (),
) -> dict[str, Any]:
    """A stretch by its formulas, as a certificate has it (see the module)."""
    return {
        "end": end,
        "center": center,
        "polynomial": list(polynomial),
        "wave": list(wave),
        "circle": list(circle),
        "seat": False,
    }


def _numbers(shape: Any, names: Sequence[str]) -> dict[str, str]:
    """A cam's numbers by name."""
    return {name: exact(getattr(shape, name)) for name in names}


def _arcs(shape: Any) -> dict[str, Any]:
    """Base circle, flank, nose, top dwell, and back: the circles are tangent to one another.

    `b`, `c` and `top` among the formulas ARCS are the angles at which the flank, the nose and the
    top dwell begin; the lobe is symmetric about half a turn.
    """
    names = ("base_radius", "flank_center", "nose_center", "nose_radius", "top_dwell_deg", "offset")
    flank = ("-flank_center", "rho1")
    nose = ("nose_center", "nose_radius")
    stretches = [
        _stretch("b", ["low"]),
        _stretch("c", ["-offset"], "b", circle=flank),
        _stretch("top", ["-offset"], "top", circle=nose),
        _stretch("2*pi - top", ["high"]),
        _stretch("2*pi - c", ["-offset"], "2*pi - top", circle=nose),
        _stretch("2*pi - b", ["-offset"], "2*pi - b", circle=flank),
        _stretch("2*pi", ["low"]),
    ]
    return _cam("arcs", _numbers(shape, names), ARCS, stretches)


class Zone(NamedTuple):
    """A part of a law s(x), in shares of the motion's length, or of a cam's turn, in deg.

    start, end, center are shares from 0 to 1, or deg. polynomial and wave are those of a stretch
    (see the module), about the center.
    """

    start: Fraction
    end: Fraction
    center: Fraction
    polynomial: Sequence[str]
    wave: Sequence[str] = ()

    def moved(self, angle: int) -> Zone:
        """The same zone of a turn, so many degrees later."""
        return self._replace(
            start=self.start + angle, end=self.end + angle, center=self.center + angle
        )


def _law(shape: LawCam) -> dict[str, Any]:
    """A cam of rise, top dwell, fall and base dwell; what goes beyond the turn begins the turn."""
    rise_start = written(shape.rise.start_deg) % TURN
    rise_end = rise_start + written(shape.rise.length_deg)
    fall_start = rise_end + written(shape.top_dwell_deg)
    next_rise = rise_start + TURN
    fall_end = min(fall_start + written(shape.fall.length_deg), next_rise)
    formulas: dict[str, str] = {}
    zones = [
        *_motion("rise", shape.rise.law, rise_start, rise_end, "base", "lift", formulas),
        Zone(rise_end, fall_start, rise_end, ["base + lift"]),
        *_motion("fall", shape.fall.law, fall_start, fall_end, "base + lift", "-lift", formulas),
        Zone(fall_end, next_rise, fall_end, ["base"]),
    ]
    both_turns = [*(zone.moved(-TURN) for zone in zones), *zones]
    within = [
        zone for zone in both_turns if zone.start < TURN and zone.end > 0 and zone.start < zone.end
    ]
    stretches = [
        _stretch(_rad(min(zone.end, Fraction(TURN))), zone.polynomial, _rad(zone.center), zone.wave)
        for zone in sorted(within, key=lambda zone: zone.start)
    ]
    return _cam("law", _numbers(shape, ("base", "lift")), formulas, stretches)


def _motion(
    name: str,
    law: str | SccaLaw,
    start: Fraction,
    end: Fraction,
    low: str,
    step: str,
    formulas: dict[str, str],
) -> list[Zone]:
    """The zones of c = low + step s((theta - start)/length) from start to end, deg.

    low, step: formulas of the height where the motion begins, and of how far it goes. Its length in
    rad is put among the formulas, by `name`, and so is what its law needs.
    """
    length = end - start
    formulas[name] = _rad(length)
    return [
        _on_turn(zone, name, start, length, low, step) for zone in _law_zones(name, law, formulas)
    ]


def _law_zones(name: str, law: str | SccaLaw, formulas: dict[str, str]) -> list[Zone]:
    """The zones of a law s(x), 0 <= x <= 1; an SCCA law puts its formulas among those given."""
    if isinstance(law, SccaLaw):
        b = written(law.scca.b)
        return _scca(name, b, min(written(law.scca.d), 1 - b), formulas)
    if law in SCCA:
        b, d = map(Fraction, SCCA[law])
        return _scca(name, b, d, formulas)
    factors = POLYNOMIALS[law]
    polynomial = [str(factors.get(power, 0)) for power in range(max(factors) + 1)]
    return [Zone(Fraction(0), Fraction(1), Fraction(0), polynomial)]


def _on_turn(
    zone: Zone, length_name: str, start: Fraction, length: Fraction, low: str, step: str
) -> Zone:
    """A zone of s(x) as a zone of c = low + step s(x), x = (theta - start)/length, deg.

    length_name: the formula of the length in rad; a coefficient of x^j is divided by its j-th
    power, and the wave's k by it.
    """
    polynomial = []
    for power, factor in enumerate(zone.polynomial):
        if power == 0:
            polynomial.append(f"{low} + ({step})*({factor})")
        else:
            divisor = "*".join([length_name] * power)
            polynomial.append(f"({step})*({factor})/({divisor})")
    wave: list[str] = []
    if zone.wave:
        cosine, sine, k = zone.wave
        wave = [f"({step})*({cosine})", f"({step})*({sine})", f"({k})/{length_name}"]
    return Zone(
        start + length * zone.start,
        start + length * zone.end,
        start + length * zone.center,
        polynomial,
        wave,
    )


def _scca(name: str, b: Fraction, d: Fraction, formulas: dict[str, str]) -> list[Zone]:
    """The zones of the law of the SCCA family with a sine of width b and a cosine of width d.

    The acceleration is a sine over b/2, constant, a cosine over d, and so back: up to a factor
    sin(pi x/b), 1, and cos(pi y/d) with y = x - (1 - d)/2. Integrated twice from rest these are

        zone 1   (b/pi) x - (b/pi)^2 sin(pi x/b)
        zone 2   height + (b/pi) z + z^2/2,                              z = x - b/2
        zone 3   turn + (d/pi)^2 + turning y - (d/pi)^2 cos(pi y/d)

    and their mirror images. All are divided by `most`, twice what they reach at x = 1/2. Put among
    the formulas, each with the name of the motion before it: `sine` = b/pi, `cosine` = d/pi,
    `height` where zone 2 begins, `turn` and `turning`, height and rate where it ends, and `most`.
    """
    zero = Fraction(0)
    half = Fraction(1, 2)
    if b == d == half:  # one sine throughout
        return [Zone(zero, Fraction(1), zero, ["0", "1"], ["0", "-1/(2*pi)", "2*pi"])]
    sine = f"{name}_sine"
    cosine = f"{name}_cosine"
    height = f"{name}_height"
    turn = f"{name}_turn"
    turning = f"{name}_turning"
    most = f"{name}_most"
    constant = _over((1 - b - d) / 2)
    formulas[sine] = f"{_over(b)}/pi"
    formulas[cosine] = f"{_over(d)}/pi"
    formulas[height] = f"{sine}*{_over(b)}/2 - {sine}*{sine}"
    formulas[turn] = f"{height} + {sine}*{constant} + {constant}*{constant}/2"
    formulas[turning] = f"{sine} + {constant}"
    formulas[most] = f"2*({turn} + {cosine}*{cosine} + {turning}*{_over(d)}/2)"
    first = Zone(
        start=zero,
        end=b / 2,
        center=zero,
        polynomial=["0", f"{sine}/{most}"],
        wave=["0", f"-{sine}*{sine}/{most}", f"1/{sine}"],
    )
    second = Zone(
        start=b / 2,
        end=(1 - d) / 2,
        center=b / 2,
        polynomial=[f"{height}/{most}", f"{sine}/{most}", f"1/(2*{most})"],
    )
    third = Zone(
        start=(1 - d) / 2,
        end=(1 + d) / 2,
        center=(1 - d) / 2,
        polynomial=[f"({turn} + {cosine}*{cosine})/{most}", f"{turning}/{most}"],
        wave=[f"-{cosine}*{cosine}/{most}", "0", f"1/{cosine}"],
    )
    zones = [first, second, third, _mirrored(second), _mirrored(first)]
    return [zone for zone in zones if zone.start < zone.end]


def _mirrored(zone: Zone) -> Zone:
    """The zone of 1 - s(1 - x).

    The distance from the center changes its sign, and with it the odd powers and the sine; the
    minus before s changes all of them. So the factors of odd powers and of the sine stay, those of
    even powers and of the cosine change their sign.
    """
    level = f"1 - ({zone.polynomial[0]})"
    slopes = [
        f"-({factor})" if power % 2 == 0 else factor
        for power, factor in enumerate(zone.polynomial[1:], 1)
    ]
    wave: list[str] = []
    if zone.wave:
        cosine, sine, k = zone.wave
        wave = [f"-({cosine})", sine, k]
    return Zone(1 - zone.end, 1 - zone.start, 1 - zone.center, [level, *slopes], wave)


def _over(x: Fraction) -> str:
    """A fraction as a formula: (3/4)."""
    return f"({x.numerator}/{x.denominator})"


def _rad(degrees: Fraction) -> str:
    """An angle as a formula, rad."""
    return f"pi*{_over(degrees / 180)}"


def _pieces(shape: Shape) -> dict[str, Any]:
    """The polynomials of a fitted cam, each an equal share of the turn, and its dwells.

    An angle is written as 2 pi k/count, where `count` equal pieces make up the turn. Raises
    ValueError where a part is given by a function alone.
    """
    with precision(DIGITS):
        parts = shape.parts()
    if any(part.lift is not None and not part.pieces for part in parts):
        raise ValueError("a cam without a formula that a certificate knows")
    turn = 2 * arb.pi()
    count = max(
        round(float(turn * max(1, len(part.pieces)) / (part.end - part.start))) for part in parts
    )
    stretches = []
    for part in parts:
        if not part.pieces:
            last = round(float(part.end / turn * count))
            stretches.append(_stretch(f"2*pi*{last}/{count}", [exactly(arb(part.level))]))
        first = round(float(part.start / turn * count))
        for i, piece in enumerate(part.pieces):
            factors = [exact(x) for x in piece.coefficients]
            while len(factors) > 1 and factors[-1] == "0":
                factors.pop()
            end = f"2*pi*{first + i + 1}/{count}"
            stretches.append(_stretch(end, factors, exact(piece.center)))
    return _cam("pieces", {}, {}, stretches)
