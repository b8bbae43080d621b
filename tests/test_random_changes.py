"""The changes that `tests/support/random_mutants.py` draws: what they change and leave alone."""

import pytest

from tests.support.changes import changes_meaning, changes_of
from tests.support.random_mutants import PACKAGE, by_hand

TEXT = '''"""A module's text, which is no meaning."""
from math import pi

__all__ = ["lowest", "said"]
LEAST = 0.5


def lowest(values: dict[str, float], kept: bool = True) -> float:
    """The least value of 2 or more."""
    if not values or len(values) < 2 and kept:
        return LEAST - pi
    return min(values)


class Said:
    def __repr__(self) -> str:
        return "nothing else"

    def words(self, n: int) -> str:
        self.count += 1
        return f"about {n + 1:.3f} turns" if n else "é: " + str(-n)
'''


def made() -> dict[int, set[str]]:
    """Each changed line of the text, by its number."""
    return {
        line: {
            change.made_in(TEXT).splitlines()[line - 1].strip()
            for change in changes
            if changes_meaning(change, TEXT)
        }
        for line, changes in changes_of(TEXT).items()
    }


def test_a_line_is_changed_where_its_meaning_stands():
    assert made() == {
        5: {"LEAST = 0.55"},
        8: {"def lowest(values: dict[str, float], kept: bool = False) -> float:"},
        10: {
            "if False:",
            "if (not values and (len(values) < 2 and kept)):",
            "if (len(values) < 2 and kept):",
            "if (not values):",
            "if values or len(values) < 2 and kept:",
            "if not values or (len(values) < 2 or kept):",
            "if not values or kept:",
            "if not values or (len(values) < 2):",
            "if not values or (len(values) <= 2) and kept:",
            "if not values or len(values) < 3 and kept:",
            "if not values or len(values) < 1 and kept:",
        },
        11: {"return (LEAST + pi)", "return LEAST"},
        12: {"return max(values)"},
        20: {"pass", "self.count += 2", "self.count += 0"},
        21: {
            "return ('é: ' + str(-n) if n else f'about {n + 1:.3f} turns')",
            "return f'{n + 1:.3f} turns' if n else \"é: \" + str(-n)",
            "return f'about {n + 1:.3f} ' if n else \"é: \" + str(-n)",
            "return f'about {n - 1:.3f} turns' if n else \"é: \" + str(-n)",
            "return f'about {n:.3f} turns' if n else \"é: \" + str(-n)",
            "return f'about {n + 2:.3f} turns' if n else \"é: \" + str(-n)",
            "return f'about {n + 0:.3f} turns' if n else \"é: \" + str(-n)",
            "return f'about {n + 1:.2f} turns' if n else \"é: \" + str(-n)",
            'return f"about {n + 1:.3f} turns" if n else \'é: \'',
            'return f"about {n + 1:.3f} turns" if n else "é: " + str(n)',
        },
    }  # fmt: skip


def test_a_sum_of_texts_keeps_its_plus():
    kinds = {change.kind for changes in changes_of("a = b + 'c'").values() for change in changes}
    assert kinds == {"addend dropped"}


def test_a_change_by_hand_knows_its_lines_and_its_function():
    """Within a function, and where a module gives a value to a name."""
    first = by_hand(
        "words/in_print.py", 'return number_range(low, high).replace("-", "−")', "return 1"
    )
    assert (first.function, first.names, first.kind) == ("range_of", (), "by hand")
    text = (PACKAGE / "words/in_print.py").read_text(encoding="utf-8")
    assert text.splitlines()[first.line - 1].strip() == first.old
    assert first.made_in(text) == text.replace(first.old, "return 1")
    value = by_hand("cli/help.py", "FULL = 92", "FULL = 91")
    assert (value.function, value.names, value.line) == (None, ("FULL",), value.last_line)
    with pytest.raises(SystemExit, match="stands 0 times"):
        by_hand("cli/help.py", "no such line", "")
