#include "cubic.h"
#include <string.h>

double pc_cubic_blossom(const double knots[5], int span, double x0, double x1, double x2) {
    const double x[3] = {x0, x1, x2};
    double n[5] = {0};
    n[span] = 1;
    for (int p = 1; p <= 3; p++)
        for (int i = 0; i + p < 4; i++) {
            double rising = (x[p - 1] - knots[i]) / (knots[i + p] - knots[i]);
            double falling = (knots[i + p + 1] - x[p - 1]) / (knots[i + p + 1] - knots[i + 1]);
            n[i] = rising * n[i] + falling * n[i + 1];
        }
    return n[0];
}

void pc_cubic_bezier(double coefficient[4], const double knots[5], double low, double high) {
    int span = 0;
    memset(coefficient, 0, 4 * sizeof(double));
    if (low < knots[0] || high > knots[4]) return;
    while (span < 3 && high > knots[span + 1])
        span++;
    coefficient[0] = pc_cubic_blossom(knots, span, low, low, low);
    coefficient[1] = pc_cubic_blossom(knots, span, low, low, high);
    coefficient[2] = pc_cubic_blossom(knots, span, low, high, high);
    coefficient[3] = pc_cubic_blossom(knots, span, high, high, high);
}

void pc_bernstein(double value[4], double first[4], double second[4], double u) {
    const double v = 1 - u;
    pc_bernstein_values(value, u);
    first[0] = -3 * v * v, first[1] = 3 * v * (v - 2 * u), first[2] = 3 * u * (2 * v - u),
    first[3] = 3 * u * u;
    second[0] = 6 * v, second[1] = 6 * (u - 2 * v), second[2] = 6 * (v - 2 * u), second[3] = 6 * u;
}

void pc_bezier_blossom_weights(double weight[4], double low, double high, const double x[3]) {
    memset(weight, 0, 4 * sizeof(double));
    weight[0] = 1;
    for (int p = 0; p < 3; p++) {
        double u = (x[p] - low) / (high - low);
        for (int i = p + 1; i > 0; i--)
            weight[i] = (1 - u) * weight[i] + u * weight[i - 1];
        weight[0] *= 1 - u;
    }
}
