# The spline of a run, evaluated: places, a grid, nearest points; what is wrong with a list is told by its line.
. "$here/lib.sh"
torus 48 24 >t.obj
convert t.obj -o t --quads 200 --tolerance 1% --no-pictures
rows() { tail -n +2 "$1"; }
largest() { awk -F, -v column="$1" '{ if ($column > most) most = $column } END { print (most < 1e-6 ? "same" : most) }'; }

"$PERCALE" eval t --grid 3 --derivatives -o grid.csv
head -1 grid.csv
awk -F, 'NR > 1 && $3 == 0 && $2 == 0 { faces++ } END { print NR - 1 == 9 * faces ? "nine rows per face" : NR }' grid.csv
echo "as the places of the table itself, read from standard input:"
rows grid.csv | cut -d, -f1-3 | "$PERCALE" eval t --at - --derivatives | cmp - grid.csv && echo same

echo "points on the normals, 0.05 away, are nearest to where they came from:"
rows grid.csv | awk -F, '{ printf "%.17g %.17g %.17g\n", $4 + $7 / 20, $5 + $8 / 20, $6 + $9 / 20 }' >off.txt
"$PERCALE" eval t/result.h5 --project off.txt -o near.csv
head -1 near.csv
paste -d, <(rows grid.csv | cut -d, -f4-6) <(rows near.csv | cut -d, -f4-6,10) | awk -F, 'function abs(x) { return x < 0 ? -x : x }
    { print abs($1 - $4) + abs($2 - $5) + abs($3 - $6) "," abs($7 - 0.05) }' >gaps
largest 1 <gaps
largest 2 <gaps
echo "of a torus of radii 3 and 1 the outer curvatures are near 1 and 1/4:"
printf '4 0 0\n' | "$PERCALE" eval t --project - --derivatives | tail -1 | awk -F, '{ printf "%.1f %.2f\n", $(NF - 1), $NF }'

printf 'face s t\n# nothing\n' | "$PERCALE" eval t --at -
for list in '0 1' '0 1 2 3' '0 .5 x' '9999 0 0' '-1 0 0' '1.5 0 0' '0 0 1.5' '0 nan 0'; do
    printf '0 0 0\n\n%s\n' "$list" >list.txt
    try "$PERCALE" eval t --at list.txt
done
try "$PERCALE" eval t --at missing.txt
try "$PERCALE" eval t.obj --grid 3
try "$PERCALE" eval t/stages/quads.h5 --grid 3
try "$PERCALE" eval t --grid 3 -o grid.csv
try "$PERCALE" eval t
try "$PERCALE" eval t --grid 3 --at list.txt
ls
