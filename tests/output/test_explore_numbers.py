"""Functions of explore.html that know nothing of the page, without one where node is found."""

import json
import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import camcli
from tests.output.test_explore import BROWSER, needs_browser

SCRIPT = Path(camcli.__file__).parent / "output/explore_page/numbers.js"
NODE = shutil.which("node")


def values_of(expressions):
    """The values of expressions in which the functions of numbers.js may stand."""
    asked = f"JSON.stringify([{', '.join(expressions)}])"
    source = SCRIPT.read_text("utf-8")
    if NODE is not None:
        words = [NODE, "--input-type=commonjs", "-e", f"{source}\nconsole.log({asked});"]
        done = subprocess.run(words, capture_output=True, text=True, check=True)
        return json.loads(done.stdout)
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        page = chromium.new_page()
        page.add_script_tag(content=source)
        found = page.evaluate(asked)
        chromium.close()
        return json.loads(found)


@pytest.fixture(scope="module")
def found():
    """All at once: starting node takes as long as a hundred of these."""
    asked = {
        **{f"fixed {x}": f"fixed({x}, 3)" for x in (-0.0, -0.0004, -0.0006, 12.5)},
        "short": "short(-1234.567890123)",
        "shown": 'shown("P(2;inf:1)")',
        "plural": "[plural(1, 'turn'), plural(2, 'turn')]",
        "ticks": "ticksOf(-0.31, 1.22, 6)",
        "before": "[0.5, 1, 2.5, 9].map(x => before([1, 2, 2, 3], 0, 4, x))",
        "cubic": "[0, 0.25, 1].map(x => cubic(2, 3, 24, 21, 2, x))",
        "line": "smoothLine(t => [Math.cos(t), Math.sin(t)], 0, 6.283185307179586, 1e-3)",
        "corner": "smoothLine(t => [t, 2 * t], 0, 1, 1e-9).length",
        "far": "[distanceToLine([0, 1], [0, 0], [2, 0]), distanceToLine([3, 0], [0, 0], [2, 0])]",
        "decoded": 'decoded({a: {f4: "AACAPwAAAMA="}, b: [{u1: "AQ=="}, "inf"]}).a[1]',
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


def test_ticks_are_round_and_inside(found):
    values = [value for value, _ in found["ticks"]]
    assert values == pytest.approx([0, 0.5, 1.0])
    assert [text for _, text in found["ticks"]] == ["0.0", "0.5", "1.0"]


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
