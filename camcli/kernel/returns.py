"""After how many turns a record repeats at its end, by its states at the strobe.

Distances are relative: each coordinate's to its largest value in the record, and the larger of the
two counts.
"""

from camcli.kernel.marks import inlined, outlined

SAME = 1e-7  # distance that counts as none: solved orbits differ by rounding, neighbours by more
CLOSE = 1e-2  # distance of two passages of the section that suggests a period
LONGEST_PERIOD = 64
WINDOW = 16  # periods compared at least


@outlined
def find_return(strobe, turns):
    """(m, near): the fewest turns m that repeat the end of a record of whole turns; 0: none do.

    The last turns, 2 m and WINDOW at least, are those m turns before, symbols and states to SAME.
    near: 1 where no m does, but some bring the last state CLOSE to itself and the symbols back.
    """
    last = strobe.first + turns - 1
    q, w = 0.0, 0.0
    for k in range(strobe.first, last + 1):
        q = max(q, abs(strobe.q[k]))
        w = max(w, abs(strobe.w[k]))
    if q == 0.0:
        q = 1.0
    if w == 0.0:
        w = 1.0
    near = 0
    for m in range(1, min(LONGEST_PERIOD, turns // 2) + 1):
        if not distance(strobe, last, last - m, q, w) <= CLOSE:
            continue
        window = min(turns - m, max(2 * m, WINDOW))
        alike = count_alike(strobe, last, m, window)
        if alike >= m:
            near = 1
        if alike == window and count_same(strobe, last, m, window, q, w) == window:
            return m, 0
    return 0, near


@inlined
def distance(strobe, k, j, q, w):
    """The relative distance of the states in two rows, of sizes q and w."""
    return max(abs(strobe.q[k] - strobe.q[j]) / q, abs(strobe.w[k] - strobe.w[j]) / w)


@inlined
def count_alike(strobe, last, m, most):
    """How many turns in a row, back from the last, have the symbols of those m turns before."""
    for n in range(most):
        k = last - n
        chattered = strobe.chatter[k] != 0
        if chattered != (strobe.chatter[k - m] != 0):
            return n
        if not chattered and strobe.impacts[k] != strobe.impacts[k - m]:
            return n
    return most


@inlined
def count_same(strobe, last, m, most, q, w):
    """How many states in a row, back from the last, are the SAME as m turns before."""
    for n in range(most):
        if not distance(strobe, last - n, last - n - m, q, w) <= SAME:
            return n
    return most
