"""Functions of explore.html that know nothing of the page, without one where node is found."""

import json
import math
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import camcli
from camcli.words.in_print import label_text
from tests.output.test_explore import BROWSER, needs_browser

SCRIPTS = Path(camcli.__file__).parent / "output/explore_page"
NODE = shutil.which("node")


def script(name):
    return (SCRIPTS / f"{name}.js").read_text("utf-8")


def values_of(expressions, source=None):
    """The values of expressions in which functions of a source may stand."""
    asked = f"JSON.stringify([{', '.join(expressions)}])"
    if source is None:
        source = script("numbers") + script("head")
    if NODE is not None:
        words = [NODE, "--input-type=commonjs", "-"]
        told = f"{source}\nconsole.log({asked});"
        done = subprocess.run(words, input=told, capture_output=True, text=True, check=True)
        return json.loads(done.stdout)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        page = chromium.new_page()
        page.add_script_tag(content=source)
        found = page.evaluate(asked)
        chromium.close()
        return json.loads(found)


PLAIN = {
    "kind": "arcs", "valve": False, "crank": 0, "speeds": [760, 660, 401], "lash": None,
    "outline": {"flat": False, "ratio": 1},
    "follower": {"mass": 1.221, "stiffness": 1430.8, "damping": 0, "preload": 0, "gravity": 0,
                 "restitution": 0.8},
}  # fmt: skip
VALVE = {
    "kind": "table", "valve": True, "crank": 2, "speeds": [3000, 4000, 11],
    "lash": 0.00025, "seat": True,
    "outline": {"flat": False, "ratio": 1.5, "told": True},
    "follower": {"mass": 0.12, "stiffness": 40000, "damping": 20, "preload": 250, "gravity": 9.81,
                 "restitution": 0.4, "seat_restitution": 0.3},
}  # fmt: skip
BALL = {
    "kind": "eccentric", "valve": False, "crank": 0, "speeds": [940, 1400, 401], "lash": None,
    "outline": {"flat": True, "ratio": 1},
    "follower": {"mass": 0.01, "stiffness": 0, "damping": 0, "preload": 0, "gravity": 9.81,
                 "restitution": 0.5},
}  # fmt: skip
MACHINES = {"plain": PLAIN, "valve": VALVE, "ball": BALL}


MOTIONS = {
    "hops": {"label": "P(2;2:1)", "symbols": [2, 1], "period": 2, "turns": 2, "loops": True,
             "stable": False, "exponent": -0.12345, "sets": {"follower.mass": 1.5}},
    "rests": {"label": "P(1;inf)", "symbols": ["inf"], "period": 1, "turns": 1, "loops": True,
              "stable": True, "exponent": "-inf", "sets": {}},
    "cut": {"label": "P(3;1:1:1)", "symbols": [1, 1, 1], "period": 3, "turns": 2, "loops": False,
            "stable": None, "exponent": None, "sets": {}},
    "contact": {"label": "contact", "symbols": [], "turns": 1, "stable": None, "sets": {},
                "exponent": 0.0},
    "chaos": {"label": "aperiodic", "symbols": [], "turns": 40, "stable": None, "sets": {},
              "exponent": 0.45678},
    "open": {"label": "undecided", "symbols": [], "turns": 40, "stable": None, "sets": {},
             "exponent": None},
    "started": {"label": "P(1;1)", "symbols": [1], "origin": "start", "q": 0.25, "v": -1.5,
                "sets": {}, "exponent": None},
    "lost": {"label": "undecided", "symbols": [], "origin": "start", "q": 0.25, "v": -1.5,
             "sets": {}, "exponent": None},
}  # fmt: skip
EVENTS = [
    {"kind": "corner-impact", "corner": "b", "classification": "border-period-doubling",
     "label": "P(1;inf)", "rpm": 739.25},
    {"kind": "period-doubling", "corner": "b", "classification": "", "label": "P(1;1)",
     "rpm": 739.25},
]  # fmt: skip


