"""explore.html in use: stops, forces, lens, zoom, paper and saved pictures, in a browser."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import camcli
from tests.output.test_explore import chromium, data_of, needs_browser
from tests.support.machines import CHAPTER, VALVE

__all__ = ["chromium"]  # a fixture
pytestmark = [pytest.mark.slow, pytest.mark.browser, needs_browser]
SPEEDS = {
    "sweep.rpm": {"start": 672, "stop": 686, "num": 8}, "run.transient": 300, "run.record": 40,
    "orbits.starts": 4, "orbits.at": 680, "run.patience": 0,
}  # fmt: skip
CONFIGS = Path(__file__).parents[2] / "configs"
VALVE_SPEEDS = {
    "sweep.rpm": {"start": 6500, "stop": 7000, "num": 2},
    "run.record": 5,
    "orbits.starts": 0,
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("chapter")
    camcli.explore(CHAPTER.load(SPEEDS)).save(place)
    return place


@pytest.fixture(scope="module")
def one_page(chromium, folder):
    yield from opened(chromium, folder)


@pytest.fixture(scope="module")
def valve(chromium, tmp_path_factory):
    """The page of a valve train, whose crank turns twice as fast as its cam."""
    place = tmp_path_factory.mktemp("valve")
    camcli.explore(VALVE.load(VALVE_SPEEDS)).save(place)
    yield from opened(chromium, place)


AS_OPENED = """() => {
  window.trueClick ??= click; // a test hears with an ear of its own
  click = trueClick;
  Object.assign(state, {lens: "auto", close: false, playing: false, dragged: false, sound: false});
  Object.assign(state, wholeView());
  $("lens").value = "auto";
  set($("sound"), {"aria-pressed": false});
  host.classList.remove("tall");
  boxes.clear();
  window.trueBifurcations ??= data.bifurcations;
  data.bifurcations = trueBifurcations;
  choose(motions.find(m => m.rpm === 680));
  drawDiagram();
}"""


@pytest.fixture
def page(one_page):
    """The page as it is after it was opened; opening it takes most of the time."""
    one_page.evaluate(AS_OPENED)
    return one_page


def opened(chromium, folder, fragment="", size=(1280, 800), **more):
    """The page in a window of this size; whatever it complains of is a failure."""
    width, height = size
    page = chromium.new_page(
        viewport={"width": width, "height": height}, reduced_motion="reduce", **more
    )
    complaints = []
    page.on("console", lambda said: complaints.append(said.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(f"file://{folder / 'explore.html'}{fragment}")
    yield page
    page.close()
    assert not complaints


def bottom_of(page, element):
    box = page.locator(element).bounding_box()
    return box["y"] + box["height"]


def test_each_stop_shows_what_its_sentence_says(page, folder):
    """From the data: a rest all round, a lift-off at corner b, a chatter, an impact at b, chaos."""
    stops = data_of(folder)["stops"]
    names = ["Contact", "Lift-off at b", "Chatter", "Impact at corner b", "Chaos", "Two motions"]
    assert [stop["name"] for stop in stops] == names
    assert page.locator("#stops button").all_inner_texts() == names
    seen = {}
    for stop in stops:
        page.click(f"#stops >> text='{stop['name']}'")
        assert page.inner_text("#stop-words") == stop["words"]
        seen[stop["name"]] = page.evaluate(
            """() => { const m = state.motion, {t, kind} = data.events; let events = [];
                 for (let k = m.event; k < m.event + m.events; k++)
                   events.push([KINDS[kind[k]], phaseAt(t[k]), t[k] - state.t]);
                 return {rpm: m.rpm, label: m.label, events, rests: at(m, state.t).rests}; }"""
        )
        assert f"{seen[stop['name']]['rpm']:.4g}"[:3] in stop["words"]
    assert seen["Contact"]["label"] == "contact"
    assert seen["Contact"]["rpm"] < 114.979326744 < seen["Lift-off at b"]["rpm"]  # of the chapter
    (kind, phase, ahead), *_ = seen["Lift-off at b"]["events"]
    assert kind == "detachment"
    assert phase == pytest.approx(150.1793714951576, abs=1e-4)  # corner b
    assert 0 < ahead < 0.1
    assert seen["Lift-off at b"]["rests"]
    assert "chatter accumulates" in [kind for kind, *_ in seen["Chatter"]["events"]]
    (impact,) = seen["Impact at corner b"]["events"]
    assert abs(impact[1] - 150.18) < 3.0
    assert 0 < impact[2] < 0.1
    assert seen["Chaos"]["label"] == "aperiodic"
    assert page.locator("#choices button").count() > 1
    page.focus("#diagram")
    page.keyboard.press("ArrowLeft")
    assert page.inner_text("#stop-words").startswith("Take the tour")


def test_the_sentence_on_a_motion_is_never_cut(page):
    """What follows it is left out where its line has no room, and its tooltip has all."""
    said = page.evaluate(
        """() => motions.map(m => {
             choose(m);
             const said = $("said");
             return [said.scrollWidth - said.clientWidth, said.textContent, said.title];
           })"""
    )
    assert max(beyond for beyond, *_ in said) <= 0
    assert all(whole.startswith(text) for _, text, whole in said)
    assert {text == whole for _, text, whole in said} == {True, False}


def test_the_tour_leads_from_stop_to_stop_and_then_into_the_diagram(chromium, folder):
    stops = data_of(folder)["stops"]
    for page in opened(chromium, folder):
        for stop, after in zip(stops, [*stops[1:], None], strict=True):
            assert page.inner_text("#stop-words") == stop["words"]
            assert page.evaluate("state.motion.number") == stop["motion"]
            beside = page.locator("#diagram >> text=now at").count()
            outside = not 672 <= page.evaluate("state.motion.rpm") <= 686
            assert beside == outside, stop["name"]
            value = float(page.get_attribute("#diagram", "aria-valuenow"))
            assert 672 <= value <= 686
            rpm, name = page.evaluate("[state.motion.rpm, name(state.motion)]")
            assert page.get_attribute("#diagram", "aria-valuetext") == f"{rpm:.10g} rpm, {name}"
            told = f"Next: {after['name']}" if after else "Now drag the speed"
            assert page.inner_text("#onward").startswith(told)
            page.keyboard.press("n") if after else page.click("#onward")
        assert page.inner_text("#stop-words").startswith("Take the tour")
        assert page.evaluate("isInDiagram(state.motion) && document.activeElement === host")
        page.click("#onward")
        assert page.inner_text("#stop-words") == stops[0]["words"]


def test_the_law_that_holds_now_is_marked(page):
    page.click("#stops >> text='Chatter'")
    holds = """t => { state.t = t; drawNow();
      return [...document.querySelectorAll("#laws .holds dt")].map(name => name.textContent); }"""
    events = page.evaluate(
        """() => { const m = state.motion, {t, kind} = data.events;
          return Array.from({length: m.events}, (_, k) => [t[m.event + k], kind[m.event + k]]); }"""
    )
    (leaves,) = (t for t, kind in events if kind == 2)
    first = next(t for t, kind in events if kind == 0 and t > leaves)
    assert page.evaluate(holds, leaves - 0.01) == ["on the cam"]
    assert page.evaluate(holds, leaves + 0.001) == ["in flight"]
    assert page.evaluate(holds, first + 0.001) == ["in flight", "at an impact"]
    edges, lines = page.evaluate(
        """() => {
          const lines = {flight: "#time .flight", rest: "#time .rest", impact: "#machine .flash"};
          const edges = Object.values(lawRows).map(row => {
            row.classList.add("holds");
            return getComputedStyle(row).borderLeftColor;
          });
          return [edges, Object.keys(lawRows).map(law =>
            getComputedStyle(document.querySelector(lines[law])).stroke)]; }"""
    )
    assert edges == lines  # of the colour of what it is about
    assert len(set(edges)) == 3


def test_the_arrows_are_the_forces_and_that_of_the_contact_is_gone_in_flight(page):
    """Against the numbers of the chapter: k q, and m k q / m in flight, by hand."""
    page.click("#stops >> text='Lift-off at b'")
    forces = """t => { state.t = t; drawNow(); const m = state.motion, now = at(m, t);
      const d = machine.arrows.map(arrow => arrow.getAttribute("d"));
      return [forcesOn(m, now), now.q, now.rests, d, machine.perNewton]; }"""
    shown, q, rests, drawn, _ = page.evaluate(forces, 0.0)
    assert rests
    assert shown["pull"] == pytest.approx(-1430.8 * q)
    assert shown["contact"] == pytest.approx(1430.8 * 0.1)  # dwell of the base
    assert drawn[1]
    shown, q, rests, drawn, scale = page.evaluate(forces, 151.0 / 360.0)
    assert not rests
    assert shown["contact"] == 0
    assert not drawn[1]
    assert shown["inertia"] == pytest.approx(1430.8 * q)
    top, *_, bottom = sorted(float(y) for y in re.findall(r"[V ]([\d.]+)", drawn[0]))
    assert bottom - top == pytest.approx(1430.8 * q * scale, abs=0.1)


def test_the_lens_enlarges_the_gap_of_a_valve_by_itself(valve, page):
    page.evaluate("choose(motionAtSpeed(676))")
    assert page.evaluate("machine.lens") is None  # it flies as high as a man
    page.select_option("#lens", "10")
    assert page.evaluate("machine.lens.times") == 10
    valve.evaluate("choose(motions.find(m => m.origin === 'stop' && m.events > 0))")
    times = valve.evaluate("machine.lens.times")
    assert times in (10, 100, 1000)
    gap, drawn, scale = valve.evaluate(
        """() => { const m = state.motion; let best = [0];
          for (let t = 0; t < m.end; t += 1e-3) {
            const now = at(m, t);
            if (now.gap > best[0]) best = [now.gap, t];
          }
          state.t = best[1]; drawNow();
          return [best[0], machine.lens.ground - machine.lens.tip.transform.baseVal[0].matrix.f,
                  machine.scale]; }"""
    )
    assert drawn == pytest.approx(gap * scale * times, abs=0.01)
    slope, wanted = valve.evaluate(
        """() => { const {theta_deg, c1} = data.cam;
          const phase = theta_deg[c1.indexOf(Math.max(...c1))];
          const c = camAt(phase), now = {phase, c: c[0]};
          const places = surfaceInLens(now).split("V")[0].slice(1).split("L")
            .map(place => place.split(" ").map(Number));
          const [[left, high], [right, low]] = [places[11], places[13]];
          const {x, ground} = machine.lens;
          if (Math.hypot(places[12][0] - x, places[12][1] - ground) > 0.02) return [NaN, 0];
          return [(high - low) / (right - left),
                  c[1] / data.outline.ratio / machine.radius(c[0])]; }"""
    )
    assert slope == pytest.approx(wanted, rel=0.05)  # of the surface, dR/(R dtheta)
    away, depth, radius = valve.evaluate(
        """() => { const c = camAt(0)[0], {x, ground, times} = machine.lens;
          const [right, down] = surfaceInLens({phase: 0, c}).slice(1).split("L")[0].split(" ");
          return [right - x, down - ground, machine.radius(c) * machine.scale * times]; }"""
    )
    assert depth == pytest.approx(radius - np.sqrt(radius**2 - away**2), abs=0.02)  # base circle
    assert depth > 0.1
    assert "valve" in valve.inner_text("#stop-words") or "of the crank" in valve.inner_text("#said")


def test_what_is_needed_first_is_on_the_first_screen(page):
    for element in ("#stops", "#machine", "#speed", "#time", "#phase", "#diagram"):
        assert bottom_of(page, element) <= 800, element
    assert page.locator("#machine").bounding_box()["height"] > 380  # it was 230
    assert page.evaluate("diagram.height") > 120  # it was 90
    assert bottom_of(page, "#first") <= 800
    stops, onward, present = (
        page.locator(f"#{name}").bounding_box() for name in ("stops", "onward", "present")
    )
    assert stops["y"] == onward["y"] == present["y"]  # one row
    assert stops["x"] + stops["width"] < onward["x"] < present["x"]
    assert page.locator("#diagram >> text=drag me").count() == 1
    box = page.locator("#diagram").bounding_box()
    y = box["y"] + 0.7 * box["height"]
    x = box["x"] + page.evaluate("diagram.X(state.motion.rpm)")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + page.evaluate("diagram.X(684) - diagram.X(state.motion.rpm)"), y, steps=4)
    page.mouse.up()
    assert page.evaluate("state.motion.rpm") == 684
    assert page.locator("#diagram >> text=drag me").count() == 0
    page.fill("#speed", "0")
    assert page.evaluate("state.motion.rpm") == 672
    assert page.get_attribute("#speed", "aria-valuetext") == "672 rpm"


@pytest.mark.ci
def test_a_link_opens_all_that_was_set(chromium, folder, page):
    """Also the sentence of a stop, which was empty where a link led to it."""
    page.click("#stops >> text='Chatter'")
    page.select_option("#lens", "100")
    page.fill("#pace", "80")
    page.click("#tall")
    stops = {stop["name"]: stop["words"] for stop in data_of(folder)["stops"]}
    fragment = "#" + page.evaluate("link()")
    for again in opened(chromium, folder, fragment):
        assert again.inner_text("#stop-words") == stops["Chatter"]
        assert again.get_attribute("#stops >> text='Chatter'", "aria-pressed") == "true"
        assert again.evaluate("[state.lens, machine.lens.times, $('pace').value]") == [
            "100", 100, "80",
        ]  # fmt: skip
        assert again.inner_text("#slowed") == page.inner_text("#slowed")
        assert again.evaluate("host.classList.contains('tall')")
        assert again.evaluate("link()") == fragment[1:]
    page.fill("#pace", "50")


@pytest.mark.ci
def test_for_a_room_letters_grow_and_the_pointer_is_where_it_points(chromium, folder):
    for page in opened(chromium, folder, "#rpm=680&present=1", size=(1920, 1080)):
        assert page.get_attribute("#present", "aria-pressed") == "true"
        letters = page.evaluate("letters")
        assert letters == pytest.approx(1080 / 690)
        font = page.evaluate("parseFloat(getComputedStyle($('said')).fontSize)")
        assert font == pytest.approx(15 * letters, abs=0.1)
        box = page.locator("#diagram").bounding_box()
        assert box["y"] + box["height"] <= 1080
        page.evaluate("setClose(true); redrawMachine()")  # with the letters of its corners
        fonts = page.evaluate(FONTS_OF_DRAWINGS)
        check_sizes_in_a_saved_picture(page, letters)
        found = page.evaluate(SHOWN, [IN_A_ROOM, NOT_IN_A_ROOM])
        assert found == [dict.fromkeys(IN_A_ROOM, True), dict.fromkeys(NOT_IN_A_ROOM, False)]
        x = box["x"] + letters * page.evaluate("diagram.X(684)")
        page.mouse.click(x, box["y"] + 0.6 * box["height"])
        assert page.evaluate("state.motion.rpm") == 684
        assert page.evaluate("time.upper.right") < page.evaluate("boxOf($('time')).width")
        page.keyboard.press("f")
        page.wait_for_function("!state.presents && letters === 1.2")
        assert page.locator("#command-panel").is_visible()
        page.set_viewport_size({"width": 1280, "height": 800})
        page.wait_for_function("letters === 1")
        assert fonts == page.evaluate(FONTS_OF_DRAWINGS)  # a drawing is enlarged as a whole
        assert "corner" in dict(fonts)


FONTS_OF_DRAWINGS = """[...new Map([...document.querySelectorAll("svg text")].map(text =>
  [text.getAttribute("class"), getComputedStyle(text).fontSize]))].sort()"""


def check_sizes_in_a_saved_picture(page, letters):
    """Panels are as large as on the screen, in pixels of which a unit of a drawing has several."""
    places = page.evaluate(
        """["machine", "time", "phase", "overlay"].map(id => {
             const {x, y, width, height} = $(id).getBoundingClientRect();
             return [x, y, width, height]; })"""
    )
    left, top = (min(place[k] for place in places) for k in (0, 1))
    panels = [one for one in ElementTree.fromstring(page.evaluate("picture()")) if one.get("id")]
    for panel, (x, y, wide, high) in zip(panels, places, strict=True):
        box = [float(panel.get(key)) for key in ("x", "y", "width", "height")]
        assert box == pytest.approx([x - left + 10.0, y - top + 40.0, wide, high], abs=0.01)
        view = [float(length) for length in panel.get("viewBox").split()]
        assert view == pytest.approx([0.0, 0.0, wide / letters, high / letters], abs=0.01)


@pytest.mark.ci
def test_a_page_inside_another_one_works(chromium, folder):
    """In a frame without an address and without rights, as courses embed what is uploaded."""
    text = (folder / "explore.html").read_text("utf-8")
    outer, complaints = chromium.new_page(), []
    outer.on("console", lambda said: complaints.append(said.text))
    outer.on("pageerror", lambda error: complaints.append(str(error)))
    outer.set_content('<iframe sandbox="allow-scripts" width="800" height="700"></iframe>')
    outer.evaluate("text => { document.querySelector('iframe').srcdoc = text; }", text)
    outer.wait_for_timeout(300)
    inner = outer.frames[1]
    inner.click("#stops >> text='Chaos'")
    outer.wait_for_timeout(300)  # for the address, which is written a little later
    assert inner.evaluate("state.motion.label") == "aperiodic"
    assert inner.evaluate("document.documentElement.scrollWidth") <= 800
    outer.close()
    assert not complaints


def test_on_a_phone_the_name_of_the_speeds_is_not_cut(valve):
    for width, name in ((1280, "; the crank turns 2× as fast"), (390, "camshaft speed (rpm)")):
        valve.set_viewport_size({"width": width, "height": 844})
        valve.wait_for_function("width => drawnFor.startsWith(width)", arg=f"{width} 844")
        text = valve.locator("#overlay >> text=camshaft speed")
        assert text.inner_html().endswith(name)
        left = valve.locator("#overlay").bounding_box()["x"]
        assert text.bounding_box()["x"] >= left


def test_on_a_phone_all_that_is_pressed_is_as_large_as_a_finger(chromium, folder):
    for page in opened(chromium, folder, size=(390, 844), has_touch=True, is_mobile=True):
        boxes = page.evaluate(
            """[...document.querySelectorAll("button, select, input, summary")]
                 .map(node => [node.id || node.textContent, node.getBoundingClientRect()])
                 .filter(([, box]) => box.width > 0)
                 .map(([name, box]) => [name, box.width, box.height])"""
        )
        assert len(boxes) > 15
        assert not [box for box in boxes if min(box[1:]) < 44]
        for _ in range(page.locator("#stops button").count() - 1):
            page.click("#onward")
            chosen = page.locator("#stops [aria-pressed=true]").bounding_box()
            assert chosen["x"] >= 0
            assert chosen["x"] + chosen["width"] <= 390
        assert page.evaluate("document.documentElement.scrollWidth") == 390
        assert page.evaluate("FINGER") == 20
        about = page.locator("#about").bounding_box()["y"]
        assert about >= bottom_of(page, "#stage")  # the machine itself comes before its constants
        assert page.locator("#onward").bounding_box()["y"] >= bottom_of(page, "#stops")


def test_zoom_is_about_the_chosen_motion_and_keys_take_the_view_along(page):
    page.evaluate("choose(motions.find(m => m.rpm === 676 && m.label === 'P(1;1)'))")
    place = """() => { const [values, k] = drawnPoints(state.motion);
      return [diagram.X(676), diagram.Y(values[k])]; }"""
    before = page.evaluate(place)
    ends = page.evaluate("state.x.map(x => diagram.X(x))")
    page.mouse.move(640, bottom_of(page, "#diagram") - 60)
    page.focus("#diagram")
    for _ in range(4):
        page.keyboard.press("+")
    page.wait_for_timeout(60)
    assert page.locator("#hint").is_hidden()
    assert page.evaluate(place) == pytest.approx(before, abs=0.01)
    low, high = page.evaluate("state.x")
    assert high - low < 2.0
    assert page.evaluate("state.x.map(x => diagram.X(x))") == pytest.approx(
        ends
    )  # drawn after each key
    page.keyboard.press("ArrowRight")
    page.wait_for_timeout(60)
    rpm, (low, high) = page.evaluate("[state.motion.rpm, state.x]")
    assert rpm > 676.0
    assert low < rpm < high


def test_a_click_on_a_stable_line_gives_its_orbit_though_chaos_is_closer(page):
    """At 680 rpm impacts of the chaos lie within a pixel of every place of the line."""
    page.click("#tall")
    branch = """() => {
      const b = data.branches.find(b => b.label.includes("P(1;1)") && b.stable.includes(1));
      const k = b.rpm.findIndex((rpm, k) => b.stable[k] === 1 && Math.abs(rpm - 680) < 0.5);
      return [diagram.X(b.rpm[k]), diagram.Y(b.theta_deg[0][k])]; }"""
    x, y = page.evaluate(branch)
    page.locator("#diagram").click(position={"x": x, "y": y})
    assert page.evaluate("[state.motion.label, state.motion.stable]") == ["P(1;1)", True]
    assert "-0" not in page.inner_text("body")
    assert "−0.0 " not in page.inner_text("body")


def test_what_never_changes_is_drawn_in_the_middle_of_a_tenth_of_the_lift(page):
    """It was between -1 and 1 m, of a valve that lifts 10 mm."""
    ranges = page.evaluate(
        """() => { const own = pointsOf, {quantity} = state, found = [];
          pointsOf = () => [[0.25], 0, 1];
          for (state.quantity of ["q", "u"]) found.push(rangeOfValues());
          pointsOf = own;
          state.quantity = quantity;
          return found; }"""
    )
    tenth = 0.1 * (0.25393320723821 - 0.1)
    assert ranges == [pytest.approx([0.25 - tenth, 0.25 + tenth]), [-0.75, 1.25]]


def test_a_click_on_an_event_zooms_to_it(page):
    whole = page.evaluate("state.x")
    page.click("#events button >> nth=0")
    page.wait_for_timeout(60)
    low, high = page.evaluate("state.x")
    assert low < 673.2344450038120 < high
    assert high - low < 0.1 * (whole[1] - whole[0])


def test_a_saved_picture_has_its_colours_written_out(page):
    text = page.evaluate("picture()")
    assert "var(" not in text
    root = ElementTree.fromstring(text)
    colours = set(re.findall(r"#[0-9a-fA-F]{6}|#[0-9a-fA-F]{3}\b|rgb\([\d, ]+\)", text))
    assert len(colours) > 8
    assert "aperiodic" in "".join(root.itertext())


SHOWN = """lists => lists.map(names => Object.fromEntries(names.map(name =>
  [name, [...document.querySelectorAll(name)].some(node => node.checkVisibility())])))"""
ON_PAPER = [
    "#title", "#intro", "#about", "#machine", "#now", "#said", "#time", "#phase", "#laws",
    "#diagram-title", "#overlay", "#legend", "#events-title", "#events button",
    "#command-title", "#command", "#overlay .cursor",
]  # fmt: skip
NOT_ON_PAPER = [
    ".skip", "#stops", "#onward", "#present", "#stop-words.idle", "#play", "#back", "#next",
    "#pace", "#slowed", "#speed", "#rpm", "#choices", "#close", "#lens", "#sound",
    "#quantity", "#in", "#out", "#whole", "#tall", "#save", "#copy", "#link", "#hint",
    ".handle", ".grip", ".drag-me", ".label", "details", "#said .faint",
]  # fmt: skip
IN_A_ROOM = [
    "#title", "#intro", "#stops", "#onward", "#present", "#stop-words", "#machine", "#play",
    "#back", "#next", "#pace", "#slowed", "#speed", "#rpm", "#choices", "#said", "#time",
    "#phase", "#laws", "#diagram-title", "#diagram", "#legend", ".handle",
]  # fmt: skip
NOT_IN_A_ROOM = [
    "#about", "#now", "#close", "#lens", "#sound", "#quantity", "#in", "#out", "#whole",
    "#tall", "#save", "#legend .of-lines", "#events-panel", "#command-panel", "details",
    "#planes", "#hint",
]  # fmt: skip
LETTER_PAPER = 964  # px: 11 inches less 12 mm of margin on either side; A4 is longer


def test_on_paper_axes_and_points_are_one_and_nothing_is_to_be_pressed(page):
    is_image_of_paper = page.evaluate(
        """() => { dispatchEvent(new Event("beforeprint"));
             const {width, height} = boxOf(host), image = host.querySelector("img");
             return [image.src === canvas.toDataURL(), canvas.width === Math.round(3 * width),
                     canvas.height === Math.round(3 * height), diagram.right === width - 48]; }"""
    )  # at once, as the browser prints after its event
    assert is_image_of_paper == [True] * 4
    page.emulate_media(media="print", color_scheme="dark")
    page.wait_for_function("document.querySelector('#diagram img').complete")
    boxes = [page.locator(f"#diagram {tag}").bounding_box() for tag in ("img", "svg")]
    assert boxes[0] == boxes[1]
    assert page.evaluate("document.querySelector('#diagram img').naturalWidth === canvas.width")
    view = page.evaluate("overlay.viewBox.baseVal.width")
    assert view == pytest.approx(boxes[0]["width"], abs=0.5)
    assert page.evaluate("canvas.width / canvas.height") == pytest.approx(
        boxes[0]["width"] / boxes[0]["height"], rel=0.01
    )
    assert (
        page.evaluate("document.body.getBoundingClientRect().width") <= 703
    )  # A4, 12 mm of margin
    shown = page.locator("button:visible, select:visible, input:visible").all()
    assert all(button.evaluate("node => node.closest('#events') !== null") for button in shown)
    found = page.evaluate(SHOWN, [ON_PAPER, NOT_ON_PAPER])
    assert found == [dict.fromkeys(ON_PAPER, True), dict.fromkeys(NOT_ON_PAPER, False)]
    assert (
        page.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--paper')")
        == "#fff"
    )
    assert bottom_of(page, "#command-panel") < LETTER_PAPER
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.emulate_media(media="screen")
    assert page.locator("#diagram img").count() == 0
    assert page.evaluate("overlay.viewBox.baseVal.width") > 720


def test_the_end_of_a_record_that_does_not_repeat_fades(page):
    page.evaluate("choose(motions.find(m => m.label === 'aperiodic'))")
    clear = page.evaluate(
        "() => { state.playing = true; const end = state.motion.end;"
        "  return [0, 0.05, 1, end - 0.03, end].map(t => clearness(state.motion, t)); }"
    )
    assert clear[2] == 1
    assert clear[0] < 0.1
    assert clear[4] == 0
    assert 0 < clear[3] < 0.5
    page.evaluate("choose(motions.find(m => m.loops))")
    assert page.evaluate("clearness(state.motion, state.motion.end)") == 1


def test_sound_is_off_until_it_is_asked_for(page):
    assert page.evaluate("[state.sound, speaker]") == [False, None]
    page.evaluate("() => { clicked = []; click = loudness => clicked.push(loudness); }")
    page.evaluate("choose(motions.find(m => m.label === 'P(1;1)')); soundImpacts(-1, 2)")
    assert page.evaluate("clicked") == []
    page.click("#sound")
    page.evaluate("soundImpacts(-1, 2)")
    assert page.evaluate("clicked.length") >= 1
    assert np.all(np.array(page.evaluate("clicked")) <= 1)


FEW_SPEEDS = {
    "sweep.rpm.num": 3, "orbits.rpm.num": 3, "orbits.starts": 0, "run.transient": 60,
    "run.record": 12, "run.patience": 0,
}  # fmt: skip
HOW_MANY = [
    pytest.param(FEW_SPEEDS, marks=pytest.mark.ci, id="few"),
    pytest.param({"sweep.rpm.num": 41}, marks=pytest.mark.soak, id="many"),
]


UNREADABLE = """() => { // texts of drawings that leave them or run into one another, by 1 and 4 px
  const found = [];
  for (const svg of document.querySelectorAll("svg")) {
    const all = svg.getBoundingClientRect();
    const texts = [...svg.querySelectorAll("text")].map(text => [text.textContent, text])
      .filter(([words, text]) => words.trim() && text.checkVisibility())
      .map(([words, text]) => [words, text.getBoundingClientRect()]);
    texts.forEach(([words, box], k) => {
      if (box.left < all.left - 1 || box.right > all.right + 1) found.push([svg.id, words]);
      for (const [other, beside] of texts.slice(0, k)) {
        const wide = Math.min(box.right, beside.right) - Math.max(box.left, beside.left);
        const high = Math.min(box.bottom, beside.bottom) - Math.max(box.top, beside.top);
        if (wide > 1 && high > 4) found.push([svg.id, words, other]);
      }
    });
  }
  return found; }"""


@pytest.mark.parametrize("values", HOW_MANY)
@pytest.mark.parametrize("file", sorted(CONFIGS.glob("*.yaml")), ids=lambda file: file.stem)
def test_every_shipped_machine_opens_and_plays_without_a_complaint(
    file, values, chromium, tmp_path
):
    camcli.explore(camcli.load_scene(file, values)).save(tmp_path)
    for page in opened(chromium, tmp_path):
        assert bottom_of(page, "#legend") <= 800
        for size in ((390, 844), (1280, 800)):
            page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))
            page.wait_for_function("size => drawnFor.startsWith(size)", arg=f"{size[0]} {size[1]}")
            assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
            for stop in range(page.locator("#stops button").count()):
                page.evaluate("stop => showStop(data.stops[stop])", stop)
                assert page.evaluate(UNREADABLE) == [], stop
        for quantity in ("u", "q", "theta"):
            page.select_option("#quantity", quantity)
        page.evaluate("play(true)")
        turns = page.evaluate("state.t")
        page.wait_for_function("turns => state.t !== turns", arg=turns)
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        page.emulate_media(media="print")
        assert bottom_of(page, "#command-panel") < LETTER_PAPER


def test_the_accuracy_of_a_measured_cam_stands_above_its_motions(page):
    told = page.evaluate("""() => { data.measured = "right to 1 µm"; return machineWords(); }""")
    assert told.endswith("restitution r 0.8. right to 1 µm")
    assert bottom_of(page, "#about") < page.locator("#machine").bounding_box()["y"]


# --- what stands where, against the page's data and the laws of the machine


def chosen(page, number):
    """Show a motion from its begin; what the page has of it and of the machine."""
    return page.evaluate(
        """number => { const m = motions[number], {rows, events, cam} = data; choose(m);
          const part = (columns, from, to) => Object.fromEntries(
            Object.entries(columns).map(([key, all]) => [key, [...all.slice(from, to)]]));
          return {rpm: m.rpm, turns: m.turns, rows: part(rows, m.row, m.row + m.rows),
                  events: part(events, m.event, m.event + m.events), cam: part(cam, 0, Infinity),
                  follower: data.follower, outline: {...data.outline, x: [...data.outline.x],
                  y: [...data.outline.y]}}; }""",
        number,
    )


def size_of(page, panel):
    return page.evaluate(f"(({{width, height}}) => [width, height])(boxOf($('{panel}')))")


def texts_in(page, panel, kind="text"):
    """The words in a drawing, each with its place."""
    return page.evaluate(
        f"""[...$('{panel}').querySelectorAll('{kind}')].map(text =>
          [text.textContent, +text.getAttribute('x'), +text.getAttribute('y')])"""
    )


CHAOS_AT_680 = 7


def test_the_time_response_has_its_axes_words_and_events_where_they_belong(page):
    """A share of its height is the force; positions have 8 % of room, forces the same above."""
    m = chosen(page, CHAOS_AT_680)
    wide, high = size_of(page, "time")
    assert high == 208.0
    split = high - 0.48 * high
    axes = page.evaluate(
        "[time.upper, time.lower].map(({left, top, right, bottom}) => [left, top, right, bottom])"
    )
    assert axes == [
        pytest.approx([46.0, 24.0, wide - 8.0, split]),
        pytest.approx([46.0, split + 30.0, wide - 8.0, high - 34.0]),
    ]
    c, q = m["cam"]["c"], m["rows"]["q"]
    low, top = min(*c, *q), max(*c, *q)
    room = 0.08 * (top - low)
    assert page.evaluate("time.upper.y") == pytest.approx([low - room, top + room], rel=1e-6)
    omega, f = m["rpm"] * np.pi / 30.0, m["follower"]
    assert (f["damping"], f["gravity"], f["preload"]) == (0.0, 0.0, 0.0)
    forces = f["stiffness"] * np.array(c) + f["mass"] * omega**2 * np.array(m["cam"]["c2"])
    assert page.evaluate("time.lower.y") == pytest.approx([0.0, 1.08 * max(forces)], rel=1e-6)
    layers, body, line = page.evaluate(
        """(({children: [body, line, ...more]}) => [[body, line, ...more].map(node =>
             node.getAttribute("class")), body.getAttribute("d"), line.getAttribute("d")])
           ($("time").querySelector("g"))"""
    )
    assert layers[:4] == ["under", "lines camline", "lines flight", "lines rest"]
    assert set(layers[4:]) == {"kind0"}
    assert body == f"{line}V{split:g}H46.00Z"
    corners = np.array([place.split() for place in line[1:].split("L")], float)
    assert corners[:, 0] == pytest.approx(np.linspace(46.0, wide - 8.0, 721), abs=0.01)
    words = [one for one in texts_in(page, "time") if len(one[0]) > 4]
    assert words == [
        ["\xa0\xa0●\xa0impact", pytest.approx(wide - 8.0), 13],
        ["position of follower and cam (m)", 4, 13],
        ["contact force (N); impacts as lines", 4, pytest.approx(split + 22.0)],
        ["turns 1 to 3 of 16", pytest.approx(wide - 8.0), pytest.approx(split + 22.0)],
        ["cam angle θ (deg)", pytest.approx(wide - 8.0), high - 4.0],
    ]
    angles = [one for one in texts_in(page, "time") if one[2] == high - 19.0]
    places = [46.0 + k * (wide - 54.0) / 6.0 for k in range(7)]
    assert [one[1] for one in angles] == pytest.approx(places, abs=0.01)
    assert [one[0] for one in angles] == ["0", "180"] * 3 + ["0"]
    seen = [k for k, t in enumerate(m["events"]["t"]) if t <= 3.0]
    assert len(seen) > 2
    marks = page.evaluate(
        "[...$('time').querySelectorAll('circle.kind0')].map(mark => ['cx', 'cy', 'r']"
        ".map(key => +mark.getAttribute(key)))"
    )
    strokes = page.evaluate(
        "[...$('time').querySelectorAll('path.struck')].map(path => path.getAttribute('d'))"
    )
    assert len(marks) == len(strokes) == len(seen)
    hardest = max(map(abs, m["events"]["u"]))
    for k, (x, y, r), stroke in zip(seen, marks, strokes, strict=True):
        t, u = m["events"]["t"][k], m["events"]["u"][k]
        lift = np.interp(t % 1.0 * 360.0, m["cam"]["theta_deg"], c)
        assert x == pytest.approx(46.0 + t / 3.0 * (wide - 54.0), abs=0.01)
        share = (lift - low + room) / (top - low + 2.0 * room)
        assert y == pytest.approx(split - share * (split - 24.0), abs=0.3)
        assert r == 3
        tall = abs(u) / hardest * (high - 64.0 - split)
        assert stroke == f"M{x:.2f} {high - 34.0:g}v-{tall:.2f}"
    assert page.evaluate("[0, 2.9, 3, 4, 15.5].map(t => windowOf(state.motion, t))") == [
        [0, 3], [0, 3], [3, 6], [3, 6], [13, 16],
    ]  # fmt: skip
    one_turn = page.evaluate("[340, 170, 130, 70, 40].map(wide => angleTicks([0, 1], wide).length)")
    assert one_turn == [7, 5, 3, 3, 2]  # every 60, 90, 180, 180 and 360 deg


def test_the_machine_fills_its_panel_and_moves_as_the_motion_does(page):
    m = chosen(page, CHAOS_AT_680)
    wide, high = size_of(page, "machine")
    size = min(1.6, high / 300.0, wide / 330.0)
    assert 1.0 < size < 1.6
    body = m["outline"]
    assert body["ratio"] == 1
    reach = max(np.hypot(body["x"], body["y"]))
    radius = max(*m["rows"]["q"], *m["cam"]["c"]) + body["rise"]
    scale = min(
        (high - 120.0 * size - 16.0) / (reach + max(reach, radius)), (wide - 16) / 2 / reach
    )
    y = high - 8.0 - reach * scale
    assert page.evaluate("[machine.size, machine.scale, machine.x, machine.y]") == pytest.approx(
        [size, scale, wide / 2.0, y], rel=1e-5
    )
    path = page.evaluate("machine.cam.querySelector('.shining').getAttribute('d')")
    outline = [tuple(map(float, place.split())) for place in path.strip("MZ").split("L")]
    assert np.array(outline) == pytest.approx(
        np.column_stack([body["x"], -np.array(body["y"])]) * scale, abs=0.011
    )
    t, events = m["events"]["t"][2], m["events"]
    hardness = np.sqrt(abs(events["u"][2]) / max(map(abs, events["u"])))
    page.evaluate("t => { state.t = t; drawNow(); }", t + 0.03)  # half of what a flash takes
    q, c, phase = page.evaluate("(({q, c, phase}) => [q, c, phase])(at(state.motion, state.t))")
    tip = y - (q + body["rise"]) * scale
    moved = page.evaluate("[machine.cam, machine.follower, machine.spring]"
                          ".map(part => part.getAttribute('transform'))")  # fmt: skip
    numbers = [[float(x) for x in re.findall(r"-?\d+\.?\d*", text)] for text in moved]
    assert numbers[0] == pytest.approx([wide / 2.0, y, -phase], abs=0.01)
    assert numbers[1] == pytest.approx([wide / 2.0, tip, size], abs=0.01)
    stretch = (tip - 82.0 * size - 5.0) / 100.0  # from below the frame to the follower's top
    assert numbers[2] == pytest.approx([wide / 2.0, 5.0, size, stretch], abs=0.01)
    flash = page.evaluate(
        "['cx', 'cy', 'r', 'opacity'].map(key => +machine.flash.getAttribute(key))"
    )
    sides = page.evaluate("(({x, y, width, height}) => [x, y, width, height])"
                          "(machine.follower.getBBox())")  # fmt: skip
    assert sides == pytest.approx([-22.0, -82.0, 44.0, 82.0])  # its mass above, its tip below
    path = page.evaluate("machine.follower.querySelector('path').getAttribute('d')")
    assert path == "M0 0L-7 -14V-18H7V-14Z"  # an edge, which stands on the cam
    legend = page.evaluate("COLOUR_WORDS.contact")
    assert legend == "always on the cam"
    surface = y - (c + body["rise"]) * scale
    assert flash == pytest.approx([wide / 2, surface, 4 + (6 + 22 * hardness) / 2, 0.5], abs=0.02)
    page.evaluate("t => { state.t = t; drawNow(); }", t + 0.07)
    assert page.evaluate("machine.flash.style.display") == "none"
    length = max(x for x in (0.1, 0.2, 0.5, 1.0) if x * scale <= 60.0)
    bar, *key = [one for one in texts_in(page, "machine") if "θ" not in one[0]]
    assert bar == [f"{length:g} m", pytest.approx(wide - 4.0), pytest.approx(high - 6.0)]
    drawn = page.evaluate("[...$('machine').querySelectorAll(':scope > .axis')].pop()"
                          ".getAttribute('d')")  # fmt: skip
    numbers = [float(x) for x in re.findall(r"-?\d+\.?\d*", drawn)]
    left, base = wide - 4.0 - length * scale, high - 20.0
    assert numbers == pytest.approx([left, base, -5.0, 5.0, wide - 4.0, -5.0], abs=0.01)
    meant = ["path in flight", "path on the cam", "spring", "contact", "inertia −m·a"]
    assert key == [[words, 21, 12 + 15 * k] for k, words in enumerate(meant)]
    assert page.evaluate("[angleWords(state.motion, 12.34)]") == [
        f"θ 12.3°, turn {int(t + 0.07) + 1} of 16"
    ]


def test_the_diagram_has_its_marks_where_they_belong(page):
    m = chosen(page, CHAOS_AT_680)
    wide, high = size_of(page, "diagram")
    right, bottom = wide - 48.0, high - 34.0  # beside it letters of corners
    assert page.evaluate("[diagram.left, diagram.top, diagram.right, diagram.bottom]") == [
        46, 28, pytest.approx(right), pytest.approx(bottom),
    ]  # fmt: skip
    low, top = page.evaluate("state.x")
    assert (low, top) == pytest.approx((672.0 - 0.015 * 14.0, 686.0 + 0.015 * 14.0))

    def x_of(rpm):
        return 46.0 + (rpm - low) / (top - low) * (right - 46.0)

    def y_of(value, ends=(0.0, 360.0)):
        return bottom - (value - ends[0]) / (ends[1] - ends[0]) * (bottom - 28.0)

    words = texts_in(page, "overlay")
    assert ["θ (deg)", 2, 13] in words
    assert ["speed (rpm)", pytest.approx(right), pytest.approx(high - 4.0)] in words
    corners = page.evaluate("data.corners")
    letters = {one[0]: one[1:] for one in words if one[0] in corners}
    assert {name: y for name, (_, y) in letters.items()} == pytest.approx(
        {name: y_of(angle) + 3.0 for name, angle in corners.items()}, abs=0.01
    )
    assert [letters[name][0] - right for name in "abcdef"] == pytest.approx([5, 15, 5, 15, 5, 5])
    angles = [one[:1] + one[2:] for one in words if one[1] == 41]
    assert angles == [[f"{x}", pytest.approx(y_of(x) + 4, abs=0.01)] for x in range(0, 361, 60)]
    (event,) = page.evaluate("data.bifurcations")
    number, handle = page.evaluate(
        "[...overlay.querySelectorAll('circle')].map(mark => ['cx', 'cy', 'r']"
        ".map(key => +mark.getAttribute(key)))"
    )
    assert number == pytest.approx([x_of(event["rpm"]), 14.0, 8.0], abs=0.01)
    assert handle == pytest.approx([x_of(680.0), bottom, 8.0], abs=0.01)
    (diamond,) = page.evaluate("[...overlay.querySelectorAll('.diamond')].map(one =>"
                               " one.getAttribute('d'))")  # fmt: skip
    x, y = x_of(event["rpm"]) - 5.0, y_of(event["theta_deg"][0])
    assert diamond == f"M{x:.2f} {y:.2f}l5 -5l5 5l-5 5z"
    chosen(page, CHAOS_AT_680 + 1)  # of one impact a turn
    ring = page.evaluate("['cx', 'cy', 'r'].map(key => +overlay.querySelector('.ring')"
                         ".getAttribute(key))")  # fmt: skip
    impact = page.evaluate("pointsOf(state.motion)[0][pointsOf(state.motion)[1]]")
    assert ring == pytest.approx([x_of(680.0), y_of(impact), 6.0], abs=0.01)
    place = page.evaluate("['x', 'y'].map(key => +overlay.querySelector('.drag-me')"
                          ".getAttribute(key))")  # fmt: skip
    assert place == pytest.approx([x_of(680.0) + 13.0, bottom - 6.0], abs=0.01)
    page.evaluate("choose(motions.find(m => m.rpm === 686))")  # beyond four fifths: at the left
    label = page.evaluate("['x', 'text-anchor'].map(key => overlay.querySelector('.drag-me')"
                          ".getAttribute(key))")  # fmt: skip
    assert label == [f"{x_of(686.0) - 13.0:.2f}", "end"]
    page.evaluate("goTo(data.bifurcations[0])")
    page.wait_for_timeout(60)
    half = 1.03 * 14.0 / 24.0
    assert page.evaluate("state.x") == pytest.approx([event["rpm"] - half, event["rpm"] + half])
    theta = event["theta_deg"][0]
    assert page.evaluate("state.y") == pytest.approx([theta - 45.0, theta + 45.0])
    page.evaluate("state.motion = motions.find(m => m.rpm === 686); drawCursor()")
    aside = page.evaluate(
        "(one => [one.textContent, +one.getAttribute('x'),"
        " one.getAttribute('text-anchor')])(overlay.querySelector('.drag-me'))"
    )
    assert aside == ["now at 686 rpm ▸", pytest.approx(right - 6.0, abs=0.01), "end"]
    page.evaluate("state.x = [690, 700]; drawDiagram()")
    aside = page.evaluate(
        "(one => [one.textContent, +one.getAttribute('x'),"
        " one.getAttribute('text-anchor')])(overlay.querySelector('.drag-me'))"
    )
    assert aside == ["◂ now at 686 rpm", 52, "start"]
    page.evaluate("state.quantity = 'u'; Object.assign(state, wholeView())")
    view = page.evaluate("state.y")
    page.evaluate("state.quantity = 'theta'")
    speeds = page.evaluate("inDiagram.flatMap(m => [...data.points.u.slice(m.impact,"
                           " m.impact + m.impacts)])")  # fmt: skip
    room = 0.04 * (max(speeds) - min(speeds))
    assert view == pytest.approx([min(speeds) - room, max(speeds) + room])
    assert m["rpm"] == 680


def test_each_point_and_line_of_the_diagram_has_the_colour_of_its_motion(page):
    """As a pen is told: a mark at each impact, lines of stable orbits solid, of others dashed."""
    found = page.evaluate(
        """() => { const marks = [], lines = [];
          const pen = {
            fillRect(x, y, wide, high) {
              marks.push([this.fillStyle, this.globalAlpha, x + wide / 2, y + high / 2]);
            },
            beginPath() { this.path = []; },
            moveTo(...place) { this.path.push([...place, 0]); },
            lineTo(...place) { this.path.push([...place, 1]); },
            setLineDash(dash) { this.dash = dash.length > 0; },
            stroke() { lines.push([this.strokeStyle, this.dash, this.lineWidth, this.path]); },
          };
          const resting = inDiagram.filter(m => m.rpm === 674), labels = resting.map(m => m.label);
          for (const m of resting) m.label = "contact";
          drawPoints(pen);
          resting.forEach((m, k) => { m.label = labels[k]; });
          for (const branch of data.branches) drawBranch(pen, branch, "theta_deg");
          const motions = inDiagram.filter(m => m.origin !== "solved").map(m => {
            const [values, from, to] = pointsOf(m);
            return [colours[m.colour], m.rpm, [...values.slice(from, to)]];
          });
          const branches = data.branches.map(({colour, rpm, theta_deg, stable, label}) =>
            [colours[colour], [...rpm], theta_deg.map(all => [...all]), [...stable], label]);
          const {left, right, top, bottom} = diagram;
          return [marks, lines, motions, branches, [left, right, top, bottom, ...state.x],
            [colours.contact, colours.aperiodic, resting.length]]; }"""
    )
    marks, lines, motions, branches, (left, right, top, bottom, low, high), names = found
    contact, aperiodic, resting = names

    def place(rpm, theta):
        across = left + (rpm - low) / (high - low) * (right - left)
        return [across, bottom - theta / 360.0 * (bottom - top)]

    dots = [[colour, *place(rpm, theta)] for colour, rpm, phases in motions for theta in phases]
    assert len(dots) > 100
    points, bars = marks[: len(dots)], marks[len(dots) :]
    assert [[colour, *at] for colour, _, *at in points] == [
        [colour, pytest.approx(x), pytest.approx(y)] for colour, x, y in dots
    ]
    assert {colour for colour, opacity, *_ in points if opacity < 1} == {aperiodic}
    bar = [contact, 1, pytest.approx(place(674, 0.0)[0]), bottom - 2.5]  # it is 5 px high
    assert bars == [bar] * resting
    assert resting > 0
    assert len(lines) == 2 * len(branches)
    for k, (colour, rpms, phases, stable, label) in enumerate(branches):
        pieces: dict[bool, set] = {True: set(), False: set()}
        for values in phases:
            corners = [tuple(np.round(place(*at), 6)) for at in zip(rpms, values, strict=True)]
            for j in range(1, len(rpms)):
                is_one = label[j] == label[j - 1] and abs(values[j] - values[j - 1]) < 40.0
                if is_one:
                    pieces[bool(stable[j])].add((corners[j - 1], corners[j]))
        for is_stable, line in ((True, lines[2 * k]), (False, lines[2 * k + 1])):
            assert line[:3] == [colour, not is_stable, 2 if is_stable else 1.5]
            corners = [tuple(np.round(corner[:2], 6)) for corner in line[3]]
            drawn = {
                tuple(corners[j - 1 : j + 1]) for j, (*_, is_line) in enumerate(line[3]) if is_line
            }
            assert drawn == pieces[is_stable]
    assert all(any(line[3] for line in lines[k::2]) for k in (0, 1))


def test_each_exponent_has_its_mark_in_the_strip(page):
    """One below -1.5, also one of minus infinity, has a longer mark at the lower edge."""
    marks, exponents, (low, high) = page.evaluate(
        """() => { const marks = [], own = inDiagram.slice(0, 2).map(m => m.exponent);
          const pen = {fillRect(...box) { marks.push([this.fillStyle, ...box]); }};
          inDiagram[0].exponent = -Infinity;
          inDiagram[1].exponent = -2;
          drawStrip(pen, overlay, 600, 500, diagram.right);
          const exponents = inDiagram.map(m => [colours[m.colour], m.rpm, m.exponent]);
          own.forEach((exponent, k) => { inDiagram[k].exponent = exponent; });
          drawDiagram();
          return [marks, exponents.filter(([, , exponent]) => exponent !== null), state.x]; }"""
    )
    right = page.evaluate("diagram.right")
    most = max(0.05, *(exponent for *_, exponent in exponents))
    room = 0.1 * (most + 1.5)
    wanted = []
    for colour, rpm, exponent in exponents:
        x = 46.0 + (rpm - low) / (high - low) * (right - 46.0) - 1.0
        y = 466.0 - 64.0 * (exponent + 1.5 + room) / (most + 1.5 + 2.0 * room) - 1.0
        box = [x, y, 2, 2] if exponent >= -1.5 else [x, 461.0, 2, 5]
        wanted.append([colour, *map(pytest.approx, box)])
    assert marks == wanted
    assert len({exponent > 0 for *_, exponent in exponents}) == 2


def test_the_hint_tells_the_motion_below_it_and_stays_beside_the_diagram(page):
    """Its lines broke as at the place before, and it stood too high: here by a short one there."""
    wide, high = size_of(page, "diagram")
    words, boxes = page.evaluate(
        """([wide, high]) => { const m = inDiagram.find(one => one.label === "aperiodic");
          const [values, k] = pointsOf(m), words = [], found = [];
          for (const [x, y] of [[diagram.X(m.rpm), diagram.Y(values[k])],
              [diagram.left + 1, 60], [diagram.right - 1, 60], [90, 110], [300, diagram.top + 1]]) {
            $("hint").style.left = `${wide - 60}px`;
            showHint(x, y);
            const box = $("hint").getBoundingClientRect(), panel = host.getBoundingClientRect();
            const near = motionNear(x, y);
            words.push([$("hint").textContent, near.rpm, name(near), near.exponent]);
            found.push([box.left - panel.left, box.width, box.top - panel.top, box.height, x, y]);
          }
          showHint(diagram.left - 5, 60);
          found.push($("hint").hidden);
          return [words, found]; }""",
        [wide, high],
    )
    assert boxes.pop() is True  # there is nothing beside the diagram
    for told, rpm, name, exponent in words:
        more = "" if exponent is None else f"; Lyapunov exponent {exponent:.3f} per turn"
        assert told == f"{rpm:.10g} rpm: {name}{more}".replace("-", "−")
    for left, width, above, height, x, y in boxes:
        assert left == pytest.approx(max(0.0, min(x + 14.0, wide - width)), abs=0.02)
        assert above == pytest.approx(max(0.0, y - height - 12.0), abs=0.02)


def test_keys_and_sliders_do_what_they_say(page):
    m = chosen(page, CHAOS_AT_680)
    told = {}
    for value in (0, 50, 100):
        page.evaluate("value => { $('pace').value = value; setPace(); }", value)
        told[page.evaluate("state.pace")] = page.inner_text("#slowed")
    assert [*told.values()] == ["450× slower", "45× slower", "4.5× slower"]  # 11.33 turns a second
    assert [*told] == pytest.approx([40.0, 4.0, 0.4])
    page.evaluate("state.pace = 0.05; showPace()")
    assert page.inner_text("#slowed") == "1.8× faster"  # 0.5667 turns a turn
    page.evaluate("$('pace').value = 50; setPace(); document.activeElement.blur()")
    for key, k in ((".", 0), (".", 1), (",", 0), (",", -1), (".", 0)):  # round and round
        page.keyboard.press(key)
        t, u = m["events"]["t"][k], m["events"]["u"][k]
        assert page.evaluate("state.t") == pytest.approx(t, abs=1e-6)
        said = page.evaluate("machine.angle.textContent").replace("−", "-")
        assert said == f"θ {t * 360.0 % 360.0:.1f}°: impact, u⁻ {u:.3f} m/s"
    page.focus("#diagram")
    rpms = []
    for key in ("ArrowRight", "ArrowLeft", "Shift+ArrowLeft", "Shift+ArrowRight"):
        page.keyboard.press(key)
        rpms.append(page.evaluate("state.motion.rpm"))
    assert rpms[1] == 680
    assert rpms[0] > 680
    assert rpms[2:] == [672, 682]  # all there are; ten, of which five are of solved orbits
    chosen(page, CHAOS_AT_680)
    names = page.evaluate("motionsAt(state.motion).map(name)")
    found = []
    for key in ("ArrowUp", "ArrowUp", "ArrowUp", "ArrowDown"):
        page.keyboard.press(key)
        found.append(page.evaluate("name(state.motion)"))
    assert names == ["aperiodic", "P(1;1)", "P(1;1), unstable"]
    assert found == [names[1], names[2], names[0], names[2]]
    chosen(page, CHAOS_AT_680)
    box = page.locator("#time").bounding_box()
    at = page.evaluate("time.upper.X(1.5)")
    page.mouse.click(box["x"] + at, box["y"] + 60)
    assert page.evaluate("state.t") == pytest.approx(1.5, abs=0.01)
    page.mouse.click(box["x"] + 2, box["y"] + 60)  # left of the axis
    assert page.evaluate("state.t") == 0
    assert page.evaluate("clearness(state.motion, 0.01)") == 1  # it does not play
    page.evaluate("state.playing = true")
    clear = page.evaluate("[0, 0.03, 8, 15.97, 16].map(t => clearness(state.motion, t))")
    page.evaluate("state.playing = false")
    assert clear == pytest.approx([0.05, 0.25, 1.0, 0.2, 0.0])
    last = page.evaluate("data.stops.length") - 1
    onward = page.evaluate("last => [-1, 0, last].map(wordsOfOnward)", last)
    second = page.evaluate("data.stops[1].name")
    assert onward == ["Start the tour ▸", f"Next: {second} ▸", "Now drag the speed ▸"]
    assert page.inner_text("#stop-words") == (
        "Take the tour: each stop shows one thing that this machine does. Or drag the speed."
    )
    for button, what in (("#copy", "command"), ("#link", "link")):
        page.evaluate("button => $(button.slice(1)).click()", button)
        page.wait_for_function("$('copied').textContent !== ''")
        assert page.evaluate("$('copied').textContent") == f"The {what} is copied."
        page.evaluate("$('copied').textContent = ''")
    page.evaluate("choose(motions.find(m => m.label === 'contact'))")
    resting = page.inner_text("#command")
    assert resting.endswith("--set 'run.start={q: null, v: null, theta_deg: 0}'")  # on the cam
    assert page.evaluate("$('choices').textContent") == "no other motion on this page"
    # a stop may have a speed of the diagram; it is no other motion of that speed
    offered = page.evaluate("""() => { const m = motions.find(one => one.origin === 'stop');
      const {rpm} = m; m.rpm = 680;
      const found = motionsAt(motions.find(one => one.rpm === 680 && one.origin !== 'stop'));
      m.rpm = rpm; return found.map(one => one.origin); }""")
    assert len(offered) == 3
    assert "stop" not in offered
    legend = page.evaluate("[...$('legend').querySelectorAll('li')].map(one => one.textContent)")
    assert legend == [
        "period 1",
        "aperiodic",
        "lines: solved orbits; dashed: unstable; ◇\xa0bifurcations",
    ]
    # the motion nearest to the middle, 679 rpm, is a solved orbit that is stable
    near = page.evaluate("Math.min(...motions.map(m => Math.abs(m.rpm - 679)))")
    assert page.evaluate("[first().rpm, first().label]") == [pytest.approx(679 + near), "P(1;1)"]
    # without solved orbits 678 and 680 rpm are equally near: the first of all that are there
    number, wanted = page.evaluate(
        """() => { const all = inDiagram.splice(0);
             inDiagram.push(...all.filter(m => m.origin !== "solved"));
             const near = inDiagram.filter(m => Math.abs(m.rpm - 679) === 1);
             const {number} = first();
             inDiagram.splice(0, Infinity, ...all);
             return [number, near.map(m => [m.rpm, m.number])]; }"""
    )
    assert {rpm for rpm, _ in wanted} == {678, 680}
    assert [678, number] == min(wanted)


def test_the_phase_plane_and_the_strip_of_exponents_have_room_for_what_they_show(page):
    """A twentieth of the largest gap at the left, 6 % at the right, a twentieth of the rates."""
    chosen(page, CHAOS_AT_680)
    wide, high = size_of(page, "phase")
    axes = page.evaluate("(({left, top, right, bottom}) => [left, top, right, bottom])(phase)")
    assert axes == pytest.approx([46.0, 24.0, wide - 8.0, high - 34.0])
    path = page.evaluate("$('flights').getAttribute('d')")
    line = np.array([place.split() for place in path[1:].replace("M", "L").split("L")], float)
    x, y = page.evaluate("[phase.x, phase.y]")
    gap = x[0] + (line[:, 0].max() - 46.0) / (wide - 54.0) * (x[1] - x[0])
    assert x == pytest.approx([-0.05 * gap, 1.06 * gap], rel=2e-3)
    rates = np.array([line[:, 1].max(), line[:, 1].min()])  # from below
    low, top = y[0] + (high - 34.0 - rates) / (high - 58.0) * (y[1] - y[0])
    assert y == pytest.approx([low - 0.05 * (top - low), top + 0.05 * (top - low)], abs=0.2)
    words = [one for one in texts_in(page, "phase") if len(one[0]) > 4]
    assert words == [
        ["relative velocity u (m/s)", 4, 13],
        ["gap q − c (m)", pytest.approx(wide - 8.0), high - 4.0],
    ]
    page.evaluate("choose(motions.find(m => m.label === 'contact'))")
    still = [one[0] for one in texts_in(page, "phase") if "flight" in one[0]]
    assert still == ["no flight"]
    assert page.evaluate("[phase.x, phase.y]") == [[-0.05, 1.06], [-1.1, 1.1]]
    chosen(page, CHAOS_AT_680)
    page.evaluate("setTall(true); drawAll()")
    wide, high = size_of(page, "diagram")
    assert high > 400.0
    assert page.evaluate("diagram.bottom") == pytest.approx(high - 34.0 - 84.0)
    words = texts_in(page, "overlay")
    assert ["largest exponent per turn", 4, pytest.approx(high - 34.0 - 64.0 - 5.0)] in words
    exponents = page.evaluate("inDiagram.map(m => m.exponent).filter(Number.isFinite)")
    low, top = max(min(-0.05, *exponents), -1.5), max(0.05, *exponents)
    room = 0.1 * (top - low)
    zero = page.evaluate("+[...overlay.querySelectorAll('line.axis')].find(line =>"
                         " +line.getAttribute('x1') === 46).getAttribute('y1')")  # fmt: skip
    share = (0.0 - low + room) / (top - low + 2.0 * room)
    assert zero == pytest.approx(high - 34.0 - 64.0 * share, abs=0.01)
    page.evaluate("setTall(false); drawAll()")


def test_a_saved_picture_says_what_it_shows_and_has_its_name(page):
    chosen(page, CHAOS_AT_680)
    page.evaluate("state.t = 0.25; drawNow()")
    with page.expect_download() as saved:
        page.click("#save")
    assert saved.value.suggested_filename == "cam-680-rpm.svg"
    root = ElementTree.parse(saved.value.path()).getroot()
    svg = "{http://www.w3.org/2000/svg}"
    title, *legend = [one for one in root if one.tag == f"{svg}text"]
    assert title.text == "680 rpm: aperiodic, θ = 90.0°"
    assert (title.get("x"), title.get("y")) == ("10", "20")
    wide, high = float(root.get("width")), float(root.get("height"))
    named = ["period 1", "aperiodic", "lines: solved orbits; dashed: unstable; ◇\xa0bifurcations"]
    assert [one.text for one in legend] == named
    places = [(float(one.get("x")), float(one.get("y"))) for one in legend]
    lefts = [10.0, 10.0 + 7 * len(named[0]) + 30]
    lefts.append(lefts[1] + 7 * len(named[1]) + 30)
    assert places == [
        (lefts[0] + 15.0, high - 22.0), (lefts[1] + 15.0, high - 22.0), (lefts[2], high - 22.0),
    ]  # fmt: skip
    panels = [one for one in root if one.tag == f"{svg}svg"]
    assert [one.get("id") for one in panels] == ["machine", "time", "phase", "overlay"]
    marks = page.evaluate(
        """() => { const place = make("div"), shown = {};
          document.body.append(place);
          const root = place.attachShadow({mode: "open"}), {x} = state;
          for (state.x of [x, [690, 700]]) { // with the handle, and with the speed beside the view
            drawDiagram();
            root.innerHTML = picture();
            for (const node of root.querySelectorAll("#overlay .chosen *"))
              shown[node.getAttribute("class")] = getComputedStyle(node).display !== "none";
          }
          state.x = x;
          place.remove();
          return shown; }"""
    )
    to_be_dragged = dict.fromkeys(["handle", "grip", "label", "drag-me"], False)
    assert marks == {"cursor": True, **to_be_dragged}
    boxes = [[float(one.get(key)) for key in ("x", "y", "width", "height")] for one in panels]
    assert min(box[0] for box in boxes) == 10.0
    assert min(box[1] for box in boxes) == 40.0
    assert max(x + w for x, _, w, _ in boxes) == pytest.approx(wide - 10.0)
    assert max(y + h for _, y, _, h in boxes) == pytest.approx(high - 50.0)


# --- gestures: each against what the pointer, the wheel or a key should do to the view

GESTURE = """([on, kind, more]) => new Promise(done => {
  const {left, top} = $(on).getBoundingClientRect();
  const {x = 0, y = 0, ...others} = more, place = {clientX: left + x, clientY: top + y};
  const kinds = {pointer: PointerEvent, wheel: WheelEvent, key: KeyboardEvent, dbl: MouseEvent};
  const Kind = kinds[/^(pointer|wheel|key|dbl)/.exec(kind)[1]];
  $(on).setPointerCapture = () => {}; // of a pointer that no hand moves
  const event = new Kind(kind, {bubbles: true, cancelable: true, ...place, ...others});
  $(on).dispatchEvent(event);
  const told = [event.defaultPrevented, event.clientX - left, event.clientY - top];
  requestAnimationFrame(() => requestAnimationFrame(() => done(told)));
})"""


def gesture(page, kind, on="diagram", **more):
    """An event on a panel; whether the page keeps it from the browser, and its place there.

    Places of the wheel and of clicks are whole pixels of the window.
    """
    return page.evaluate(GESTURE, [on, kind, more])


def view(page):
    """The ends of the view in rpm and deg, and the box of the axes in pixels."""
    x, y, box = page.evaluate(
        "[state.x, state.y, [diagram.left, diagram.right, diagram.top, diagram.bottom]]"
    )
    assert page.evaluate("[diagram.x, diagram.y]") == [x, y]  # it is drawn
    return np.array(x), np.array(y), box


def under(seen, x, y):
    """The speed and the phase at a place in pixels."""
    (low, high), (least, most), (left, right, top, bottom) = seen
    return np.array(
        [low + (x - left) / (right - left) * (high - low),
         least + (bottom - y) / (bottom - top) * (most - least)]
    )  # fmt: skip


def zoomed(before, after, factor, x, y):
    """Whether both ranges are so many times as wide, about what lies at a place in pixels."""
    assert np.ptp(after[0]) == pytest.approx(factor * np.ptp(before[0]))
    assert np.ptp(after[1]) == pytest.approx(factor * np.ptp(before[1]))
    assert under(after, x, y) == pytest.approx(under(before, x, y))


def test_axes_have_lines_from_end_to_end_and_each_number_in_full(page):
    words = "a number that is told in words"
    lines, texts, frame, clip = page.evaluate(
        """words => { const svg = document.createElementNS(SVG, "svg");
          svg.id = "sheet";
          const axes = new Axes(svg, 50, 20, 450, 220, [990, 1030], [-0.00026, 0.00011]);
          axes.ticksX(5);
          axes.ticksX(0, [[1000, words]]);
          axes.ticksY(6);
          axes.ticksY(0, [[0, words]]);
          axes.frame();
          const clipped = axes.clip().getAttribute("clip-path"), rect = svg.querySelector("rect");
          const of = (node, names) => names.map(key => +node.getAttribute(key));
          return [[...svg.querySelectorAll("line")].map(line => of(line, ["x1", "x2", "y1", "y2"])),
                  [...svg.querySelectorAll("text")].map(text => [text.textContent,
                    ...of(text, ["x", "y"]), text.getAttribute("text-anchor")]),
                  svg.querySelector(".axis").getAttribute("d"),
                  [clipped, rect.parentNode.id, ...of(rect, ["x", "y", "width", "height"])]]; }""",
        words,
    )
    across = [(f"{rpm}", 50.0 + 10.0 * (rpm - 990)) for rpm in range(990, 1031, 10)]
    up = [(text, 220.0 - (value + 0.00026) / 0.00037 * 200.0) for text, value in
          (("−0.0002", -2e-4), ("−0.0001", -1e-4), ("0.0000", 0.0), ("0.0001", 1e-4))]  # fmt: skip
    across.append((words, 150.0))
    up.append((words, up[2][1]))
    wanted = [[x, x, 20.0, 220.0] for _, x in across] + [[50.0, 450.0, y, y] for _, y in up]
    assert np.array(lines) == pytest.approx(np.array(wanted), abs=0.006)
    last = 458.0 - 4 * 7.6 / 2  # a number at the right end stays in the drawing
    below = [[text, pytest.approx(min(x, last)), 235.0, "middle"] for text, x in across]
    beside = [[text, 45.0, pytest.approx(y + 4.0, abs=0.006), "end"] for text, y in up]
    assert texts == below + beside
    assert frame == "M50 20V220H450"
    assert clip == ["url(#sheet-clip20)", "sheet-clip20", 50, 20, 400, 200]


TOGGLES = {
    "close": "state.close",
    "sound": "state.sound",
    "tall": "host.classList.contains('tall')",
    "present": "state.presents && document.documentElement.classList.contains('presenting')",
}  # fmt: skip


def test_each_button_that_stays_pressed_tells_what_holds(page):
    """After clicks, stops of the tour and links; what is pressed changes nothing else."""
    page.evaluate("document.documentElement.requestFullscreen = async () => {}")  # of no screen
    asked = ", ".join(f"[$('{name}').ariaPressed, {what}]" for name, what in TOGGLES.items())

    def pressed():
        found = page.evaluate(f"[{asked}]")
        assert [told for told, _ in found] == [str(holds).lower() for _, holds in found]
        return [name for name, (_, holds) in zip(TOGGLES, found, strict=True) if holds]

    assert pressed() == []
    for name in TOGGLES:
        page.evaluate("name => $(name).click()", name)
        assert pressed() == [name]
        page.evaluate("name => $(name).click()", name)
        assert pressed() == []
    for is_close in (True, False):
        page.evaluate("close => showStop({...data.stops[0], close})", is_close)
        assert pressed() == ["close"] * is_close
    for link, wanted in (("&close=1&tall=1&present=1", ["close", "tall", "present"]), ("", [])):
        page.evaluate("link => { history.replaceState(null, '', link); follow(); }",
                      f"#rpm=680&t=0{link}")  # fmt: skip
        assert pressed() == wanted
    page.evaluate("choose(motions[data.stops.at(-1).motion]); setClose(true); goOnward()")
    assert pressed() == []
    words = page.evaluate("[true, false].map(on => { play(on); return $('play').textContent; })")
    assert words == ["Pause", "Play"]


def test_the_table_of_the_follower_has_each_constant_in_full(page, valve):
    units = {"mass": "kg", "stiffness": "N/m", "damping": "N s/m", "preload": "N",
             "gravity": "m/s²", "restitution": ""}  # fmt: skip
    for opened_page, machine in ((page, CHAPTER), (valve, VALVE)):
        rows = opened_page.evaluate(
            "[...$('constants').rows].map(row => [...row.cells].map(cell => cell.textContent))"
        )
        follower = machine.load({}).follower
        values = {key: f"{getattr(follower, key):.10g} {unit}" for key, unit in units.items()}
        assert dict(rows) == values
        assert len(rows) == len(values)


def test_numbers_of_bifurcations_lead_there_wherever_they_stand(page):
    """Of four, the first stands right of the axis's symbol and one more aside of its line."""
    speeds = [672.0, 673.2, 673.25, 680.0]
    symbol, discs, events = page.evaluate(
        """speeds => { const [one] = data.bifurcations;
          data.bifurcations = speeds.map(rpm => ({...one, rpm}));
          drawDiagram();
          return [diagram.endOfSymbol, [...overlay.querySelectorAll("circle.number")].map(disc =>
            ["cx", "cy"].map(key => +disc.getAttribute(key))),
            data.bifurcations.map(event => [diagram.X(event.rpm), eventWords(event)])]; }""",
        speeds,
    )
    edge, places = symbol + 11.0 - 17.0, []
    for x, _ in events:
        edge = max(x, edge + 17.0)
        places.append(edge)
    assert sum(place > x + 1.0 for place, (x, _) in zip(places, events, strict=True)) == 2
    assert [x for x, _ in discs] == pytest.approx(places, abs=0.01)
    aside = 8.4  # px: half of what is between two discs is 8.5
    found = page.evaluate(
        """places => {
          host.setPointerCapture = () => {};
          const found = [];
          for (const [x, y, pointerType] of places) {
            Object.assign(state, wholeView());
            drawDiagram();
            const {left, top} = host.getBoundingClientRect(); // a sentence above may move it
            const place = {clientX: left + x, clientY: top + y, pointerId: 7, pointerType};
            const send = kind => host.dispatchEvent(new PointerEvent(kind, place));
            send("pointermove");
            const hint = $("hint").textContent;
            send("pointerdown");
            send("pointerup");
            found.push([hint, (state.x[0] + state.x[1]) / 2]);
          }
          return found; }""",
        [
            [x + way * aside, y, kind]
            for x, y in discs
            for way, kind in ((-1, "mouse"), (0, "touch"), (0, "pen"), (1, "mouse"))
        ],
    )
    wanted = [[words, pytest.approx(rpm)] for rpm, (_, words) in zip(speeds, events, strict=True)]
    assert found == [one for one in wanted for _ in range(4)]


