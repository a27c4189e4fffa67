"""Every dataset of the given files has units and a description, and a row in docs/file-format.md.

Usage: check_documented.py FILE.h5... Exit status 77 where h5py is not installed.
"""
import os
import re
import sys

root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
sys.path.insert(0, os.path.join(root, "scripts"))
import percale_read  # noqa: E402  (exits with 77 where modules are missing)


def documented():
    """{"group/dataset": type} from the tables below the headings of groups."""
    found, group = {}, None
    with open(os.path.join(root, "docs", "file-format.md"), encoding="utf-8") as page:
        for line in page:
            if line.startswith("#"):
                heading = re.match(r"### `(\w+)`", line)
                group = heading and heading[1]
            elif group and line.startswith("| `"):
                names, kind = line.split("|")[1:3]
                found.update({f"{group}/{name}": kind.strip() for name in re.findall(r"`(\w+)`", names)})
    return found


def problems(path, known):
    with percale_read.open_file(path) as file:
        for name, item in percale_read.datasets(file).items():
            if name not in known:
                yield f"{path}: {name} is not documented"
            elif known[name] != str(item.dtype):
                yield f"{path}: {name} is {item.dtype}, documented as {known[name]}"
            for attribute in ("units", "description"):
                if not item.attrs.get(attribute):
                    yield f"{path}: {name} has no {attribute}"


wrong = [problem for path in sys.argv[1:] for problem in problems(path, documented())]
print("\n".join(wrong))
sys.exit(1 if wrong else 0)