def told_of(machine):
    """An expression: what words.js says on the page of a machine."""
    data = {"measured": "Measured.", **machine, "outline": {"told": False, **machine["outline"]}}
    given = {"motions": MOTIONS, "events": EVENTS}
    return f"""(data => {{
      {script("words")}
      const given = JSON.parse({json.dumps(json.dumps(given))}, (key, value) =>
        value === "inf" ? Infinity : value === "-inf" ? -Infinity : value);
      const of = call => Object.fromEntries(
        Object.entries(given.motions).map(([key, m]) => [key, call(m)]));
      return {{words: of(words), name: of(name), exponent: of(exponentWords),
        short: of(exponent), sources: SOURCES,
        events: given.events.map(eventWords), machine: machineWords(), drawing: drawingWords()}};
    }})({json.dumps(data)})"""


def arrows_and_colours():
    """An expression: arrows of forces.js, and colours that planes.js gives to basins."""
    return f"""(() => {{
      const data = {{follower: {{stiffness: 1}}, planes: []}}, px = String;
      const colours = {{period1: "one", period2: "two", period3: "three", period4: "four"}};
      const pen = {{fillRect() {{}}, getImageData: () => ({{data: pen.fillStyle}})}};
      {script("forces")}
      {script("planes")}
      return [arrowPath(10, 50, 20, 2), arrowPath(10, 50, -20, 2), arrowPath(10, 50, 1.9, 2),
        coloursOfPlane({{of: "start", colours: Array(4).fill("period1")}}, pen)];
    }})()"""


FOLLOWERS = {  # what pulls each of them to its cam
    "spring": [[1, 0, 0], [1, 9.81, 0], [1, 0, 5], [1, 9.81, 5]],
    "weight": [[0, 9.81, 0], [0, 9.81, 5], [0, 0, 0]],
    "preload": [[0, 0, 5]],
}


def words_of_pulls():
    """An expression: the arrow and the sentence of the head for each of FOLLOWERS."""
    return f"""Object.values({json.dumps(FOLLOWERS)}).flat()
      .map(([stiffness, gravity, preload]) => {{
        const data = {{follower: {{stiffness, gravity, preload}}, outline: {{flat: false}}}};
        {script("forces")}
        return [ARROWS.map(({{words}}) => words), introOf(data)];
      }})"""


GAPS = [0, 1e-5, 1.28e-4, 1.29e-4, 1.28e-3, 1.29e-3, 0.0459, 0.0461]  # m


def seen_through_the_lens():
    """An expression: how much the lens enlarges GAPS, ends of followers, and surfaces of 0.05 m.

    A millimetre of the valve is half a pixel: a rocker of 2 : 1 and 1000 px/m.
    """
    return f"""(() => {{
      const TURN = 360, RADIUS_OF_BALL = 12, px = String, camAt = () => [0.05];
      const data = {{outline: {{flat: false, ratio: 2, x: [-0.03, 0, 0.07, 0]}}}}, state = {{}};
      let far = 0;
      const extentOf = () => ({{far}});
      const machine = {{width: 400, height: 300, scale: 1000, size: 1.5, radius: c => c}};
      machine.lens = {{x: 300, ground: 80, times: 10}};
      {script("lens")}
      const times = ["off", "10", "100", "1000", "auto"].map(lens => {{
        state.lens = lens;
        return {json.dumps(GAPS)}.map(gap => {{ far = gap; return enlargement({{}}); }});
      }});
      const radii = [[329, 999], [330, 1]].map(([width, height]) => {{
        Object.assign(machine, {{width, height}});
        return lensRadius();
      }});
      const kinds = [[true, true], [false, true], [false, false]].map(([isBall, flat]) => {{
        machine.isBall = isBall;
        data.outline.flat = flat;
        return [tipInLens(10), surfaceInLens({{phase: 90, c: 0.05}})];
      }});
      return {{times, radii, kinds}};
    }})()"""


PEAK = 10


