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
