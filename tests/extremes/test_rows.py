"""The table of extreme cases: one test per row, the rows `cam bench stability` runs."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

import camcli
from camcli.analysis.bench import stability
from camcli.analysis.bench.stability import FAILED, OK, ROWS, MismatchError, measure
from camcli.api.bench import machines
from camcli.errors import Status
from tests.support.kernel_runs import run, system

SHEET = {  # what each row is called, what is expected, and what is observed
    1: ("r = 0", "one impact then sticking if a < 0; no chatter test",
        "P(1;2); 39 events in order at 700 rpm; no chatter"),
    2: ("r = 1", "runs; warning", "3172 bounces; speeds equal to 0.0e+00; warning said"),
    3: ("r = 0.999999", "impact budget with status or chatter map in tolerance",
        "impact-budget after 5000 impacts"),
    5: ("b critical +- 1 ulp and +- 1e-12", "continuous; same digits on both sides",
        "phases within 1.2e-12 rad on both sides"),
    6: ("b > 6.6e3 at 115 rpm; > 4e4 at 700 rpm", "the oracle's stored value",
        "0.02 of the limit at most: 6.2e-26 m in 107 steps; 5.6e-17 m in 309 steps"),
    7: ("b = 1e9 and 1e12", "against the oracle within the rounding of its steps",
        "0.04 of the limit at most: 2.1e-27 m in 96 steps; 5.6e-17 m in 78 steps"),
    8: ("k = 0; ball dropped from 1 m", "rests at 4.06371277 s",
        "rests at 4.0637127689 s; relative error 2.2e-16"),
    9: ("k = b = g = preload = 0", "separating follower: no-return",
        "no-return; no event invented"),
    10: ("k 4^n; rpm and v 2^n; n = +-20", "bit-identical phases", "556 phases identical"),
    11: ("m; k; b times 2^n", "bit-identical phases", "244 phases identical"),
    12: ("1e-3 rpm; many turns", "sticks throughout; phases exact after many turns",
         "contact for 2000 turns; phases of turn 2000 those of turn 10"),
    13: ("1e6 rpm", "bounded cost; warning",
         "13 impacts; 53 evaluations; 20018 crossings in 20000 turns; warning said"),
    14: ("k = 1e8 N/m at 50000 rpm", "as exact as the example's machine",
         "46 impacts; 0 missed; error 5.6e-15 turns; 0.03 of the bound at most"),
    15: ("114.979326744 rpm +- 1e-5", "no impact below; detachment at b above",
         "no event below; detachment at b above"),
    16: ("114.98 rpm", "impacts of about 1e-7 m/s resolved",
         "8 impacts from 1.06e-09 m/s down; speeds right to 1.1e-10"),
    17: ("exact graze +- 1 ulp", "at most one contact of near-zero speed",
         "75 grazes; 48 contacts; fastest 2.4e-08 m/rad"),
    18: ("start with q = c; u = 0", "leaves or sticks; no impact recorded",
         "5 starts stick; 3 leave; no impact recorded; zero force: as if stuck to 0e+00 rad"),
    19: ("start with q = c; u < 0", "one impact at t = 0",
         "one impact at t = 0 from each of 4 phases"),
    20: ("start below the cam", "exit 2 with the depth",
         "exit 2; 'found q = 0.05 m; 0.05 m below the cam'; one ulp below is on it"),
    21: ("impact exactly on a corner", "once",
         "one impact on c at 13 speeds around 124.998296821 rpm; its hops follow"),
    22: ("event exactly at the strobe", "counted in exactly one period",
         "counted once for 17 strobes within 8 ulp; a start on it too"),
    23: ("198.5605 +- 0.01 rpm", "complete to incomplete chatter once",
         "complete up to 198.5605 rpm; incomplete from 198.5615 rpm"),
    24: ("cam below zero; no spring needed", "said in words",
         "'not held even at standstill'; 'a spring does not press'; 'no spring is needed'"),
    25: ("chatter at 1e-300 m/s", "signs compared; not products",
         "as r = 0; 328 impacts down to 2e-82 m/rad; all with u < 0"),
}  # fmt: skip


@pytest.mark.parametrize("number", ROWS)
def test_row(number):
    outcome = measure(ROWS[number], machines())
    case, expected, observed = SHEET[number]
    assert (outcome.case, outcome.expected) == (f"{number}: {case}", expected)
    assert (outcome.observed, outcome.status) == (observed, OK)
    assert 0.0 < outcome.seconds < 600.0


def test_every_numerical_row_is_there_once():
    assert list(ROWS) == list(SHEET) == [1, 2, 3, *range(5, 26)]


class OtherMachines:
    """The example with some constants changed, whatever a row asks for."""

    def __init__(self, **changes: float):
        self.changes, self.real = changes, machines()

    def example(self, *strobe: float, **asked: float):
        return self.real.example(*strobe, **{**asked, **self.changes})

    def system(self, follower, section):
        return self.real.system(replace(follower, **self.changes), section)


FAILS = [  # row, what its machine has instead, and what is told
    (1, {"restitution": 0.5}, "events ['detachment', 'impact', 'impact']"),
    (2, {"restitution": 0.99999}, "3224 bounces; drift 3.2e-02"),
    (2, {"restitution": 0.999}, "1 bounce; drift 0.0e+00"),
    (6, {"stiffness": 1400.0}, "6.7e3 at 115 rpm: departures 6.5e-05 rad off"),
    (7, {"damping": 1e5}, "1e9 at 115 rpm: departures 5.5e-05 rad off"),
    (8, {"restitution": 0.81}, "rests at 4.301356790443017 s"),
    (9, {"stiffness": 100.0}, "ok; 44 events"),
    (9, {"gravity": 1.0}, "ok; 0 events"),
    (10, {"gravity": 2.0}, "other phases with n = -20"),
    (11, {"preload": 6.0}, "other phases with n = -40"),
    (12, {"stiffness": 800.0}, "phases drift with the turns"),
    (12, {"stiffness": 0.0}, "the run: no-return"),
    (13, {"stiffness": 1e7}, "1287 impacts; 5443 evaluations; 22021 crossings"),
    (14, {"restitution": 0.5}, "24 impacts; 56 missed; error 7.3e-02 turns"),
    (15, {"stiffness": 1430.7}, "45 events below"),
    (16, {"restitution": 0.8000001}, "speeds off by 9.4e-07"),
    (16, {"restitution": 0.1}, "1 impact"),
    (18, {"stiffness": 700.0}, "does not stick at 0.0 deg"),
    (21, {"restitution": 0.0}, "['impact'] and 0 hops at 124.9982968208033 rpm"),
    (22, {"restitution": 0.5}, "67 counted; 67 logged"),
    (23, {"restitution": 0.81}, f"complete: {[False] * 21}"),
    (23, {"restitution": 0.3}, f"complete: {[True] * 21}"),
]


@pytest.mark.parametrize(("number", "changes", "observed"), FAILS)
def test_a_row_fails_on_a_machine_that_is_another(number, changes, observed):
    outcome = measure(ROWS[number], OtherMachines(**changes))
    assert (outcome.observed, outcome.status) == (observed, FAILED)


def test_what_a_row_raises_is_told():
    """No double of a row's own, and a command that ends with another code."""
    outcome = measure(ROWS[19], OtherMachines(stiffness=0.0))
    assert outcome.status == FAILED
    assert outcome.observed.startswith("ValueError: not enough values to unpack")
    with pytest.raises(MismatchError, match=r"^exit 0: "):
        stability.said("--version", code=3)
    with pytest.raises(MismatchError, match=r"^said: "):
        stability.said("--version", "no such text")