def test_what_is_dragged_is_held_also_outside_its_panel(page):
    """By a hand, until its button is up; then what only hovers changes nothing."""
    page.evaluate("['diagram', 'time'].forEach(id => { delete $(id).setPointerCapture; })")
    box = page.locator("#diagram").bounding_box()
    at = {rpm: box["x"] + page.evaluate("rpm => diagram.X(rpm)", rpm) for rpm in (674, 680, 684)}
    page.mouse.move(at[680], box["y"] + 60.0)
    page.mouse.down()
    page.mouse.move(at[684], box["y"] - 40.0)  # above the diagram
    assert page.evaluate("state.motion.rpm") == 684
    page.mouse.up()
    page.mouse.move(at[674], box["y"] + 60.0)
    assert page.evaluate("[state.motion.rpm, pointers.size]") == [684, 0]
    chosen(page, CHAOS_AT_680)
    box = page.locator("#time").bounding_box()
    at = [box["x"] + x for x in page.evaluate("[0.5, 1.25, 2].map(t => time.upper.X(t))")]
    page.mouse.move(at[0], box["y"] + 60.0)
    page.mouse.down()
    page.mouse.move(at[1], box["y"] + box["height"] + 40.0)
    assert page.evaluate("state.t") == pytest.approx(1.25, abs=0.01)
    page.mouse.up()
    page.mouse.move(at[2], box["y"] + 60.0)
    assert page.evaluate("state.t") == pytest.approx(1.25, abs=0.01)


