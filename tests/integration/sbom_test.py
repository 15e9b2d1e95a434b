"""tests/sbom.py on the program: the document keeps the rules of SPDX 2.3 and holds what the program links."""

import json
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ["CEILMAP_EXE"]
SMALL = "/usr/bin/dpkg"  # few libraries: fast

RELATIONS = {"DESCRIBES", "CONTAINS", "STATIC_LINK", "DYNAMIC_LINK", "GENERATED_FROM"}
DOCUMENT_FIELDS = {
    "spdxVersion", "dataLicense", "SPDXID", "name", "documentNamespace", "creationInfo", "packages", "relationships"}
PACKAGE_FIELDS = {"SPDXID", "name", "downloadLocation"}
OPTIONAL_FIELDS = {
    "versionInfo", "supplier", "filesAnalyzed", "sourceInfo", "primaryPackagePurpose", "licenseConcluded", "licenseDeclared",
    "licenseComments", "copyrightText", "externalRefs", "comment"}
LICENCE = r"(?!GPL-\d$)[A-Za-z0-9][A-Za-z0-9.-]*"
EXPRESSION = re.compile(rf"NOASSERTION|{LICENCE}((?: AND {LICENCE})+|(?: OR {LICENCE})+)?")


def sbom(*arguments, path=None, epoch="1700000000"):
    environment = {**os.environ, "SOURCE_DATE_EPOCH": epoch}
    if path:
        environment["PATH"] = f"{path}:{environment['PATH']}"
    return subprocess.run([ROOT / "tests/sbom.py", *arguments], capture_output=True, text=True, check=False, env=environment)


def packages_of_needed(file):
    """The Debian packages of the libraries that the file itself names."""
    listed = subprocess.run(["objdump", "-p", file], capture_output=True, text=True, check=True).stdout
    needed = [line.split()[1] for line in listed.splitlines() if line.split()[:1] == ["NEEDED"]]
    resolved = dict(re.findall(r"(\S+) => (/\S+)", subprocess.run(["ldd", file], capture_output=True, text=True, check=True).stdout))
    paths = [os.path.realpath(resolved[name]) for name in needed if name in resolved]
    owned = subprocess.run(["dpkg", "-S", *paths, *[path.removeprefix("/usr") for path in paths]],
                           capture_output=True, text=True, check=False).stdout
    return {line.split(":")[0] for line in owned.splitlines()}