def peaks_anywhere():
    """An expression: what motion.js and machine.js make of columns that are zero but for a peak.

    The peak is at each row in turn. A mass of 2 kg weighs 14 N and is preloaded by 11 N; of three
    motions of four rows it is the second one. The cam turns by 1 and by 2 rad/s.
    """
    return f"""(() => {{
      const zeros = () => Array(5).fill(0), peak = k => zeros().with(k, {PEAK});
      const follower = {{mass: 2, stiffness: 3, damping: 5, gravity: 7, preload: 11}};
      const data = {{strobe_deg: 0, motions: [], follower, outline: {{x: [3, 0], y: [0, -1]}},
        cam: {{theta_deg: [0, 90, 180, 270, 360], c: zeros(), c1: zeros(), c2: zeros()}},
        rows: {{t: Array(12).fill(0), q: Array(12).fill(0)}}, events: {{}}}};
      const m = {{row: 4, rows: 4, turns: 4, sets: {{}}}}, heavy = {{"follower.mass": 4}};
      const state = {{close: false}};
      {script("motion")}
      {script("machine")}
      const forces = ["c", "c1", "c2"].map(column => [0, 1, 2, 3, 4].map(k => {{
        data.cam[column] = peak(k);
        const all = [[1, {{}}], [2, {{}}], [1, heavy]].map(([omega, sets]) =>
          largestForce({{...m, rpm: omega * 30 / Math.PI, sets}}));
        data.cam[column] = zeros();
        return all;
      }}));
      const heights = () => [positionsOf(m), scaleOf(m, 1e9, 316, lift => lift / 2)];
      const flown = data.rows.q.map((_, k) => {{
        data.rows.q[k] = {PEAK};
        const all = heights();
        data.rows.q[k] = 0;
        return all;
      }});
      const lifted = data.cam.c.map((_, k) => {{
        data.cam.c = peak(k);
        return heights();
      }});
      return {{forces, flown, lifted}};
    }})()"""


LOSSES = [0.1, 0.5, 0.9]


def jumps_by_hand():
    """An expression: jumps of the phase plane at 2 m/s, and that of a hop, which no event tells."""
    velocities = [[-2.0, 2.0 * r] for r in LOSSES] + [[-0.5, 0.25]]
    times = [0.125, 0.25, 0.5, 0.75]
    rows = {
        "t": [0, *np.repeat(times, 2).tolist(), 1],
        "v": [-2.0, *np.ravel(velocities).tolist(), 0.25],
        "q": [0.0] * 10,
        "rest": [0] * 10,
    }
    events = {"t": times[:3], "u": [-2.0] * 3, "kind": [0] * 3}
    cam = {"theta_deg": [0, 360], "c": [0, 0], "c1": [0, 0], "c2": [0, 0]}
    data = {"strobe_deg": 0, "motions": [], "follower": {"restitution": 0.7}, "cam": cam,
            "rows": rows, "events": events}  # fmt: skip
    return f"""(data => {{
      const px = length => length.toFixed(2), phase = {{Y: u => 100 * u}};
      {script("motion")}
      {script("phase")}
      return jumpPath({{row: 0, rows: 10, event: 0, events: 3, rpm: 60, sets: {{}}}}, "7");
    }})({json.dumps(data)})"""


