# A conversion with all its outputs, told as JSON and as a log.
. "$here/lib.sh"
torus 24 10 >t.obj
"$PERCALE" convert t.obj -o deep/out --quads 200 --device host --threads 1 --json >report.json 2>log
sed 's/ *[0-9.]* s *[0-9]* MB//' log | awk '{ print $1, $2 }'
cmp report.json deep/out/report.json
find deep -type f | sort
python3 - <<'P'
import json
r = json.load(open("report.json"))
faces = r["statistics"]["quads"]["faces"]
print("count met:", abs(faces / 200 - 1) <= 0.05)
print("certificate:", r["certificate"]["passed"], len(r["certificate"]["checks"]) >= 9)
print("stages:", [s["name"] for s in r["stages"]], all(s["seconds"] >= 0 for s in r["stages"]))
print("chi:", r["statistics"]["scan"]["euler_number"], r["statistics"]["quads"]["euler_number"])
P
"$PERCALE" info deep/out/result.h5 | grep -cE '^(scan|mesh|curvature|field|param|layout|quads)/'
"$PERCALE" info deep/out/stages/field.h5 --json | python3 -c 'import json, sys; print(json.load(sys.stdin)["stage"])'
# What is there is not overwritten, unless asked to.
try "$PERCALE" convert t.obj -o deep/out --quiet
try convert t.obj -o deep/out --force --to mesh --no-pictures
find deep -type f | sort
"$PERCALE" render deep/out -o scan.png --size 160x120
python3 -c 'import struct; print(struct.unpack(">II", open("scan.png", "rb").read()[16:24]))'
try "$PERCALE" render deep/out -o scan.png --size 160x120
try "$PERCALE" render deep/out -o field.png --what field
# Before there is more, the scan itself is drawn.
convert t.obj -o early --to scan --no-pictures
try "$PERCALE" render early -o early.png --size 160x120
