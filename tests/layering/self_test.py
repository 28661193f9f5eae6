"""Proves that check.py names each kind of fault: one small tree for each, with one fault in it."""
import pathlib
import tempfile

ROOMS = """base: | openssl
math: base |
scene: base math |
proto: | grpc
server: base proto | grpc
client: proto | grpc
client/cli: base client |
any: | unistd.h sys/
"""
SOUND = {
    "core/base/status.h": '#pragma once\n#include <string>\n#include <sys/stat.h>\n',
    "core/base/hash.cpp": '#include "core/base/status.h"\n#include <openssl/evp.h>\n',
    "core/base/README.md": "# base\n",
    "core/math/CMakeLists.txt": "lightbatch_room(math SOURCES a.cpp DEPENDS base LIBRARIES z)\n",
    "server/main.cpp": '#include "core/base/status.h"\n#include "lightbatch/v1/jobs.pb.h"\n',
    "client/src/client.cpp": '#include "lightbatch/client.h"\n#include <grpcpp/grpcpp.h>\n',
    "client/src/upload.cpp": "auto stub = v1::BlobService::NewStub(channel);\n",
    "core/math/loop.h": "// Included once by each kernel.\n",
    "core/math/README.md": "# math\n",
    "client/cli/main.cpp": '#include "core/base/status.h"\n#include "client/cli/bar.h"\n',
}
# (what is added or replaced, words that one finding must hold)
FAULTS = [
    ({"core/base/a.cpp": '#include "core/math/vec.h"\n'}, "base may not include core/math/vec.h"),
    ({"core/math/a.cpp": '#  include   "core/scene/scene.h"\n'}, "may not include core/scene"),
    ({"core/math/a.cpp": "#include <openssl/evp.h>\n"}, "third-party openssl/evp.h"),
    ({"core/math/a.cpp": '#include "png.h"\n'}, "third-party png.h"),
    ({"core/base/a.cpp": '#include "server/config.h"\n'}, "base may not include server/config.h"),
    ({"server/a.cpp": '#include "core/math/vec.h"\n'}, "server may not include core/math"),
    ({"client/src/a.cpp": '#include "core/base/status.h"\n'}, "client may not include core/base"),
    ({"core/new/a.cpp": "\n"}, "its folder is not in rooms.txt"),
    ({"core/math/CMakeLists.txt": "lightbatch_room(math\n  DEPENDS base scene)\n"}, "links scene"),
    ({"core/base/a.cpp": "int x;\n" * 401}, "401 lines"),
    ({"core/base/a.h": "int x;\n"}, "without #pragma once"),
    ({"core/base/a.cpp": "// TO" "DO: more\n"}, "unfinished"),
    ({"deploy/a.sh": "# FIX" "ME\n"}, "unfinished"),
    ({"tests/unit/a.cpp": "// a st" "ub of it\n"}, "unfinished"),
    ({"tests/unit/a.cpp": "TEST(A, DISAB" "LED_B) {}\n"}, "switched off"),
    ({"core/scene/scene.h": "#pragma once\n"}, "core/scene: a room without README.md"),
    ({"core/base/README.md": "line\n" * 41}, "more than 40 lines"),
]


def findings_for(check_tree, files, rooms=ROOMS):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in files.items():
            path = root / "tree" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        (root / "rooms.txt").write_text(rooms)
        return check_tree(root / "tree", root / "rooms.txt")


def run(check_tree):
    failures = []
    if found := findings_for(check_tree, SOUND):
        failures.append(f"a sound tree was refused: {found}")
    for fault, words in FAULTS:
        found = findings_for(check_tree, {**SOUND, **fault})
        if len(found) != 1 or words not in found[0]:
            failures.append(f"expected one finding with '{words}', got {found}")
    upside_down = ROOMS.replace("base: |", "base: math |")
    if not any("not above it" in f for f in findings_for(check_tree, SOUND, upside_down)):
        failures.append("a row that names a room below it was accepted")
    print("\n".join(failures) if failures else f"self-test: {len(FAULTS) + 2} trees judged rightly")
    return 1 if failures else 0
