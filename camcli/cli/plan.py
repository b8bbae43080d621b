"""--dry-run: what a run would do and cost, and the refusal of what cannot fit."""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass

from camcli.analysis.engine import Orbit, Settings, with_turns
from camcli.cli.report import table
from camcli.errors import Fault, SceneError
from camcli.kernel import backend
from camcli.parallel import thread_count
from camcli.system import System

PROBE_TURNS = 60
COMPILED_SECONDS = 2.5e-7  # per impact on one thread, with its share of crossings
PLAIN_SECONDS = 6e-5
SHARE_OF_MEMORY = 0.8


@dataclass(frozen=True)
class Plan:
    """Estimated cost of a run."""

    orbits: int
    periods: int
    impacts: int
    seconds: float
    bytes: int
    memory: int

    def show(self, name: str, as_json: bool) -> None:
        """Print the plan of `cam NAME`, as a table or as one JSON object."""
        if as_json:
            print(json.dumps({"command": name, "plan": asdict(self)}, indent=2))
        else:
            table(f"cam {name}, planned", ["what", "how much"], self._lines())

    def _lines(self) -> list[list[str]]:
        return [
            ["orbits", f"{self.orbits}"],
            ["periods", f"{self.periods}"],
            ["impacts (estimated)", f"{self.impacts}"],
            ["seconds (estimated)", f"{self.seconds:.2g}"],
            ["artefacts (estimated)", f"{self.bytes / 1e6:.3g} MB"],
            ["memory (estimated)", f"{self.memory / 1e6:.3g} MB"],
        ]


def estimate(
    system: System,
    rpms: list[float],
    settings: Settings,
    threads: int | None,
    bytes_per_impact: float,
    bytes_per_period: float,
) -> Plan:
    """Cost from a short probe at up to five of the speeds, in plain Python."""
    picks = rpms if len(rpms) <= 5 else [rpms[k * (len(rpms) - 1) // 4] for k in range(5)]
    turns = min(PROBE_TURNS, settings.transient + settings.record)
    probe = with_turns(settings, 0, turns)
    found = sum(Orbit(system, rpm, probe).run(events=False).cost.impacts for rpm in picks)
    per_turn = found / (turns * len(picks))
    orbits = len(rpms)
    periods = orbits * (settings.transient + settings.record)
    recorded = orbits * settings.record
    impacts = round(per_turn * periods)
    plain = periods < 10_000 and not backend.is_compiled()
    work = max(impacts, periods) * (PLAIN_SECONDS if plain else COMPILED_SECONDS)
    return Plan(
        orbits=orbits,
        periods=periods,
        impacts=impacts,
        seconds=work / (1 if plain else thread_count(threads)) + 0.5,
        bytes=round(recorded * (per_turn * bytes_per_impact + bytes_per_period)),
        memory=round(recorded * (per_turn * 40 + 48)) + 150_000_000,
    )


def refuse_if_too_large(orbits: int, settings: Settings) -> None:
    """Raise SceneError where the record alone cannot fit the memory (allocates nothing)."""
    needed = orbits * settings.record * 48
    available = memory()
    if needed > SHARE_OF_MEMORY * available:
        found = f"found {orbits} speeds x {settings.record} recorded turns, {needed / 1e9:.3g} GB"
        expected = f"expected at most {SHARE_OF_MEMORY * available / 1e9:.3g} GB of memory"
        raise SceneError(Fault("run.record", "", found, expected, "ask for fewer points or turns"))


def memory() -> float:
    """Bytes of memory of this machine."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (ValueError, OSError, AttributeError):
        return 4e9
