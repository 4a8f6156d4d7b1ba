"""The package: all that the compiled module has is exported, has a stub, and says that it is of `lockstep`."""
import ast
import pathlib
import subprocess
import sys
import unittest

import lockstep
from lockstep import _lockstep

PUBLIC = sorted(name for name in vars(_lockstep) if not name.startswith("_"))
FOLDER = pathlib.Path(lockstep.__file__).parent


def members(kind):
    return {name for name in vars(kind) if not name.startswith("_")}


class Package(unittest.TestCase):
    def test_all_of_the_module_is_exported(self):
        self.assertEqual(PUBLIC, sorted(lockstep.__all__))

    def test_classes_are_of_the_package(self):
        for name in PUBLIC:
            if isinstance(getattr(lockstep, name), type):
                self.assertEqual(getattr(lockstep, name).__module__, "lockstep", name)

    def test_the_stub_has_what_the_module_has(self):
        self.assertTrue((FOLDER / "py.typed").is_file())
        tree = ast.parse((FOLDER / "_lockstep.pyi").read_text())
        classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
        functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
        self.assertEqual(set(PUBLIC), set(classes) | functions)
        for name, node in classes.items():
            if name == "Error":
                continue
            stubs = {item.name for item in node.body if isinstance(item, ast.FunctionDef)}
            stubs = {stub for stub in stubs if not stub.startswith("_")}
            self.assertEqual(members(getattr(lockstep, name)), stubs, name)

    def test_the_module_is_the_program(self):
        listed = subprocess.run([sys.executable, "-m", "lockstep", "scenes"], check=True, capture_output=True, text=True)
        for name in lockstep.scenes():
            self.assertIn(name, listed.stdout)
        version = subprocess.run([sys.executable, "-m", "lockstep", "--version"], capture_output=True, text=True)
        self.assertIn(lockstep.__version__, version.stdout)
        wrong = subprocess.run([sys.executable, "-m", "lockstep", "run", "no_such_scene"], capture_output=True)
        self.assertEqual(wrong.returncode, 2)


if __name__ == "__main__":
    unittest.main()