def test_a_click_is_what_moves_less_than_a_hand_shakes(page):
    for moved, rpm in ((3.9, 676), (4.1, 680)):
        page.evaluate("state.motion = motions.find(m => m.rpm === 680); state.x = [674, 678]")
        page.evaluate("drawDiagram()")
        x = page.evaluate("diagram.X(676)")
        gesture(page, "pointerdown", pointerId=7, x=x, y=60)
        gesture(page, "pointermove", pointerId=7, x=x, y=60 + moved)
        gesture(page, "pointerup", pointerId=7, x=x, y=60 + moved)
        assert page.evaluate("state.motion.rpm") == pytest.approx(rpm, abs=0.5)


def test_each_change_of_the_view_ends_the_hint_and_is_kept_in_the_link(page):
    found = page.evaluate(
        """async () => { const keep = keepLink, found = {};
          const frames = () => new Promise(done =>
            requestAnimationFrame(() => requestAnimationFrame(done)));
          let kept = "";
          keepLink = () => { kept = link(); };
          host.setPointerCapture = () => {};
          const {left, top} = host.getBoundingClientRect();
          const send = (Kind, kind, {x = 300, y = 80, ...more} = {}) => host.dispatchEvent(new Kind(
            kind, {bubbles: true, cancelable: true, clientX: left + x, clientY: top + y, ...more}));
          const point = (kind, x, pointerId = 7) => send(PointerEvent, kind, {x, pointerId});
          const ways = {
            wheel: () => send(WheelEvent, "wheel", {deltaY: -100, ctrlKey: true}),
            double: () => send(MouseEvent, "dblclick"),
            drag: () => {
              point("pointerdown", 300);
              for (const kind of ["pointermove", "pointerup"]) point(kind, 340);
            },
            pinch: () => {
              point("pointerdown", 300);
              point("pointerdown", 340, 8);
              for (const kind of ["pointermove", "pointerup"]) point(kind, 380, 8);
              point("pointercancel", 300);
            },
            event: () => $("events").querySelector("button").click(),
            slider: () => { $("speed").value = 7; $("speed").oninput(); },
          };
          for (const id of ["in", "out", "whole"]) ways[id] = () => $(id).click();
          const press = key => send(KeyboardEvent, "keydown", {key, shiftKey: key.length > 1});
          for (const key of ["+", "=", "-", "0"]) ways[key] = () => press(key);
          ways.speed = () => press("ArrowRight");
          for (const quantity of ["u", "q", "theta"])
            ways[quantity] = () => { $("quantity").value = quantity; $("quantity").onchange(); };
          for (const [name, way] of Object.entries(ways)) {
            choose(motionAtSpeed(676));
            Object.assign(state, {x: [674, 678], y: wholeView().y});
            state.y = [state.y[0], (state.y[0] + state.y[1]) / 2];
            drawDiagram();
            const before = new URLSearchParams(link()).get("view");
            showHint(300, 80);
            const hint = $("hint").hidden;
            kept = "";
            way();
            await frames();
            const {x, y} = diagram, told = new URLSearchParams(kept);
            found[name] = [hint, $("hint").hidden, told.get("view") !== before,
              (told.get("view") || "").split("_").map(Number), [...x, ...y], told.get("show")];
          }
          keepLink = keep;
          return found; }"""
    )
    assert len(found) == 17
    for name, (was_hidden, is_hidden, is_new, told, shown, quantity) in found.items():
        assert (was_hidden, is_hidden, is_new) == (False, True, True), name
        assert told == pytest.approx(shown, rel=1e-7), name
        assert quantity == (name if name in ("u", "q") else None)


