/* One cubic B-spline function over five knots, one variable: its polynomial pieces as blossoms. */
#ifndef PC_CUBIC_H
#define PC_CUBIC_H

/* The blossom (polar form) of the piece of N[knot] that lives on the interval between knots[span] and
 * knots[span+1], span 0..3, at the three arguments. The knots must be distinct. Cox-de Boor with one argument
 * per degree; digest C02. */
double pc_cubic_blossom(const double knots[5], int span, double x0, double x1, double x2);

/* The four Bezier coefficients on [low, high], which lies within one interval of the knots; all 0 where it
 * lies outside of them. */
void pc_cubic_bezier(double coefficient[4], const double knots[5], double low, double high);

/* The four cubic Bernstein polynomials at u in 0..1. */
static inline void pc_bernstein_values(double value[4], double u) {
    const double v = 1 - u;
    value[0] = v * v * v, value[1] = 3 * u * v * v, value[2] = 3 * u * u * v, value[3] = u * u * u;
}
/* The same, and their first and second derivatives. */
void pc_bernstein(double value[4], double first[4], double second[4], double u);

/* The blossom of the cubic with Bezier coefficients b over [low, high] is the sum of weight[i]*b[i]; any
 * arguments. */
void pc_bezier_blossom_weights(double weight[4], double low, double high, const double x[3]);

#endif
