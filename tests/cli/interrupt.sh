# Ctrl-C: exit code 75, nothing half-written, a word on how to go on.
. "$here/lib.sh"
torus 60 30 >t.obj
"$PERCALE" convert t.obj -o out --device host --threads 1 --quads 2k 2>log &
pid=$!
while kill -0 $pid 2>/dev/null && [ ! -e out/stages/curvature.h5 ]; do sleep 0.01; done
kill -TERM $pid
wait $pid
echo "exit code $?"
tail -n 2 log
ls out
ls out/stages | grep -v 'h5$'
# Another option asks for another result: the stages that depend on it are made again.
convert t.obj -o out --resume --to curvature --no-pictures
convert t.obj -o out --resume --to curvature --no-pictures --json | python3 -c '
import json, sys
print([s["state"] for s in json.load(sys.stdin)["stages"]])'
"$PERCALE" convert t.obj -o out --device host --resume --to curvature --no-pictures --edge-factor 3 --json 2>log2 |
    python3 -c 'import json, sys
print([s["state"] for s in json.load(sys.stdin)["stages"]])'
cut -d " " -f 1,2 log2
# A damaged file is not taken.
printf 'x' | dd of=out/stages/mesh.h5 bs=1 seek=5000 conv=notrunc 2>/dev/null
"$PERCALE" convert t.obj -o out --device host --resume --to curvature --no-pictures --edge-factor 3 2>&1 |
    grep -c 'made again'
