"""Reference results of `cam bench`, made by the multiple-precision oracle alone.

    python tests/bench/make_reference.py [NAME ...]

writes camcli/analysis/bench/reference/NAME.json (two minutes in all). Nothing of the kernel is
used. stability.json holds values of the rows of extreme cases; every other file holds its machine,
its start at theta = 0, the events of whole turns (phases in rad and relative velocities in m/s with
25 digits) and the state at the end.

`growth` says how far rounding may take a program that does everything right: the exact motion is
run again with a disturbance of relative size NOISE at every event, and growth is the largest change
of a phase (turns) over NOISE. Disturbed are the phase of an event, its relative velocity, and the
height of a landing: by NOISE times q, or in a short hop by NOISE times what the hop moves.
"""

from __future__ import annotations

import json
import random
import sys
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

from mpmath import mp, mpf

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tests.support import oracle  # noqa: E402
from tests.support.oracle import ArcsCam, Flight, Oracle  # noqa: E402

FOLDER = ROOT / "camcli" / "analysis" / "bench" / "reference"
DIGITS = 25
NOISE = "1e-60"
DISTURBED = 8  # runs with other signs
SHORT = 1 / 64  # rad: hops below this can be followed in relative coordinates
CUT = "1e-16"  # rad of chatter replaced by its first-order map: an error of about its square
ARCS = {
    "kind": "arcs",
    "base_radius": 0.85 - 0.45,  # exact in doubles
    "flank_center": 0.45,
    "flank_radius": 0.85,
    "nose_center": 0.40393320723821,
    "nose_radius": 0.15,
    "top_dwell_deg": 40.0,
    "offset": 0.3,
}
ECCENTRIC = {"kind": "eccentric", "base": 0.1, "lift": 0.2}
EXAMPLE = {
    "mass": 1.221, "stiffness": 1430.8, "damping": 0.0, "gravity": 0.0, "preload": 0.0,
    "restitution": 0.8,
}  # fmt: skip


class Harmonic(NamedTuple):
    """A turn of the eccentric cam: c = middle - half cos x, x = theta - origin."""

    middle: Any
    half: Any
    origin: Any
    end: Any

    def laws(self, lib, x):
        """Lift and its first two derivatives in the angle."""
        cos, sin = lib.cos(x), lib.sin(x)
        return self.middle - self.half * cos, self.half * sin, self.half * cos


class EccentricCam:
    """c = base + lift (1 - cos theta)/2, with what the oracle asks of a cam."""

    def __init__(self, base: float, lift: float):
        self.half = mpf(lift) / 2
        self.middle = mpf(base) + self.half

    def segments(self, psi, side=1):
        """One piece per turn, from the unbounded angle psi on."""
        turn = mp.floor(psi / (2 * mp.pi))
        while True:
            origin = 2 * mp.pi * turn
            yield Harmonic(self.middle, self.half, origin, origin + 2 * mp.pi)
            turn += 1

    def laws(self, theta, side=1):
        """(c, c_theta, c_thetatheta)."""
        return Harmonic(self.middle, self.half, mpf(0), None).laws(mp, mpf(theta))


def case(title, rpm, turns, start=None, cam=ARCS, chatter="none", **changes):
    """What defines a case; `start` is (q, v) at theta = 0, None for rest on the cam."""
    data = {"title": title, "follower": {**EXAMPLE, **changes}, "cam": cam, "rpm": rpm}
    q, v = start or (None, None)
    return {**data, "start": {"q": q, "v": v}, "turns": turns, "chatter": chatter}


CASES = {
    "periodic": case("P(1;1) at 700 rpm", 700.0, 40, (2.355530525660, -16.6)),
    "chatter": case("complete chatter at 190 rpm", 190.0, 3, chatter="complete"),
    "incomplete": case("incomplete chatter at 198.7 rpm", 198.7, 4, chatter="complete"),
    "p3": case("P(3;3:3:2) at 358.5 rpm", 358.5, 9, (0.36, -1.0)),
    "chaotic": case("chaotic stretch at 745 rpm", 745.0, 20),
    "critical": case(
        "critical damping, 300 rpm", 300.0, 3, chatter="complete", damping=83.594
    ),
    "overdamped": case("overdamped, 300 rpm", 300.0, 3, chatter="complete", damping=500.0),
    "stiff": case(
        "k = 1e8 N/m at 50000 rpm", 50000.0, 3, chatter="complete", stiffness=1e8
    ),
    "eccentric": case("eccentric cam, 700 rpm", 700.0, 10, cam=ECCENTRIC),
}  # fmt: skip