def test_the_view_grows_about_the_point_nearest_to_the_middle(page):
    """Of a motion of many; where none of them is in sight about the middle itself."""
    chosen(page, CHAOS_AT_680)
    press = """button => new Promise(done => { $(button).click();
      requestAnimationFrame(() => requestAnimationFrame(done)); })"""
    ways = {
        "+": lambda: gesture(page, "keydown", key="+"),
        "in": lambda: page.evaluate(press, "in"),
        "-": lambda: gesture(page, "keydown", key="-"),
        "out": lambda: page.evaluate(press, "out"),
    }
    for name, way in ways.items():
        before = view(page)
        (left, right, top, bottom) = before[2]
        x, points = page.evaluate(
            """(([all, from, to]) => [diagram.X(680), [...all.slice(from, to)]
                 .map(value => diagram.Y(value))])(drawnPoints(state.motion))"""
        )
        middle = (top + bottom) / 2.0
        nearest = min(points, key=lambda y, to=middle: abs(y - to))
        assert min(points) < nearest < max(points)
        way()
        zoomed(before, view(page), 0.6 if name in ("+", "in") else 1.0 / 0.6, x, nearest)
    for show, x in (
        ("choose(motions.find(m => m.origin === 'stop'))", (left + right) / 2.0),
        ("choose(motions.find(m => m.rpm === 684)); state.x = [674, 678]", (left + right) / 2.0),
        ("choose(motionAtSpeed(676)); state.y = [-20, -10]", page.evaluate("diagram.X(676)")),
    ):
        page.evaluate(AS_OPENED)
        page.evaluate(f"() => {{ {show}; drawDiagram(); }}")
        before = view(page)
        page.evaluate(press, "in")
        zoomed(before, view(page), 0.6, x, middle)