@pytest.fixture(scope="module")
def found():
    """All at once: starting node takes as long as a hundred of these."""
    asked = {
        **{f"fixed {x}": f"fixed({x}, 3)" for x in (-0.0, -0.0004, -0.0006, 12.5)},
        "short": "short(-1234.567890123)",
        "shown": 'shown("P(2;inf:1)")',
        "long": 'shown("P(340;inf:5:5:4:4:5:4:4:4:5:4:5:4:4)")',
        "letters": "[[1280, 800, false], [1280, 800, true], [1920, 1080, false],"
        " [1920, 1080, true], [2560, 1440, true], [390, 844, true]]"
        ".map(size => lettersFor(...size))",
        **{
            f"{name} {what}": f"{what}Of({json.dumps(machine)})"
            for name, machine in MACHINES.items()
            for what in ("title", "intro", "speeds", "constants", "laws", "terms", "speedAxis")
        },
        **{
            f"{name} speed": f"speedOf(3258.47725, {json.dumps(machine)})"
            for name, machine in MACHINES.items()
        },
        **{f"{name} words": told_of(machine) for name, machine in MACHINES.items()},
        "decimals": "[9.99, 10, 99.9, 100, 1e4].map(decimalsOf)",
        "plural": "[plural(1, 'turn'), plural(2, 'turn')]",
        "ticks": "ticksOf(-0.31, 1.22, 6)",
        "few ticks": "[[0, 475, 2], [-0.05, 0.6, 1], [0.91, 1.06, 2]]"
        ".map(ends => ticksOf(...ends))",
        "before": "[0.5, 1, 2.5, 9].map(x => before([1, 2, 2, 3], 0, 4, x))",
        "cubic": "[0, 0.25, 1].map(x => cubic(2, 3, 24, 21, 2, x))",
        "line": "smoothLine(t => [Math.cos(t), Math.sin(t)], 0, 6.283185307179586, 1e-3)",
        "corner": "smoothLine(t => [t, 2 * t], 0, 1, 1e-9).length",
        "far": "[distanceToLine([0, 1], [0, 0], [2, 0]), distanceToLine([3, 0], [0, 0], [2, 0])]",
        "decoded": 'decoded({a: {f4: "AACAPwAAAMA="}, b: [{u1: "AQ=="}, "inf"]}).a[1]',
        "drawn": arrows_and_colours(),
        "pulls": words_of_pulls(),
        "lens": seen_through_the_lens(),
        "peaks": peaks_anywhere(),
        "jumps": jumps_by_hand(),
        "lengths": "[lengths(0.05).factor, lengths(0.2).factor]",
    }
    if NODE is None and needs_browser.args[0]:
        pytest.skip("neither node nor a browser is here")
    return dict(zip(asked, values_of(asked.values()), strict=True))


def test_numbers_in_print(found):
    assert found["fixed -0.0"] == found["fixed -0.0004"] == "0.000"  # no zero with a minus
    assert found["fixed -0.0006"] == "−0.001"
    assert found["fixed 12.5"] == "12.500"
    assert found["short"] == "−1234.56789"
    assert found["shown"] == "P(2;∞:1)"
    assert found["plural"] == ["1 turn", "2 turns"]
    assert found["lengths"] == [1000, 1]


def test_numbers_of_one_cell_have_about_as_many_digits(found):
    assert found["decimals"] == [3, 2, 2, 1, 1]


def test_a_speed_is_told_of_both_shafts_where_there_is_a_crank(found):
    assert found["plain speed"] == "3258.47725 rpm"
    assert found["valve speed"] == "3258.47725 rpm of the cam, 6516.95 of the crank"
    assert found["plain speedAxis"] == "speed (rpm)"
    assert found["valve speedAxis"] == "camshaft speed (rpm); the crank turns 2× as fast"


def test_ticks_are_round_and_inside(found):
    values = [value for value, _ in found["ticks"]]
    assert values == pytest.approx([0, 0.5, 1.0])
    assert [text for _, text in found["ticks"]] == ["0.0", "0.5", "1.0"]


def test_an_axis_has_two_numbers_at_least_however_low_it_is(found):
    """One of a step of 500 alone does not tell how long a newton is."""
    forces, exponents, lifts = ([text for _, text in ticks] for ticks in found["few ticks"])
    assert forces == ["0", "200", "400"]
    assert exponents == ["0.0", "0.5"]
    assert lifts == ["0.95", "1.00", "1.05"]


