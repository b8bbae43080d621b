/* The default scene's orbit as one would write it by hand in C: no damping, no gravity, the cam's
   circles by their formulas, contact by Halley's iteration, libm for sin and cos.
   Nothing certifies that no contact is missed. Angles in rad, velocities by angle. */
#include <math.h>

#define TURN 6.283185307179586
#define REGIONS 7
#define DEG (TURN / 360.0)

typedef struct { double start, end, centre, e, r2, lift, jerk; } Region; /* r2 = 0: a dwell */

static const double BASE = 0.1, TOP = 0.25393320723821;
static Region regions[REGIONS];

static void lift(const Region *p, double theta, double *c, double *c1, double *c2) {
    if (p->r2 == 0.0) { *c = p->lift; *c1 = *c2 = 0.0; return; }
    double x = theta - p->centre, s = sin(x), k = cos(x), e = p->e;
    double root = sqrt(p->r2 - e * e * s * s), es = e * s, ek = e * k;
    *c = ek + root - 0.3;
    *c1 = -es - es * ek / root;
    *c2 = -ek - (ek * ek - es * es) / root - es * es * ek * ek / (root * root * root);
}

static void make_cam(void) {
    double b = 150.1793714951576, e = 360.0 - b, ends[] = {0, 90, b, 160, 200, e, 270, 360};
    double centre[] = {0, 90, 160, 0, 200, 270, 0}, far[] = {0, -0.45, 0.40393320723821};
    int kind[] = {0, 1, 2, 0, 2, 1, 0};
    for (int i = 0; i < REGIONS; i++) {
        double radius = kind[i] == 1 ? 0.85 : kind[i] == 2 ? 0.15 : 0.0;
        regions[i] = (Region){ends[i] * DEG, ends[i + 1] * DEG, centre[i] * DEG, far[kind[i]],
                              radius * radius, i == 3 ? TOP : BASE,
                              kind[i] == 1 ? 0.19 : kind[i] == 2 ? 6.0 : 0.0};
    }
}

/* Follow an orbit from (q, w) at angle 0, from rest where q is not above the cam; the log takes the
   angle, place and speed of the last impact of each row. Returns the number of impacts. */
long plain_orbit(double W, double r, double tolerance, long turns, double q, double w, double *log,
                 long rows, double *final) {
    double cosines[REGIONS], sines[REGIONS], theta = 0.0, c, c1, c2;
    long impacts = 0;
    int i = 0, resting = 0;
    make_cam();
    for (int k = 0; k < REGIONS; k++) {
        double angle = W * (regions[k].end - regions[k].start);
        cosines[k] = cos(angle), sines[k] = sin(angle);
    }
    if (!(q > BASE)) q = BASE, w = 0.0, resting = 1;
    for (long turn = 0; turn < turns;) {
        const Region *p = &regions[i];
        double length = p->end - theta, co, si;
        if (resting) { /* the contact force is lost where c'' falls below -W^2 c */
            lift(p, theta, &c, &c1, &c2);
            if (W * W * c + c2 < 0.0) resting = 0, q = c, w = c1;
            else { /* within this cam's regions it is lost at their start or not at all */
                theta = p->end, i++;
                if (i == REGIONS) i = 0, theta = 0.0, turn++;
                continue;
            }
        }
        if (theta == p->start) co = cosines[i], si = sines[i];
        else co = cos(W * length), si = sin(W * length);
        double end_q = q * co + w / W * si, end_w = w * co - q * W * si;
        lift(p, p->end, &c, &c1, &c2);
        double gap = end_q - c;
        if (q > TOP && end_q > TOP) gap = 1.0;
        if (gap > 0.0) { /* concave in between, or a landing before a later rise */
            theta = p->end, q = end_q, w = end_w, i++;
            if (i == REGIONS) i = 0, theta = 0.0, turn++;
            continue;
        }
        double d, d1, d2, s, high = length, low = 0.0;
        lift(p, theta, &d, &d1, &d2);
        double g0 = q - d, u = w - d1, a = -W * W * q - d2;
        s = a < 0.0 ? (u + sqrt(u * u - 2.0 * a * (g0 > 0.0 ? g0 : 0.0))) / -a : 0.5 * length;
        if (!(s > 0.0 && s < length)) s = 0.5 * length;
        for (int n = 0; n < 60; n++) {
            co = cos(W * s), si = sin(W * s);
            end_q = q * co + w / W * si, end_w = w * co - q * W * si;
            lift(p, theta + s, &c, &c1, &c2);
            double g = end_q - c;
            u = end_w - c1;
            if (g > 0.0) low = s;
            else high = s;
            double accel = -W * W * end_q - c2, step = -g / u, curve = step * accel / u;
            if (fabs(curve) < 0.5) step /= 1.0 + 0.5 * curve; /* Halley's iteration */
            if (!(u < 0.0 && s + step > low && s + step < high)) step = 0.5 * (low + high) - s;
            else if (fabs(step) < 3e-6 && fabs(curve) < 3e-6) n = 60; /* the next is a rounding */
            if (n == 60) u += step * accel;
            s += step;
        }
        theta += s;
        lift(p, theta, &c, &c1, &c2);
        if (impacts < rows) log[3 * impacts] = theta, log[3 * impacts + 1] = c, log[3 * impacts + 2] = u;
        impacts++;
        u *= -r, q = c, w = c1 + u;
        double alpha = W * W * c + c2;
        if (alpha > 0.0) { /* accumulation, to second order in u */
            double hop = 2.0 * u / alpha, left = hop / (1.0 - r), rho = -W * W * c1 / alpha;
            double eta = (W * W * fabs(w) + W * W * W * c + p->jerk) / alpha * left;
            if (left * eta * eta < tolerance && theta + left < p->end) {
                theta += left + (rho / 3.0 + r * 2.0 * rho / 3.0 / (1.0 - r)) * hop * hop / (1.0 - r * r);
                resting = 1;
            }
        }
    }
    final[0] = q, final[1] = w;
    return impacts;
}
