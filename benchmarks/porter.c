/* Zehnder's governor of the scene `porter` by its one-coordinate equation, with its numbers in:
   I a'' + I' a'^2 / 2 + V' - J' w^2 / 2 = 0. DOP853 with error control, and angles at given times between steps.
   The coefficients stand in tableau.h, which reduced.py writes. */
#include <math.h>
#include "tableau.h"

static double bend(double angle, double rate) {
    const double arm = 0.3, offset = 0.04, ball = 5.0, sleeve = 20.0, g = 9.81, w = 12.566370614359172;
    double s = sin(angle), c = cos(angle);
    double inertia = 2 * ball * arm * arm + 4 * sleeve * arm * arm * s * s;
    double growth = 8 * sleeve * arm * arm * s * c;
    double pull = 2 * arm * g * s * (ball + sleeve);
    double out = 2 * ball * (offset + arm * s) * arm * c * w * w;
    return (out - pull - 0.5 * growth * rate * rate) / inertia;
}

static void open_step(const double *k, double change, double h, double *dense) {
    dense[0] = change;
    dense[1] = h * k[0] - change;
    dense[2] = 2 * change - h * (k[12] + k[0]);
    for (int r = 0; r < 4; r++) {
        double total = 0;
        for (int m = 0; m < 16; m++) total += DENSE_WEIGHTS[r][m] * k[m];
        dense[3 + r] = h * total;
    }
}

static double within(const double *d, double p) {
    double rest = 1 - p, total = (d[6] * p + d[5]) * rest + d[4];
    return ((((total * p + d[3]) * rest + d[2]) * p + d[1]) * rest + d[0]) * p;
}

int run(double start, double speed, double tolerance, const double *times, int count, double *angles, double *rates) {
    double q = start, v = speed, t = 0, h = 0.01, a[16], b[16], dense[2][7], end = times[count - 1];
    int reached = 0, evaluations = 0;
    a[0] = v;
    b[0] = bend(q, v);
    while (reached < count && times[reached] <= 0) { angles[reached] = q; rates[reached++] = v; }
    while (t < end) {
        double qn = q, vn = v;
        if (h > end - t) h = end - t;
        for (int s = 1; s < 12; s++) {
            double x = 0, y = 0;
            for (int m = 0; m < s; m++) { x += STAGES[s][m] * a[m]; y += STAGES[s][m] * b[m]; }
            qn = q + h * x; vn = v + h * y;
            a[s] = vn; b[s] = bend(qn, vn);
        }
        double x = 0, y = 0, fq = 0, tq = 0, fv = 0, tv = 0;
        for (int m = 0; m < 12; m++) { x += WEIGHTS[m] * a[m]; y += WEIGHTS[m] * b[m]; }
        qn = q + h * x; vn = v + h * y;
        a[12] = vn; b[12] = bend(qn, vn);
        evaluations += 12;
        for (int m = 0; m < 12; m++) {
            fq += ERROR_5[m] * a[m]; tq += ERROR_3[m] * a[m]; fv += ERROR_5[m] * b[m]; tv += ERROR_3[m] * b[m];
        }
        double fifth = fq * fq + fv * fv / (12.566370614359172 * 12.566370614359172);
        double third = tq * tq + tv * tv / (12.566370614359172 * 12.566370614359172);
        double error = h * fifth / (sqrt((fifth + 0.01 * third) * 2) + 1e-300) / tolerance + 1e-30;
        if (error <= 1) {
            double later = t + h;
            if (end - later < 1e-13) later = end;
            if (reached < count && times[reached] <= later) {
                for (int e = 0; e < 3; e++) {
                    x = y = 0;
                    for (int m = 0; m < 13 + e; m++) { x += DENSE_STAGES[e][m] * a[m]; y += DENSE_STAGES[e][m] * b[m]; }
                    a[13 + e] = v + h * y; b[13 + e] = bend(q + h * x, v + h * y);
                }
                evaluations += 3;
                open_step(a, qn - q, h, dense[0]);
                open_step(b, vn - v, h, dense[1]);
                for (; reached < count && times[reached] <= later; reached++) {
                    double p = (times[reached] - t) / h;
                    angles[reached] = q + within(dense[0], p);
                    rates[reached] = v + within(dense[1], p);
                }
            }
            t = later; q = qn; v = vn; a[0] = a[12]; b[0] = b[12];
        }
        double growth = 0.9 * pow(error, -0.125);
        h *= growth < 0.2 ? 0.2 : growth > 6 ? 6 : growth;
    }
    return evaluations;
}
