# Writes a torus as OBJ: awk -v n=40 -v m=20 -f torus.awk
BEGIN {
    pi = atan2(0, -1)
    for (i = 0; i < n; i++)
        for (j = 0; j < m; j++) {
            u = 2 * pi * i / n; v = 2 * pi * j / m
            printf "v %.9g %.9g %.9g\n", (3 + cos(v)) * cos(u), (3 + cos(v)) * sin(u), sin(v)
        }
    for (i = 0; i < n; i++)
        for (j = 0; j < m; j++) {
            a = i * m + j; b = (i + 1) % n * m + j
            c = (i + 1) % n * m + (j + 1) % m; d = i * m + (j + 1) % m
            printf "f %d %d %d\nf %d %d %d\n", a + 1, b + 1, c + 1, a + 1, c + 1, d + 1
        }
}
