"""host/scene/mjcf_schema.def has every element and attribute of MuJoCo's schema; skipped where mujoco is not installed."""
import pathlib
import re
import unittest

try:
    import mujoco
except ImportError:
    mujoco = None

TABLE = pathlib.Path(__file__).parents[2] / "host" / "scene" / "mjcf_schema.def"
ACTUATORS = "general motor position velocity intvelocity damper cylinder muscle adhesion dcmotor pid orientation"


def table():
    """(parent, element): attributes; "*" where all is said at once."""
    words = {}
    for parent, element, attributes in re.findall(r'MJCF\("(\w*)", "(\w+)", \w+,\s*((?:"[^"]*"\s*)+),', TABLE.read_text()):
        words.setdefault((parent, element), set()).update(re.sub(r'"\s*"|"', "", attributes).split())
    return words


def schema():
    """(parent, element, attributes) of each element that MuJoCo prints."""
    stack, rows = [], []
    for line in mujoco.mj_printSchema(False, False).splitlines():
        found = re.match(r"( *)(\S+) \((.)\)\s*(.*)", line)
        if found:
            depth, name = len(found[1]) // 3, found[2].replace("(world)body", "body")
            stack[depth:] = [name]
            rows.append([stack[depth - 1] if depth else "", name, found[4].split(), list(stack)])
        elif line.strip():
            rows[-1][2] += line.split()
    return rows


@unittest.skipUnless(mujoco, "the package mujoco is not installed")
class MjcfSchema(unittest.TestCase):
    def test_each_word_has_a_row(self):
        words, missing = table(), []
        for parent, element, attributes, path in schema():
            if parent == "material" or any(words.get((a, b)) == {"*"} for a, b in zip(path, path[1:])):
                continue
            if element == "body":  # a <worldbody>, and the bodies in it
                parent = "body"
            if parent == "default":
                parent = {"mesh": "asset", "material": "asset", "texture": "asset", "pair": "contact", "tendon": "tendon",
                          "equality": "equality", "default": "default"}.get(element, "body")
                if element in ACTUATORS:
                    parent = "actuator"
                if element == "tendon":
                    element = "fixed"
            known = words.get((parent, element), set())
            if known == {"*"}:
                continue
            if (parent, element) not in words:
                missing.append(f"{parent} {element}")
            missing += [f"{parent} {element} {a}" for a in attributes if a not in known]
        self.assertEqual(missing, [])


if __name__ == "__main__":
    unittest.main()
