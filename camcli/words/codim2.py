"""What is said of a point of codimension two."""

from collections.abc import Sequence

from camcli.analysis.orbits.codim2 import CodimTwo, PointKind, PointProof, Test
from camcli.exact.shooting import ProofStep
from camcli.words.proofs import FAILED, place_of

UNFOLDS = {
    PointKind.FOLD_GRAZING: "the curve of folds ends on the curve of grazing, tangent to it",
    PointKind.PERIOD_DOUBLING_GRAZING: "the curve of doublings ends on the curve of grazing",
    PointKind.CUSP: "two folds meet here and vanish",
    PointKind.CORNER_IMPACT_FOLD: "the curve of folds ends on the curve of corner impacts, "
    "tangent to it; its orbit is no motion beyond",
    PointKind.CORNER_IMPACT_PERIOD_DOUBLING: "the curve of doublings ends on the curve of corner "
    "impacts, and corner impacts of the doubled orbit begin here",
    PointKind.DOUBLE_CORNER_IMPACT: "two curves of corner impacts cross, each with a kink",
    PointKind.CORNER_IMPACT_GRAZING: "a curve of corner impacts meets one of grazing",
    PointKind.DOUBLE_GRAZING: "two curves of grazing cross",
    PointKind.CORNER_GRAZING: "the flight touches the cam at a corner: the curve of grazing has "
    "another square root on either side, and corner impacts of the grazing impact begin here",
    PointKind.CONSERVATIVE: "the curve ends where nothing is lost in an impact or in flight: there "
    "every orbit has the determinant 1",
}  # fmt: skip

NO_PROOF = "there is no proof yet for points of this kind"


def meets_words(point: CodimTwo) -> str:
    """The two bifurcations that meet: fold & corner-impact at a."""
    corners = iter(point.corners)  # one for each corner impact that meets
    words = []
    for bifurcation in point.meets:
        is_corner_impact = bifurcation == Test.CORNER
        words.append(f"{bifurcation} at {next(corners)}" if is_corner_impact else bifurcation)
    return " & ".join(words)


def place_words(point: CodimTwo, names: Sequence[str]) -> str:
    """Both parameters: rpm 376.3732, restitution 0.7717172."""
    return place_of((point.first, point.second), names)


def point_line(point: CodimTwo, names: Sequence[str]) -> str:
    """The point as a sentence: its kind, its orbit, where it is, and what unfolds there.

    Where a proof was asked for, what it shows of the point stands before what theory says of it.
    """
    meets = meets_words(point)
    proof = "" if point.proof is None else f", {_proof_words(point.proof)}"
    by_theory = "" if point.proof is None else "by theory, "
    return (
        f"{point.kind} of {point.label} at {place_words(point, names)} ({meets}){proof}: "
        f"{by_theory}{UNFOLDS[point.kind]}"
    )


def _proof_words(proof: PointProof) -> str:
    """What is proved of a point, or what failed."""
    if proof.step is None:
        return "proved to be one orbit with both"
    why = NO_PROOF if proof.step is ProofStep.MODEL else FAILED[proof.step]
    return f"not proved: {why}"