def test_an_arrow_points_the_way_of_its_force_and_attractors_of_one_period_differ(found):
    """A shaft of 2 px to a head of 2.4 times that length, which is 1.4 times its length wide."""
    up, down, dot, colours = found["drawn"]
    for path, tip, neck in ((up, 30.0, 34.8), (down, 70.0, 65.2)):
        corners = [float(x) for x in re.findall(r"[\d.]+", path)]
        wanted = [9, 50, neck, 10 - 3.36, 10, tip, 10 + 3.36, neck, 11, 50]
        assert corners == pytest.approx(wanted)
    assert dot == ""
    assert sorted(colours) == ["four", "one", "three", "two"]


def test_an_arrow_and_the_head_name_what_pulls_the_follower(found):
    """A spring, where there is one; a preload alone is no weight."""
    wanted = [kind for kind, followers in FOLLOWERS.items() for _ in followers]
    pulls = {"spring": "A spring", "weight": "Its weight", "preload": "A preload"}
    assert found["pulls"] == [
        [
            [kind, "contact", "inertia −m·a"],
            f"{pulls[kind]} holds the follower on a turning cam. Too fast, and it flies, lands and "
            "bounces.",
        ]
        for kind in wanted
    ]


def test_the_lens_enlarges_what_is_small_or_as_it_is_asked(found):
    """By itself a gap up to 1.4 radii, or half a radius before it; by hand whatever the motion."""
    by_hand = [[times] * len(GAPS) for times in (0, 10, 100, 1000)]
    assert found["lens"]["times"] == [*by_hand, [0, 1000, 1000, 100, 100, 10, 10, 0]]
    assert found["lens"]["radii"] == [36, 46]  # by the width of the drawing


def test_the_lens_shows_ends_and_surfaces_as_they_are(found):
    """A ball of 12 px is a circle of 12 x 1.5 x 10 px; a surface of 0.05 m bends by 500 px."""
    (ball, table), (_, disk), (edge, lobe) = found["lens"]["kinds"]
    half = "A180 180 0 0 0"
    assert ball == f"M0 0{half} 0 -360{half} 0 0Z"
    assert edge == "M0 0L-24 -40V-120H24V-40Z"
    for path, is_level in ((table, True), (disk, False), (lobe, False)):
        surface, _, rest = path.partition("V")
        x, y = np.array([place.split() for place in surface[1:].split("L")], float).T
        assert rest == "218H244.8Z"
        assert len(x) == 25
        assert x[[0, 12, -1]] == pytest.approx([249.4, 300.0, 350.6], abs=0.1)
        if is_level:
            assert np.all(y == 80.0)
        else:
            assert np.hypot(x - 300.0, y - 580.0) == pytest.approx(500.0, abs=0.01)


def test_the_largest_force_and_lift_are_found_wherever_they_are(found):
    """25 N of weight and preload, and of the spring, the damper and the inertia what 10 makes."""
    lifted, damped, bent = found["peaks"]["forces"]
    assert lifted == [[25 + 30, 25 + 30, 39 + 30]] * 5
    assert damped == [pytest.approx([25 + 50, 25 + 100, 39 + 50])] * 5
    assert bent == [pytest.approx([25 + 20, 25 + 80, 39 + 40])] * 5
    level, high = [[0, 0], 300 / (3 + 3)], [[0, PEAK], 300 / (3 + PEAK / 2)]
    assert found["peaks"]["flown"] == [level] * 4 + [high] * 4 + [level] * 4
    assert found["peaks"]["lifted"] == [high] * 5


def test_each_jump_of_the_phase_plane_ends_by_its_own_restitution(found):
    impacts = "".join(f"M7 -200.00V{200 * r:.2f}" for r in LOSSES)
    assert found["jumps"] == f"{impacts}M7 -50.00V25.00"


def test_the_row_before_a_time(found):
    assert found["before"] == [0, 0, 2, 3]


def test_a_cubic_goes_through_a_cubic(found):
    """2 + 3 s + 3 s^2 + s^3/2, which has 24 and the slope 21 at s = 2."""
    for share, pair in zip((0.0, 0.25, 1.0), found["cubic"], strict=True):
        s = 2.0 * share
        assert pair == pytest.approx([2 + 3 * s + 3 * s**2 + 0.5 * s**3, 3 + 6 * s + 1.5 * s**2])


