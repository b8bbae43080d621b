"""The one true motion after a rest, with many digits, where doubles lose it."""
