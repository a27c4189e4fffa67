"""Cubic B-splines for the scripts that check files."""


def de_boor(knots, points, x):
    """The point at x of the cubic with these knots; `points` along the first axis."""
    k = 3
    while k + 5 < len(knots) and x >= knots[k + 1]:
        k += 1
    d = [points[k - 3 + i] for i in range(4)]
    for r in range(1, 4):
        for j in range(3, r - 1, -1):
            low, high = knots[k - 3 + j], knots[k + 1 + j - r]
            a = (x - low) / (high - low)
            d[j] = (1 - a) * d[j - 1] + a * d[j]
    return d[3]
