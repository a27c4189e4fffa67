# Scans that are no surface: exit code 4 in words; repaired ones say what was done.
. "$here/lib.sh"
# A Moebius strip of five quads has no inside and outside.
awk 'BEGIN { n = 9; pi = atan2(0, -1)
    for (i = 0; i < n; i++) for (k = -1; k <= 1; k += 2) { a = 2 * pi * i / n
        print "v", (3 + k * cos(a / 2)) * cos(a), (3 + k * cos(a / 2)) * sin(a), k * sin(a / 2) }
    for (i = 0; i < n; i++) { a = 2 * i + 1; b = a + 1; c = a + 2; d = a + 3
        if (i == n - 1) { c = 2; d = 1 }
        print "f", a, c, d; print "f", a, d, b } }' >moebius.obj
try "$PERCALE" check moebius.obj >/dev/null
try convert moebius.obj -o out
# Three sheets along one edge.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n' >sheets.obj
try "$PERCALE" check sheets.obj --strict >/dev/null
try convert sheets.obj -o out2 --strict
try "$PERCALE" check sheets.obj | grep -E '^(repair|convertible)'
# Forty fins on a grid of 800 triangles: few enough to be cut off.
awk 'BEGIN { n = 20; m = n + 1
    for (y = 0; y <= n; y++) for (x = 0; x <= n; x++) print "v", x, y, 0
    for (i = 0; i < 40; i++) print "v", i % 20 + 0.5, 5 + 10 * int(i / 20), 1
    for (y = 0; y < n; y++) for (x = 0; x < n; x++) { a = y * m + x + 1
        print "f", a, a + 1, a + m + 1; print "f", a, a + m + 1, a + m }
    for (i = 0; i < 40; i++) { a = (5 + 10 * int(i / 20)) * m + i % 20 + 1; print "f", a, a + 1, m * m + i + 1 } }' >fins.obj
try "$PERCALE" check fins.obj | grep -E '^(repair|convertible)'
# Triangles that nobody joined.
awk 'BEGIN { for (i = 0; i < 40; i++) { print "v", i, 0, 0; print "v", i + 0.9, 0, 0; print "v", i, 1, 0 }
    for (i = 0; i < 40; i++) print "f", 3 * i + 1, 3 * i + 2, 3 * i + 3 }' >shreds.obj
try convert shreds.obj -o out3
