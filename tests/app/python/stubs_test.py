"""Types, docstrings and the package's list of names agree."""
import ast
import inspect
import re
import unittest

import ceilmap
import support

STUB = support.SOURCE / "app" / "python" / "ceilmap" / "_ceilmap.pyi"
NO_ARGUMENTS = ("__repr__", "__bool__")


def argument_names(function):
    """Names of a stub's arguments, those with a default marked by '=', '*' where keywords begin."""
    a = function.args
    first_default = len(a.args) - len(a.defaults)
    names = [arg.arg + "=" * (i >= first_default) for i, arg in enumerate(a.args)]
    if a.kwonlyargs:
        names.append("*")
        names += [arg.arg + "=" * (d is not None) for arg, d in zip(a.kwonlyargs, a.kw_defaults)]
    return [name for name in names if name != "self"]


def documented_names(doc):
    """The same of the signature in the first line of a docstring."""
    signature = re.match(r"\w+\((.*)\) -> ", doc).group(1)
    names, depth, start = [], 0, 0
    for i, letter in enumerate(signature + ","):
        depth += (letter in "[(") - (letter in "])")
        if letter == "," and depth == 0:
            word = signature[start:i].strip()
            names.append(re.split("[:=]", word)[0].strip() + "=" * ("=" in word))
            start = i + 1
    return [name for name in names if name not in ("self", "")]


class Stubs(unittest.TestCase):
    def setUp(self):
        body = ast.parse(STUB.read_text()).body
        self.functions = {n.name: n for n in body if isinstance(n, ast.FunctionDef)}
        self.classes = {n.name: n for n in body if isinstance(n, ast.ClassDef)}

    def test_every_public_name_has_a_stub(self):
        variables = {"__version__"}
        self.assertEqual(
            sorted(ceilmap.__all__), sorted({*self.functions, *self.classes, *variables})
        )

    def test_functions(self):
        for name, stub in self.functions.items():
            doc = getattr(ceilmap, name).__doc__
            self.assertEqual(argument_names(stub), documented_names(doc), name)
            self.assertGreater(len(doc.splitlines()), 2, name)

    def test_members(self):
        for name, stub in self.classes.items():
            cls = getattr(ceilmap, name)
            members = {n.name: n for n in stub.body if isinstance(n, ast.FunctionDef)}
            self.assertTrue(inspect.getdoc(cls), name)
            self.assertEqual([b.id for b in stub.bases] or ["pybind11_object"],
                             [b.__name__ for b in cls.__bases__], name)
            real = {m for m in vars(cls) if not m.startswith("_")}
            self.assertEqual(real, {m for m in members if not m.startswith("_")}, name)
            for member, function in members.items():
                with self.subTest(member=f"{name}.{member}"):
                    self.check_member(vars(cls)[member], member, function)

    def check_member(self, value, name, function):
        decorators = [d.id for d in function.decorator_list]
        doc = value.__func__.__doc__ if isinstance(value, staticmethod) else value.__doc__
        self.assertTrue(doc)
        self.assertEqual("property" in decorators, isinstance(value, property))
        self.assertEqual("staticmethod" in decorators, isinstance(value, staticmethod))
        if not isinstance(value, property):
            self.assertEqual(argument_names(function), documented_names(doc))
            if name not in NO_ARGUMENTS:
                self.assertGreater(len(doc.splitlines()), 2, "only a signature")


if __name__ == "__main__":
    unittest.main()
