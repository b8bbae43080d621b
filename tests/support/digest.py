"""Print a hash of simulated and solved orbits: run by the tests in other processes."""

import hashlib
import struct

from camcli.analysis.labels import label
from camcli.analysis.orbits.shooter import Shooter
from camcli.kernel.cam_table import stretch_at
from tests.support.kernel_runs import run, system

ORBITS = [
    (745.0, {}, {}, 100),
    (682.0, {}, {}, 100),
    (361.0, {}, {"q": 0.3, "v": 5.0, "theta_deg": 10.0}, 100),
    (190.0, {}, {}, 20),
    (115.2, {}, {}, 3),
    (198.6, {}, {}, 20),
    (520.0, {"damping": 3.0, "gravity": 9.81}, {}, 60),
    (700.0, {"damping": 2.0 * (146 * 9.8 * 1.221) ** 0.5}, {}, 50),
    (900.0, {"damping": 300.0, "preload": 20.0}, {}, 100),
    (250.0, {"stiffness": 0.0, "gravity": 9.81, "damping": 1.0}, {}, 60),
]


def digest(sink, orbits=ORBITS):
    """Feed every number of every orbit to sink, bit for bit."""
    for rpm, changes, start, record in orbits:
        tape = run(rpm, system(**changes), record=record, **start)
        for column in (tape.theta, tape.q, tape.u, tape.strobe_q, tape.strobe_w):
            sink(struct.pack(f"<{len(column)}d", *(float(x) for x in column)))
        for column in (tape.kind, tape.period, tape.impacts, tape.chatter):
            sink(struct.pack(f"<{len(column)}q", *(int(x) for x in column)))
        sink(f"{label(tape)} {tape.status} {tape.cost} {tape.detachments}".encode())


ROOTS = [
    ({}, 700.0, [2.7105, 0.85], (1,)),
    ({}, 700.0, [1.818, 0.4], (1,)),
    ({"damping": 2.0, "gravity": 9.81, "preload": 5.0}, 700.0, [2.7105, 0.85], (1,)),
    ({"damping": 90.0}, 700.0, [2.7, 0.3], (1, 2)),
    ({}, 358.5, [2.6354469, 0.978, 5.8108811, 0.994], (1,)),
    ({"stiffness": 0.0, "gravity": 9.81}, 250.0, [2.9, 0.2], (1, 2, 3)),
]


def digest_roots(sink):
    """Every number of every root, tangent and verdict, bit for bit; failures too."""
    for changes, rpm, start, turns in ROOTS:
        machine = system(**changes)
        n = len(start) // 2
        whole = tuple(v for k in range(n) for v in (stretch_at(machine.cam, start[2 * k]), 0))
        for parameter in ("rpm", "restitution", "stiffness", "damping"):
            shooter = Shooter(machine, rpm, parameter)
            value = shooter.machine[shooter.parameter]
            for m in turns:
                root = shooter.at_value([*start, value], whole, m, value)
                if root is None:
                    sink(b"none")
                    continue
                verdict = shooter.verdict(root)
                numbers = [*root.x, *root.rates, *root.tangent, root.trace, root.step, verdict[2]]
                sink(struct.pack(f"<{len(numbers)}d", *numbers))
                sink(f"{root.steps} {verdict[:2]} {shooter.cost}".encode())


if __name__ == "__main__":
    from camcli.kernel import backend

    backend.for_work(0)
    state = hashlib.sha256()
    digest(state.update)
    digest_roots(state.update)
    print(backend.current().compiled, state.hexdigest())
