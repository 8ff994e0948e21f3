"""The scanner against tomllib, on texts written in every style TOML knows."""

from __future__ import annotations

import json
import tomllib

import pytest
import tomli_w
from hypothesis import given
from hypothesis import strategies as st

from gough.toml_lines import key_lines, too_deep

KEYS = st.text("abc_-19", min_size=1, max_size=3) | st.sampled_from(
    ["a.b", "é", 'q"u', "sp ace", "#", "=", "[x]", "\\"]
)
WORDS = st.sampled_from(
    ['x = "1"', "[a]", "# no", "a\nb = 2\n[c]\n", 'quo"te', "'", '"""', "'''", "]", "}", ",", "\\", ""]
)
LEAVES = WORDS | st.integers(-9, 9) | st.booleans() | st.floats(allow_nan=False)
VALUES = st.recursive(
    LEAVES, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3), max_leaves=12
)
TABLES = st.dictionaries(KEYS, VALUES, max_size=5)


def paths(value, prefix=()):
    """Every key path of data, arrays included, with the value there."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield prefix + (str(key),), inner
        yield from paths(inner, prefix + (str(key),))


class Writer:
    """Writes data as TOML with a style drawn anew at every choice, and notes the line where each key begins."""

    def __init__(self, draw):
        self.draw, self.text, self.noted = draw, "", {}

    def choose(self, *options):
        return self.draw(st.sampled_from(options))

    def here(self, path):
        self.noted.setdefault(".".join(path), self.text.count("\n") + 1)

    def key(self, key):
        bare = key.isascii() and key.replace("_", "a").replace("-", "a").isalnum()
        literal = [f"'{key}'"] if "'" not in key and "\n" not in key else []
        return self.choose(json.dumps(key), *literal, *([key] * 3 if bare else []))

    def string(self, text):
        options = [json.dumps(text), '"""' + text.replace("\\", "\\\\").replace('"', '\\"') + '"""']
        if '"""' not in text and not text.endswith('"') and "\\" not in text:
            options.append('"""\n' + text + '"""')
        if "'" not in text:
            options.append("'''\n" + text + "'''")
            options += [f"'{text}'"] if "\n" not in text else []
        return self.choose(*options)

    def blank(self):
        self.text += self.choose("", " ", "\n", " # [x] = {\n", "\n\n\t")

    def value(self, value, path):
        if isinstance(value, dict):
            self.text += "{ "
            for i, (key, inner) in enumerate(value.items()):
                self.text += ", " if i else ""
                self.pair(key, inner, path)
            self.text += " }"
        elif isinstance(value, list):
            self.text += "["
            for i, inner in enumerate(value):
                self.blank()
                self.here(path + (str(i),))
                self.value(inner, path + (str(i),))
                self.blank()
                self.text += "," if i < len(value) - 1 else self.choose("", ",")
            self.blank()
            self.text += "]"
        else:
            self.text += self.string(value) if isinstance(value, str) else tomli_w.dumps({"v": value})[4:].strip()

    def pair(self, key, value, path):
        self.here(path + (key,))
        self.text += self.key(key)
        path += (key,)
        while isinstance(value, dict) and len(value) == 1 and self.choose(True, False):  # dotted
            ((key, value),) = value.items()
            path += (key,)
            self.here(path)
            self.text += self.choose(".", " . ") + self.key(key)
        self.text += self.choose(" = ", "=")
        self.value(value, path)

    def table(self, table, path, header):
        below = []
        for key, value in table.items():
            tables = isinstance(value, list) and value and all(isinstance(v, dict) for v in value)
            if (isinstance(value, dict) or tables) and self.choose(True, False):
                below.append((key, value))
                continue
            self.pair(key, value, path)
            self.text += self.choose("\n", " # c = 1\n", "\n\n")
        for key, value in below:
            name = header + (self.key(key),)
            if isinstance(value, list):
                for i, inner in enumerate(value):
                    self.here(path + (key,))
                    self.here(path + (key, str(i)))
                    self.text += f"[[{'.'.join(name)}]]\n"
                    self.table(inner, path + (key, str(i)), name)
            else:
                self.here(path + (key,))
                self.text += f"[ {'.'.join(name)} ]\n"
                self.table(value, path + (key,), name)


@pytest.mark.full
@given(TABLES, st.data())
def test_every_path_that_tomllib_reads_has_the_line_where_it_was_written(table, data):
    writer = Writer(data.draw)
    writer.table(table, (), ())
    read = tomllib.loads(writer.text)
    assert read == table, "the writer of this test is wrong"
    found = key_lines(writer.text)
    for path, _ in paths(read):
        assert found[".".join(path)] == writer.noted[".".join(path)], (path, writer.text)


@given(TABLES)
def test_every_path_of_a_text_by_another_writer_is_found(table):
    text = tomli_w.dumps(table, multiline_strings=True)
    assert {".".join(path) for path, _ in paths(tomllib.loads(text))} <= set(key_lines(text))


def test_lines_of_a_text_with_every_construct():
    text = '''\
# comment = 1
name = "x"            # 2
"a.b" = 3
 c . 'd' = { e = [1,  # 4
  2], f = """
g = 1
"""}

[t.u]
v.w = 1               # 10
[[list]]
x = 1
[list.sub]            # 13
y = 2
[[list]]              # 15
[[list.deep]]
z = 3
[t]                   # 18
'''
    tomllib.loads(text)
    lines = key_lines(text)
    expected = {
        "name": 2,
        "a.b": 3,
        "c": 4,
        "c.d.e": 4,
        "c.d.e.0": 4,
        "c.d.e.1": 5,
        "c.d.f": 5,
        "t.u": 9,
        "t.u.v.w": 10,
    }
    expected |= {
        "list.0": 11,
        "list.0.x": 12,
        "list.0.sub.y": 14,
        "list.1": 15,
        "list.1.deep.0.z": 17,
        "list": 11,
        "t": 18,
    }
    assert {key: lines[key] for key in expected} == expected
    assert "g" not in lines


def test_depth_is_counted_over_brackets_and_dots_but_not_in_texts_or_comments():
    assert too_deep("a = [[[1]]]", 3) is None
    assert too_deep("a = [[[1]]]", 2) == 6
    assert too_deep("a.b.c = 1", 1) == 3
    assert too_deep('a = "[[[["  # [[[[', 1) is None
    assert too_deep("a = '''[[[[", 1) is None
