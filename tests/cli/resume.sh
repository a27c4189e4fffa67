# Interrupted after each stage, and killed while each is under way: resuming gives the bytes of an undisturbed run.
. "$here/lib.sh"
torus 20 8 >t.obj
options="t.obj --edge-length 1.5 --curl-correction --parts 3 --no-pictures"
convert $options -o whole
for stage in scan mesh parts curvature field curl param layout quads; do
    PERCALE_STOP_AFTER=$stage convert $options -o $stage
    [ $? -eq 75 ] || echo "$stage: not interrupted"
    [ -e $stage/result.h5 ] && echo "$stage: has a result"
    convert $options -o $stage --resume || echo "$stage: resume failed"
    same whole $stage && cmp whole/stages/parts.h5 $stage/stages/parts.h5 && echo "$stage: same after an interrupt"
done
# One folder is killed again and again, each time as soon as the next stage has begun.
for stage in scan mesh parts curvature field curl param layout quads; do
    convert $options -o killed --resume &
    pid=$!
    while kill -0 $pid 2>/dev/null && [ ! -e killed/stages/$stage.h5 ] && [ ! -e killed/stages/$stage.h5.partial ]; do
        sleep 0.002
    done
    kill -KILL $pid 2>/dev/null
    wait $pid 2>/dev/null
done
convert $options -o killed --resume || echo "resume failed"
same whole killed && echo "same after being killed"
