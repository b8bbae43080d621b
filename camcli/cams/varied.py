"""A cam with one of its numbers replaced by a ball or a series: a family of cams in exact numbers.

The number at a key of the scene, like cam.nose_radius or cam.rise.length_deg, becomes any value p.
The parts of the cam then are balls, or series in which every edge and every lift has its derivative
by p. Angles of a law that do not vary stay the decimal numbers that were written. A flank circle
stays closed: its radius is base_radius + flank_center, so that a flank_radius of p means a
flank_center of p - base_radius. The widths b, c and d of a law add up to 1: another one goes along.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from flint import arb

from camcli.cams.balls import number
from camcli.cams.compile import Part, Piece, Shape


def can_vary(shape: Any, key: str) -> bool:
    """Whether `with_number` knows the cam at another value of the number.

    A lift table with lash is not known, as its polynomials are rounded anew where they pass the
    seat; nor is a cam without lash, as it is drawn, at another height of its seat: whether the
    base circle is at that height, balls do not tell.
    """
    lash = getattr(shape, "lash", None)
    if _kind(shape) == "table":
        return lash is None and key in _of_table(shape)
    if lash == 0.0:
        return key not in OF_THE_SEAT
    return True


def with_number(shape: Any, key: str, value: Any) -> Shape:
    """The cam whose number at a key of the scene has this value: a ball or a series.

    Its `parts` raise UndecidedError where the ball does not tell which parts it has. The numbers
    that go along with another are those of the module: the centre of a closed flank circle, and a
    width of a law.
    """
    if _kind(shape) == "table":
        factor_and_base = _of_table(shape)[key]
        factor, base = factor_and_base(value)
        return ScaledTable(shape, factor, base)
    path = key.removeprefix("cam.").split(".")  # as [rise, law, scca, b]
    if path[1:3] == ["law", "scca"]:
        motion, _, _, width = path
        widths = getattr(shape, motion).law.scca
        return _replaced(shape, path[:-1], widths.with_width(width, value))
    if _kind(shape) == "arcs" and path == ["flank_radius"]:
        return _replaced(shape, ["flank_center"], value - number(shape.base_radius))
    return _replaced(shape, path, value)


def constants_of(shape: Any) -> dict[str, Any]:
    """What of the follower varies with the numbers of the cam, and the exact speed (rpm).

    An oscillator turns as fast as its force, whatever double its speed is rounded to.
    """
    if _kind(shape) != "oscillator":
        return {}
    constants = {
        "mass": shape.mass,
        "stiffness": shape.stiffness,
        "damping": shape.follower_damping,
    }
    varied = {name: value for name, value in constants.items() if not isinstance(value, float)}
    return {**varied, "rpm": number(shape.frequency) * 30 / arb.pi()}


OF_THE_SEAT = ("cam.base", "cam.base_radius", "cam.offset", "cam.lash")  # keys of its height

IN_FORMULA = {  # numbers of a cam that a certificate may vary
    "arcs": {
        "base_radius",
        "flank_center",
        "nose_center",
        "nose_radius",
        "top_dwell_deg",
        "offset",
    },
    "eccentric": {"base", "lift"},
    "law": {"base", "lift"},
    "oscillator": {"mass", "stiffness", "damping", "amplitude", "frequency", "clearance"},
}


def name_in_formula(shape: Any, key: str) -> tuple[str, set[str]] | None:
    """(the name that a certificate gives a number, the machine's constants that follow from it).

    None where a certificate cannot let this number vary: its cam has no formula in the number, or
    has lash, so that its corners, which are numbers of the certificate, would vary too; or it is an
    oscillator with a damping ratio, whose damping would vary with mass and stiffness. The speed of
    an oscillator always follows from its frequency.
    """
    if getattr(shape, "lash", None) is not None:
        return None
    name = key.removeprefix("cam.")
    kind = _kind(shape)
    if name not in IN_FORMULA.get(kind, ()):
        return None
    if kind != "oscillator":
        return key, set()
    if name in ("mass", "stiffness") and shape.damping_ratio is not None:
        return None
    constants = {"rpm"}
    if name in ("mass", "stiffness", "damping"):
        constants.add(name)
    return key, constants


def _kind(shape: Any) -> str:
    """The kind of a cam; kinds are told apart by it, as analyses may not import their classes."""
    return getattr(shape, "kind", "")


def _replaced(model: Any, names: list[str], value: Any) -> Any:
    """A section of a scene with one number replaced: the one at the path `names`, as ["rise",
    "length_deg"], through the sections within it.
    """
    name, *rest = names
    if rest:
        value = _replaced(getattr(model, name), rest, value)
    return model.model_copy(update={name: value})


@dataclass(frozen=True)
class ScaledTable:
    """A lift table's cam with its lift times a factor and another base.

    c = base + factor (c of the table - base of the table)
    """

    table: Any  # a TableCam
    factor: Any  # a ball or a series, as base
    base: Any  # m

    def parts(self) -> list[Part]:
        """The polynomials of the fit, each a part, and its dwells."""
        parts = []
        for part in self.table.parts():
            if not part.pieces:
                parts.append(replace(part, level=self._moved(part.level)))
                continue
            count = len(part.pieces)
            width = (part.end - part.start) / count
            edges = [part.start + k * width for k in range(count + 1)]
            parts += [
                Part(edges[k], edges[k + 1], self._lift(piece))
                for k, piece in enumerate(part.pieces)
            ]
        return parts

    def _moved(self, c: Any) -> Any:
        """c of this cam, m, where the table has the given c."""
        return self.base + self.factor * (c - arb(self.table.base))

    def _lift(self, piece: Piece) -> Callable[[Any], Any]:
        """A function that returns c of this cam where the table's is the polynomial of a piece."""

        def lift(theta: Any) -> Any:
            """c in m at theta in rad, a ball or a series; the polynomial by Horner's scheme."""
            x = theta - arb(piece.center)
            total = 0 * x
            for coefficient in reversed(piece.coefficients):
                total = total * x + arb(coefficient)
            return self._moved(total)

        return lift


def _of_table(table: Any) -> dict[str, Callable[[Any], tuple[Any, Any]]]:
    """The keys of a table that can vary, each with a function of the key's value.

    The function returns (factor, base) of the `ScaledTable` with that value.
    """
    base = arb(table.base)

    def factor(home: float | None) -> Callable[[Any], tuple[Any, Any]]:
        """The function of a number to which the lift is proportional; home: its value here."""
        return lambda value: (value / arb(home), base)

    known: dict[str, Callable[[Any], tuple[Any, Any]]] = {
        "cam.base": lambda value: (arb(1), value),
        "cam.lift_scale": factor(table.lift_scale),
    }
    if table.max_lift is not None:
        known["cam.max_lift"] = factor(table.max_lift)
    if table.measured_at == "lobe":
        known["cam.rocker_ratio"] = factor(table.rocker_ratio)
    return known