def test_arrow_keys_go_round_the_motions_at_one_speed(page):
    """And round again: the focus is on the button of the motion that is shown."""
    chosen(page, CHAOS_AT_680)
    names = page.locator("#choices button").all_inner_texts()
    assert len(names) == 3
    page.focus("#choices [aria-checked=true]")
    k = 0
    for key, way in (("ArrowRight", 1), ("ArrowDown", 1), ("ArrowLeft", -1), ("ArrowUp", -1)):
        for _ in range(2):
            page.keyboard.press(key)
            k = (k + way) % 3
            told = page.evaluate(
                """[name(state.motion), document.activeElement.textContent,
                    ...[...$("choices").children].map(one => [one.ariaChecked, one.tabIndex])]"""
            )
            radios = [["true", 0] if j == k else ["false", -1] for j in range(3)]
            assert told == [names[k], names[k], *radios]
    page.keyboard.press("Home")  # is no key of them
    assert page.evaluate("name(state.motion)") == names[k]


A_PART = """() => { Object.assign(state, {x: [674, 678], y: [100, 200]}); drawDiagram(); }"""


def test_a_pinch_zooms_about_the_finger_that_rests(page):
    """By the ratio of the fingers' distances: 100 px before it and 200 px after it."""
    before = view(page)
    gesture(page, "pointerdown", pointerId=7, x=200, y=90, pointerType="touch")
    gesture(page, "pointerdown", pointerId=8, x=260, y=170, pointerType="touch")
    gesture(page, "pointermove", pointerId=8, x=320, y=250, pointerType="touch")
    after = view(page)
    zoomed(before, after, 0.5, 200, 90)
    gesture(page, "pointermove", pointerId=8, x=230, y=130, pointerType="touch")
    zoomed(after, view(page), 4.0, 200, 90)
    gesture(page, "pointerup", pointerId=7, x=200, y=90)
    gesture(page, "pointercancel", pointerId=8)
    assert page.evaluate("pointers.size") == 0
    assert page.evaluate("state.motion.rpm") == 680  # neither finger has clicked


