#!/usr/bin/env python3
"""Fails on an include that runs against rooms.txt, and on what the house rules forbid in a file.

Usage: check.py ROOT          checks the tree, prints one line for each finding, exit code 1 on any
       check.py --self-test   builds small trees with one fault each and expects it to be named

Checked: includes of core/, proto/, server/ and client/ against rooms.txt; CMake links of core rooms
(DEPENDS within the room's row); no file over 400 lines; no marks of unfinished work; no switched-off
test; `#pragma once` in headers; a README of at most 40 lines in each room.
"""
import pathlib
import re
import sys

LONGEST_FILE = 400
LONGEST_README = 40
CODE = {".h", ".cpp"}
TEXT = CODE | {".py", ".sh", ".proto", ".mjs", ".cmake"}
FOLDERS = ("core", "proto", "server", "client", "tests", "deploy")
SKIPPED = {"build", "data", "__pycache__", "node_modules"}
# Spelled in halves so that this file passes its own check.
UNFINISHED = re.compile("|".join([r"\bTO" r"DO\b", r"\bFIX" r"ME\b", r"\bXX" r"X\b", r"\bHA" r"CK\b",
                                  r"\b[Nn]ot imple" r"mented\b", r"\b(?i:place" r"holder)\b",
                                  # A word of gRPC in code, a mark of unfinished work in a comment.
                                  r"(//|#)[^\"']*\bst" r"ub\b"]))
SEVERAL_TIMES = re.compile(r"[Ii]ncluded (once )?by")  # a header that is meant to be, says so on top
SWITCHED_OFF = re.compile(r"\bDISAB" r"LED_\w|\bGTEST_SK" r"IP\(")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
DEPENDS = re.compile(r"lightbatch_room\(\s*(\w+)(.*?)\)", re.S)


class Row:
    def __init__(self, name, rooms, headers):
        self.name, self.rooms, self.headers = name, rooms, headers


def read_rooms(path):
    """rooms.txt: `name: rooms | header prefixes`, lowest room first, then folders, then `any`."""
    rows = {}
    for line in path.read_text().splitlines():
        line = line.split("#")[0].strip()
        if not line:
            continue
        name, rest = line.split(":", 1)
        rooms, _, headers = rest.partition("|")
        rows[name.strip()] = Row(name.strip(), rooms.split(), headers.split())
    return rows


def folder_of(name):
    """Where a row's files live: a name with a slash or known at top level is a path, others a room."""
    top = name.split("/")[0]
    return name if top in ("server", "client", "proto") else f"core/{name}"


def owner_of_file(path, rows):
    """The row of a file: the longest folder that holds it."""
    held = [n for n in rows if n != "any" and path.startswith(folder_of(n) + "/")]
    return max(held, key=lambda n: len(folder_of(n)), default=None)


def owner_of_include(target, rows):
    """The row an include leads to, or None for a header from outside the project."""
    if target.startswith("lightbatch/v1/"):
        return "proto"
    if target.startswith("lightbatch/"):
        return "client"
    if target.split("/")[0] in ("core", "server", "client", "proto"):
        return owner_of_file(target, rows) or target
    return None


def is_standard(target):
    return "/" not in target and "." not in target


def check_include(path, number, target, row, rows):
    owner = owner_of_include(target, rows)
    if owner is not None:
        if owner != row.name and owner not in row.rooms:
            yield f"{path}:{number}: {row.name} may not include {target} (rooms.txt)"
    elif not is_standard(target):
        allowed = row.headers + rows["any"].headers
        if not any(target.startswith(prefix) for prefix in allowed):
            yield f"{path}:{number}: {row.name} may not include third-party {target} (rooms.txt)"


def check_text(path, lines):
    if len(lines) > LONGEST_FILE:
        yield f"{path}: {len(lines)} lines; the most is {LONGEST_FILE}: split it by idea"
    for number, line in enumerate(lines, 1):
        if UNFINISHED.search(line):
            yield f"{path}:{number}: a mark of unfinished work: {line.strip()[:60]}"
        if SWITCHED_OFF.search(line):
            yield f"{path}:{number}: a test switched off: {line.strip()[:60]}"
    on_top = SEVERAL_TIMES.search(" ".join(lines[:3]))
    if path.endswith(".h") and "#pragma once" not in lines and not on_top:
        yield f"{path}: a header without #pragma once"


def check_rows(rows):
    """Rooms stand in the order of the data: a row may name only rows above it."""
    seen = []
    for row in rows.values():
        for room in row.rooms:
            if room not in seen:
                yield f"rooms.txt: {row.name} names {room}, which is not above it"
        seen.append(row.name)


def check_links(root, rows):
    for path in sorted(root.glob("core/*/CMakeLists.txt")):
        text = path.read_text()
        for name, rest in DEPENDS.findall(text):
            depends = re.search(r"DEPENDS((?:\s+\w+)*)", re.sub(r"\b(LIBRARIES|SOURCES)\b", ";", rest))
            linked = depends.group(1).split() if depends else []
            if name not in rows:
                yield f"{path.relative_to(root)}: room {name} is not in rooms.txt"
                continue
            for room in linked:
                if room not in rows[name].rooms:
                    yield f"{path.relative_to(root)}: {name} links {room}, not in its row of rooms.txt"


def check_readmes(root):
    for room in sorted(p for p in root.glob("core/*") if any(p.glob("*.h"))):
        readme = room / "README.md"
        if not readme.exists():
            yield f"{room.relative_to(root)}: a room without README.md"
        elif len(readme.read_text().splitlines()) > LONGEST_README:
            yield f"{readme.relative_to(root)}: more than {LONGEST_README} lines"


def files_of(root):
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            parts = path.relative_to(root).parts
            if path.is_file() and path.suffix in TEXT and not SKIPPED.intersection(parts):
                yield path


def check_tree(root, rooms):
    rows = read_rooms(rooms)
    findings = list(check_rows(rows))
    for path in files_of(root):
        name = str(path.relative_to(root))
        lines = path.read_text(errors="replace").splitlines()
        findings += check_text(name, lines)
        if path.suffix not in CODE or name.startswith("tests/"):
            continue
        owner = owner_of_file(name, rows)
        if owner is None:
            findings.append(f"{name}: its folder is not in rooms.txt")
            continue
        for number, line in enumerate(lines, 1):
            if match := INCLUDE.match(line):
                findings += check_include(name, number, match.group(2), rows[owner], rows)
    return findings + list(check_links(root, rows)) + list(check_readmes(root))


def main():
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    here = pathlib.Path(__file__).resolve().parent
    if sys.argv[1] == "--self-test":
        import self_test
        return self_test.run(check_tree)
    findings = check_tree(pathlib.Path(sys.argv[1]).resolve(), here / "rooms.txt")
    print("\n".join(findings) if findings else "layering: every include is allowed")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    sys.exit(main())
