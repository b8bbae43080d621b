"""Why the checker of certificates does not confirm a statement, read from what it prints."""

from __future__ import annotations


def reasons(printed: str) -> list[str]:
    """The whole reason of each statement that is not confirmed, and that of a file that is none."""
    found = []
    for line in printed.splitlines():
        if line.startswith("not confirmed: "):
            found.append(line.rsplit(": ", 1)[1])
        elif ": no certificate: " in line:
            found.append(line.split(": no certificate: ", 1)[1])
    return found