def test_a_drag_takes_a_part_of_the_diagram_along(page):
    """What lies under the pointer stays there; a finger moves it along the speeds alone."""
    page.evaluate(A_PART)
    before = view(page)
    gesture(page, "pointerdown", pointerId=7, x=300, y=80)
    gesture(page, "pointermove", pointerId=7, x=302, y=82)  # less than a click's 4 px
    assert view(page)[0] == pytest.approx(before[0])
    gesture(page, "pointermove", pointerId=7, x=330, y=50)
    after = view(page)
    assert np.ptp(after[0]) == pytest.approx(4.0)
    assert np.ptp(after[1]) == pytest.approx(100.0)
    assert under(after, 330, 50) == pytest.approx(under(before, 302, 82))
    gesture(page, "pointerup", pointerId=7, x=330, y=50)
    assert page.evaluate("state.motion.rpm") == 680  # no click
    gesture(page, "pointermove", pointerId=7, x=400, y=60)  # nothing is held any more
    assert view(page)[0] == pytest.approx(after[0])
    gesture(page, "pointerdown", pointerId=9, x=300, y=80, pointerType="touch")
    gesture(page, "pointermove", pointerId=9, x=250, y=20, pointerType="touch")
    gesture(page, "pointercancel", pointerId=9)
    moved = view(page)
    assert moved[1] == pytest.approx(after[1])
    assert under(moved, 250, 80) == pytest.approx(under(after, 300, 80))


