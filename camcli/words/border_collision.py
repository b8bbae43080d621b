"""What is said of a border collision: its class, its inequalities, and what attracts."""

from camcli.analysis.border_collision import (
    DECIDED,
    LESS,
    THEOREM,
    Collision,
    Cycle,
    Equal,
    Inequality,
    Prediction,
    Rule,
)

SIDES = {-1: "Where the normal form's parameter is below 0", 1: "Where it is above 0"}

KINDS = {
    "degenerate": "an equality holds within rounding: the linear parts do not decide",
    "dangerous": "a stable fixed point on both sides, yet its basin shrinks to nothing between",
    "robust-chaos": "a chaotic attractor on one side, and for all linear parts close to these",
    "no-attractor": "something attracts on one side, nothing bounded on the other",
    "nonsmooth-fold": "two fixed points are born on one side, there is none on the other",
    "border-period-doubling": "a fixed point on each side, and a cycle LR is born on one of them",
    "persistence": "a fixed point on each side, and no cycle LR is born",
}

EQUALITIES = {
    Equal.PLUS_ONE: "a multiplier is +1",
    Equal.MINUS_ONE: "a multiplier is -1",
    Equal.UNIT_PAIR: "two multipliers on the unit circle",
}
LEFT = {  # {s}: the side, or that of the saddle; {o}: the other one
    Rule.PRODUCT_AT_ONE: "(1 - tau_L + delta_L)(1 - tau_R + delta_R)",
    Rule.PRODUCT_AT_MINUS_ONE: "(1 + tau_L + delta_L)(1 + tau_R + delta_R)",
    Rule.AT_ONE: "1 - tau_{s} + delta_{s}",
    Rule.AT_MINUS_ONE: "1 + tau_{s} + delta_{s}",
    Rule.DET_BELOW_ONE: "delta_{s}",
    Rule.DET_POSITIVE: "delta_{s}",
    Rule.GROWTH: "log growth per step at mu = 0",
    Rule.BEYOND_ONE: "tau_{s}",
    Rule.BEYOND_MINUS_ONE: "tau_{s}",
    Rule.TRAPPING: "(l1 tau_{o} - delta_{o})(l1 - 1) + l1^2 (1 - l2)",
}
RIGHT = {  # of the others 0
    Rule.DET_BELOW_ONE: "1",
    Rule.GROWTH: f"{DECIDED:.2g}",
    Rule.BEYOND_ONE: "1 + delta_{s}",
    Rule.BEYOND_MINUS_ONE: "-(1 + delta_{s})",
    Rule.TRAPPING: "0, l1 > l2 the multipliers of {s}",
}


def inequality_text(inequality: Inequality) -> str:
    """The inequality as a formula: `1 - tau_L + delta_L > 0`."""
    sign = "<" if inequality.rule in LESS else ">"
    formula = f"{LEFT[inequality.rule]} {sign} {RIGHT.get(inequality.rule, '0')}"
    other_side = "R" if inequality.side == "L" else "L"
    return formula.format(s=inequality.side, o=other_side)


def inequality_record(inequality: Inequality) -> dict[str, str | float | bool]:
    """The inequality for run.json."""
    text = inequality_text(inequality)
    return {
        "text": text,
        "left": inequality.left,
        "right": inequality.right,
        "holds": inequality.holds,
    }


def equality_words(where: str, equality: Equal) -> str:
    """An equality within rounding; where: the side L or R, or LR for the cycle."""
    if equality is Equal.TANGENCY:
        return "the unstable manifold of a fixed point touches the stable one of the saddle"
    preposition = "along" if where == "LR" else "on"
    return f"{preposition} {where}, {EQUALITIES[equality]}"


def collision_words(collision: Collision) -> list[str]:
    """Sentences: the class, what is open, what attracts, and why there is no robust chaos."""
    sentences = [f"{collision.kind}: {KINDS[collision.kind]}."]
    sentences += [
        f"Equal within rounding: {equality_words(where, equality)}."
        for where, equality in collision.equal
    ]
    if collision.growth is not None and abs(collision.growth.left) <= DECIDED:
        growth = f"The growth at the event, {collision.growth.left:.2g} per step,"
        sentences.append(f"{growth} is too small to exclude that the event is dangerous.")
    sentences += [
        f"{SIDES[-1]}, {_what_attracts(collision.below)}.",
        f"{SIDES[1]}, {_what_attracts(collision.above)}.",
    ]
    return sentences + _two_cycle(collision.cycles[2]) + _no_theorem(collision)


def _what_attracts(prediction: Prediction) -> str:
    """What attracts on one side of the collision, as a clause.

    prediction.word: the letters of a fixed point or a cycle, or a list of all that attract.
    """
    exponent = ""
    if prediction.exponent is not None:
        measured = f"{prediction.exponent:.4g} +- {prediction.spread:.1g} per step"
        exponent = f", largest exponent {measured}"
    return {
        "none": "nothing bounded attracts",
        "fixed-point": f"the fixed point {prediction.word} attracts",
        "cycle": f"the cycle {prediction.word} of period {prediction.period} attracts",
        "chaos": f"there is a chaotic attractor{exponent}",
        "several": f"several attract: {prediction.word}",
        "undecided": (
            "what attracts is not decided: orbits stay bounded, "
            f"{prediction.word or 'without a period'}{exponent}"
        ),
    }[prediction.kind]


def _two_cycle(cycle: Cycle) -> list[str]:
    """A sentence on the cycle LR, none where it exists on neither side."""
    if not cycle.exists_for:
        return []
    first = cycle.multipliers[0]
    size = f"larger multiplier {first.real:.6g}"
    if first.imag != 0.0:
        size = f"multipliers {first.real:.6g} +- {first.imag:.6g} i"
    state = "stable" if cycle.stable else "unstable"
    return [f"{SIDES[cycle.exists_for]}, the cycle LR exists and is {state}: {size}."]


def _no_theorem(collision: Collision) -> list[str]:
    """A sentence on why the theorem on robust chaos does not apply, none where it does.

    collision.chaos has its conditions up to the first that fails. Where that is the very first one
    there is no sentence: chaos is then not in question. Where it is the last one, a chaotic
    attractor may exist all the same.
    """
    last_tried = collision.chaos[-1]
    if len(collision.chaos) < 2 or last_tried.holds:
        return []
    numbers = f"{last_tried.left:.6g} against {last_tried.right:.6g}"
    fails = f"{inequality_text(last_tried)} fails, {numbers}"
    if len(collision.chaos) == THEOREM:
        fails += ", which leaves it open whether a chaotic attractor exists"
    return [f"The theorem on robust chaos does not apply: {fails}."]
