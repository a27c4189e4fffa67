# What the tests share. Computing is done by plain C with one thread, so that many tests can run at once.
torus() { awk -v n="$1" -v m="$2" -f "$here/torus.awk"; }
convert() { "$PERCALE" convert --device host --threads 1 --quiet "$@"; }
# Prints a command's exit code where it is not 0, and goes on.
try() { "$@" || echo "exit code $?"; }
# The page of a run without what a second one takes another time or memory for.
page() { sed -E 's/class="(n )?time">[^<]*/class="time">/g' "$1/report.html"; }
# Are the results of two runs the same bytes? The report, which tells times, is left out.
same() {
    local file
    [ -f "$1/result.h5" ] || return 1
    for file in $(cd "$1" && find . -type f ! -name 'report.*' ! -name parts.h5 | sort); do
        cmp "$1/$file" "$2/$file" || return 1
    done
    cmp <(page "$1") <(page "$2") || return 1
    diff <(cd "$1" && find . -type f ! -name parts.h5 | sort) <(cd "$2" && find . -type f ! -name parts.h5 | sort)
}
