# Several devices together write the same bytes as one; what cannot be had is refused.
. "$here/lib.sh"
read -r place units < <("$PERCALE" devices | awk '/^[0-9]+:[0-9]+ +cpu / { p = $1 } p && / units, / { print p, $1; exit }')
[ -n "$place" ] || { echo "no CPU has OpenCL"; exit 77; }
# So many vertices that the solver spreads its rows over both.
torus 184 90 >t.obj
members() { "$PERCALE" convert t.obj -o "$1" --device "$2" --threads 2 --edge-length 0.6 --quiet; }
both="$place/2"
[ "$units" -gt 1 ] || both="$place,$place"
members one "$place"
members two "$both"
same one two && echo "devices: same"
grep -q halo_gather one/report.json || echo "one: alone"
grep -q halo_gather two/report.json && echo "two: together"
for wanted in "$place/17" "$place,host" "host/2" "$place,nothing"; do
    try members no "$wanted" 2>&1 | sed -E "s/$place/PLACE/; s/there is: .*/there is: .../"
done
