"""What the error of a lift table leaves open stands wherever its critical speeds are read.

The law of the shipped table is known: contact is first lost at 3345.4 rpm
(tests/support/valve_lift.py).
"""

import csv
import json
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest

import camcli
from camcli.analysis.contact_loss.detachment import CriticalQuantity, detachment, loss_range
from camcli.api.detach import _critical_rows
from camcli.api.detach import _summary as summary
from camcli.api.explore_page import machine_data
from camcli.api.lift_table import lost_between, widened, with_ranges
from camcli.api.machine import machine_of
from camcli.cli.simulate import _on_base_circle
from camcli.output.run_record import as_json
from camcli.system import omega_of
from camcli.words.speeds import range_words
from tests.conftest import rows

CONFIGS = Path(__file__).parents[2] / "configs"
TABLE = str(CONFIGS / "lift-table.yaml")
TRUTH = 3345.4
SHORT = {"detach.rpm": {"start": 3400.0, "stop": 3500.0, "num": 2}, "detach.settle": 0}
WORDS = "3333 to 3378 rpm"


@pytest.fixture(scope="module")
def found():
    return camcli.detach(camcli.load_scene(TABLE, {**SHORT, "detach.hold_to": 3600.0}))


@pytest.fixture(scope="module")
def left(found):
    """The range of the library, which holds the truth."""
    low, high = found.error["lift_table"]["first_detachment_rpm"]
    assert low < TRUTH < high
    assert low < found.values.detachment.first.rpm < high
    assert range_words(low, high) == WORDS
    return low, high


@pytest.mark.ci
def test_the_table_and_the_summary_have_the_range(found, left):
    named = {row["quantity"]: row for row in csv.DictReader("".join(found.tables["detach"].csv())
                                                            .splitlines())}  # fmt: skip
    for quantity in ("first_detachment", "opens"):
        row = named[quantity]
        assert (float(row["rpm_low"]), float(row["rpm_high"])) == left
    assert (named["fills"]["rpm_low"], named["fills"]["rpm"]) == ("inf", "inf")
    columns = found.tables["detach"].columns
    assert columns[-2:] == ("rpm_low", "rpm_high")
    assert columns[:5] == ("quantity", "region", "theta_deg", "rpm", "omega_rad_per_s")
    for speed in found.summary["critical_speeds"][:2]:
        assert (speed["low_rpm"], speed["high_rpm"]) == left
    for hold in found.summary["hold"]:
        row = named[hold["quantity"]]
        assert float(row["rpm_low"]) == hold["low_rpm"]
        assert float(row["rpm_high"]) == hold["high_rpm"]
        assert 3600.0 < hold["low_rpm"] < hold["detaches_rpm"] < hold["high_rpm"]
        wide = (hold["high_rpm"] - hold["low_rpm"]) / hold["detaches_rpm"]
        assert wide == pytest.approx((left[1] - left[0]) / TRUTH, rel=0.1)


def test_chatter_on_a_table_has_no_bracket_that_anybody_knows(found):
    """A bracket of the computation alone would promise too much."""
    first = found.values.detachment.first
    loss = replace(
        first, quantity=CriticalQuantity.COMPLETION_LOSS, low=3500.0, rpm=3501.0, high=3502.0
    )
    widened = with_ranges(replace(found.values, completion=(loss,)), found.system)
    *_, row = [row for row in _critical_rows(widened) if row[0] == CriticalQuantity.COMPLETION_LOSS]
    assert row[3:] == (3501.0, omega_of(3501.0), None, None)
    (told,) = [c for c in as_json(summary(widened))["critical_speeds"] if c["rpm"] == 3501.0]
    assert (told["low_rpm"], told["high_rpm"]) == (None, None)


def test_a_law_keeps_the_brackets_of_the_computation():
    exact = camcli.detach(camcli.load_scene(None, {**SHORT, "detach.hold_to": 150.0}))
    columns = (exact.tables["detach"][name] for name in ("rpm_low", "rpm", "rpm_high"))
    finite = [row for row in zip(*columns, strict=True) if row[1] < inf]
    assert len(finite) > 4
    assert all(low < rpm < high < low * (1 + 1e-9) for low, rpm, high in finite)
    assert "lift_table" not in exact.error