def oracle_cam(section: dict):
    """The oracle's cam of a scene section."""
    values = {key: value for key, value in section.items() if key != "kind"}
    return ArcsCam(**values) if section["kind"] == "arcs" else EccentricCam(**values)


def digits(x, n=DIGITS) -> str:
    """A number of so many significant digits, as text."""
    return mp.nstr(mpf(x), n, strip_zeros=False)


def final(reference: Oracle, omega, turns: int, raw) -> tuple[mpf, mpf]:
    """(q, v) after the last event of `raw`, flown to the end of the last turn."""
    end = 2 * mp.pi * turns
    c, c1, _ = reference.cam.laws(end)
    last = raw[-1]
    if last.kind == "chatter":
        return c, omega * c1
    _, slope, _ = reference.cam.laws(last.psi)
    follower = oracle.Follower.make(*reference.data)
    return follower.flow((end - last.psi) / omega, last.q, omega * slope + last.u_plus)


class Disturbed(oracle._Orbit):
    """The motion with a disturbance at every event; `signs` gives +1 or -1, or nothing at all."""

    signs = None

    def sign(self):
        """NOISE, up or down."""
        return self.signs.choice((-1, 1)) * mpf(NOISE) if self.signs else mpf(0)

    def departs(self, psi):
        """A little later."""
        return psi + 2 * mp.pi * abs(self.sign())

    def lands(self, psi, u, rise, time):
        """Elsewhere, and at another rate."""
        if not u < 0:
            return psi, u
        c, c1, _ = self.cam.laws(psi)
        short = self.omega * time < SHORT
        height = abs(rise) * time if short else abs(c)
        psi += self.sign() * (2 * mp.pi + self.omega * height / -u)
        return psi, u - self.sign() * (-u if short else abs(self.omega * c1) - u)


def motion(data: dict[str, Any], signs: random.Random | None):
    """(events, (q, v) at the end) of a case; disturbed where there are signs."""
    with mp.workdps(oracle.CAM_DPS):
        cam = oracle_cam(data["cam"])
    reference = Oracle(cam, rpm=data["rpm"], **data["follower"])
    q, v = (None if x is None else mpf(x) for x in data["start"].values())
    with mp.workdps(oracle.CAM_DPS):
        omega, end = mpf(data["rpm"]) * mp.pi / 30, 2 * mp.pi * data["turns"]
        follower = oracle.Follower.make(*reference.data)
        orbit = Disturbed(cam, follower, reference.r, omega, mpf(0), end, mpf(CUT))
        orbit.signs = signs
        raw = []
        for event in orbit.events(q, v):
            if event.psi > end:
                break
            raw.append(event)
        return raw, final(reference, omega, data["turns"], raw)


def solved(data: dict[str, Any]) -> dict[str, Any]:
    """Events and final state of a case, with what rounding may do to them."""
    exact, end = motion(data, None)
    others = [motion(data, random.Random(k)) for k in range(DISTURBED)]
    with mp.workdps(oracle.CAM_DPS):
        eps, turn = mpf(NOISE), 2 * mp.pi
        omega = mpf(data["rpm"]) * mp.pi / 30
        rows = []
        for k, (kind, psi, _, u, _) in enumerate(exact):
            if any(raw[k].kind != kind for raw, _ in others):
                raise ArithmeticError("a disturbed motion has other events")
            far = max(abs(raw[k].psi - psi) for raw, _ in others)
            whole = int(mp.floor(psi / turn))
            row = {"kind": kind, "turn": whole, "theta": digits(psi - turn * whole)}
            rows.append({**row, "u": digits(u), "growth": round_up(far / turn / eps)})
        far = max(max(abs(q - end[0]), abs(v - end[1]) / omega) for _, (q, v) in others)
        state = {"q": digits(end[0]), "v": digits(end[1]), "growth": round_up(far / eps)}
    return {**data, "events": rows, "final": state}


def round_up(x) -> float:
    """Three digits, at least 1."""
    return max(1.0, float(f"{float(x):.3g}"))


