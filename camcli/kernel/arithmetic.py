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
TWO_TO_MINUS_32 = 2.3283064365386963e-10
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
SPLIT = 134217729.0  # 2^27 + 1 (Veltkamp)


@inlined
def product_rest(a, b, product):
    """a b - product, exact where product is a b in doubles (Dekker, Numer. Math. 18, 1971).

    Both factors are split into halves of 26 bits (Veltkamp), whose products are exact.
    """
    a_split = SPLIT * a
    b_split = SPLIT * b
    a_high = a_split - (a_split - a)
    b_high = b_split - (b_split - b)
    a_low = a - a_high
    b_low = b - b_high
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@inlined
def sum_rest(a, b, total):
    """a + b - total, exact where total is a + b in doubles (Knuth)."""
    b_in_total = total - a
    a_in_total = total - b_in_total
    return (a - a_in_total) + (b - b_in_total)


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
    """atan(x)/x for y = x^2 <= LARGEST_TANGENT^2, to about 1 ulp.

    It is 1 + sum A_n y^n, n = 1 to 12, whose terms are added up in three groups of four.
    """
    y2 = y * y
    y4 = y2 * y2
    first = (A1 + y * A2) + y2 * (A3 + y * A4)
    second = (A5 + y * A6) + y2 * (A7 + y * A8)
    third = (A9 + y * A10) + y2 * (A11 + y * A12)
    return 1.0 + y * (first + y4 * (second + y4 * third))


@outlined
def sincos(x):
    """(sin x, cos x); full precision for |x| < 1.6e6, bounded for any finite x.

    x is n pi/2 + z with n whole and |z| <= pi/4 (Cody and Waite); n modulo 4 is the quadrant.
    """
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
    """sin and 1 - cos of x + x_rest, x >= 0, each in two parts, to about 2e-17.

    (sine, sine_rest, versine, versine_rest). As in `sincos` the angle is n pi/2 + z, here with what
    z leaves out: z + z_rest. With y = z^4 the series of z, each without its first term, are
        sin z = z + z s,    s = y (S2 + S4 y + ..) - z^2 (S1 + S3 y + ..),
        1 - cos z = z^2/2 + z^2 v,    v = y (V2 + V4 y + ..) - z^2 (V1 + V3 y + ..),
    and z_rest is added to first order.
    """
    if x > MEANINGLESS:
        return 0.0, 0.0, 0.0, 0.0
    n = int(x * TWO_OVER_PI + 0.5)
    whole = float(n)
    nearly = x - whole * PIO2_1
    correction = whole * PIO2_2
    z = nearly - correction
    z_rest = sum_rest(nearly, -correction, z) - whole * PIO2_3 + x_rest
    if z > 1.0 or z < -1.0:  # only far beyond 1.6e6, where the phase means nothing
        z = 0.0
    square = z * z
    y = square * square
    v = y * (V2 + y * (V4 + y * V6)) - square * (V1 + y * (V3 + y * (V5 + y * V7)))
    s = y * (S2 + y * (S4 + y * (S6 + y * S8))) - square * (S1 + y * (S3 + y * (S5 + y * S7)))
    sine_gain = z * s
    sine = z + sine_gain
    half = 0.5 * square
    versine_gain = square * v
    versine = half + versine_gain
    sine_rest = (z - sine) + sine_gain + z_rest * (1.0 - versine)
    square_rest = product_rest(z, z, square)
    versine_rest = (half - versine) + versine_gain + (0.5 * square_rest + sine * z_rest)
    quadrant = n & 3
    if quadrant == 0:
        return sine, sine_rest, versine, versine_rest
    cosine = 1.0 - versine
    cosine_rest = (1.0 - cosine) - versine - versine_rest
    if quadrant == 2:  # sin(pi + z), 1 + cos z
        turned = 1.0 + cosine
        return -sine, -sine_rest, turned, (1.0 - turned) + cosine + cosine_rest
    if quadrant == 1:  # sin(pi/2 + z), 1 + sin z
        turned = 1.0 + sine
        return cosine, cosine_rest, turned, (1.0 - turned) + sine + sine_rest
    turned = 1.0 - sine  # of 3 pi/2 + z
    return -cosine, -cosine_rest, turned, (1.0 - turned) - sine - sine_rest


@outlined
def exp_decay(x):
    """exp(-x) for x >= 0, to about 1 ulp; 0 where it underflows.

    It is 2^-n exp(z) with n whole and |z| <= ln 2/2, and exp(z) is its Taylor series of 14 terms.
    """
    if -x < UNDERFLOW:
        return 0.0
    n = int(x * LOG2_E + 0.5)
    z = (n * LN2_HI - x) + n * LN2_LO
    value = 1.0
    for k in range(14, 0, -1):
        value = 1.0 + value * z / k
    while n >= 32:
        value *= TWO_TO_MINUS_32
        n -= 32
    while n > 0:
        value *= 0.5
        n -= 1
    return value


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