def test_pictures_say_it(found, left):
    words = found.pictures["detach"]().caption
    assert words.startswith(f"contact is first lost at 3352 rpm, 190.5 deg ({WORDS} by the error")
    profile = camcli.simulate(found.scene, profile_only=True)
    assert profile.summary["first_detachment_between_rpm"] == list(left)
    words = profile.pictures["profile"]().caption
    assert f"first detachment at 3352 rpm, 190.5 deg ({WORDS} by the error of the table)" in words


@pytest.mark.parametrize(
    ("height", "told"), [(0.0, True), (2.4e-6, True), (-2.4e-6, True), (2.6e-6, False)]
)
def test_less_than_its_last_digit_above_the_base_circle_is_on_it(found, height, told):
    """The table has 0.0001 inch."""
    assert _on_base_circle(found.scene.cam, height) is told


def test_the_sheet_of_a_table_says_that_its_lowest_place_is_the_base_circle(cam):
    said = cam(f"simulate -c {TABLE} --profile-only --no-plot", code=0).stdout
    (line,) = [line for line in said.splitlines() if line.startswith("least c (mm)")]
    assert line.split("  ")[0] == "least c (mm)"
    assert line.removeprefix("least c (mm)").split() == ["base", "circle", "-"]


def test_the_page_says_it(found):
    said = machine_data(machine_of(found.scene))["measured"]
    assert f"contact is first lost at {WORDS} (3352 by the fit)" in said
    assert machine_data(machine_of(None))["measured"] == ""


def test_the_end_of_a_run_and_its_record_say_it(cam, tmp_path, left):
    short = "--set run.transient=5 --set run.record=5 --no-plot"
    done = cam(f"sweep -c {TABLE} --rpm 3500:3510 --points 2 {short}", code=0)
    assert "error of each event: contact within 9e-18 m of the fitted cam, which" in done.stdout
    assert "which is within 0.75 um rms of its measured table" in done.stdout
    assert f"first detachment at {WORDS}" in done.stdout.splitlines()[-1]
    done = cam(f"detach -c {TABLE} --rpm 3400:3500 --points 2 --no-plot -v", code=0)
    assert "3333 to 3378" in done.stdout
    assert "3352.175" not in done.stdout.partition("Critical speeds")[2].partition("Bursts")[0]
    record = json.loads((tmp_path / "out/detach/run.json").read_text())
    assert record["error"]["lift_table"]["first_detachment_rpm"] == list(left)
    table = {row["quantity"]: row for row in rows(tmp_path / "out/detach/detach.csv")}
    assert float(table["first_detachment"]["rpm_high"]) == left[1]


@pytest.mark.parametrize("line", ["detach --rpm 3400:3500 --points 2", "simulate --rpm 3500"])
def test_the_object_of_json_has_the_sentences_of_the_verdict(cam, line):
    words = f"{line} -c {TABLE} --no-plot --set run.transient=5 --set run.record=5"
    record = json.loads(cam(f"{words} --json", code=0).stdout)
    said = cam(words, code=0).stdout.splitlines()
    assert said[: len(record["verdict"])] == record["verdict"]
    assert all(sentence.endswith(".") for sentence in record["verdict"])


def test_the_library_has_the_verdict_too(found):
    first, second, *rest = found.verdict
    assert first == (
        "Contact holds up to 3352 rpm of the cam (6704 of the crank); its table leaves "
        "3333 to 3378 rpm."
    )
    assert second.startswith("What gives first is the spring: at 190.5 deg it presses too little")
    assert any(
        one.startswith("To hold up to 3600 rpm of the cam (7200 of the crank) with ")
        for one in rest
    )


def test_the_verdict_says_what_of_the_springs_is_for_the_error_of_the_table(found):
    """The least force on the fitted cam, from the sheet of the cam."""
    sheet = camcli.simulate(found.scene, profile_only=True).tables["profile"]
    c, c1, c2 = (
        np.asarray(sheet[name]) for name in ("c_m", "c_theta_m_per_rad", "c_thetatheta_m_per_rad2")
    )
    follower, omega = found.scene.follower, omega_of(3600.0)
    moved = follower.damping * omega * c1 + follower.mass * omega * omega * c2
    least = min(
        float((hold["stiffness"] * c + hold["preload"] + moved).min())
        for hold in found.summary["hold"]
    )
    more = least - found.summary["hold_margin_n"]
    assert more > 5.0
    told = f"at least {least:.3g} N, {more:.2g} N of it for the error of the table."
    assert found.verdict_details[-1].endswith(told)


