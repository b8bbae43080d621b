"""The machine in motion beside its time response, frame by frame."""

from collections.abc import Iterator
from math import ceil

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from camcli.analysis.labels import period_of
from camcli.analysis.simulate import Simulation
from camcli.plots import style
from camcli.plots.axes import TURN_DEG
from camcli.plots.mechanism import Outline, draw_machine
from camcli.plots.simulate import Trace
from camcli.system import System

DPI, WIDE, HIGH = 100, 9.6, 5.4  # inches: 960 x 540 pixels
FRAMES = 40  # per turn


def draw_frames(
    simulation: Simulation, system: System, outline: Outline, turns: int
) -> Iterator[Figure]:
    """The last `turns` turns as one figure that is drawn anew for each frame.

    Of a motion with a shorter period one period, so that the end joins the beginning.
    """
    trace = Trace.of(simulation, system, min(turns, period_of(simulation.label) or turns))
    turn = trace.low // TURN_DEG * TURN_DEG  # the first one shown is counted from 0
    angles, low, high = trace.angle - turn, trace.low - turn, trace.high - turn
    with style.look():
        figure = Figure(figsize=(WIDE, HIGH), dpi=DPI, layout="constrained")
        FigureCanvasAgg(figure)
        machine, time = figure.subplots(1, 2, width_ratios=(2, 3))
        time.fill_between(angles, trace.cam.min(), trace.cam, color=style.CAM_BODY, lw=0)
        time.plot(angles, trace.cam, color=style.CAM, lw=0.8)
        for colour, state in ((style.FLIGHT, ~trace.sticks), (style.STICKING, trace.sticks)):
            time.plot(angles, trace.during(trace.q, state), color=colour)
        title = f"{style.number(simulation.rpm)} rpm, {style.motion(simulation.label)}"
        time.set(xlim=(low, high), title=title, ylabel="position (m)")
        time.set_xlabel(r"cam angle $\theta$ (deg)")
        line, (dot,) = time.axvline(color=style.GUIDE, lw=0.8), time.plot([], [], "o")
        figure.canvas.draw()
        figure.set_layout_engine("none")
    highest = float(trace.gap.max() + outline.radius.max())
    count = ceil((high - low) / TURN_DEG * FRAMES)
    for angle in np.linspace(low, high, count, endpoint=False):
        gap, q = (float(np.interp(angle, angles, y)) for y in (trace.gap, trace.q))
        line.set_xdata([angle])
        dot.set(data=([angle], [q]), color=style.FLIGHT if gap > 0.0 else style.STICKING)
        with style.look():
            machine.clear()
            draw_machine(machine, outline, gap, angle % TURN_DEG, highest)
        yield figure
