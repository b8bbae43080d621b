"""What of a study is proved, and of what a certificate has a statement: evidence, or none."""

from dataclasses import dataclass
from types import SimpleNamespace as Stub

import pytest

from camcli.analysis.orbits import certificate
from camcli.analysis.orbits.kinds import Kind


@dataclass(frozen=True)
class Evidence:
    """Of a range: the events at its ends."""

    ends: tuple = (None, None)
    axes: tuple = ()


COVERED = (Kind.PERIOD_DOUBLING, Kind.FOLD, Kind.CORNER_IMPACT)


def proved(orbits=(), events=(), ranges=()):
    study = Stub(orbits=[one for one, _ in orbits], bifurcations=[one for one, _ in events])
    proofs = Stub(
        orbits=[proof for _, proof in orbits], events=[proof for _, proof in events], ranges=ranges
    )
    return list(certificate._proved(study, proofs))


@pytest.mark.parametrize("kind", [*COVERED, Kind.GRAZING])
@pytest.mark.parametrize("end", [0, 1])
def test_events_that_no_statement_covers_leave_no_evidence(kind, end):
    """Neither of themselves nor of a branch that ends at one of them."""
    evidence = Evidence(tuple(Stub(kind=kind) if k == end else None for k in (0, 1)))
    part = Stub(failed_step=None, evidence=evidence, label="P(1;1)", stable=True, low="700",
                high="[701 +/- 0.5]")  # fmt: skip
    event = Stub(kind=kind, orbit=Stub(label="P(1;1)"))
    proof = Stub(proved=True, evidence="evidence", value="[739 +/- 0.25]", signs=[("rule", -1)])
    of_event, of_range = proved(events=[(event, proof)], ranges=[part])
    covered = kind in COVERED
    assert (of_event.of, of_event.evidence) == (event, "evidence" if covered else None)
    assert of_event.claims == {
        "kind": "event", "label": "P(1;1)", "signs": [-1], "low": "7385e-1", "high": "7395e-1",
    }  # fmt: skip
    assert (of_range.of, of_range.evidence) == (part, evidence if covered else None)
    assert of_range.claims == {
        "kind": "branch", "label": "P(1;1)", "stable": True, "low": ["700", "700"],
        "high": ["700", "702"],
    }  # fmt: skip


def test_what_is_not_proved_is_left_out():
    """A range of which nothing is known but that it is proved has no evidence either."""
    event = Stub(kind=Kind.FOLD, orbit=Stub(label="P(1;1)"))
    part = Stub(failed_step=None, evidence=None, label="P(1;1)", stable=False, low="1", high="2")
    orbit = Stub(label="P(1;1)", stable=True)
    (found,) = proved(
        orbits=[(orbit, Stub(proved=False, axes=(), evidence=Evidence()))],
        events=[(event, Stub(proved=False))], ranges=[Stub(failed_step="grazes"), part],
    )  # fmt: skip
    assert (found.of, found.evidence) == (part, None)
