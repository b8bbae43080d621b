"""The digest of a run and its comparison, on small tables whose numbers are written out here."""

from __future__ import annotations

from hashlib import sha256
from math import inf, nan

import numpy as np
import pytest

from camcli.output.digest import Drift, caption, digest, drifts
from camcli.output.tables import Table


def table(columns, *rows):
    return Table.of_rows(tuple(columns.split()), lambda: iter(rows))


def bits(*columns):
    """The bits of columns, one after the other: doubles, or lines of text."""
    joined = b"".join(
        "\n".join(column).encode()
        if isinstance(column[0], str)
        else np.array(column, "<f8").tobytes()
        for column in columns
    )
    return sha256(joined).hexdigest()[:16]


def test_motions_that_repeat_and_those_that_do_not_apart():
    """Five impacts at 700 rpm, which repeats, and two at 745, which does not."""
    theta = [30.0, 10.0, 50.0, 20.0, 40.0]
    impacts = [(700.0, k, x, 0.5) for k, x in enumerate(theta)]
    found = digest(
        {
            "impacts": table("rpm period theta_deg q_m", *impacts,
                             (745.0, 0, 8.0, 0.25), (745.0, 1, 6.0, 0.25)),
            "speeds": table("rpm label status", (700.0, "P(1;1)", "ok"), (720.0, "P(1;1)", "ok"),
                            (745.0, "aperiodic", "ok"), (750.0, "undecided", "unresolved")),
        },
        None,
    )  # fmt: skip

    def quantiles(name, *values):
        names = ["least", "q05", "q25", "median", "q75", "q95", "largest"]
        return {f"impacts.csv {name} {at}": x for at, x in zip(names, values, strict=True)}

    assert found == {
        "regular": {
            "impacts.csv rows": 5,
            "impacts.csv bits": bits([700.0] * 5, [0.0, 1.0, 2.0, 3.0, 4.0], theta, [0.5] * 5),
            **quantiles("theta_deg", 10.0, 10.0, 20.0, 30.0, 40.0, 50.0, 50.0),
            **quantiles("q_m", *[0.5] * 7),
            "speeds.csv status = ok": 3,
            "speeds.csv status = unresolved": 1,
            "speeds.csv different labels": 3,
            "speeds.csv P(1;1) speeds": 2,
            "speeds.csv P(1;1) from rpm": 700.0,
            "speeds.csv P(1;1) to rpm": 720.0,
            "speeds.csv aperiodic speeds": 1,
            "speeds.csv aperiodic from rpm": 745.0,
            "speeds.csv aperiodic to rpm": 745.0,
            "speeds.csv undecided speeds": 1,
            "speeds.csv undecided from rpm": 750.0,
            "speeds.csv undecided to rpm": 750.0,
        },
        "chaotic": {
            "impacts.csv rows": 2,
            "impacts.csv bits": bits([745.0] * 2, [0.0, 1.0], [8.0, 6.0], [0.25] * 2),
            # of two numbers the first stands for shares up to a half, which rounds to even
            **quantiles("theta_deg", 6.0, 6.0, 6.0, 6.0, 8.0, 8.0, 8.0),
            **quantiles("q_m", *[0.25] * 7),
        },
        "solved": {},
    }


def test_what_happens_in_a_run_in_time():
    """Two turns with two impacts each; both rests end at the corner b."""
    events = table(
        "t_s event theta_deg",
        (0.1, "impact", 100.0), (0.2, "detachment", 150.25), (0.3, "impact", 110.0),
        (0.4, "impact", 101.0), (0.5, "detachment", 150.2500004), (0.6, "impact", 111.0),
    )  # fmt: skip
    result = {
        "label": "P(1;2)", "rpm": 700.0, "periods": 2, "corners_deg": [90.0, 150.2500001],
        "chaos": {"proved": True, "entropy_per_turn": 0.25},
    }  # fmt: skip
    found = digest({"events": events}, result)
    assert found["solved"] == {
        "impacts a turn": 2.0,
        "detachments a turn": 1.0,
        "detachment deg": 150.25,
        "detachment corner": "b",
        "entropy per turn": 0.25,
    }
    regular = found["regular"]
    assert (regular["label"], regular["rpm"], regular["periods"]) == ("P(1;2)", 700.0, 2)
    assert (regular["events.csv event = impact"], regular["events.csv event = detachment"]) == (
        4,
        2,
    )
    wild = digest({"events": events}, {**result, "label": "aperiodic"})
    assert wild["chaotic"]["events.csv rows"] == 6
    assert wild["regular"].keys() == {"label", "rpm", "periods"}


