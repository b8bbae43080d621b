"""Chaos proved: boxes of impacts, of which each is mapped over others."""
