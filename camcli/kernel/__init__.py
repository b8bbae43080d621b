"""The hybrid core: flow, contact search, reset, chatter and sticking on bare numbers.

Rules of this package (they keep the bits portable, see README):
only IEEE add, subtract, multiply, divide and sqrt; no libm function; no callables as
arguments; no exceptions, only status codes; no allocation per event. Every function runs
the same, bit for bit, in plain Python and compiled by numba; `backend` is the seam.

Units inside: lengths in m, the cam angle theta in rad as the independent variable, so a
velocity is dq/dtheta (m/rad) and the follower is described by dimensionless numbers
(`flow.Constants`). That makes results exactly scale-free.

The same letters everywhere: c, c1, c2, ... the cam and its derivatives by theta; q, w = q' the
follower; gap = q - c, rate = gap'; u the rate at an impact, before it
(after it in `chatter_map`); i a stretch of the cam, on which c is smooth; x_rest what x leaves out
of a number that is kept in two doubles.
"""