def test_a_line_is_as_near_to_its_curve_as_asked(found):
    """Around the unit circle: the chords' middles are within 1e-3 of it, with few points."""
    points = np.array(found["line"])
    middles = 0.5 * (points[1:] + points[:-1])
    assert np.abs(1.0 - np.hypot(*middles.T)).max() < 1e-3
    assert len(points) < 4 * math.pi / math.sqrt(8e-3) * 2
    assert found["corner"] == 9  # a straight line is not halved any further
    assert found["far"] == pytest.approx([1.0, 1.0])
    assert found["decoded"] == -2.0


def test_a_long_label_is_cut_as_in_print(found):
    """A motion of 340 turns had a button wider than the page."""
    label = "P(340;inf:5:5:4:4:5:4:4:4:5:4:5:4:4)"
    assert found["long"] == label_text(label) == "P(340;∞:5:5:4:4:5:4:4:4:5:4:5…)"


def test_letters_grow_with_the_window_and_more_for_a_room(found):
    laptop, in_room, desk, on_wall, large, phone = found["letters"]
    assert laptop == phone == 1
    assert 1 < in_room < 1.2 < desk + 1e-9
    assert desk == pytest.approx(1.2)  # 1080 / 900
    assert on_wall == pytest.approx(1080 / 690)
    assert large == pytest.approx(1440 / 690)


def test_the_head_names_every_constant_that_acts(found):
    assert found["plain constants"] == [
        "cam of circular arcs", "mass m 1.221 kg", "spring k 1430.8 N/m", "restitution r 0.8",
    ]  # fmt: skip
    assert found["valve constants"] == [
        "measured cam", "mass m 0.12 kg", "spring k 40 N/mm", "damping b 20 N s/m",
        "preload F₀ 250 N", "gravity g 9.81 m/s²", "restitution r 0.4", "on the seat 0.3",
        "lash 0.25 mm", "rocker 1.5 : 1",
    ]  # fmt: skip
    assert found["ball constants"] == [
        "eccentric cam", "mass m 0.01 kg", "gravity g 9.81 m/s²", "restitution r 0.5",
    ]  # fmt: skip
    titles = [found[f"{name} title"] for name in MACHINES]
    assert titles == [
        "A follower on its cam, in motion", "A valve train in motion", "A ball on a moving table",
    ]  # fmt: skip


def test_the_head_has_the_laws_of_this_machine(found):
    """m q'' + b q' + k q = -m g - F0 in flight; the contact force is above zero on the cam."""
    flights = {
        "plain": "m q″ + k q = 0",
        "valve": "m q″ + b q′ + k q = −m g − F₀",
        "ball": "m q″ = −m g",
    }
    pushes = {
        "plain": "m c″ + k c > 0",
        "valve": "m c″ + b c′ + k c + m g + F₀ > 0",
        "ball": "m c″ + m g > 0",
    }
    for name in MACHINES:
        laws = {law: text.replace("\xa0", " ") for law, text in found[f"{name} laws"].items()}
        assert laws == {
            "flight": flights[name],
            "rest": f"q = c, {pushes[name]}",
            "impact": "u⁺ = −r u⁻, u = q′ − c′",
        }
        assert pushes[name][:-4].replace(" ", "\xa0") in found[f"{name} laws"]["rest"]


