# report.html: one page that is whole by itself, whatever the scan is called and however the conversion ends.
. "$here/lib.sh"
torus 24 10 >"$(printf 'a<b>&"c\047 \344\001.obj')"
torus 24 10 >t.obj
cat >look.py <<'P'
import base64, re, struct, sys, zlib
import xml.etree.ElementTree as tree
from html.parser import HTMLParser

text = open(sys.argv[1], encoding="utf-8").read()
body = tree.fromstring(text.split("\n", 1)[1])  # well-formed, the first line apart, which XML knows not
print("title:", ascii(body.find("head/title").text), "| heading:", ascii(next(body.iter("h1")).text))

class Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.open, self.outside, self.pictures = [], [], []

    def handle_starttag(self, tag, attributes):
        if tag in ("script", "link", "iframe", "object"):
            self.outside.append(tag)
        for name, value in attributes:
            if name in ("src", "href", "srcset", "data", "action") and not value.startswith("data:image/png;base64,"):
                self.outside.append(value)
            if name == "src":
                self.pictures.append((dict(attributes), base64.b64decode(value.split(",", 1)[1], validate=True)))

page = Page()
page.feed(text)
print("from outside:", page.outside, re.findall(r"https?:|url\(|@import", text))

def size(png):  # decoded, row by row
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    at, data = 8, b""
    while at < len(png):
        length, kind = struct.unpack(">I4s", png[at:at + 8])
        part = png[at + 8:at + 8 + length]
        assert zlib.crc32(kind + part) == struct.unpack(">I", png[at + 8 + length:at + 12 + length])[0]
        if kind == b"IHDR":
            width, height = struct.unpack(">II", part[:8])
        data += part if kind == b"IDAT" else b""
        at += 12 + length
    assert len(zlib.decompress(data)) == height * (3 * width + 1)
    return width, height

for attributes, png in page.pictures:
    assert size(png) == (int(attributes["width"]), int(attributes["height"]))
print("pictures:", *[a["alt"] for a, png in page.pictures])
print("size:", "fine" if len(text) < 4e6 else len(text))
print("verdict:", next(e for e in body.iter("strong")).text)
print("sections:", [e.text for e in body.iter("h2")])
print("drawings:", sum(1 for e in body.iter("svg")))
P
convert a*.obj -o strange --quads 200
python3 look.py strange/report.html
convert t.obj -o early --to field --no-pictures
python3 look.py early/report.html
# With a spline; and one that cannot be as near as it was asked to be: the page tells what to do.
convert t.obj -o spline --tolerance 1%
python3 look.py spline/report.html
"$PERCALE" convert t.obj -o threads --tolerance 1% --device host --threads 2 --quiet
same spline threads && echo "threads: same"
try convert t.obj -o poor --tolerance 0.001% --max-control-points 300 --no-pictures 2>/dev/null
python3 look.py poor/report.html
grep -c 'failed.*spline tolerance.*found.*expected.*--max-control-points' poor/report.html
for what in surface zebra error; do
    "$PERCALE" render spline -o $what.png --what $what --size 320x240
    python3 -c 'import struct, sys; print(struct.unpack(">II", open(sys.argv[1], "rb").read()[16:24]))' $what.png
done
try "$PERCALE" render early -o none.png --what zebra
