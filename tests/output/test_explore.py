"""explore.html holds what `cam simulate` writes, and in a browser it shows just that."""

import json
import re
import shlex
import shutil
from base64 import b64decode
from html.parser import HTMLParser
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

import camcli
from camcli.analysis.simulate import Happening
from camcli.api.explore_page import _hops
from camcli.api.explore_page import page as text_of_page
from camcli.api.machine import machine_of
from camcli.scene import load_scene
from tests.cli.test_whole_faults import LAW
from tests.conftest import cam_in

pytestmark = pytest.mark.slow
FEW = {"sweep.rpm.num": 11, "run.transient": 300, "run.record": 60, "orbits.starts": 6}
MASSES = [{"key": "follower.mass", "start": 1.1, "stop": 1.3, "num": 3}]
SCENES = {
    "chapter": (None, {"basins.cells": [40, 40], "sweep.vary": MASSES}),
    "valve-train": (
        "configs/valve-train.yaml",
        {"sweep.rpm.start": 3200, "sweep.rpm.stop": 3400, "orbits.at": 3300},
    ),
    "bouncing-ball": ("configs/bouncing-ball.yaml", {}),  # chaos and rests without a spring
}  # fmt: skip


# machines of the tests of gestures, which are the same for a ball
GESTURES = pytest.mark.parametrize(
    "made",
    ["chapter", "valve-train", pytest.param("bouncing-ball", marks=pytest.mark.soak)],
    indirect=True,
    scope="module",
)


@pytest.fixture(scope="module", params=SCENES)
def made(request, tmp_path_factory):
    """The scene, the folder of its page, and the data in it."""
    file, values = SCENES[request.param]
    path = None if file is None else str(request.config.rootpath / file)
    scene = camcli.load_scene(path, {**FEW, **values})
    source = "" if path is None else shlex.join(["-c", path])
    folder = tmp_path_factory.mktemp(request.param)
    planes = {"with_basins": file is None, "with_map": file is None}
    camcli.explore(scene, source=source, **planes).save(folder)
    return scene, folder, data_of(folder)


def data_of(folder):
    text = (folder / "explore.html").read_text()
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', text, re.DOTALL)
    return decoded(json.loads(found[1]))


def decoded(value):
    if isinstance(value, list):
        return [decoded(one) for one in value]
    if isinstance(value, dict) and value and value.keys() <= {"f4", "u1"}:
        ((kind, text),) = value.items()
        return np.frombuffer(b64decode(text), f"<{kind}")
    return {k: decoded(v) for k, v in value.items()} if isinstance(value, dict) else value


def rows_of(data, number):
    """The rows of one motion: t, q, v and rest."""
    first = sum(m["rows"] for m in data["motions"][:number])
    some = slice(first, first + data["motions"][number]["rows"])
    return {name: column[some] for name, column in data["rows"].items()}


def command_of(data, motion):
    """The arguments of the command that the page shows for a motion."""
    start = {"q": motion["q"], "v": motion["v"], "theta_deg": data["strobe_deg"]}
    text = json.dumps(start).replace('"', "")
    sets = [word for key, value in motion["sets"].items() for word in ("--set", f"{key}={value}")]
    return [
        "simulate", *shlex.split(data["source"]), "--rpm", repr(motion["rpm"]), *sets,
        "--set", "run.transient=0", "--set", f"run.record={motion['turns']}",
        "--set", f"'run.start={text}'", "--no-plot",
    ]  # fmt: skip


def some_motions(data):
    """The first motion of each label and origin."""
    return {
        (m["label"], m["origin"], m["stable"]): k for k, m in enumerate(data["motions"])
    }.values()


@pytest.fixture(scope="module")
def tables(made, tmp_path_factory):
    """What `cam simulate` writes into trajectory.csv for some motions of the page, by number."""
    _, _, data = made
    found = {}
    for number in some_motions(data):
        folder = tmp_path_factory.mktemp("trajectory")
        command = command_of(data, data["motions"][number])
        done = cam_in(folder, *command, "--set simulate.samples=720 -o here")
        assert done.returncode in (0, 3), done.stderr
        path = folder / "here" / "trajectory.csv"
        found[number] = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8")
    return found


