"""The pictures: a function takes a result and returns a matplotlib Figure; nothing is written.

Matplotlib is imported in this folder only: import its modules where a picture is due.
"""