def compact(data: dict[str, Any]) -> str:
    """JSON with a line per entry of a list."""
    lines = []
    for key, value in data.items():
        text = json.dumps(value)
        if isinstance(value, list):
            rows = ",\n  ".join(json.dumps(row) for row in value)
            text = f"[\n  {rows}\n ]"
        lines.append(f" {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + "\n}"


def write(name: str, found: dict[str, Any]) -> None:
    """Write one file."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    text = compact(found)
    (FOLDER / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    print(name, len(text), "bytes", flush=True)


# --- stored values of the rows of extreme cases: stability.json

HEAVY = {
    "6.7e3 at 115": (6.7e3, 115.0),
    "4.1e4 at 700": (4.1e4, 700.0),
    "1e9 at 115": (1e9, 115.0),
    "1e12 at 115": (1e12, 115.0),
}
TURNS = 2
WEAK = 114.98  # rpm: hops near b just above the first detachment


def coarse(self) -> mpf:
    """Cells of the turn alone: the fast decay is over at once, its cell is bisected."""
    return 2 * mp.pi / self.omega / oracle.CELLS_PER_TURN


def heavy(b: float, rpm: float) -> dict[str, Any]:
    """Landings after a flight, departures, and the height at the end, with heavy damping."""
    own = Flight._width
    if b > 1e6:
        Flight._width = coarse
    data = case("", rpm, TURNS, damping=b)
    reference = Oracle(oracle_cam(ARCS), rpm=rpm, **data["follower"])
    events = reference.run(turns=TURNS, chatter_cut=mpf(CUT))
    with mp.workdps(80):
        omega, end = mpf(rpm) * mp.pi / 30, 2 * mp.pi * TURNS
        raw = reference._run(mpf(0), end, mpf(CUT), 0, mpf(rpm), reference.r, None, None)
        q, _ = final(reference, omega, TURNS, raw)
    Flight._width = own
    kept = [
        [e.kind, e.turn, digits(e.theta)]
        for before, e in zip([None, *events], events, strict=False)
        if e.kind == "detachment" or (before is not None and before.kind == "detachment")
    ]
    return {"damping": b, "rpm": rpm, "turns": TURNS, "events": kept, "q": digits(q)}


def graze(rpm: float, degrees: float, delta: float, s: float) -> dict[str, float] | None:
    """Start of an undamped flight that is tangent to the cam `s` rad later, raised by delta m."""
    cam, theta = oracle_cam(ARCS), degrees * pi / 180
    with mp.workdps(40):
        omega = mpf(rpm) * mp.pi / 30
        W = mp.sqrt(mpf(EXAMPLE["stiffness"]) / mpf(EXAMPLE["mass"])) / omega
        c, c1, _ = cam.laws(theta)
        q, w = c + mpf(delta), c1
        q, w = q * mp.cos(W * s) - w / W * mp.sin(W * s), w * mp.cos(W * s) + W * q * mp.sin(W * s)
        if q <= cam.c(theta - s):
            return None
        start = {"theta_deg": (theta - s) * 180 / pi, "q": float(q), "v": float(w * omega)}
    return {"rpm": rpm, "at": theta, **start}


def stability() -> dict[str, Any]:
    """Stored values of the rows of the extreme cases that need some."""
    flights = [
        graze(rpm, degrees, delta, s)
        for rpm in (300.0, 400.0, 700.0)
        for degrees in (150.5, 153.0, 155.0, 158.0)
        for s in (0.2, 0.3, 0.6, 1.0)
        for delta in (-1e-16, 0.0, 1e-16)
    ]
    grazes = [flight for flight in flights if flight is not None]
    values = {name: heavy(*data) for name, data in HEAVY.items()}
    weak = Oracle(oracle_cam(ARCS), rpm=WEAK, **EXAMPLE).run(impacts=8)
    hops = [[digits(e.theta), digits(e.u_minus)] for e in weak if e.kind == "impact"]
    more = {"weak": {"rpm": WEAK, "impacts": hops}, "grazes": grazes}
    return {"follower": EXAMPLE, "cam": ARCS, "heavy": values, **more}


if __name__ == "__main__":
    for case_name in sys.argv[1:] or [*CASES, "stability"]:
        found = stability() if case_name == "stability" else solved(CASES[case_name])
        write(case_name, found)
