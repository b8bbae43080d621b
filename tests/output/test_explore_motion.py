"""What explore.html knows of a motion at any time against trajectory.csv: without a browser."""

import json
import re

import numpy as np
import pytest

import camcli
from tests.output.test_explore import FEW, decoded, some_motions
from tests.output.test_explore_numbers import NODE, script, values_of

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(NODE is None, reason="the page's scripts do not run here: needs node"),
]
LASH = {"cam.lash": 2e-4, "follower.seat_restitution": 0.3}
SCENES = {
    "chapter at 190 rpm": (None, {"sweep.rpm": {"start": 189, "stop": 190, "num": 2}}),
    "chapter at 758 rpm": (None, {"sweep.rpm": {"start": 757, "stop": 758, "num": 2}}),
    "valve-train with lash": (
        "configs/valve-train.yaml",
        {"sweep.rpm": {"start": 3300, "stop": 3400, "num": 2}, "orbits.at": 3300, **LASH},
    ),
}  # fmt: skip
WIDTH, HEIGHT = 500.0, 400.0  # px, of a phase plane


@pytest.mark.parametrize(
    "name",
    [
        "chapter at 190 rpm",
        pytest.param("chapter at 758 rpm", marks=pytest.mark.ci),
        "valve-train with lash",
    ],
)
def test_a_motion_at_any_time_and_in_the_phase_plane_is_that_of_the_trajectory(
    name, request, tmp_path
):
    file, values = SCENES[name]
    path = None if file is None else str(request.config.rootpath / file)
    more = {**FEW, "orbits.starts": 0, "run.record": 20, **values}
    camcli.explore(camcli.load_scene(path, more)).save(tmp_path)
    text = re.search(
        r'<script id="data" type="application/json">(.*?)</script>',
        (tmp_path / "explore.html").read_text(),
        re.DOTALL,
    )[1]
    data = decoded(json.loads(text))
    machine = {key: value for key, value in values.items() if key in LASH}
    asked, wanted = [], []
    for number in some_motions(data):
        motion = data["motions"][number]
        start = {"q": motion["q"], "v": motion["v"], "theta_deg": data["strobe_deg"]}
        run = {"run.rpm": motion["rpm"], "run.start": start, "run.transient": 0}
        run |= {"run.record": motion["turns"], "simulate.samples": 180, **machine}
        table = camcli.simulate(camcli.load_scene(path, run)).tables["trajectory"]
        inner = slice(1, -1)  # the ends belong to two turns
        table = {key: column[inner] for key, column in table.items()}
        table["gap"] = table["q_m"] - table["c_m"]
        table["u"] = table["v_m_per_s"] - table["c_dot_m_per_s"]
        table["pixels"] = [
            WIDTH / max(table["gap"].max(), 1e-9), HEIGHT / max(np.ptp(table["u"]), 1e-9)
        ]  # fmt: skip
        right, up = table["pixels"]
        times = (table["t_s"] * motion["rpm"] / 60.0).tolist()
        asked += [
            f"{times}.map(t => at(motions[{number}], t))"
            ".map(one => [one.q, one.gap, one.u, Number(one.rests), one.force])",
            f"flightLines(motions[{number}], (gap, u) => [{right} * gap, {up} * u], 0.1)",
            f"(phase = {{Y: u => {up} * u}}, jumpPath(motions[{number}], 0))",
        ]
        wanted.append(table)
    source = f"{script('numbers')}\nconst data = decoded({text});\n{script('motion')}"
    source += f"\nlet phase; const px = String;\n{script('phase')}"
    found = values_of(asked, source)
    flown = impacts = 0
    losses = [data["follower"].get(key) for key in ("restitution", "seat_restitution")]
    restitutions = [r for r in losses if r is not None]
    for table, states, lines, jumps in zip(wanted, *(found[k::3] for k in range(3)), strict=True):
        q, gap, u, rests, force = np.array(states).T
        size = np.ptp(table["q_m"])
        assert np.abs(q - table["q_m"]).max() < size / 2000
        away = table["gap"] > 1e-3 * table["gap"].max()  # impacts are two rows: before and after
        flies = (table["contact"] == "flight") & away
        assert not rests[flies].any()
        assert np.all(force[flies] == 0.0)
        if not flies.any():
            continue
        drawn = np.array([gap, u]).T[flies] * table["pixels"]
        true = np.array([table["gap"], table["u"]]).T[flies] * table["pixels"]
        assert np.hypot(*(drawn - true).T).max() < 0.5
        assert distance(lines, true).max() < 0.5
        flown += len(true)
        struck = np.flatnonzero((np.diff(table["t_s"]) == 0.0) & (np.abs(np.diff(table["u"])) > 0))
        ends = np.array(
            [[table["pixels"][1] * table["u"][n] for n in (k, k + 1)] for k in struck]
        ).reshape(-1, 2)
        marks = np.array([line.split()[1].split("V") for line in jumps.split("M")[1:]], float)
        assert len(marks) >= len(struck)  # and hops of a chatter, which no row tells
        impacts += len(struck)
        before, after = marks.T  # whichever it is: on the cam, or on the seat of a valve
        errors = [np.abs(after + r * before) for r in restitutions]
        assert np.min(errors, axis=0).max() < 0.5
        for end in ends:
            assert np.hypot(*(marks.reshape(-1, 2) - end).T).min() < 0.5
    assert flown > 50
    assert impacts > 3


def distance(lines, points):
    """Pixels from each point to the nearest of the lines."""
    far = np.full(len(points), np.inf)
    for line in lines:
        corners = np.array(line)
        starts, along = corners[:-1], np.diff(corners, axis=0)
        square = np.maximum((along**2).sum(axis=1), 1e-30)
        between = points[:, None] - starts
        share = np.clip((between * along).sum(axis=2) / square, 0.0, 1.0)
        away = between - share[:, :, None] * along
        far = np.minimum(far, np.hypot(*away.T).T.min(axis=1))
    return far
