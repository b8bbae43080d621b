"""sin, cos, atan, exp and ln from IEEE additions and multiplications alone.

The C library's versions differ in the last bit between machines, and a chaotic orbit
differs with them; these give the same bits everywhere.
"""

from math import factorial

from camcli.kernel.marks import inlined, outlined

# pi/2 in three parts of 33 bits, ln 2 in two parts: products with small integers are exact.
PIO2_1 = 1.57079632673412561417e00
PIO2_2 = 6.07710050630396597660e-11
PIO2_3 = 2.02226624879595063154e-21
TWO_OVER_PI = 6.36619772367581382433e-01
LN2_HI = 6.93147180369123816490e-01
LN2_LO = 1.90821492927058770002e-10
LOG2_E = 1.44269504088896338700e00
LN2 = 0.6931471805599453
UNDERFLOW = -745.2
MEANINGLESS = 1e15  # beyond it one ulp of an angle is a sizeable part of a turn

# V_n = 1/(2n+2)!, S_n = 1/(2n+1)!
V0, V1, V2, V3, V4, V5, V6, V7, V8, V9, V10 = (1.0 / factorial(2 * n + 2) for n in range(11))
_, S1, S2, S3, S4, S5, S6, S7, S8, S9, S10 = (1.0 / factorial(2 * n + 1) for n in range(11))

LARGEST_TANGENT = 0.5
# (atan(x)/x - 1)/x^2 in powers of x^2 up to its square, interpolated at Chebyshev's nodes
ATAN = (
    -0.33333333333333326,
    0.199999999999916,
    -0.14285714284106285,
    0.11111110990139533,
    -0.09090904370311348,
    0.07692198451257941,
    -0.06665052856794013,
    0.058664967492257074,
    -0.05157516225552972,
    0.04283578705573422,
    -0.02895352123252625,
    0.011152908092096216,
)
A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, A11, A12 = ATAN
INVERSE = (0.0, *(1.0 / n for n in range(1, 33)))  # a product costs a quarter of a division
SPLIT = 134217729.0  # 2^27 + 1 (Veltkamp)


@inlined
def product_rest(a, b, product):
    """a b - product, exact where product is a b in doubles (Dekker, Numer. Math. 18, 1971)."""
    high, low = SPLIT * a, SPLIT * b
    a1, b1 = high - (high - a), low - (low - b)
    a2, b2 = a - a1, b - b1
    return ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2


@inlined
def sum_rest(a, b, total):
    """a + b - total, exact where total is a + b in doubles (Knuth)."""
    part = total - a
    return (a - (total - part)) + (b - part)


@inlined
def cos_sin_series(t):
    """V(t) = (C(t) - 1)/t and S(t) for |t| <= 2.5, both to about 1 ulp.

    C(t) = sum t^n/(2n)! is cos(x) for t = -x^2 and cosh(x) for t = x^2;
    S(t) = sum t^n/(2n+1)! is sin(x)/x and sinh(x)/x. One series through t = 0 is what makes
    the flow continuous through critical damping.
    """
    y = t * t
    v_even = V0 + y * (V2 + y * (V4 + y * (V6 + y * (V8 + y * V10))))
    v_odd = V1 + y * (V3 + y * (V5 + y * (V7 + y * V9)))
    s_even = 1.0 + y * (S2 + y * (S4 + y * (S6 + y * (S8 + y * S10))))
    s_odd = S1 + y * (S3 + y * (S5 + y * (S7 + y * S9)))
    return v_even + t * v_odd, s_even + t * s_odd


@inlined
def atan_ratio(y):
    """atan(x)/x for y = x^2 <= LARGEST_TANGENT^2, to about 1 ulp."""
    z = y * y
    w = z * z
    p = (A1 + y * A2) + z * (A3 + y * A4)
    q = (A5 + y * A6) + z * (A7 + y * A8)
    r = (A9 + y * A10) + z * (A11 + y * A12)
    return 1.0 + y * (p + w * (q + w * r))