def test_the_page_is_one_small_file_that_asks_for_nothing(made):
    _, folder, _ = made
    text = (folder / "explore.html").read_text()
    assert sorted(path.name for path in folder.iterdir()) == ["explore.html", "run.json"]
    assert len(text) < 8e6
    tags = Tags(text)
    assert not {tag for tag, _ in tags.found} & {"img", "iframe", "object"}
    links = [a["href"] for _, a in tags.found if {"src", "href"} & a.keys()]
    (icon,) = (link for link in links if link[0] != "#")
    assert icon.startswith("data:image/svg+xml,")
    code = re.sub(r"""["']http://www.w3.org/2000/svg["']""", "", text)
    assert not re.search(r"https?://|fetch\(|XMLHttp|@import|url\((?!#)", code)


def test_every_script_of_the_page_is_in_it_and_no_place_is_left_open():
    folder = Path(camcli.__file__).parent / "output/explore_page"
    whole = text_of_page({})
    scripts = sorted(folder.glob("*.js"))
    assert len(scripts) > 5
    for file in (*scripts, folder / "style.css"):
        lines = file.read_text(encoding="utf-8").strip().splitlines()
        assert "\n".join(lines[2:]) in whole, file.name
    assert not re.search(r"/\*[A-Z]+\*/", whole)


def test_no_name_of_the_scripts_is_given_twice():
    """They are one script on the page: of two functions with one name the second would win."""
    folder = Path(camcli.__file__).parent / "output/explore_page"
    given = re.compile(r"^(?:async )?(?:function\*?|const|let|class) ([A-Za-z_]\w*)", re.M)
    names = [name for file in folder.glob("*.js") for name in given.findall(file.read_text())]
    assert len(names) > 100
    assert sorted(names) == sorted(set(names))


