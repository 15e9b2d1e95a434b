#!/usr/bin/env python3
"""Software bill of materials of programs or libraries of ceilmap, as SPDX 2.3 (JSON), from what ldd and dpkg know.

    tests/sbom.py build/release/app/ceilmap > ceilmap.spdx.json
    tests/sbom.py --advisories build/release/app/ceilmap      a table: known advisories of the same packages

The document holds the Debian packages of all shared libraries, with versions, licences (tests/licences.sh), source packages and who
links whom, and the packages of which headers, archives or scripts became part of the program. It is the same for the same
packages: its date is SOURCE_DATE_EPOCH, otherwise that of the last commit, and its name contains a hash of its content.
The table is that of Debian's debsecan, which asks the security tracker. Without it, or without network, one line says so, and the
table has only what apt's lists on this machine know: packages with a newer version in Debian. Exit code 1: some is known.
"""

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from datetime import datetime, timezone
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TRACKER = "https://security-tracker.debian.org/tracker/source-package/"

# What becomes part of the program without a shared library. Each is a package of samples/install-deps.sh.
COMPILED_IN = {
    "libceres-dev": "static library",
    "libcli11-dev": "headers",
    "libeigen3-dev": "headers",
    "libhnswlib-dev": "headers",
    "libjs-dygraphs": "scripts in pages",
    "libjs-leaflet": "scripts in pages",
    "nlohmann-json3-dev": "headers",
    "pybind11-dev": "headers",
}

# Debian's names of licences that SPDX names otherwise; names are compared in lower case.
SPDX_OF = {
    "expat": "MIT",
    "bsd3": "BSD-3-Clause",
    "mpl-2": "MPL-2.0",
    "openldap-2.8": "OLDAP-2.8",
    "bsd-3-clause-clear": "BSD-3-Clause-Clear",
}
SPDX_OF.update((name.lower(), name) for name in (
    "Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "BSD-4-Clause", "curl", "FTL", "ISC", "MIT", "MPL-1.1", "MPL-2.0", "PostgreSQL",
    "Qhull", "TU-Berlin-2.0", "X11", "Zlib"))
for _family, _versions in {"GPL": "1 2 3", "LGPL": "2 2.1 3"}.items():
    for _version in _versions.split():
        _number = _version if "." in _version else _version + ".0"
        for _name in {_version, _number}:
            SPDX_OF[f"{_family}-{_name}".lower()] = f"{_family}-{_number}-only"
            SPDX_OF[f"{_family}-{_name}+".lower()] = f"{_family}-{_number}-or-later"


def spdx_licence(debian: str) -> str:
    """The expression, or NOASSERTION where Debian's words are not one for certain."""
    words = re.split(r"\s+(and|or)\s+", debian, flags=re.IGNORECASE)
    joints = {word.upper() for word in words[1::2]}
    names = [SPDX_OF.get(word.lower()) for word in words[0::2]]
    if None in names or len(joints) > 1:
        return "NOASSERTION"
    return f" {''.join(joints)} ".join(names)


