# The help of each command tells every option.
for command in convert check info render eval devices; do
    "$PERCALE" help $command
    [ "$("$PERCALE" help $command)" = "$("$PERCALE" $command --help)" ] || echo "differs from --help"
done
