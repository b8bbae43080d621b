"""Values of a range at even steps."""


def rpm_grid(start: float, stop: float, num: int) -> list[float]:
    """num speeds from start to stop, both exact; descending where start > stop."""
    if num == 1:
        return [start]
    return [stop if k == num - 1 else start + (stop - start) * (k / (num - 1)) for k in range(num)]
