"""Why a chaotic attractor changes size at once, or is lost: the tangency solved, runs beside it."""

from camcli.analysis.explain.crisis.search import Crisis, CrisisKind, find_crisis

__all__ = ["Crisis", "CrisisKind", "find_crisis"]