def test_a_drag_of_the_line_and_along_the_whole_diagram_changes_the_speed(page):
    """To the computed speed that is nearest, also beyond the ends; the view stays."""
    page.evaluate(A_PART)
    page.evaluate("choose(motionAtSpeed(676))")
    seen = view(page)
    (left, right, *_) = seen[2]

    def pixel(rpm):
        return left + (rpm - seen[0][0]) / np.ptp(seen[0]) * (right - left)

    gesture(page, "pointerdown", pointerId=7, x=pixel(676.0) + 11.0, y=60)  # within 12 px
    gesture(page, "pointermove", pointerId=7, x=pixel(674.9), y=60)
    assert page.evaluate("state.motion.rpm") == 674
    assert page.evaluate("state.dragged")
    gesture(page, "pointermove", pointerId=7, x=pixel(675.1), y=60)
    assert page.evaluate("state.motion.rpm") == 676
    assert view(page)[0] == pytest.approx(seen[0])
    gesture(page, "pointerup", pointerId=7, x=pixel(675.1), y=60)
    gesture(page, "pointerdown", pointerId=7, x=pixel(676.0) + 13.0, y=60)  # beside it
    gesture(page, "pointermove", pointerId=7, x=pixel(676.0) + 53.0, y=60)
    assert page.evaluate("state.motion.rpm") == 676
    assert view(page)[0] == pytest.approx(seen[0] - 40.0 * np.ptp(seen[0]) / (right - left))
    gesture(page, "pointercancel", pointerId=7)
    page.evaluate(AS_OPENED)
    gesture(page, "pointerdown", pointerId=7, x=300, y=60)
    for x, rpm in ((5, 672), (5000, 686)):  # anywhere in the whole diagram, and beside it
        gesture(page, "pointermove", pointerId=7, x=x, y=60)
        assert page.evaluate("state.motion.rpm") == rpm
    gesture(page, "pointercancel", pointerId=7)


