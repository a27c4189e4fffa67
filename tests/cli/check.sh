# Everything about a scan: a torus with a hole, a loose tetrahedron, a duplicate face and an unused vertex.
. "$here/lib.sh"
torus 12 8 | grep -v '^f 1 9' >t.obj
n=$(grep -c '^v' t.obj)
printf 'v 9 9 9\nv 10 9 9\nv 9 10 9\nv 9 9 10\nv 50 50 50\n' >>t.obj
echo "f $((n + 1)) $((n + 3)) $((n + 2))
f $((n + 1)) $((n + 2)) $((n + 4))
f $((n + 2)) $((n + 3)) $((n + 4))
f $((n + 3)) $((n + 1)) $((n + 4))
f $((n + 3)) $((n + 1)) $((n + 4))" >>t.obj
"$PERCALE" check t.obj
"$PERCALE" check t.obj --json >check.json
python3 - <<'P'
import json
c = json.load(open("check.json"))
print(c["convertible"], c["genus"], c["boundary_loops"], len(c["components"]), c["repair"]["duplicate_faces"])
P