class Program(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        run = sbom(PROGRAM)
        assert run.returncode == 0, run.stderr
        cls.document = json.loads(run.stdout)
        cls.packages = {package["SPDXID"]: package for package in cls.document["packages"]}

    def linked(self, *kinds):
        return {self.packages[link["relatedSpdxElement"]]["name"] for link in self.document["relationships"]
                if link["spdxElementId"] == "SPDXRef-Package-ceilmap" and link["relationshipType"] in kinds}

    def test_keeps_the_rules_of_the_document(self):
        document = self.document
        self.assertEqual(set(document), DOCUMENT_FIELDS)
        self.assertEqual(document["spdxVersion"], "SPDX-2.3")
        self.assertEqual(document["dataLicense"], "CC0-1.0")
        self.assertEqual(document["SPDXID"], "SPDXRef-DOCUMENT")
        self.assertRegex(document["documentNamespace"], r"^https://[a-z0-9./-]+$")  # an absolute address without '#'
        self.assertEqual(document["creationInfo"]["created"], "2023-11-14T22:13:20Z")
        for creator in document["creationInfo"]["creators"]:
            self.assertRegex(creator, r"^(Tool|Organization|Person): \S")

    def test_keeps_the_rules_of_packages(self):
        self.assertEqual(len(self.packages), len(self.document["packages"]), "an SPDXID twice")
        for package in self.document["packages"]:
            name = package["name"]
            self.assertLessEqual(PACKAGE_FIELDS, set(package), name)
            self.assertLessEqual(set(package), PACKAGE_FIELDS | OPTIONAL_FIELDS, name)
            self.assertRegex(package["SPDXID"], r"^SPDXRef-[A-Za-z0-9.-]+$")
            self.assertFalse(package["filesAnalyzed"], name)
            for field in ("licenseConcluded", "licenseDeclared"):
                self.assertRegex(package[field], rf"^(?:{EXPRESSION.pattern})$", name)
            for reference in package.get("externalRefs", []):
                self.assertEqual(set(reference), {"referenceCategory", "referenceType", "referenceLocator"}, name)
                self.assertNotRegex(reference["referenceLocator"], r"\s", name)
                if reference["referenceType"] == "purl":
                    self.assertRegex(reference["referenceLocator"], r"^pkg:deb/debian/[a-z0-9.%B-]+@\S+\?arch=\w+&distro=\S+$")

    def test_keeps_the_rules_of_relationships(self):
        known = set(self.packages) | {"SPDXRef-DOCUMENT"}
        reached = {"SPDXRef-DOCUMENT"}
        links = [(link["spdxElementId"], link["relationshipType"], link["relatedSpdxElement"])
                 for link in self.document["relationships"]]
        self.assertEqual(len(links), len(set(links)), "a relationship twice")
        for one, kind, other in links:
            self.assertLessEqual({one, other}, known)
            self.assertIn(kind, RELATIONS)
        for _ in links:  # as long as more are reached
            more = {other for one, _, other in links if one in reached} - reached
            if not more:
                break
            reached |= more
        self.assertEqual(known - reached, set(), "not linked with the program")

    def test_holds_what_the_program_links(self):
        needed = packages_of_needed(PROGRAM)
        self.assertGreater(len(needed), 10)
        self.assertEqual(self.linked("DYNAMIC_LINK"), needed)

    def test_holds_what_is_compiled_in(self):
        self.assertLessEqual({"libeigen3-dev", "libceres-dev"}, self.linked("STATIC_LINK"))
        self.assertEqual({"libjs-leaflet", "libjs-dygraphs"}, self.linked("CONTAINS"))
        self.assertNotIn("pybind11-dev", self.linked("STATIC_LINK"))  # the Python module's
        installed = (ROOT / "samples/install-deps.sh").read_text().split()
        for name in self.linked("STATIC_LINK", "CONTAINS"):
            self.assertIn(name, installed)

    def test_states_the_installed_versions(self):
        shown = subprocess.run(["dpkg-query", "-W", "-f", "${Package} ${Version} ${source:Package}\n"],
                               capture_output=True, text=True, check=True).stdout
        installed = {line.split()[0]: line.split()[1:] for line in shown.splitlines()}
        sources = {link["spdxElementId"]: self.packages[link["relatedSpdxElement"]]["name"]
                   for link in self.document["relationships"] if link["relationshipType"] == "GENERATED_FROM"}
        self.assertGreater(len(sources), 100)
        for key, source in sources.items():
            package = self.packages[key]
            self.assertEqual([package["versionInfo"], source], installed[package["name"]], package["name"])

    def test_translates_licences(self):
        by_name = {package["name"]: package for package in self.packages.values() if "sourceInfo" in package}
        self.assertEqual(by_name["libfmt9"]["licenseDeclared"], "NOASSERTION")  # with an exception of its own
        self.assertEqual(by_name["libcpp-httplib0.11"]["licenseDeclared"], "MIT")
        self.assertEqual(by_name["libspqr2"]["licenseDeclared"], "GPL-2.0-or-later")
        self.assertIn("Debian: ", by_name["libc6"]["licenseComments"])


class Script(unittest.TestCase):
    def test_is_the_same_each_time(self):
        first = sbom(SMALL).stdout
        self.assertEqual(first, sbom(SMALL).stdout)
        later = sbom(SMALL, epoch="1800000000").stdout
        self.assertEqual(first.replace("2023-11-14T22:13:20Z", "2027-01-15T08:00:00Z"), later)

    def debsecan(self, folder, text):
        program = Path(folder) / "debsecan"
        program.write_text("#!/bin/sh\n" + text)
        program.chmod(0o755)

    def test_lists_advisories_of_its_packages_only(self):
        with tempfile.TemporaryDirectory() as folder:
            self.debsecan(folder, "echo 'CVE-2099-1 libc6 (fixed, high urgency)'; echo 'CVE-2099-2 nethack-common'")
            run = sbom("--advisories", SMALL, path=folder)
        self.assertEqual(run.returncode, 1)
        self.assertEqual(run.stderr, "")
        self.assertRegex(run.stdout, r"(?m)^CVE-2099-1\tlibc6\t\S+\tglibc\tfixed, high urgency$")
        self.assertNotIn("CVE-2099-2", run.stdout)
        self.assertRegex(run.stdout, r"packages; advisories: 1; ")

    def test_says_so_when_nothing_is_known(self):
        with tempfile.TemporaryDirectory() as folder:
            self.debsecan(folder, "echo 'error: no network' >&2; exit 1")
            run = sbom("--advisories", SMALL, path=folder)
        self.assertEqual(run.stderr, "sbom.py: advisories are not known: the security tracker cannot be asked (error: no network); "
                                     "below only newer versions in apt's lists\n")
        self.assertIn("packages; advisories: not known; ", run.stdout)

    def test_refuses_what_is_no_file(self):
        run = sbom("/nowhere/ceilmap")
        self.assertEqual(run.returncode, 2)
        self.assertIn("/nowhere/ceilmap: is not a file; build it first", run.stderr)


if __name__ == "__main__":
    unittest.main()
