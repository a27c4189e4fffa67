# Interrupted after each stage, and killed while each is under way: resuming gives the bytes of an undisturbed run.
. "$here/lib.sh"
torus 24 10 >t.obj
options="t.obj --edge-length 1 --curl-correction --parts 3 --no-pictures"
stages="scan mesh parts curvature field curl param layout quads"
convert $options -o whole || echo "exit code $?"
for stage in $stages; do
    PERCALE_STOP_AFTER=$stage convert $options -o $stage 2>/dev/null
    [ $? -eq 75 ] || echo "$stage: not interrupted"
    [ -e $stage/stages/$stage.h5 ] || echo "$stage: not kept"
    [ -e $stage/result.h5 ] && echo "$stage: has a result"
    convert $options -o $stage --resume || echo "exit code $?"
    same whole $stage && cmp whole/stages/parts.h5 $stage/stages/parts.h5 && echo "$stage: same after an interrupt"
    rm -r $stage
done
# One folder is killed again and again, each time when the next stage has its file.
for stage in $stages; do
    "$PERCALE" convert --device host --threads 1 --quiet $options -o killed --resume &
    pid=$!
    while kill -0 $pid 2>/dev/null && [ ! -e killed/stages/$stage.h5 ] && [ ! -e killed/stages/$stage.h5.partial ]; do
        sleep 0.002
    done
    kill -KILL $pid
    wait $pid 2>/dev/null
done 2>/dev/null
convert $options -o killed --resume || echo "exit code $?"
same whole killed && echo "same after being killed"
# Two at once in one folder: the second is refused.
"$PERCALE" convert --device host --threads 1 --quiet $options -o both &
pid=$!
while kill -0 $pid 2>/dev/null && [ ! -e both/stages/scan.h5 ]; do sleep 0.002; done
try convert $options -o both --resume
wait $pid
same whole both && echo "same beside another"
