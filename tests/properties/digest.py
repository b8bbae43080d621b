"""Print a hash of chaotic, chattering and damped orbits: run by the tests in other processes."""

import hashlib
import struct

from camcli.analysis.labels import label
from tests.kernel.helpers import run, system

ORBITS = [
    (745.0, {}, {}, 300),
    (682.0, {}, {}, 200),
    (361.0, {}, {"q": 0.3, "v": 5.0, "theta_deg": 10.0}, 300),
    (190.0, {}, {}, 20),
    (115.2, {}, {}, 3),
    (198.6, {}, {}, 20),
    (520.0, {"damping": 3.0, "gravity": 9.81}, {}, 200),
    (700.0, {"damping": 2.0 * (146 * 9.8 * 1.221) ** 0.5}, {}, 50),
    (900.0, {"damping": 300.0, "preload": 20.0}, {}, 100),
    (250.0, {"stiffness": 0.0, "gravity": 9.81, "damping": 1.0}, {}, 60),
]


def digest(sink):
    """Feed every number of every orbit to sink, bit for bit."""
    for rpm, changes, start, record in ORBITS:
        tape = run(rpm, system(**changes), record=record, **start)
        for column in (tape.theta, tape.q, tape.u, tape.strobe_q, tape.strobe_w):
            sink(struct.pack(f"<{len(column)}d", *(float(x) for x in column)))
        for column in (tape.kind, tape.period, tape.impacts, tape.chatter):
            sink(struct.pack(f"<{len(column)}q", *(int(x) for x in column)))
        sink(f"{label(tape)} {tape.status} {tape.cost} {tape.detachments}".encode())


if __name__ == "__main__":
    from camcli.kernel import backend

    backend.for_work(0)
    state = hashlib.sha256()
    digest(state.update)
    print(backend.current().compiled, state.hexdigest())
