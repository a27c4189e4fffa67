# A T-spline by the command line: its files, a tighter one from the same quads, and an interrupted run.
. "$here/lib.sh"
torus 24 12 >t.obj
convert t.obj -o t --quads 200 --tolerance 1% --formats all --no-pictures
ls t
convert t.obj -o t --quads 200 --tolerance 0.5% --resume --no-pictures
grep -c '"passed": true' t/report.json
convert t.obj -o kept --quads 150 --ngons keep --tolerance 0.5% --no-pictures
grep -c '"passed": true' kept/report.json
try convert t.obj -o few --quads 200 --tolerance 0.1% --max-control-points 10 --no-pictures
ls few/surface.step
PERCALE_STOP_AFTER=spline try convert t.obj -o stopped --quads 200 --tolerance 1% --formats all --no-pictures
convert t.obj -o stopped --quads 200 --tolerance 1% --formats all --no-pictures --resume
convert t.obj -o whole --quads 200 --tolerance 1% --formats all --no-pictures
same stopped whole && echo the same bytes