def test_a_command_is_stopped_after_a_minute(monkeypatch):
    limits = []

    def run(command, timeout, **more):
        limits.append(timeout)
        return SimpleNamespace(returncode=0, stdout="done", stderr="")

    monkeypatch.setattr(stability.subprocess, "run", run)
    assert stability.said("detach") == "done"
    assert limits == [60.0]


class OtherRecord:
    """A record with some of its columns changed."""

    def __init__(self, record, **changes):
        self.record = record
        for name, change in changes.items():
            setattr(self, name, change(getattr(record, name)))

    def __getattr__(self, name):
        return getattr(self.record, name)


def first_counts_more(impacts):
    return [impacts[0] + 1, *impacts[1:]]


def last_is_one(chatter):
    return [*chatter[:-1], True]


def backwards(events):
    """Of a method: what it returns, in the other order."""
    return lambda: list(events())[::-1]


def drifting(rates):
    return [x + 1e-17 for x in rates]


@pytest.mark.parametrize(
    ("number", "run", "changes", "observed"),
    [
        (1, 0, {"impacts": first_counts_more}, "impacts per turn [3, 2, 2, 2]"),
        (1, 0, {"chatter": last_is_one}, "a chatter was recorded"),
        (1, 1, {"events": backwards}, "events out of order at 700 rpm"),
        (10, 1, {"strobe_w": drifting}, "other states with n = -20"),
        (22, 1, {"impacts": first_counts_more}, "51 counted; 50 logged"),
    ],
)
def test_a_row_fails_on_a_record_that_is_another(monkeypatch, number, run, changes, observed):
    """Each comparison alone. run: which run of the row, from 0, has another record."""
    real, count = stability.run, [0]

    def runs(*asked, **wanted):
        record = real(*asked, **wanted)
        count[0] += 1
        return OtherRecord(record, **changes) if count[0] == run + 1 else record

    monkeypatch.setattr(stability, "run", runs)
    outcome = measure(ROWS[number], machines())
    assert (outcome.observed, outcome.status) == (observed, FAILED)


def test_a_spring_without_force_on_the_dwell_is_no_trouble():
    """c = 0 on the base, so force and acceleration of a landing there vanish together."""
    scene = camcli.load_scene(None, {"cam.offset": 0.4, "run.rpm": 300.0, "run.record": 50})
    cost = camcli.simulate(scene).values.cost
    assert cost.evaluations < 10 * cost.impacts


@pytest.mark.parametrize("q", [0.1, 0.4 - 0.3])
def test_the_height_of_the_dwell_as_written_is_on_the_cam(q):
    """Row 18 too: 0.4 m - 0.3 m is an ulp more than 0.1 m."""
    scene = camcli.load_scene(None, {"run.start.q": q, "run.start.v": 0.0, "run.rpm": 100.0})
    assert not len(camcli.simulate(scene).tables["events"]["t_s"])


def test_a_damped_follower_without_force_is_thrown_off_by_the_lobe():
    """Row 9 from rest on the cam, where damping brakes it: no impact is invented."""
    tape = run(1.0, system(stiffness=0.0, damping=1.0), record=50)
    assert tape.status in (Status.OK, Status.NO_RETURN)
    assert len(tape.kind) < 100
