/* The paper's four-bar written by hand for this one mechanism: the yardstick of rhs.py.

   Coupler (2) and rocker (3) with the crank's motion given; play at O3 and O4 as massless links; RK4.
   S lambda = R of the Schur complement is solved by an unrolled L D L^T (S31 = S30 = 0).

   Build:  cc -O3 -march=native handwritten_fourbar.c -o handwritten_fourbar -lm
   Use:    handwritten_fourbar STEPS RUNS
   Prints  {"steps": .., "error": [rad] at 0.05 s, "seconds_per_run": .., "seconds_per_rhs": ..} */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { X2, Y2, TH2, X3, Y3, TH3, N };
static const double l1 = 0.2, l = 0.6, omega = 10, m = 2, J = 0.06, r3 = 0.005, r4 = 0.005, M = 40;
static const double END = 0.05, REFERENCE[2] = {0.8548610709, -1.1619901719}; /* th2, th3 [rad] at END */
static double XO4;

/* y = (q, v); dy = (v, dv) */
static inline void rhs(double t, const double *y, double *dy)
{
    const double *v = y + N;
    const double a = l / 2, im = 1 / m, iJ = 1 / J;
    const double c1 = cos(omega * t), s1 = sin(omega * t); /* calls first: 10 % faster than where they are used */
    const double ax = a * cos(y[TH2]), ay = a * sin(y[TH2]), bx = a * cos(y[TH3]), by = a * sin(y[TH3]);
    const double w2 = v[TH2], w3 = v[TH3];

    /* unit vectors of the massless links, rates of their ends */
    const double n3x = (y[X3] - bx - y[X2] - ax) / r3, n3y = (y[Y3] - by - y[Y2] - ay) / r3;
    const double n4x = (XO4 - y[X3] - bx) / r4, n4y = (-y[Y3] - by) / r4;
    const double d3x = v[X3] + w3 * by - v[X2] + w2 * ay, d3y = v[Y3] - w3 * bx - v[Y2] - w2 * ax;
    const double d4x = -(v[X3] - w3 * by), d4y = -(v[Y3] + w3 * bx);

    /* moments of a unit force along each link */
    const double e2 = n3y * ax - n3x * ay, e3 = -n3y * bx + n3x * by, f3 = n4y * bx - n4x * by;

    /* S = Phi_q M^-1 Phi_q^T */
    const double S00 = im + ay * ay * iJ, S10 = -ax * ay * iJ, S11 = im + ax * ax * iJ;
    const double S20 = -n3x * im - ay * e2 * iJ, S21 = -n3y * im + ax * e2 * iJ;
    const double S22 = 2 * im + (e2 * e2 + e3 * e3) * iJ;
    const double S32 = -(n3x * n4x + n3y * n4y) * im - e3 * f3 * iJ, S33 = im + f3 * f3 * iJ;

    /* R = Phi_q M^-1 Q - gamma */
    double R0 = l1 * omega * omega * c1 + ax * w2 * w2;
    double R1 = l1 * omega * omega * s1 + ay * w2 * w2;
    double R2 = (d3x * d3x + d3y * d3y) / r3 + n3x * (w3 * w3 * bx + w2 * w2 * ax)
                + n3y * (w3 * w3 * by + w2 * w2 * ay) + e3 * M * iJ;
    double R3 = (d4x * d4x + d4y * d4y) / r4 + n4x * (w3 * w3 * bx) + n4y * (w3 * w3 * by) - f3 * M * iJ;

    /* factor and solve; R becomes lambda */
    const double i0 = 1 / S00, L10 = S10 * i0, L20 = S20 * i0;
    const double i1 = 1 / (S11 - L10 * S10), t21 = S21 - L20 * S10, L21 = t21 * i1;
    const double i2 = 1 / (S22 - L20 * S20 - L21 * t21), L32 = S32 * i2;
    R1 -= L10 * R0;
    R2 -= L20 * R0 + L21 * R1;
    R3 -= L32 * R2;
    R3 /= S33 - L32 * S32;
    R2 = R2 * i2 - L32 * R3;
    R1 = R1 * i1 - L21 * R2;
    R0 = R0 * i0 - L10 * R1 - L20 * R2;

    /* dv = M^-1 (Q - Phi_q^T lambda) */
    memcpy(dy, v, N * sizeof *dy);
    dy[N + X2] = im * (-R0 + n3x * R2);
    dy[N + Y2] = im * (-R1 + n3y * R2);
    dy[N + TH2] = iJ * (-ay * R0 + ax * R1 + e2 * R2);
    dy[N + X3] = im * (-n3x * R2 + n4x * R3);
    dy[N + Y3] = im * (-n3y * R2 + n4y * R3);
    dy[N + TH3] = iJ * (M - e3 * R2 + f3 * R3);
}

static void run(int steps, double *y)
{
    const double alpha = acos(-1) / 3, h = END / steps;
    const double start[2 * N] = {l1 + l / 2 * cos(alpha), l / 2 * sin(alpha), alpha,
                                 XO4 - r4 - l / 2 * cos(alpha), l / 2 * sin(alpha), -alpha,
                                 0, l1 * omega, 0, 0, 0, 0};
    double k1[2 * N], k2[2 * N], k3[2 * N], k4[2 * N], z[2 * N];
    memcpy(y, start, sizeof start);
    for (int s = 0; s < steps; s++) {
        const double t = s * h;
        rhs(t, y, k1);
        for (int i = 0; i < 2 * N; i++) z[i] = y[i] + h / 2 * k1[i];
        rhs(t + h / 2, z, k2);
        for (int i = 0; i < 2 * N; i++) z[i] = y[i] + h / 2 * k2[i];
        rhs(t + h / 2, z, k3);
        for (int i = 0; i < 2 * N; i++) z[i] = y[i] + h * k3[i];
        rhs(t + h, z, k4);
        for (int i = 0; i < 2 * N; i++) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    }
}

int main(int count, char **words)
{
    const int steps = count > 1 ? atoi(words[1]) : 2000, runs = count > 2 ? atoi(words[2]) : 100;
    struct timespec before, after;
    double y[2 * N];
    if (steps < 1 || runs < 1) {
        fprintf(stderr, "usage: %s STEPS RUNS, both at least 1\n", words[0]);
        return 2;
    }
    XO4 = l1 + 2 * l * cos(acos(-1) / 3) + r3 + r4;
    clock_gettime(CLOCK_MONOTONIC, &before);
    for (int r = 0; r < runs; r++) run(steps, y);
    clock_gettime(CLOCK_MONOTONIC, &after);
    const double seconds = ((after.tv_sec - before.tv_sec) + 1e-9 * (after.tv_nsec - before.tv_nsec)) / runs;
    const double error = fmax(fabs(y[TH2] - REFERENCE[0]), fabs(y[TH3] - REFERENCE[1]));
    printf("{\"steps\": %d, \"error\": %.3e, \"seconds_per_run\": %.6e, \"seconds_per_rhs\": %.6e}\n",
           steps, error, seconds, seconds / (4.0 * steps));
    return 0;
}
