# Command lines that make no sense: exit code 2, one clear line, nothing on standard output.
. "$here/lib.sh"
torus 6 4 >t.obj
mkdir full && touch full/mine.txt
for line in "" "convrt t.obj" "frobnicate" "convert" "convert t.obj --qads 20k -o out" "convert t.obj --zzz" \
    "convert t.obj more.obj" "convert t.obj -o" "convert t.obj --quads many" "convert t.obj --quads 0" \
    "convert t.obj --quads 1.5" "convert t.obj --edge-length -3" "convert t.obj --quads 9 --edge-factor 3" \
    "convert t.obj --smoothness 1.5" "convert t.obj --ngons some" "convert t.obj --to fild" \
    "convert t.obj --tolerance 0" "convert t.obj --tolerance 2mm" \
    "convert t.obj --formats step" "convert t.obj --tolerance 1% --formats iges,dxf" \
    "convert t.obj --quiet=yes" "convert t.obj -o full" "convert t.obj -o full --resume" "convert t.obj -o t.obj" \
    "render t.obj" "render t.obj -o x.png --size 9x9" "render t.obj -o x.png --view behind" \
    "render t.obj -o x.png --what quads" "help frobnicate" "info" "--device gpu convert"; do
    echo "percale $line" >&2
    # shellcheck disable=SC2086
    "$PERCALE" $line
    code=$?
    [ $code -eq 2 ] || echo "exit code $code"
done
ls full
