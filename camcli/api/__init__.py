"""The library: a scene in, a result with tables, a summary, pictures and a `save` out."""

ANALYSES = {  # each is a function of its name in a module of its name, and a command
    "simulate": "One orbit in time: its events and its trajectory.",
    "sweep": "Bifurcation diagram over speeds, or another number.",
    "detach": "Where contact is lost, and which spring would hold.",
    "orbits": "Periodic orbits, followed, and their bifurcations.",
    "basins": "Which attractor a start lands on, over a window of starts.",
    "classify": "The motion at each speed, its exponents, why it changes.",
    "explore": "A page for a browser on which the machine moves.",
}
