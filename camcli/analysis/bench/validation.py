"""Published numbers beside ours: what a row of `cam bench validation` is, and when it is right.

A number is compared with its digits as printed: ours may be off by half a unit in the last of them
and by our own error. A published number that is wrong by more is told as such where an independent
value of some 40 digits is known; ours is then held to that value.
"""

from dataclasses import KW_ONLY, dataclass
from decimal import Decimal

OK = "ok"
MISPRINT = "published-off"  # the published number is off by more than its digits say; ours is not
FAILED = "failed"
COUNT = "count"  # in place of digits: a number of things, compared exactly
FORMULA = "formula"  # a formula of the source, evaluated here in 40 digits
ROUNDING = 2.0**-52  # relative, of reading a decimal number and of printing ours


@dataclass(frozen=True)
class Claim:
    """A published number and ours.

    quantity: what it is, with its unit; place: where in the source it stands; published: as it is
    printed there, as text; ours and error: our number, and how far off it may be at most;
    independent: the number in 40 digits, from a computation of its own that the tests repeat; kind:
    "" for a printed number, COUNT or FORMULA.
    """

    quantity: str
    place: str
    _: KW_ONLY
    published: str
    ours: float
    error: float = 0.0
    independent: str = ""
    kind: str = ""


@dataclass(frozen=True)
class ValidationRow:
    """A row of validation.csv."""

    source: str
    quantity: str
    published: str
    ours: float
    difference: float
    bound: float
    place: str
    digits: str
    independent: str
    status: str
    seconds: float
    problem: str


def half_unit(published: str) -> float:
    """Half a unit in the last digit of a number as it is printed: "1.36" gives 0.005."""
    exponent = Decimal(published).as_tuple().exponent
    assert isinstance(exponent, int)
    return float(Decimal(5).scaleb(exponent - 1))


def row_of(claim: Claim, source: str, problem: str, seconds: float) -> ValidationRow:
    """The row of a number: its difference, what it may be, and whether it is right."""
    ours = float(claim.ours)
    difference = float(Decimal(ours) - Decimal(claim.published))
    our_error = float(claim.error) + ROUNDING * abs(ours)
    bound = 0.0 if claim.kind == COUNT else half_unit(claim.published) + our_error
    status = OK
    if not abs(difference) <= bound:
        status = MISPRINT if _is_misprint(claim, our_error) else FAILED
    digits = claim.kind
    if not digits:
        digits = str(len(Decimal(claim.published).as_tuple().digits))
    return ValidationRow(
        source=source,
        quantity=claim.quantity,
        published=claim.published,
        ours=ours,
        difference=difference,
        bound=bound,
        place=claim.place,
        digits=digits,
        independent=claim.independent,
        status=status,
        seconds=seconds,
        problem=problem,
    )


def _is_misprint(claim: Claim, our_error: float) -> bool:
    """Whether an independent value says that ours is right and the published number is not."""
    if not claim.independent:
        return False
    independent = Decimal(claim.independent)
    ours_off = abs(float(Decimal(float(claim.ours)) - independent))
    published_off = abs(float(Decimal(claim.published) - independent))
    return ours_off <= our_error and published_off > half_unit(claim.published)