def test_the_head_calls_the_parts_by_their_names(found):
    cam = {"gap": "gap q − c", "flies": "in flight", "pathOfFlight": "path in flight",
           "speed": "speed (rpm)"}  # fmt: skip
    assert found["plain terms"] == {
        "follower": "follower", "position": "position of follower and cam",
        "short": "follower, cam", "rests": "on the cam", **cam,
    }  # fmt: skip
    assert found["ball terms"] == {
        "follower": "ball", "position": "position of ball and table", "short": "ball, table",
        "rests": "on the table", **cam,
    }  # fmt: skip
    assert found["valve terms"] == {
        "follower": "valve train", "position": "lift of valve train and cam",
        "short": "valve train, cam", "gap": "gap", "rests": "on cam or seat", "flies": "floating",
        "pathOfFlight": "path while floating", "speed": "camshaft speed (rpm)",
    }  # fmt: skip
    assert found["plain intro"] == (
        "A spring holds the follower on a turning cam. Too fast, and it flies, lands and bounces."
    )
    assert found["valve intro"] == (
        "A cam opens a valve against its spring. Too fast, and the valve floats, lands and bounces."
    )
    assert found["ball intro"] == (
        "A ball lies on a shaking table. Too fast, and the ball flies, lands and bounces."
    )


def test_what_the_page_says_of_motions_and_events(found):
    plain, valve, ball = (found[f"{name} words"] for name in MACHINES)
    start = "from q = 0.25 m, v = −1.5 m/s at the strobe; it ends up "
    assert plain["words"] == {
        "hops": "with follower.mass = 1.5, it repeats after 2 turns, with 3 impacts; any real "
        "machine leaves it",
        "rests": "it repeats every turn; impacts accumulate, then it rests",
        "cut": "it repeats after 3 turns, with 3 impacts; 2 turns shown",
        "contact": "the follower is always on the cam",
        "chaos": "it never repeats; 40 turns shown",
        "open": "the record does not tell what it is",
        "started": f"{start}on P(1;1)",
        "lost": f"{start}undecided",
    }
    assert valve["words"]["contact"] == "the valve train is always on cam or seat"
    assert ball["words"]["contact"] == "the ball is always on the table"
    assert [plain["name"][key] for key in ("hops", "rests")] == ["P(2;2:1), unstable", "P(1;∞)"]
    assert plain["exponent"] == {
        "hops": "Lyapunov exponent −0.123 per turn: differences fade",
        "rests": "Lyapunov exponent −∞: differences vanish",
        "contact": "Lyapunov exponent 0.000 per turn: differences fade",
        "chaos": "Lyapunov exponent 0.457 per turn: differences grow",
        **dict.fromkeys(("cut", "open", "started", "lost"), ""),
    }
    assert {key: text for key, text in plain["short"].items() if text} == {
        "hops": "Lyapunov exponent −0.123 per turn",
        "rests": "Lyapunov exponent −∞",
        "contact": "Lyapunov exponent 0.000 per turn",
        "chaos": "Lyapunov exponent 0.457 per turn",
    }
    assert {key: text for key, text in plain["sources"].items() if text} == {
        "up": "found on the way up", "down": "found on the way down", "solved": "a solved orbit",
    }  # fmt: skip
    corner, doubling = (text.replace("\xa0", " ") for text in plain["events"])
    assert corner == "corner impact at b of P(1;∞) at 739.25 rpm (border period doubling)"
    assert doubling == "period doubling of P(1;1) at 739.25 rpm"
    constants = ", ".join(found["plain constants"])
    assert plain["machine"] == f"660 to 760 rpm; {constants}. Measured."


def test_the_page_says_how_its_cam_is_drawn(found):
    assert found["plain words"]["drawing"] == (
        "The cam is drawn under a knife edge, with a base radius chosen for the drawing: the scene "
        "has none."
    )
    assert found["valve words"]["drawing"] == (
        "The cam is drawn to scale, under a knife edge. It is the lobe under a rocker: what runs "
        "on it is drawn with lifts and gaps 1.5 times smaller than those of the valve."
    )
    assert found["ball words"]["drawing"] == (
        "The cam is drawn as an eccentric circle under a flat face; its radius is only that of the "
        "drawing."
    )


def test_speeds_are_told_of_both_shafts_where_there_is_a_crank(found):
    assert found["plain speeds"] == "660 to 760 rpm"
    assert found["valve speeds"] == "3000 to 4000 rpm of the cam, 6000 to 8000 of the crank"