@outlined
def sincos(x):
    """(sin x, cos x); full precision for |x| < 1.6e6, bounded for any finite x."""
    if x > MEANINGLESS or x < -MEANINGLESS:
        return 0.0, 1.0
    n = int(x * TWO_OVER_PI + 0.5) if x >= 0.0 else -int(0.5 - x * TWO_OVER_PI)
    y = float(n)
    z = ((x - y * PIO2_1) - y * PIO2_2) - y * PIO2_3
    if z > 1.0 or z < -1.0:  # only far beyond 1.6e6, where the phase means nothing
        z = 0.0
    v, s = cos_sin_series(-z * z)
    sine = z * s
    cosine = 1.0 - z * z * v
    quadrant = n & 3
    if quadrant == 0:
        return sine, cosine
    if quadrant == 1:
        return cosine, -sine
    if quadrant == 2:
        return -sine, -cosine
    return -cosine, sine


@inlined
def sine_versine(x, x_rest):
    """sin and 1 - cos of x + x_rest, x >= 0, each in two parts, to about 2e-17."""
    if x > MEANINGLESS:
        return 0.0, 0.0, 0.0, 0.0
    n = int(x * TWO_OVER_PI + 0.5)
    whole = float(n)
    a, b = x - whole * PIO2_1, whole * PIO2_2
    z = a - b
    rest = sum_rest(a, -b, z) - whole * PIO2_3 + x_rest
    if z > 1.0 or z < -1.0:
        z = 0.0
    p = z * z
    y = p * p
    v = y * (V2 + y * (V4 + y * V6)) - p * (V1 + y * (V3 + y * (V5 + y * V7)))
    s = y * (S2 + y * (S4 + y * (S6 + y * S8))) - p * (S1 + y * (S3 + y * (S5 + y * S7)))
    half, more = 0.5 * p, z * s
    sine = z + more
    versine = half + p * v
    sine_rest = (z - sine) + more + rest * (1.0 - versine)
    versine_rest = (half - versine) + p * v + (0.5 * product_rest(z, z, p) + sine * rest)
    quadrant = n & 3
    if quadrant == 0:
        return sine, sine_rest, versine, versine_rest
    cosine = 1.0 - versine
    cosine_rest = (1.0 - cosine) - versine - versine_rest
    if quadrant == 2:
        fall = 1.0 + cosine
        return -sine, -sine_rest, fall, (1.0 - fall) + cosine + cosine_rest
    if quadrant == 1:
        fall = 1.0 + sine
        return cosine, cosine_rest, fall, (1.0 - fall) + sine + sine_rest
    fall = 1.0 - sine
    return -cosine, -cosine_rest, fall, (1.0 - fall) - sine - sine_rest


@outlined
def exp_decay(x):
    """exp(-x) for x >= 0, to about 1 ulp; 0 where it underflows."""
    if -x < UNDERFLOW:
        return 0.0
    n = int(x * LOG2_E + 0.5)
    z = (n * LN2_HI - x) + n * LN2_LO
    term = 1.0
    for k in range(14, 0, -1):
        term = 1.0 + term * z / k
    while n >= 32:
        term *= 2.3283064365386963e-10
        n -= 32
    while n > 0:
        term *= 0.5
        n -= 1
    return term


@outlined
def one_minus_exp_ratio(z):
    """(1 - exp(-z))/z for z >= 0, without cancellation at small z."""
    if z > 0.5:
        return (1.0 - exp_decay(z)) / z
    total = 1.0
    for k in range(17, 1, -1):
        total = 1.0 - total * z / k
    return total


@outlined
def natural_log(x):
    """ln x for x > 0 to about 1 ulp, by 2 atanh((x - 1)/(x + 1)) of x/2^n in [0.7, 1.5)."""
    twos = 0
    while x >= 1.5:
        x *= 0.5
        twos += 1
    while x < 0.7:
        x *= 2.0
        twos -= 1
    z = (x - 1.0) / (x + 1.0)
    y = z * z
    total = 0.0
    for k in range(23, 0, -2):
        total = total * y + 1.0 / k
    return 2.0 * z * total + twos * LN2
