#!/usr/bin/env python3
"""Counts what makes the node layer hard to read: .ci/shape.py [commit]. Needs git and Python alone."""

import re
import subprocess
import sys

COMMIT = sys.argv[1] if len(sys.argv) > 1 else "HEAD"
# Of both crates: a commit may have a folder in one of them, or in both.
NODE, RUNNER, REDUNDANCY, BOOT = (
    (f"shared/src/{part}/", f"shared/canopen/src/{part}/") for part in ("node", "runner", "redundancy", "boot")
)


def git(*arguments):
    return subprocess.check_output(["git", *arguments], text=True)


def is_product(path):
    return path.endswith(".rs") and not path.endswith(("tests.rs", "flipped.rs", "probe.rs"))


def read(path):
    """The file without comments, attributes of documentation, and empty lines."""
    lines = (line.split(" //")[0].rstrip() for line in git("show", f"{COMMIT}:{path}").splitlines())
    return "\n".join(line for line in lines if line.strip() and not line.lstrip().startswith("//"))


PATHS = git("ls-tree", "-r", "--name-only", COMMIT, *NODE, *RUNNER, *REDUNDANCY, *BOOT).split()
SOURCES = {path: read(path) for path in PATHS if is_product(path)}


def text(folders):
    return "\n".join(code for path, code in SOURCES.items() if path.startswith(folders))


def functions(code):
    """Name, parameters and number of lines of each function; rustfmt has formatted them."""
    for found in re.finditer(r"^( *)(?:pub(?:\(\w+\))? )?(?:const )?fn (\w+)[^(]*\(", code, re.M):
        rest = code[found.end():]
        depth, end = 1, 0
        while depth:
            depth += {"(": 1, ")": -1}.get(rest[end], 0)
            end += 1
        if ";" in rest[end:].split("{")[0]:
            continue  # of a trait, without a body
        body = re.search(rf"^{found[1]}}}", rest[end:], re.M)
        plain = re.sub(r"\([^()]*\)|<[^<>]*>", "", rest[: end - 1])
        parameters = [part for part in plain.split(",") if part.strip()]
        yield found[2], parameters, rest[end:][: body.start() if body else 0].count("\n") + 1


node = text(NODE)
listed = list(functions(node))
longest = max(listed, key=lambda function: function[2])
rows = {
    "chains of four and more parts": len(re.findall(r"\b[a-z_]\w*(?:\.[a-z_]\w*){3,}", node)),
    "deadlines kept by hand": len(re.findall(r"(?<!guarded)\.next = |(?:self|services|canopen)\.wake\(", node)),
    "functions with `now` and `out`": sum(
        any("now: Instant" in one for one in parameters) and any("&mut Out" in one for one in parameters)
        for _, parameters, _ in listed
    ),
    "functions with more than six parameters": sum(len(parameters) > 6 for _, parameters, _ in listed),
    "public fields": len(re.findall(r"^\s+pub(?:\([^)]*\))? [a-z_]\w*:", node, re.M)),
    "impl blocks of Master": len(re.findall(r"^impl.*\bMaster<", node, re.M)),
    "sets of nodes in fields": len(re.findall(r"^\s+(?:pub )?\w+: .*(?:u128|NodeSet)", text(REDUNDANCY + BOOT), re.M)),
    "inline attributes": node.count("#[inline"),
    f"lines of the longest function ({longest[0]})": longest[2],
    "code lines of node": node.count("\n") + 1,
    "code lines of runner": text(RUNNER).count("\n") + 1,
}
for name, value in rows.items():
    print(f"{value:6}  {name}")
