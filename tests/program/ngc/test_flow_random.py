"""Random structured programs against a model of them in Python."""

import random

import pytest

from .test_flow import body


class Writer:
    """A random structured program, as NC text and as what it should do; x counts the steps of the model."""

    def __init__(self, seed):
        self.rng, self.label, self.lines = random.Random(seed), 0, []

    def block(self, depth, loop=None):
        """Write some lines; returns a function (state, out) -> "break", "continue" or None."""
        parts = [self.statement(depth, loop) for _ in range(self.rng.randint(1, 3))]

        def act(state, out):
            for part in parts:
                left = part(state, out)
                if left:
                    return left
            return None

        return act

    def statement(self, depth, loop):
        kinds = ["dwell", "add"] + (["if", "while", "repeat", "do"] if depth else []) + (["leave"] if loop else [])
        return getattr(self, "_" + self.rng.choice(kinds))(depth, loop)

    def new(self):
        self.label += 1
        return self.label

    def _dwell(self, depth, loop):
        k = self.rng.randint(1, 5)
        self.lines.append(f"G4 P[#{k}*10+{k}]")
        return lambda state, out: out.append(state[k] * 10 + k)

    def _add(self, depth, loop):
        k, j, n = self.rng.randint(1, 5), self.rng.randint(1, 5), self.rng.randint(-2, 3)
        self.lines.append(f"#{k}=[[#{j}+{n}] mod 7]")

        def act(state, out):
            state[k] = (state[j] + n) % 7

        return act

    def _if(self, depth, loop):
        label, k, n = self.new(), self.rng.randint(1, 5), self.rng.randint(0, 6)
        self.lines.append(f"o{label} if [#{k} lt {n}]")
        yes, no = self.block(depth - 1, loop), None
        if self.rng.random() < 0.5:
            self.lines.append(f"o{label} else")
            no = self.block(depth - 1, loop)
        self.lines.append(f"o{label} endif")
        return lambda state, out: yes(state, out) if state[k] < n else no(state, out) if no else None

    def _counted(self, depth, text, label):
        """A loop of at most n turns, by a counter of its own."""
        own, n = 100 + label, self.rng.randint(0, 4)
        self.lines += [f"#{own}=0", text.format(label=label, own=own, n=n), f"#{own}=[#{own}+1]"]
        return n, self.block(depth - 1, label)

    def _while(self, depth, loop):
        label = self.new()
        n, inner = self._counted(depth, "o{label} while [#{own} lt {n}]", label)
        self.lines.append(f"o{label} endwhile")

        def act(state, out):
            for _ in range(n):
                left = inner(state, out)
                if left and left[1] != label:
                    return left
                if left and left[0] == "break":
                    break
            return None

        return act

    def _do(self, depth, loop):
        label = self.new()
        n, inner = self._counted(depth, "o{label} do", label)
        self.lines.append(f"o{label} while [#{100 + label} lt {n}]")

        def act(state, out):
            for _ in range(max(n, 1)):
                left = inner(state, out)
                if left and left[1] != label:
                    return left
                if left and left[0] == "break":
                    break
            return None

        return act

    def _repeat(self, depth, loop):
        label, n = self.new(), self.rng.randint(0, 3)
        self.lines.append(f"o{label} repeat [{n}]")
        inner = self.block(depth - 1, loop)
        self.lines.append(f"o{label} endrepeat")

        def act(state, out):
            for _ in range(n):
                left = inner(state, out)
                if left:
                    return left
            return None

        return act

    def _leave(self, depth, loop):
        what, k = self.rng.choice(["break", "continue"]), self.rng.randint(1, 5)
        label = self.new()
        self.lines += [f"o{label} if [#{k} eq 3]", f"o{loop} {what}", f"o{label} endif"]
        return lambda state, out: (what, loop) if state[k] == 3 else None


@pytest.mark.parametrize("seed", range(200))
def test_a_random_structured_program_does_what_its_model_in_python_does(seed):
    writer = Writer(seed)
    model = writer.block(4)
    expected = []
    model([0.0] * 6, expected)
    assert body(*writer.lines, steps=10**7) == expected


def test_the_random_programs_use_every_kind_of_flow():
    lines = []
    for seed in range(200):
        writer = Writer(seed)
        writer.block(4)
        lines += writer.lines
    text = " ".join(lines)
    assert all(word in text for word in ("else", "endwhile", "do", "endrepeat", "break", "continue"))