class Tags(HTMLParser):
    """Every element with its attributes."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))


def test_everything_that_can_be_used_has_a_name_and_a_unique_id(made):
    _, folder, _ = made
    tags = Tags((folder / "explore.html").read_text()).found
    ids = [a["id"] for _, a in tags if "id" in a]
    assert len(ids) == len(set(ids))
    named = {"aria-label", "aria-labelledby"}
    assert all(named & a.keys() for _, a in tags if "role" in a and a["role"] != "presentation")
    labels = [
        a[key] for _, a in tags for key in ("aria-labelledby", "aria-describedby") if key in a
    ]
    assert set(labels) <= set(ids)


def test_the_position_between_two_rows_is_that_of_trajectory_csv(made, tables):
    _, _, data = made
    for number, table in tables.items():
        motion, rows = data["motions"][number], rows_of(data, number)
        q = shown(rows, motion["rpm"], table["t_s"] * motion["rpm"] / 60.0, table["c_m"])
        room = max(table["q_m"].max(), data["cam"]["c"].max()) - min(data["cam"]["c"])
        assert np.abs(q - table["q_m"]).max() < room / 2000, (motion["label"], motion["rpm"])


def shown(rows, rpm, t, c):
    """What the page shows: the cubic through two rows, and the cam where the follower rests."""
    k = np.searchsorted(rows["t"], t.astype(np.float32), side="right") - 1
    k = np.minimum(k, len(rows["t"]) - 2)
    h = (rows["t"][k + 1] - rows["t"][k]).astype(float)
    x = np.divide(t - rows["t"][k], h, out=np.zeros_like(h), where=h > 0)
    start, end = (rows["v"][n] * h * 60.0 / rpm for n in (k, k + 1))
    rise = rows["q"][k + 1] - rows["q"][k]
    bend = 3 * rise - 2 * start - end
    q = rows["q"][k] + x * (start + x * (bend + x * (start + end - 2 * rise)))
    return np.where(rows["rest"][k], c, q)


def test_a_motion_that_repeats_ends_where_it_begins(made):
    _, _, data = made
    loops = [k for k, m in enumerate(data["motions"]) if m["loops"]]
    assert len(loops) > 5
    for number in loops:
        rows = rows_of(data, number)
        room = np.abs(data["cam"]["c"]).max()
        assert abs(rows["q"][-1] - rows["q"][0]) < 1e-3 * room, data["motions"][number]


def test_attractors_beside_each_other_and_unstable_orbits_are_there(made):
    scene, _, data = made
    by_speed = {}
    for m in data["motions"]:
        by_speed.setdefault(m["rpm"], set()).add((m["label"], m["origin"]))
    if scene.cam.kind == "arcs":
        assert {("P(1;1)", "down")} & by_speed[680.0]
        assert ("aperiodic", "fixed") in by_speed[680.0]
        kinds = [event["kind"] for event in data["bifurcations"]]
        assert kinds == ["corner-impact", "period-doubling", "corner-impact"]
    if scene.cam.kind != "law":
        assert any(m["stable"] is False for m in data["motions"])


def test_the_contact_force_is_that_of_the_profile(made):
    scene, _, data = made
    rpm = scene.run.rpm
    wanted = camcli.simulate(scene, profile_only=True).tables["profile"]
    omega, cam_, f = rpm * np.pi / 30.0, data["cam"], data["follower"]
    force = f["mass"] * f["gravity"] + f["preload"] + f["stiffness"] * cam_["c"]
    force += omega * (f["damping"] * cam_["c1"] + omega * f["mass"] * cam_["c2"])
    at = np.searchsorted(cam_["theta_deg"], wanted["theta_deg"].astype(np.float32) - 1e-4)
    smooth = np.append(np.diff(wanted["theta_deg"]) > 0, True) & np.insert(
        np.diff(wanted["theta_deg"]) > 0, 0, True
    )
    error = np.abs(force[at] - wanted["force_n"])[smooth]
    assert error.max() < 1e-5 * np.abs(wanted["force_n"]).max()


BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
needs_browser = pytest.mark.skipif(
    BROWSER is None or find_spec("playwright") is None,
    reason="the page is not used in a browser here: needs chromium and the package playwright",
)


@pytest.fixture(scope="module")
def chromium():
    """A browser without a window; starting it takes longer than most of what is done in it."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def window(chromium):
    """A window for one page after the other: to open one costs more than to load a page."""
    window = chromium.new_page(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
    yield window, watched(window)
    window.close()


def watched(window):
    """A list of all that the pages of a window complain of or ask for."""
    complaints = []
    window.on("console", lambda said: complaints.append(said.text))
    window.on("pageerror", lambda error: complaints.append(str(error)))
    window.on("request", lambda asked: complaints.append(asked.url) if fetched(asked) else None)
    return complaints


@pytest.fixture
def browser(window):
    """Opens a page in the window; all that it complains of or asks for is a failure."""
    page, complaints = window

    def open_page(folder, fragment=""):
        page.goto("about:blank")  # else another fragment would not load it anew
        page.goto(f"file://{folder / 'explore.html'}{fragment}")
        return page

    yield open_page
    assert not complaints


@pytest.fixture
def page(made, window):
    """The page, for what does not change it, or sets all that it looks at."""
    page, complaints = window
    _, folder, _ = made
    if str(folder) not in page.url:
        page.goto(f"file://{folder / 'explore.html'}#rpm=1&t=0")
    yield page
    assert not complaints


def fetched(request):
    return (
        not request.url.startswith(("file:", "blob:", "data:")) or "explore.html" not in request.url
    )


def said(page):
    return page.inner_text("#said")


@pytest.mark.browser
@needs_browser
def test_what_is_drawn_is_the_row_of_trajectory_csv(made, tables, page):
    _, _, data = made
    body = data["outline"]
    for number, table in tables.items():
        motion = data["motions"][number]
        page.evaluate("number => choose(motions[number])", number)
        some = table[:: max(1, len(table) // 40)]
        drawn = page.evaluate(
            """all => all.map(turns => {
              state.t = turns; drawNow();
              const y = node => node.transform.baseVal[0].matrix.f;
              return [y(machine.follower), machine.y, machine.scale,
                      Number(time.dot.getAttribute("cy")), time.upper.Y(1), time.upper.Y(0),
                      time.factor, machine.cam.transform.baseVal[1].angle];
            })""",
            (some["t_s"] * motion["rpm"] / 60.0).tolist(),
        )
        for row, places in zip(some, drawn, strict=True):
            follower, axis, scale, dot, one, zero, factor, angle = places
            tip = row["q_m"] / body["ratio"] + body["rise"]
            assert abs(follower - (axis - tip * scale)) < 0.5, motion
            assert abs(dot - (zero + (one - zero) * row["q_m"] * factor)) < 0.5, motion
            assert abs((angle + row["theta_deg"] + 180) % 360 - 180) < 0.01, motion


@pytest.mark.browser
@needs_browser
def test_a_chatter_is_told_as_one_and_other_impacts_are_counted(made, page):
    _, _, data = made
    told = page.evaluate("motions.map(words)")
    assert not [text for text in told if "Infinity" in text or "NaN" in text]
    for motion, text in zip(data["motions"], told, strict=True):
        if motion["origin"] == "start" or not motion["symbols"]:
            continue
        if "inf" in motion["symbols"]:
            assert "impacts accumulate" in text
        else:
            count = int(sum(motion["symbols"]))
            assert f"with {count} impact{'' if count == 1 else 's'}" in text


@pytest.mark.browser
@needs_browser
def test_a_motion_has_one_button_though_neighbouring_speeds_have_it_too(made, page):
    _, _, data = made
    offered = page.evaluate("motions.map(m => motionsAt(m).map(o => [o.label, o.stable, o.rpm]))")
    for motion, buttons in zip(data["motions"], offered, strict=True):
        speeds: dict[tuple, set] = {}
        for label, stable, rpm in buttons:
            speeds.setdefault((label, stable), set()).add(rpm)
        assert all(len(rpms) == 1 for rpms in speeds.values()), motion
    assert all(
        [motion["label"], motion["stable"], motion["rpm"]] in buttons
        for motion, buttons in zip(data["motions"], offered, strict=True)
        if buttons
    )


SEEN = """[state.motion.number, state.t.toFixed(5), state.x.map(x => x.toFixed(4)),
  $("command").textContent, $("said").textContent, state.playing]"""


@GESTURES
@pytest.mark.browser
@needs_browser
def test_hover_click_keys_zoom_and_links(made, browser):
    scene, folder, data = made
    page = browser(folder)
    page.locator("#diagram").scroll_into_view_if_needed()
    box = page.locator("#diagram").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 3)
    speed_told = "of the crank:" if data["crank"] else "rpm:"
    assert speed_told in page.inner_text("#hint")
    page.mouse.click(box["x"] + 0.3 * box["width"], box["y"] + box["height"] / 3)
    assert "computed, nearest to" in said(page)
    before = page.evaluate("state.motion.rpm")
    page.focus("#diagram")
    page.keyboard.press("ArrowRight")
    span = scene.sweep.rpm
    step = (span.stop - span.start) / (span.num - 1)
    assert 0 < page.evaluate("state.motion.rpm") - before < 1.01 * step
    page.keyboard.press("Space")
    page.keyboard.press("Space")
    whole = page.evaluate("state.x")
    page.keyboard.press("+")
    page.wait_for_function("wide => state.x[1] - state.x[0] < 0.7 * wide", arg=whole[1] - whole[0])
    page.keyboard.press("0")
    page.wait_for_function("x => state.x[0] === x[0]", arg=whole)
    page.mouse.dblclick(box["x"] + 0.5 * box["width"], box["y"] + box["height"] / 3)
    page.wait_for_function("wide => state.x[1] - state.x[0] < 0.7 * wide", arg=whole[1] - whole[0])
    page.keyboard.press(".")
    page.wait_for_timeout(400)
    seen = page.evaluate(SEEN)
    again = browser(folder, page.evaluate("location.hash"))
    *shown, words, is_playing = again.evaluate(SEEN)
    assert shown == seen[:-2]
    assert words == seen[-2] or "computed" in seen[-2]
    assert not is_playing


@pytest.mark.browser
@needs_browser
def test_an_attractor_beside_the_other_is_chosen_by_key_and_by_button(made, page):
    _, _, data = made
    many = [m for m in data["motions"] if m["stable"] is False]
    if not many:
        return
    page.evaluate("rpm => goTo({rpm})", many[0]["rpm"])
    names = page.locator("#choices button").all_inner_texts()
    assert len(names) > 1
    page.focus("#diagram")
    first = said(page)
    page.keyboard.press("ArrowUp")
    assert said(page) != first
    page.click("#choices button >> nth=0")
    assert names[0] in said(page)
    assert page.get_attribute("#choices button >> nth=0", "aria-checked") == "true"


@GESTURES
@pytest.mark.browser
@needs_browser
def test_motion_is_for_those_who_want_it_and_all_fits_a_phone(made, browser, chromium, window):
    _, folder, _ = made
    window[0].emulate_media(reduced_motion="no-preference")
    moving = browser(folder)
    moving.wait_for_function("state.playing && state.t > 0")
    moving.emulate_media(reduced_motion="reduce")
    moving.goto("about:blank")
    phone = {"viewport": {"width": 375, "height": 900}, "has_touch": True}
    page = chromium.new_page(**phone, reduced_motion="reduce", color_scheme="dark")
    complaints = watched(page)
    page.goto(f"file://{folder / 'explore.html'}")
    assert not page.evaluate("state.playing")
    assert page.evaluate("document.documentElement.scrollWidth") == 375
    page.tap("#play")
    page.wait_for_function("state.t > 0")
    page.tap("#play")
    with page.expect_download() as download:
        page.tap("#save")
    root = ElementTree.parse(download.value.path()).getroot()
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert len(root.findall("{http://www.w3.org/2000/svg}svg")) == 4
    page.close()
    assert not complaints


@pytest.mark.browser
@needs_browser
def test_a_click_into_a_plane_shows_the_motion_of_that_place(made, page, browser):
    """The basins' starts and the map's points; the command and a link say which it is."""
    _, folder, data = made
    assert page.locator(".plane").count() == len(data["planes"])
    for number, plane in enumerate(data["planes"]):
        box = page.locator(f"#{plane['of']}-plane")
        box.scroll_into_view_if_needed()
        asks = f"{plane['name']}: arrow keys choose a place"
        assert box.get_attribute("aria-label") == asks
        box.click(position={"x": 300, "y": 100})
        place = page.evaluate("state.motion.place")
        at = page.evaluate(
            f"(({{axes}}) => [axes.fromX(300), axes.fromY(100)])(data.planes[{number}])"
        )
        for value, wanted, (low, high), cells in zip(
            place, at, (plane["x"], plane["y"]), plane["cells"], strict=True
        ):
            assert abs(value - wanted) < 1.01 * (high - low) / min(cells, 16)
        shown, ring, wanted = page.evaluate(
            f"""(({{mark, axes}}) => [mark.style.display,
              ["cx", "cy"].map(key => +mark.getAttribute(key)),
              [axes.X(state.motion.place[0]), axes.Y(state.motion.place[1])]])
              (data.planes[{number}])"""
        )
        assert (shown, ring) == ("", pytest.approx(wanted, abs=0.01))
        others = page.evaluate("data.planes.map(({mark}) => mark.style.display)")
        assert others == ["" if k == number else "none" for k in range(len(data["planes"]))]
        label = page.evaluate("state.motion.label")
        if plane["of"] == "map" and label.startswith("P("):
            label = f"period {label[2:].partition(';')[0]}"
        assert box.get_attribute("title") == label
        command = page.inner_text("#command")
        if plane["of"] == "map":
            assert f"--rpm {place[0]:g} --set follower.mass={place[1]}" in command
            assert f"follower.mass = {place[1]:.10g}" in said(page)
        else:
            assert f"q: {place[0]!r}, v: {place[1]!r}" in command
        page.evaluate("state.t = 0.5")
        box.press("ArrowLeft")
        left, begins = page.evaluate("[state.motion.place, state.t]")
        assert left[0] < place[0]
        assert left[1] == place[1]
        assert begins == 0  # as after a click: each motion from where it starts
        check_edges_and_numbers(page, plane, f"data.planes[{number}]")
        page.wait_for_timeout(300)
        again = browser(folder, page.evaluate("location.hash"))
        assert again.evaluate("state.motion.place") == left


def check_edges_and_numbers(page, plane, own):
    """Each corner of a plane is of its cell, what is beside it of none; numbers stand apart."""
    inside, outside, marks, wide = page.evaluate(
        f"""(plane => {{ const {{left, right, top, bottom}} = plane.axes;
          const middle = [(left + right) / 2, (top + bottom) / 2];
          const kinds = places => places.map(place => kindIn(plane, ...place));
          const marks = [...plane.svg.querySelectorAll("text[text-anchor=middle]")];
          return [kinds([[left, bottom], [right, bottom], [left, top], [right, top]]),
            kinds([[left - 1, middle[1]], [right + 1, middle[1]], [middle[0], top - 1],
                   [middle[0], bottom + 1]]), marks.map(text => +text.getAttribute("x")),
            boxOf(plane.svg).width]; }})({own})"""
    )
    codes = np.array(plane["codes"]).reshape(plane["cells"][::-1])
    corners = codes[[0, 0, -1, -1], [0, -1, 0, -1]]
    labels = [*plane["labels"], *["below the cam"] * 256]
    check_cells(page, plane, own)
    assert inside == [labels[code].replace("inf", "∞") for code in corners]
    assert outside == [""] * 4
    assert len(marks) >= 2
    assert min(np.diff(marks)) > 80.0 or wide < 600.0


def check_cells(page, plane, own):
    """The cells from above, each code in one colour; of basins the widest is the palest."""
    pixels, rgb = page.evaluate(
        f"""(plane => {{ const small = cellsOf(plane), pen = small.getContext("2d");
          const all = pen.getImageData(0, 0, ...plane.cells).data;
          const often = {{willReadFrequently: true}};
          const seen = coloursOfPlane(plane, make("canvas").getContext("2d", often));
          return [[...all], seen.map(colour => [...colour])]; }})({own})"""
    )
    columns, rows = plane["cells"]
    codes = np.array(plane["codes"]).reshape(rows, columns)[::-1]
    pixels = np.array(pixels).reshape(rows, columns, 4)
    many = [int(np.sum(codes == code)) for code in range(len(plane["labels"]))]
    for code in np.unique(codes):
        ((*colour, opacity),) = np.unique(pixels[codes == code], axis=0)
        if code >= len(rgb):
            assert opacity == 0
            continue
        is_full = plane["of"] == "map" or plane["labels"][code] == "undecided"
        pale = 70 if code == np.argmax(many) else 180
        assert opacity == (255 if is_full else pale)
        assert colour == pytest.approx(rgb[code][:3], abs=3)  # of a colour times its opacity


def test_the_page_opens_in_the_browser_when_it_is_written(cam, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda page: bool(opened.append(page)))
    words = "--rpm 700:701 --points 2 --set orbits.starts=0 -q"
    done = cam(f"explore {words} --set run.transient=50 --set run.record=20 --open", code=0)
    page = (tmp_path / "out/explore/explore.html").as_uri()
    assert opened == [page]
    assert f"no browser was found; open {page}" in done.stderr


@pytest.mark.parametrize(("theta_deg", "restitution"), [(358.0, 0.25), (2.0, 0.25), (90.0, 0.5)])
def test_the_hops_of_a_chatter_shrink_by_the_restitution_of_where_it_is(theta_deg, restitution):
    """On the seat, which is level, and on the lobe; of 0.01 s the n-th hop leaves r^n.

    At 60 rpm a second is a turn. With r = 1/4 an impact at 2 m/s is followed by those of 2/4 m/s,
    2/16 and so on; those below 0.002 of the hardest one are not drawn.
    """
    values = {**LAW, "cam": {**LAW["cam"], "lash": 0.001},
              "follower": {**LAW["follower"], "seat_restitution": 0.25}}  # fmt: skip
    system = machine_of(load_scene(values)).system
    motion = SimpleNamespace(system=system, rpm=60.0)
    happened = [
        Happening(0.10, 7, theta_deg, "impact", 0.0, -2.0, 0.5),
        Happening(0.11, 7, theta_deg, "chatter", 0.0, 0.0, 0.0),
        Happening(0.12, 7, theta_deg, "impact", 0.0, -1.0, 0.5),
        Happening(0.13, 8, theta_deg, "chatter", 0.0, 0.0, 0.0),
    ]
    ((start, end, rows),) = _hops(motion, happened)  # the second one ends in another turn
    assert (start, end) == (0.10, 0.11)
    hops = [2.0 * restitution**n for n in range(1, 20) if restitution**n > 0.002]
    assert len(rows) == 2 * len(hops)
    for n, u in enumerate(hops, 1):
        before, after = rows[2 * n - 2 : 2 * n]
        assert before[0] == after[0] == pytest.approx(0.11 - 0.01 * restitution**n)
        assert (before[3], after[3]) == (0.0, 0.0)
        assert after[2] - before[2] == pytest.approx(u * (1.0 + restitution))
        if restitution == 0.25:
            assert (before[2], after[2]) == pytest.approx((-u, u * restitution))