def test_a_click_in_the_diagram_chooses_the_motion_that_is_drawn_there(page):
    """An impact of some of the motions; the number of a bifurcation leads to it."""
    places = page.evaluate(
        """inDiagram.filter(m => m.origin !== "solved").map(m => { const [values, k] = pointsOf(m);
             return [m.rpm, diagram.X(m.rpm), diagram.Y(values[k])]; })"""
    )
    for rpm, x, y in places[::3]:
        gesture(page, "pointerdown", pointerId=7, x=x, y=y)
        gesture(page, "pointerup", pointerId=7, x=x, y=y)
        found, drawn = page.evaluate(
            """(([values, k, end]) => [state.motion.rpm,
                 [...values.slice(k, end)].map(value => diagram.Y(value))])
               (drawnPoints(state.motion))"""
        )
        assert found == pytest.approx(rpm, abs=0.5)  # of a solved orbit about there
        assert min(abs(np.array(drawn) - y)) < 6.0  # as near as a line is meant
    at, rpm = page.evaluate("[data.bifurcations[0].at, data.bifurcations[0].rpm]")
    gesture(page, "pointerdown", pointerId=7, x=at + 8, y=20)  # a mouse hits it within 9 px
    gesture(page, "pointerup", pointerId=7, x=at + 8, y=20)
    assert np.mean(page.evaluate("state.x")) == pytest.approx(rpm)


def test_the_wheel_and_a_double_click_zoom_about_the_pointer(page):
    """The wheel with Ctrl, or where the diagram has the focus; else the page scrolls."""
    page.evaluate("document.activeElement.blur()")
    before = view(page)
    is_kept, *_ = gesture(page, "wheel", x=300, y=80, deltaY=200)
    assert not is_kept
    assert view(page)[0] == pytest.approx(before[0])
    is_kept, *place = gesture(page, "wheel", x=300, y=80, deltaY=-400, ctrlKey=True)
    assert is_kept
    after = view(page)
    zoomed(before, after, np.exp(-0.6), *place)
    page.evaluate("host.focus()")
    is_kept, *place = gesture(page, "wheel", x=150, y=60, deltaY=100)
    assert is_kept
    again = view(page)
    zoomed(after, again, np.exp(0.15), *place)
    _, *place = gesture(page, "dblclick", x=250, y=70)
    zoomed(again, view(page), 0.5, *place)


def test_keys_zoom_about_the_chosen_motion_and_leave_what_is_the_browsers(page):
    """By 0.6 and by its inverse; Ctrl and + is the browser's own zoom."""
    page.evaluate("choose(motions.find(m => m.rpm === 676 && m.label === 'P(1;1)'))")
    place = page.evaluate("(([all, k]) => [diagram.X(676), diagram.Y(all[k])])"
                          "(drawnPoints(state.motion))")  # fmt: skip
    whole = view(page)
    for key, factor in (("+", 0.6), ("=", 0.6), ("-", 1.0 / 0.6)):
        before = view(page)
        assert gesture(page, "keydown", key=key)[0]
        zoomed(before, view(page), factor, *place)
    before = view(page)
    assert not gesture(page, "keydown", key="+", ctrlKey=True)[0]
    assert not gesture(page, "keydown", key="x")[0]
    assert view(page)[0] == pytest.approx(before[0])
    assert gesture(page, "keydown", key="0")[0]
    assert view(page)[0] == pytest.approx(whole[0])
    for on, key, playing in (("title", " ", True), ("play", " ", True), ("title", " ", False)):
        gesture(page, "keydown", on=on, key=key)  # a button has the space bar for itself
        assert page.evaluate("state.playing") == playing, on
    number = page.evaluate("state.motion.number")
    gesture(page, "keydown", on="lens", key="n")
    gesture(page, "keydown", on="title", key="n", metaKey=True)
    assert page.evaluate("state.motion.number") == number
    gesture(page, "keydown", on="title", key="n")
    assert page.evaluate("state.motion.number === data.stops[0].motion")
    page.evaluate("keepLink(); location.hash = '#rpm=684&t=0.5&label=aperiodic'")
    page.wait_for_function("state.motion.rpm === 684")
    assert page.evaluate("state.t") == pytest.approx(0.5)


def test_the_skip_to_the_diagram_keeps_the_motion_shown(page):
    """It changes the fragment of the address as a link does, but names a place on the page."""
    chosen(page, CHAOS_AT_680)
    page.evaluate("state.t = 0.25")
    page.evaluate("() => new Promise(done => {"
                  " addEventListener('hashchange', () => setTimeout(done), {once: true});"
                  " document.querySelector('a.skip').click(); })")  # fmt: skip
    assert page.evaluate("[state.motion.number, state.t, state.playing]") == [
        CHAOS_AT_680, 0.25, False,
    ]  # fmt: skip


def test_a_drag_along_the_time_response_moves_the_machine(page):
    chosen(page, CHAOS_AT_680)
    x = page.evaluate("[0.5, 1.25, 2].map(t => time.upper.X(t))")
    gesture(page, "pointerdown", on="time", x=x[0], y=60, pointerId=7)
    gesture(page, "pointermove", on="time", x=x[1], y=60, pointerId=7, buttons=1)
    assert page.evaluate("state.t") == pytest.approx(1.25, abs=1e-6)
    dot = page.evaluate("[+time.dot.getAttribute('cx'), machine.angle.textContent]")
    assert dot == [pytest.approx(x[1], abs=0.01), "θ 90.0°, turn 2 of 16"]
    gesture(page, "pointermove", on="time", x=x[2], y=60, pointerId=7, buttons=0)
    assert page.evaluate("state.t") == pytest.approx(1.25, abs=1e-6)


FRAMES = """([t, clocks]) => { // as the browser calls it, which waits meanwhile
  const soon = requestAnimationFrame, found = [];
  requestAnimationFrame = () => 0;
  lastClock = null;
  Object.assign(state, {t, playing: true});
  for (const clock of clocks) { frame(clock); found.push(state.t); }
  requestAnimationFrame = soon;
  state.playing = false;
  return found; }"""


def test_each_impact_is_heard_once_when_it_happens_and_harder_ones_louder(page):
    """The motion of 4 s a turn is played in frames of 50 ms and, once, of more than 100 ms."""
    m = chosen(page, CHAOS_AT_680)
    page.evaluate(
        """() => { heard = []; click = loudness => heard.push([state.t, loudness]);
             Object.assign(state, {pace: 4, sound: true}); }"""
    )
    clocks = [50.0 * k for k in range(200)]
    found = page.evaluate(FRAMES, [0.0, clocks])
    assert found == pytest.approx([clock / 4000.0 for clock in clocks])
    heard = page.evaluate("heard")
    hardest = max(map(abs, m["events"]["u"]))
    passed = [(t, abs(u) / hardest) for t, u in zip(m["events"]["t"], m["events"]["u"], strict=True)
              if t <= found[-1]]  # fmt: skip
    assert len(passed) > 3
    for (at, loudness), (t, wanted) in zip(heard, passed, strict=True):
        assert 0 <= at - t < 0.0125 + 1e-6  # in the frame in which it happens
        assert loudness == pytest.approx(wanted)
    late = page.evaluate(FRAMES, [1.0, [0.0, 5000.0]])  # a page that was not looked at
    assert late == pytest.approx([1.0, 1.0 + 0.1 / 4.0])
    again = page.evaluate(FRAMES, [16.0 - 0.001, [0.0, 50.0]])
    assert again == pytest.approx([15.999, 0.0125 - 0.001], abs=1e-6)  # it begins anew


def test_a_click_is_short_and_its_pitch_and_loudness_rise_with_the_impact(page):
    """0.25 x^0.6 falls to nothing in 0.07 s, at 180 + 500 x Hz."""
    tones = page.evaluate(
        """loudnesses => { const real = speaker, told = [];
          const target = {};
          speaker = {currentTime: 5, destination: target,
            createOscillator: () => ({
              frequency: {}, start(t) { told.at(-1).start = t; }, stop(t) { told.at(-1).stop = t; },
              connect(next) { told.at(-1).tone = this; return next; }}),
            createGain: () => ({gain: {
                setValueAtTime: (...set) => told.at(-1).gains.push(set),
                exponentialRampToValueAtTime: (...set) => told.at(-1).gains.push(set)},
              connect: to => { told.at(-1).isHeard = to === target; }})};
          for (const loudness of loudnesses) { told.push({gains: []}); click(loudness); }
          speaker = real;
          return told.map(({tone, start, stop, gains, isHeard}) =>
            [tone.frequency.value, start, stop, gains, isHeard]); }""",
        [0.1, 1.0],
    )
    for loudness, tone in zip((0.1, 1.0), tones, strict=True):
        volumes = [[pytest.approx(0.25 * loudness**0.6), 5], [1e-4, pytest.approx(5.07)]]
        assert tone == [pytest.approx(180 + 500 * loudness), 5, pytest.approx(5.08), volumes, True]
