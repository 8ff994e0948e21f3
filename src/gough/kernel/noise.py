"""Standard normal numbers without a table and without a history: a hash of (seed, run, signal entry, tick).

    mix             the finisher of SplitMix64
    key of a run    r = mix(mix(seed + G) xor (run + 1) C)
    key of a pair   p = the first 8 bytes of SHA-256("signal:pair"); entries 2p and 2p + 1 of a signal share a pair
    bits            b1, b2 = mix(s + (2 k + 1) G), mix(s + (2 k + 2) G),   s = mix(r xor p),   k the tick
    uniform         u1 in (0, 1], u2 in [0, 1), 52 bits each
    normal          sqrt(-2 log u1) cos(2 pi u2), sqrt(-2 log u1) sin(2 pi u2)              Box and Muller 1958

So a number depends neither on what other signals there are, nor on which runs share a batch, nor on where a chunk ends.
SplitMix64: Steele, Lea, Flood, Fast splittable pseudorandom number generators, OOPSLA 2014; integers are modulo 2^64.
"""

from __future__ import annotations

import hashlib

import numpy as np

from ..errors import InputError
from .lanes import Calls, Lanes

_MASK = (1 << 64) - 1
_G, _C = 0x9E3779B97F4A7C15, 0xD1342543DE82EF95
_M1, _M2 = 0xBF58476D1CE4E5B9, 0x94D049BB133111EB
_TWO_PI = 2.0 * np.pi


def _mix(z: int) -> int:
    z = (z ^ (z >> 30)) * _M1 & _MASK
    z = (z ^ (z >> 27)) * _M2 & _MASK
    return z ^ (z >> 31)


def run_key(seed: int, run: int) -> int:
    """The key of one run."""
    if not isinstance(seed, (int, np.integer)) or not 0 <= seed < 1 << 63:
        raise InputError("the seed must be a whole number from 0 to 2^63 - 1", value=repr(seed))
    if isinstance(run, bool) or not isinstance(run, (int, np.integer)) or run < 0:
        raise InputError("the number of a run must be 0, 1, 2 ...", value=repr(run))
    return _mix(_mix(int(seed) + _G & _MASK) ^ ((int(run) + 1) * _C & _MASK))


