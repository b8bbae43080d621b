"""The published problems of `cam bench validation`: what each source prints, and our number.

A problem is a scene of configs/validation and a function that asks the analyses about it, through
the same functions as any user, and yields a `Claim` for every number that the source prints. Its
printed digits stand beside the question, so that both are read together. Numbers with a tail of 20
digits or more are independent values: tests/published/test_validation.py computes each of them
anew with mpmath and code of its own.

Signs: `u_minus_m_per_s` of an impact is q' - c', the velocity at which the gap closes. An
oscillator's is x' = -u.
"""

from time import perf_counter

from camcli.analysis.bench.validation import ValidationRow, row_of
from camcli.api.validation import balls, cams, oscillators
from camcli.api.validation.problem import Problem, folder

__all__ = ["PROBLEMS", "Problem", "chosen", "folder", "measure"]

PROBLEMS: dict[str, Problem] = {
    problem.scene: problem for family in (oscillators, balls, cams) for problem in family.PROBLEMS
}


def chosen(quick: bool) -> list[Problem]:
    """The problems of a run: all, or those of the quick subset."""
    return [problem for problem in PROBLEMS.values() if problem.quick or not quick]


def measure(problem: Problem) -> list[ValidationRow]:
    """The rows of a problem; the seconds of a row are those that its number took."""
    rows = []
    began = perf_counter()
    for claim in problem.claims(problem):
        now = perf_counter()
        rows.append(row_of(claim, problem.source, problem.scene, now - began))
        began = now
    return rows