def run(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def linked_packages(files: list) -> dict:
    """Package: whether a file links it directly, its licence in Debian's words, and the packages that link it."""
    # It ends with 1 where something is under the GPL.
    listed = subprocess.run([str(ROOT / "tests/licences.sh"), "--users", *files], capture_output=True, text=True, check=False)
    if listed.returncode > 1 or not listed.stdout:
        sys.exit(f"sbom.py: {listed.stderr.strip() or 'nothing is linked'}")
    packages = {}
    for line in listed.stdout.splitlines():
        name, how, licence, users = line.split("\t")
        packages[name] = {"direct": how == "direct", "licence": licence.strip(), "users": users.split()}
    return packages


def copyright_licence(package: str) -> str:
    """The licence of "Files: *" of a package without libraries."""
    file = Path("/usr/share/doc") / package / "copyright"
    found = re.search(r"^Files: \*$.*?^License: *(\S.*?)$", file.read_text(errors="replace"), re.M | re.S) if file.exists() else None
    return found.group(1).strip() if found else f"see {file}"


def add_compiled_in(packages: dict, files: list) -> None:
    for name, how in COMPILED_IN.items():
        if name == "pybind11-dev" and not any(file.endswith(".so") for file in files):
            continue
        packages[name] = {"direct": True, "licence": copyright_licence(name), "users": [], "compiled_in": how}


def add_versions(packages: dict) -> None:
    """Version, architecture, source and its version. A package that is not installed here is left out."""
    shown = subprocess.run(
        ["dpkg-query", "-W", "-f", "${Package}\t${Version}\t${Architecture}\t${source:Package}\t${source:Version}\n", *packages],
        capture_output=True, text=True, check=False).stdout
    for line in shown.splitlines():
        name, *values = line.split("\t")
        packages[name].update(zip(("version", "architecture", "source", "source_version"), values))
    for name in [name for name, package in packages.items() if not package.get("version")]:
        del packages[name]


def identifier(kind: str, name: str) -> str:
    return f"SPDXRef-{kind}-" + re.sub(r"[^A-Za-z0-9.-]", "-", name.replace("+", "plus"))


def debian_package(name: str, package: dict, release: str) -> dict:
    licence = spdx_licence(package["licence"])
    element = {
        "SPDXID": identifier("Package", name),
        "name": name,
        "versionInfo": package["version"],
        "supplier": "Organization: Debian",
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "sourceInfo": f"built from Debian's source package {package['source']} {package['source_version']}",
        "licenseConcluded": "NOASSERTION",
        "licenseDeclared": licence,
        "licenseComments": f"Debian: {package['licence']}",
        "copyrightText": "NOASSERTION",
        "externalRefs": [
            {
                "referenceCategory": "PACKAGE-MANAGER",
                "referenceType": "purl",
                "referenceLocator": f"pkg:deb/debian/{name.replace('+', '%2B')}@{package['version'].replace('+', '%2B')}"
                                    f"?arch={package['architecture']}&distro={release}",
            },
            {"referenceCategory": "SECURITY", "referenceType": "advisory", "referenceLocator": TRACKER + package["source"]},
        ],
    }
    if "compiled_in" in package:
        element["comment"] = f"{package['compiled_in']}, part of the program"
    return element


def source_package(name: str, version: str) -> dict:
    return {
        "SPDXID": identifier("Source", name),
        "name": name,
        "versionInfo": version,
        "supplier": "Organization: Debian",
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "primaryPackagePurpose": "SOURCE",
        "licenseConcluded": "NOASSERTION",
        "licenseDeclared": "NOASSERTION",
        "copyrightText": "NOASSERTION",
    }


def relation(one: str, kind: str, other: str) -> dict:
    return {"spdxElementId": one, "relationshipType": kind, "relatedSpdxElement": other}


def relations(packages: dict, own: str) -> list:
    found = [relation("SPDXRef-DOCUMENT", "DESCRIBES", own)]
    for name, package in sorted(packages.items()):
        this = identifier("Package", name)
        if package["direct"]:
            scripts = package.get("compiled_in") == "scripts in pages"
            kind = "CONTAINS" if scripts else "STATIC_LINK" if "compiled_in" in package else "DYNAMIC_LINK"
            found.append(relation(own, kind, this))
        found += [relation(identifier("Package", user), "DYNAMIC_LINK", this) for user in sorted(package["users"])]
        found.append(relation(this, "GENERATED_FROM", identifier("Source", package["source"])))
    return found


def created() -> str:
    stamp = os.environ.get("SOURCE_DATE_EPOCH")
    if stamp is None:
        asked = subprocess.run(["git", "-C", str(ROOT), "log", "-1", "--format=%ct"], capture_output=True, text=True, check=False)
        stamp = asked.stdout.strip() or str(int(datetime.now().timestamp()))
    if not stamp.isdigit():
        sys.exit(f"sbom.py: SOURCE_DATE_EPOCH = '{stamp}', must be seconds since 1970")
    return datetime.fromtimestamp(int(stamp), timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


def os_release() -> dict:
    lines = Path("/etc/os-release").read_text().splitlines()
    return {key: value.strip('"') for key, value in (line.split("=", 1) for line in lines if "=" in line)}


def document(packages: dict, files: list) -> dict:
    version = re.search(r"project\(ceilmap\s+VERSION\s+([0-9.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
    own = {
        "SPDXID": identifier("Package", "ceilmap"),
        "name": "ceilmap",
        "versionInfo": version,
        "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False,
        "licenseConcluded": "Apache-2.0",
        "licenseDeclared": "Apache-2.0",
        "copyrightText": "NOASSERTION",
        "comment": "what is described: " + ", ".join(sorted(Path(file).name for file in files)),
    }
    release = f"{os_release().get('ID', 'debian')}-{os_release().get('VERSION_ID', '12')}"
    sources = {package["source"]: package["source_version"] for package in packages.values()}
    elements = [own]
    elements += [debian_package(name, package, release) for name, package in sorted(packages.items())]
    elements += [source_package(name, source_version) for name, source_version in sorted(sources.items())]
    links = relations(packages, own["SPDXID"])
    content = hashlib.sha256(json.dumps([elements, links], sort_keys=True).encode()).hexdigest()
    return {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"ceilmap-{version}",
        "documentNamespace": f"https://ceilmap.example/spdx/ceilmap-{version}-{content[:16]}",
        "creationInfo": {"created": created(), "creators": ["Tool: ceilmap-sbom.py"]},
        "packages": elements,
        "relationships": links,
    }


def tracked_advisories(packages: dict, suite: str):
    """Lines of debsecan about these packages; a text where it cannot be asked."""
    if shutil.which("debsecan") is None:
        return "debsecan is not installed (apt-get install debsecan)"
    try:
        asked = subprocess.run(["debsecan", "--suite", suite, "--format", "summary"],
                               capture_output=True, text=True, check=False, timeout=120)
    except subprocess.TimeoutExpired:
        return "the security tracker does not answer"
    if asked.returncode != 0:
        reason = (asked.stderr.strip().splitlines() or ["debsecan ends with an error"])[-1]
        return f"the security tracker cannot be asked ({reason})"
    # CVE-2024-1 libx1 (fixed, remotely exploitable, high urgency)
    lines = [line.split(maxsplit=2) for line in asked.stdout.splitlines()]
    return sorted(line for line in lines if len(line) >= 2 and line[1] in packages)


def pending_updates(packages: dict) -> list:
    """(package, version here, version in apt's lists) where the latter is newer."""
    found = []
    name = here = None
    for line in run("apt-cache", "policy", *sorted(packages)).splitlines():
        if line and not line.startswith(" "):
            name = line.rstrip(":").split(":")[0]
        key, _, value = line.strip().partition(": ")
        if key == "Installed":
            here = value
        elif key == "Candidate" and here not in (None, "(none)", value):
            found.append((name, here, value))
    return found


def print_advisories(packages: dict) -> int:
    found = tracked_advisories(packages, os_release().get("VERSION_CODENAME", "bookworm"))
    offline = isinstance(found, str)
    if offline:
        print(f"sbom.py: advisories are not known: {found}; below only newer versions in apt's lists", file=sys.stderr)
        found = []
    for line in found:
        source = packages[line[1]]["source"]
        print("\t".join([line[0], line[1], packages[line[1]]["version"], source, line[2].strip("()") if len(line) > 2 else ""]))
    updates = pending_updates(packages)
    for name, here, newer in updates:
        print("\t".join(["newer", name, here, packages[name]["source"], newer]))
    print(f"{len(packages)} packages; advisories: {'not known' if offline else len(found)}; with a newer version: {len(updates)}")
    return 1 if found or updates else 0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--advisories", action="store_true", help="a table of known advisories instead of the document")
    parser.add_argument("files", nargs="+", metavar="FILE", help="program or shared library")
    options = parser.parse_args()
    for file in options.files:
        if not Path(file).is_file():
            parser.error(f"{file}: is not a file; build it first")
    packages = linked_packages(options.files)
    add_compiled_in(packages, options.files)
    add_versions(packages)
    if options.advisories:
        return print_advisories(packages)
    json.dump(document(packages, options.files), sys.stdout, indent=1)
    print()
    return 0


if __name__ == "__main__":
    sys.exit(main())