def pair_keys(signal: str, size: int) -> list[int]:
    """The keys of the pairs of entries of a signal."""
    return [
        int.from_bytes(hashlib.sha256(f"{signal}:{p}".encode()).digest()[:8], "little") for p in range((size + 1) // 2)
    ]


def normals(signal: str, size: int, key: int, tick: int) -> np.ndarray:
    """What the machine code gives for the run with this key at this tick, (size,), in NumPy."""
    pairs = np.array([_mix(key ^ pair) for pair in pair_keys(signal, size)], np.uint64)
    u1 = 2.0 - _mantissa(_mix_array(pairs + np.uint64((2 * tick + 1) * _G & _MASK)))
    u2 = _mantissa(_mix_array(pairs + np.uint64((2 * tick + 2) * _G & _MASK))) - 1.0
    radius = np.sqrt(-2.0 * np.log(u1))
    return np.column_stack([radius * np.cos(_TWO_PI * u2), radius * np.sin(_TWO_PI * u2)]).ravel()[:size]


def _mix_array(z: np.ndarray) -> np.ndarray:
    z = (z ^ (z >> np.uint64(30))) * np.uint64(_M1)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(_M2)
    return z ^ (z >> np.uint64(31))


def _mantissa(bits: np.ndarray) -> np.ndarray:
    """A double in [1, 2) from the upper 52 bits."""
    return ((bits >> np.uint64(12)) | np.uint64(0x3FF0000000000000)).view(np.float64)


def function(lanes: Lanes, calls: Calls) -> str:
    """LLVM: @normals(to, keys of pairs, size, keys of runs, tick) writes `size` numbers."""
    v, m = lanes.number, lanes.integer
    text: list[str] = []

    def put(line: str):
        text.append(f"  {line}\n")

    def const(value: int) -> str:
        return lanes.constant(str(value - (1 << 64) if value >> 63 else value), "i64")

    def real(value: float) -> str:
        return lanes.constant(f"0x{np.float64(value).view(np.uint64):016X}")

    def mix(z: str, name: str) -> str:
        for part, (shift, factor) in enumerate(((30, _M1), (27, _M2), (31, None))):
            put(f"%{name}.a{part} = lshr {m} {z}, {const(shift)}")
            put(f"%{name}.b{part} = xor {m} {z}, %{name}.a{part}")
            z = f"%{name}.b{part}"
            if factor is not None:
                put(f"%{name}.c{part} = mul {m} {z}, {const(factor)}")
                z = f"%{name}.c{part}"
        return z

    def unit(bits: str, name: str) -> str:
        put(f"%{name}.h = lshr {m} {bits}, {const(12)}")
        put(f"%{name}.o = or {m} %{name}.h, {const(0x3FF0000000000000)}")
        put(f"%{name}.f = bitcast {m} %{name}.o to {v}")
        return f"%{name}.f"

    put("%twice = shl i64 %tick, 1")
    put("%odd = add i64 %twice, 1")
    put("%even = add i64 %twice, 2")
    put(f"%g1 = mul i64 %odd, {_G - (1 << 64)}")
    put(f"%g2 = mul i64 %even, {_G - (1 << 64)}")
    text.append(lanes.splat("%g1", "%step1", "i64") + lanes.splat("%g2", "%step2", "i64"))
    put("%last = sub i64 %size, 1")
    put("br label %loop")
    text.append("loop:\n")
    put("%p = phi i64 [0, %0], [%next, %loop]")
    put("%q = getelementptr i64, ptr %pairs, i64 %p")
    put("%one = load i64, ptr %q, align 8")
    text.append(lanes.splat("%one", "%pair", "i64"))
    put(f"%key = xor {m} %runs, %pair")
    start = mix("%key", "s")
    put(f"%z1 = add {m} {start}, %step1")
    put(f"%z2 = add {m} {start}, %step2")
    f1, f2 = unit(mix("%z1", "h"), "h"), unit(mix("%z2", "t"), "t")
    put(f"%u1 = fsub {v} {real(2.0)}, {f1}")
    put(f"%u2 = fsub {v} {f2}, {real(1.0)}")
    put(f"%log = call {v} {calls.name('log')}({v} %u1)")
    put(f"%square = fmul {v} %log, {real(-2.0)}")
    put(f"%radius = call {v} @llvm.sqrt.{lanes.suffix()}({v} %square)")
    put(f"%angle = fmul {v} %u2, {real(_TWO_PI)}")
    put(f"%cos = call {v} {calls.name('cos')}({v} %angle)")
    put(f"%sin = call {v} {calls.name('sin')}({v} %angle)")
    put(f"%first = fmul {v} %radius, %cos")
    put(f"%second = fmul {v} %radius, %sin")
    put("%e1 = shl i64 %p, 1")
    put("%e2 = add i64 %e1, 1")
    put("%inside = icmp ult i64 %e2, %size")
    put("%e2in = select i1 %inside, i64 %e2, i64 %last")  # an odd size: the pair's second is overwritten by its first
    put(f"%to2 = getelementptr {v}, ptr %to, i64 %e2in")
    put(f"store {v} %second, ptr %to2, align {lanes.align}")
    put(f"%to1 = getelementptr {v}, ptr %to, i64 %e1")
    put(f"store {v} %first, ptr %to1, align {lanes.align}")
    put("%next = add i64 %p, 1")
    put("%done = add i64 %e1, 2")
    put("%more = icmp ult i64 %done, %size")
    put("br i1 %more, label %loop, label %end")
    text.append("end:\n  ret void\n")
    head = (
        f"define internal void @normals(ptr %to, ptr %pairs, i64 %size, {m} %runs, i64 %tick) noinline nounwind #0 {{\n"
    )
    return head + "".join(text) + "}\n"
