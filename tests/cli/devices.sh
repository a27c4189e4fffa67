# Several devices together write the same bytes as one; what cannot be had is refused.
. "$here/lib.sh"
place=$("$PERCALE" devices | sed -nE '1s/^([0-9]+:[0-9]+) .*/\1/p')
[ -n "$place" ] || { echo "there is no OpenCL device"; exit 77; }
# So many vertices that the solver spreads its rows over both.
torus 184 90 >t.obj
members() { "$PERCALE" convert t.obj -o "$1" --device "$2" --threads 2 --edge-length 0.6 --quiet; }
both="$place/2"
"$PERCALE" devices | grep -q '^ *1 units' && both="$place,$place"
members one "$place"
members two "$both"
same one two && echo "devices: same"
grep -q halo_gather one/report.json || echo "one: alone"
grep -q halo_gather two/report.json && echo "two: together"
for wanted in "$place/17" "$place,host" "host/2" "$place,nothing"; do
    try members no "$wanted" 2>&1 | sed -E "s/$place/PLACE/; s/there is: .*/there is: .../"
done
