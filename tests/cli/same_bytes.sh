# The same bytes for any number of threads and parts.
. "$here/lib.sh"
torus 24 10 >t.obj
options="t.obj --device host --edge-length 1 --quiet"
"$PERCALE" convert $options -o one --threads 1
"$PERCALE" convert $options -o two --threads 2
"$PERCALE" convert $options -o many --threads 2 --parts 64
same one two && echo "threads: same"
same one many && echo "parts: same"
ls many/stages
