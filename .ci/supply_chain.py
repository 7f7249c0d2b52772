#!/usr/bin/env python3
"""Packages that the project stands on: where from, under which licence, in how many versions, and whether somebody keeps them.

    .ci/supply_chain.py [--list]

Reads Cargo.lock through `cargo metadata`, and asks no server. With --list it prints every package with its licence.
"""

import json
import pathlib
import re
import subprocess
import sys
from collections import defaultdict

ROOT = pathlib.Path(__file__).resolve().parent.parent
SOURCE = "registry+https://github.com/rust-lang/crates.io-index"
LICENCES = {
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "ISC",
    "MIT",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
}
# In more versions than one, and who holds the older one. What is no longer so has to leave this list.
SEVERAL = {
    "embedded-io": "postcard (tests)",
    "equator": "nano-gemm",
    "equator-macro": "nano-gemm",
    "foldhash": "hashbrown 0.15 of petgraph",
    "glam": "nalgebra, which converts from all of them; none is compiled",
    "hashbrown": "petgraph",
    "miniz_oxide": "png",
    "syn": "macros",
    "thiserror": "sysctl, of gemm on macOS",
    "thiserror-impl": "sysctl, of gemm on macOS",
}
# Crates that the RustSec advisory database calls unmaintained or unsound, as of November 2026, by memory of those that are met most
# often. `cargo audit` knows all of them, and asks the network.
UNKEPT = set(
    """adler ansi_term atomic-polyfill atty backoff bincode buf_redux custom_derive daemonize derivative difference encoding
    failure fxhash gcc instant json mach memmap net2 number_prefix packed_simd packed_simd_2 paste proc-macro-error
    proc-macro-error2 rental rust-crypto rustc-serialize safemem serde_cbor serde_yaml sodiumoxide stb_truetype stdweb
    tempdir term_size traitobject tui twoway users wee_alloc yaml-rust""".split()
)
# Of these, met here all the same, and why.
UNKEPT_BUT_KEPT = {
    "paste": "a macro that gemm calls while it is compiled; finished rather than left",
}


def is_allowed(expression: str) -> bool:
    """Whether one alternative of an SPDX expression is allowed in all its parts."""
    text = re.sub(r"\s*/\s*", " OR ", expression).replace("(", " ( ").replace(")", " ) ")
    tokens = re.findall(r"\(|\)|AND\b|OR\b|[A-Za-z0-9.+-]+(?: WITH [A-Za-z0-9.-]+)?", text)
    spelt = [{"AND": "and", "OR": "or", "(": "(", ")": ")"}.get(token, str(token in LICENCES)) for token in tokens]
    return bool(spelt) and bool(eval(" ".join(spelt)))  # nothing but True, False, and, or and brackets


def main() -> int:
    command = ["cargo", "metadata", "--locked", "--format-version", "1"]
    told = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    packages = [package for package in json.loads(told)["packages"] if package["source"]]
    faults = []
    versions = defaultdict(set)
    for package in packages:
        name, version, licence = package["name"], package["version"], package["license"]
        versions[name].add(version)
        if "--list" in sys.argv:
            print(f"{name} {version}: {licence}")
        if package["source"] != SOURCE:
            faults.append(f"{name} {version} comes from {package['source']}, not from crates.io")
        if not licence or not is_allowed(licence):
            faults.append(f"{name} {version} has the licence {licence!r}; allowed are {', '.join(sorted(LICENCES))}")
        if name in UNKEPT and name not in UNKEPT_BUT_KEPT:
            faults.append(f"{name} {version} is no longer maintained; take another one, or say in .ci/supply_chain.py why not")
    several = {name for name, found in versions.items() if len(found) > 1}
    for name in sorted(several - set(SEVERAL)):
        faults.append(f"{name} is there in versions {', '.join(sorted(versions[name]))}: `cargo tree -d` says why")
    for name in sorted((set(SEVERAL) - several) | (set(UNKEPT_BUT_KEPT) - set(versions))):
        faults.append(f"{name} has no need any more to be excused in .ci/supply_chain.py")
    for fault in faults:
        print(fault, file=sys.stderr)
    print(f"{len(packages)} packages, {len(faults)} faults")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