def test_what_was_solved_cell_by_cell_or_by_quantiles():
    """Rows are named by what names them; a second one of that name has a number."""
    branch = [
        (1, "P(1;1)", 700.0, 1, 0.5),
        (1, "P(1;1)", 710.0, 1, nan),
        (1, "P(1;1)", inf, 0, 2.0),
    ]
    found = digest({"branch": table("branch label rpm stable q_m", *branch)}, {})["solved"]
    assert found == {
        "branch.csv rows": 3,
        "branch.csv 1 P(1;1) 1 rpm": 700.0,
        "branch.csv 1 P(1;1) 1 q_m": 0.5,
        "branch.csv 1 P(1;1) 1 #2 rpm": 710.0,
        "branch.csv 1 P(1;1) 0 rpm": "inf",
        "branch.csv 1 P(1;1) 0 q_m": 2.0,
    }
    for rows, whole in ((40, True), (41, False)):
        many = table("x_m rpm_error", *((float(k), 1.0) for k in range(rows)))
        found = digest({"curve": many}, {})["solved"]
        assert ("curve.csv x_m median" in found) is not whole
        assert len(found) == (1 + rows if whole else 1 + 7)
    assert found["curve.csv x_m q25"] == 10.0
    assert found["curve.csv x_m q95"] == 38.0


def test_a_motion_that_is_undecided_is_one_that_does_not_repeat():
    speeds = table("rpm label status", (700.0, "contact", "ok"), (710.0, "undecided", "ok"),
                   (720.0, "aperiodic", "ok"))  # fmt: skip
    rows = [(700.0, "a", 1.0), (700.0, "bc", 2.0), (710.0, "ab", 3.0), (720.0, "c", 4.0)]
    found = digest({"strobe": table("rpm region q_m", *rows), "speeds": speeds}, None)
    assert found["regular"]["strobe.csv bits"] == bits([700.0] * 2, ["a", "bc"], [1.0, 2.0])
    assert found["chaotic"]["strobe.csv bits"] == bits([710.0, 720.0], ["ab", "c"], [3.0, 4.0])
    assert found["regular"]["strobe.csv region = bc"] == 1
    assert found["chaotic"]["strobe.csv rows"] == 2


def test_rests_at_several_phases_are_at_no_corner():
    rows = [(0.1, "landing", 90.0), (0.2, "landing", 90.00004)]
    result = {"label": "contact", "periods": 1, "corners_deg": [90.0]}
    found = digest({"events": table("t_s event theta_deg", *rows)}, result)["solved"]
    assert found == {"landings a turn": 2.0}


@pytest.mark.parametrize("words", [24, 25])
def test_twenty_four_different_words_are_counted_one_by_one(words):
    """The commonest of them; how many there are is told where there are more."""
    labels = [f"P({k};1)" for k in range(words) for _ in range(1 if k == 3 else 2)]
    speeds = [(700.0 + k, label, f"s{label}") for k, label in enumerate(labels)]
    found = digest({"speeds": table("rpm label status", *speeds)}, None)["regular"]
    counted = [name for name in found if name.endswith(" speeds")]
    statuses = [name for name in found if name.startswith("speeds.csv status = ")]
    assert len(counted) == len(statuses) == 24
    assert ("speeds.csv P(3;1) speeds" in found) is (words == 24)
    assert found.get("speeds.csv status different") == (25 if words == 25 else None)
    assert found["speeds.csv different labels"] == words


@pytest.mark.parametrize(
    ("group", "was", "now", "told"),
    [
        ("solved", 1.0, 1.0 + 0.9e-8, None),
        ("solved", 1.0, 1.0 + 1.1e-8, False),
        ("solved", 0.0, 0.9e-12, None),
        ("solved", 0.0, 1.1e-12, False),
        ("regular", 1.0, 1.0 + 0.9e-9, True),  # another machine's rounding may do that
        ("regular", 1.0, 1.0 + 1.1e-9, False),
        ("chaotic", 1.0, 2.0, True),
        ("solved", "a", "b", False),
        ("regular", None, 3, False),
        ("regular", 3.5, None, False),
        ("solved", 3.5, "inf", False),
        ("solved", "inf", 3.5, False),
    ],
)
def test_what_has_drifted_and_whether_rounding_explains_it(group, was, now, told):
    old, new = ({g: {} for g in ("regular", "chaotic", "solved")} for _ in range(2))
    if was is not None:
        old[group]["x"] = was
    if now is not None:
        new[group]["x"] = now
    by = now - was if isinstance(was, float) and isinstance(now, float) else None
    wanted = [] if told is None else [Drift("fig", group, "x", was, now, by, *[True] * told)]
    assert list(drifts("fig", old, new)) == wanted


def test_bits_alone_may_be_those_of_another_machine():
    old = {"regular": {"impacts.csv bits": "a"}, "chaotic": {}, "solved": {}}
    new = {"regular": {"impacts.csv bits": "b"}, "chaotic": {}, "solved": {}}
    (found,) = drifts("fig", old, new)
    assert (found.portability, found.by) == (True, None)


def test_a_caption_has_the_numbers_of_its_run():
    values = {"branch.csv 1 rpm": 739.3197802160017, "label": "P(1;inf)", "rows": 3}
    text = "at {branch.csv 1 rpm|.3f} ({branch.csv 1 rpm}) rpm {rows} of {label}"
    assert caption(text, values) == "at 739.320 (739.3197802) rpm 3 of P(1;∞)"
    with pytest.raises(KeyError):
        caption("{lost}", values)
