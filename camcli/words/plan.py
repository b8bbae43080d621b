"""What a plan says of a scene: how much it asks for, and what is not known before the run."""

from camcli.errors import plural
from camcli.scene import Scene

EXPLAINING = "how long --explain takes is not known before the run: 5 to 15 s for many a change"
LESS_OF_A_SWEEP = "--set sweep.tables=npz writes less"

# --- how much is asked for


def turns_of_a_motion(recorded: int, samples: int) -> str:
    """How much one motion asks for, in words."""
    return f"{plural(recorded, 'recorded turn')} x {plural(samples, 'sample')}"


def speeds_of_a_sweep(speeds: int, turns: int, recorded: int) -> str:
    """What a sweep asks for."""
    return f"{plural(speeds, 'speed')} of {plural(turns, 'turn')}, {recorded} recorded"


def motions_at_speeds(speeds: int, starts: int, recorded: int) -> str:
    """How much classify asks for, in words."""
    return (
        f"{plural(speeds, 'speed')} x {plural(starts, 'start')} x "
        f"{plural(recorded, 'recorded turn')}"
    )


def cells_of_a_window(wide: int, high: int, levels: int) -> str:
    """How much basins ask for, in words."""
    return f"{wide} x {high} cells, refined {plural(levels, 'time')}"


def parts_of_a_page(speeds: int, cells: int, points: int) -> str:
    """What a page asks for; cells of a window and points of a map are 0 where there is none."""
    beside = f", {plural(cells, 'cell')}" if cells else ""
    beside += f", {plural(points, 'point')} of a map" if points else ""
    return f"{plural(speeds, 'speed')} of 3 sweeps{beside}"


# --- what no sample shows, by command


def simulate(scene: Scene) -> list[str]:
    """What the forecast of a motion leaves out, in sentences."""
    if scene.simulate.animate:
        return ["drawing the animation comes on top, some 10 to 20 s"]
    return []


def sweep(scene: Scene) -> list[str]:
    """What the forecast of a sweep leaves out, in sentences."""
    notes = []
    if scene.sweep.explain:
        notes.append(EXPLAINING)
    if scene.sweep.adaptive:
        notes.append("how many speeds --adaptive adds is not known before the run")
    if scene.sweep.curves == "auto":
        notes.append("how many curves --curves auto follows is not known before the run")
    if scene.sweep.prove:
        notes.append("a proof of --prove takes 0.2 to 5 s for each curve")
    return notes


def detach(scene: Scene) -> list[str]:
    """What the forecast of the loss of contact leaves out, in sentences."""
    if scene.detach.tolerance:
        machines = plural(scene.detach.machines, "machine")
        come = "comes" if scene.detach.machines == 1 else "come"
        return [f"{machines} of --tolerance {come} on top, 0.1 s each"]
    return []


def orbits(scene: Scene) -> list[str]:
    """What is not known of periodic orbits before they are followed, in a sentence."""
    return ["how many branches there are, and so the time, is not known before the run"]


def basins(scene: Scene) -> list[str]:
    """What the forecast of basins leaves out, in sentences."""
    notes = []
    if scene.basins.refine:
        notes.append("what --refine adds at boundaries is not known before the run")
    if scene.basins.count > 1:
        notes.append(
            "a speed in the middle stands for all, but speeds with chaos take many times as long"
        )
    return notes


def classify(scene: Scene) -> list[str]:
    """What the forecast of motions at each speed leaves out, in sentences."""
    return [EXPLAINING] if scene.classify.explain else []


def explore(scene: Scene) -> list[str]:
    """What the forecast of a page leaves out, in sentences."""
    return ["the orbits come on top: how many are solved is not known before the run"]


# --- of a plan itself


def of_a_shard(number: int, total: int) -> str:
    """What a part of a run leaves out."""
    return f"shard {number} of {total}: pieces only, no tables"


def cut_off(seconds: float) -> str:
    """Why there is no forecast."""
    return f"a small part took {seconds:g} s: how long it takes is not known before the run"


def budget_ends(work: int, seconds: float) -> str:
    """When the budget ends a run."""
    return f"run.work_budget = {work} ends it after some {seconds:.0f} s"