def test_an_open_end_is_said_in_words():
    assert range_words(100.0, inf) == "from 100 rpm on, or never"
    assert range_words(inf, inf) == "never"
    assert range_words(99.87, 100.13) == "99.87 to 100.13 rpm"


def test_only_the_first_loss_of_contact_has_a_range_that_the_table_leaves():
    """Where contact is lost all over a region its error is not known: neither end of the range."""
    system = machine_of(camcli.load_scene(TABLE)).system
    found = detachment(system)
    filled = replace(found.losses[0].fills, rpm=5000.0, low=4999.0, high=5001.0)
    losses = tuple(replace(loss, fills=filled) for loss in found.losses)
    low, high = lost_between(system)
    wide = widened(replace(found, losses=losses), system)
    assert low < found.first.rpm < high
    assert (wide.first.low, wide.first.high) == (low, high)
    for loss in wide.losses:
        assert loss.fills.rpm == 5000.0
        assert np.isnan([loss.fills.low, loss.fills.high]).all()
        leads = loss.region.name == found.first.region
        ends = [loss.opens.low, loss.opens.high]
        assert ends == [low, high] if leads else np.isnan(ends).all() or not loss.opens.finite


def test_the_range_ends_where_contact_is_surely_lost_at_any_phase():
    """N = k c + F0 + m w^2 (c'' + error) of an eccentric c = e (1 - cos), in closed form.

    Within 60 degrees of the nose the error is as large as c'' itself: there contact may never be
    lost. It surely is at 120 degrees, where c = 3 e/2 and c'' = -e/2, at a higher speed.
    """
    e, mass, stiffness, preload = 0.005, 0.11, 45e3, 60.0
    follower = {"mass": mass, "stiffness": stiffness, "preload": preload, "damping": 0.0,
                "restitution": 0.4}  # fmt: skip
    ring = {"kind": "eccentric", "base": 0.0, "lift": 2.0 * e}
    system = machine_of(camcli.load_scene({"cam": ring, "follower": follower})).system
    low, high = loss_range(system, (0.0, e, 0.0), system)
    surely = np.sqrt((1.5 * stiffness * e + preload) / (0.5 * mass * e)) * 30.0 / np.pi
    soonest = np.sqrt((2.0 * stiffness * e + preload) / (2.0 * mass * e)) * 30.0 / np.pi
    assert high == pytest.approx(surely, rel=1e-3)
    assert low == pytest.approx(soonest, rel=1e-9)


@pytest.mark.ci
def test_within_its_range_every_sentence_speaks_of_the_fitted_cam(left):
    """3340 rpm lies between the lower end of the range and the first loss on the fitted cam."""
    assert left[0] < 3340.0 < 3352.0
    values = {"detach.rpm": {"start": 3340.0, "stop": 3340.0, "num": 1}, "run.rpm": 3340.0}
    values |= {"detach.settle": 0, "detach.hold_to": 3340.0, "simulate.samples": 20_000}
    scene = camcli.load_scene(TABLE, values)
    result = camcli.detach(scene)
    (held,) = [words for words in result.summary["words"] if "held at every speed" in words]
    assert held.startswith("on the fitted cam contact is held at every speed asked for")
    assert held.endswith(f"the error of its table leaves that open ({WORDS})")
    (spring,) = [words for words in result.verdict if "but not with" in words]
    assert spring.startswith("On the fitted cam the present spring holds beyond 3340 rpm")
    sheet = camcli.simulate(scene, profile_only=True).tables["profile"]
    c, c1, c2 = (
        np.asarray(sheet[name]) for name in ("c_m", "c_theta_m_per_rad", "c_thetatheta_m_per_rad2")
    )
    follower, omega = scene.follower, omega_of(3340.0)
    moved = follower.mass * follower.gravity + follower.damping * omega * c1
    forces = follower.stiffness * c + follower.preload + moved + follower.mass * omega**2 * c2
    (working,) = [words for words in result.verdict if "At the working speed" in words]
    told = float(working.partition("the least force is ")[2].split()[0])
    assert "leaves open whether contact holds: on the fitted cam" in working
    assert told == pytest.approx(forces.min(), rel=0.02)
