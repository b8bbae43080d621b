"""The work that an analysis may do is counted: it ends where the count reaches the limit."""

import pytest

from camcli.analysis.integrate import Budget, BudgetSpentError, budgeted, spend
from camcli.errors import Status


@pytest.mark.parametrize(
    ("works", "done"), [([4, 6], 10), ([9, 0, 1], 10), ([9, 7], 16), ([10], 10)]
)
def test_a_budget_ends_when_its_limit_is_reached(works, done):
    """Not before: and what is shown is never more than the limit."""
    ticks = []
    budget = Budget(10, lambda *shown: ticks.append(shown))
    *before, last = works
    for work in before:
        budget.spend(work)
        assert budget.status == Status.OK
    with pytest.raises(BudgetSpentError):
        budget.spend(last)
    assert (budget.done, budget.status) == (done, Status.WORK_BUDGET)
    total = 0
    for work, shown in zip(works, ticks, strict=True):
        total += work
        assert shown == (min(total, 10), 10)
    with pytest.raises(BudgetSpentError):  # what asks whether there is any left
        budget.spend(0)


def test_work_counts_for_the_block_that_it_is_in():
    spend(10**9)  # nobody counts
    with budgeted(10, lambda *shown: None) as outer:
        spend(3)
        with budgeted(100, lambda *shown: None) as inner:
            spend(50)
        spend(4)
        assert (outer.done, inner.done) == (7, 50)
        with pytest.raises(BudgetSpentError):
            spend(3)
    spend(10**9)
