"""LLVM functions that every kernel shares: checks, the keeping of states, and rows of numbers into lanes and back.

A row is what people handle: the entries of one run side by side.  A slot is what the machine computes on: one entry of
W runs side by side.  `gather` turns W rows into slots and `scatter` back, W x W numbers at a time.
"""

from __future__ import annotations

from .lanes import Lanes

_INFINITY, _ZERO = "0x7FF0000000000000", "0x0000000000000000"


def intrinsics(lanes: Lanes) -> str:
    text = "declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)\n"
    if lanes.width > 1:
        v, m, s = lanes.number, lanes.condition, lanes.suffix()
        text += f"declare i1 @llvm.vector.reduce.or.v{lanes.width}i1({m})\n"
        text += f"declare {v} @llvm.masked.load.{s}.p0(ptr, i32, {m}, {v})\n"
        text += f"declare void @llvm.masked.store.{s}.p0({v}, ptr, i32, {m})\n"
    return text


def checks(lanes: Lanes) -> str:
    """@finite(slots, count) and @nonnegative(slots, count): the lanes in which all numbers are.  NaN is neither."""
    v, m, align = lanes.number, lanes.condition, lanes.align

    def check(name: str, test: str) -> str:
        return f"""define internal {m} @{name}(ptr %from, i64 %count) nounwind #0 {{
  %any = icmp ne i64 %count, 0
  br i1 %any, label %loop, label %end
loop:
  %i = phi i64 [0, %0], [%next, %loop]
  %ok = phi {m} [{lanes.constant("true", "i1")}, %0], [%good, %loop]
  %p = getelementptr {v}, ptr %from, i64 %i
  %x = load {v}, ptr %p, align {align}
{test}
  %good = and {m} %ok, %is
  %next = add i64 %i, 1
  %more = icmp ult i64 %next, %count
  br i1 %more, label %loop, label %end
end:
  %all = phi {m} [{lanes.constant("true", "i1")}, %0], [%good, %loop]
  ret {m} %all
}}
"""

    size = f"""  %size = call {v} @llvm.fabs.{lanes.suffix()}({v} %x)
  %is = fcmp olt {v} %size, {lanes.constant(_INFINITY)}"""
    return check("finite", size) + check("nonnegative", f"  %is = fcmp oge {v} %x, {lanes.constant(_ZERO)}")


def keep(lanes: Lanes) -> str:
    """@keep(states, kept, count, live): kept = states where live, states = kept elsewhere."""
    v, m, align = lanes.number, lanes.condition, lanes.align
    return f"""define internal void @keep(ptr %states, ptr %kept, i64 %count, {m} %live) nounwind #0 {{
  %any = icmp ne i64 %count, 0
  br i1 %any, label %loop, label %end
loop:
  %i = phi i64 [0, %0], [%next, %loop]
  %p = getelementptr {v}, ptr %states, i64 %i
  %q = getelementptr {v}, ptr %kept, i64 %i
  %new = load {v}, ptr %p, align {align}
  %old = load {v}, ptr %q, align {align}
  %x = select {m} %live, {v} %new, {v} %old
  store {v} %x, ptr %p, align {align}
  store {v} %x, ptr %q, align {align}
  %next = add i64 %i, 1
  %more = icmp ult i64 %next, %count
  br i1 %more, label %loop, label %end
end:
  ret void
}}
"""


def spread(lanes: Lanes) -> str:
    """@spread(to, from, count): a row of a table into every lane."""
    v = lanes.number
    return f"""define internal void @spread(ptr %to, ptr %from, i64 %count) nounwind #0 {{
  %any = icmp ne i64 %count, 0
  br i1 %any, label %loop, label %end
loop:
  %i = phi i64 [0, %0], [%next, %loop]
  %p = getelementptr double, ptr %from, i64 %i
  %x = load double, ptr %p, align 8
{lanes.splat("%x", "%all")}  %q = getelementptr {v}, ptr %to, i64 %i
  store {v} %all, ptr %q, align {lanes.align}
  %next = add i64 %i, 1
  %more = icmp ult i64 %next, %count
  br i1 %more, label %loop, label %end
end:
  ret void
}}
"""


def transposition(lanes: Lanes, name: str) -> str:
    """@gather(slots, rows, stride, size): rows -> slots; @scatter(rows, slots, stride, size): slots -> rows.

    Lane l of the rows begins `stride` doubles after lane l - 1 (0: all lanes read the same row).  Rows are touched
    only where they have numbers; slots in blocks of W, so behind the last slot there must be room for W - 1 more.
    """
    if lanes.width == 1:
        return f"""define internal void @{name}(ptr %to, ptr %from, i64 %stride, i64 %size) nounwind #0 {{
  %bytes = shl i64 %size, 3
  call void @llvm.memcpy.p0.p0.i64(ptr %to, ptr %from, i64 %bytes, i1 false)
  ret void
}}
"""
    return _blocks(lanes, name)


def _blocks(lanes: Lanes, name: str) -> str:
    w, v, m, s = lanes.width, lanes.number, lanes.condition, lanes.suffix()
    rows_in, none = name == "gather", f"{v} zeroinitializer"
    rows, slots = ("%from", "%to") if rows_in else ("%to", "%from")
    lines = []

    def put(line):
        lines.append(f"  {line}\n")

    put("%any = icmp ne i64 %size, 0")
    put("br i1 %any, label %loop, label %end")
    lines.append("loop:\n")
    put("%k = phi i64 [0, %0], [%next, %loop]")
    put("%left = sub i64 %size, %k")
    lines.append(lanes.splat("%left", "%rest", "i64"))
    counting = ", ".join(f"i64 {i}" for i in range(w))
    put(f"%inside = icmp ugt {lanes.integer} %rest, <{counting}>")
    for lane in range(w):
        put(f"%far{lane} = mul i64 %stride, {lane}")
        put(f"%at{lane} = add i64 %far{lane}, %k")
        put(f"%row{lane} = getelementptr double, ptr {rows}, i64 %at{lane}")
        put(f"%slot{lane}.k = add i64 %k, {lane}")
        put(f"%slot{lane} = getelementptr {v}, ptr {slots}, i64 %slot{lane}.k")
        if rows_in:
            put(f"%x0.{lane} = call {v} @llvm.masked.load.{s}.p0(ptr %row{lane}, i32 8, {m} %inside, {none})")
        else:
            put(f"%x0.{lane} = load {v}, ptr %slot{lane}, align {lanes.align}")
    stage, step = 0, w // 2
    while step:
        for i in range(w):
            if i & step:
                continue
            a, b = f"%x{stage}.{i}", f"%x{stage}.{i | step}"
            upper = [c if not c & step else w + (c ^ step) for c in range(w)]
            lower = [c | step if not c & step else w + c for c in range(w)]
            for target, order in ((i, upper), (i | step, lower)):
                mask = ", ".join(f"i32 {c}" for c in order)
                put(f"%x{stage + 1}.{target} = shufflevector {v} {a}, {v} {b}, <{w} x i32> <{mask}>")
        stage, step = stage + 1, step // 2
    for lane in range(w):
        if rows_in:
            put(f"store {v} %x{stage}.{lane}, ptr %slot{lane}, align {lanes.align}")
        else:
            put(f"call void @llvm.masked.store.{s}.p0({v} %x{stage}.{lane}, ptr %row{lane}, i32 8, {m} %inside)")
    put(f"%next = add i64 %k, {w}")
    put("%more = icmp ult i64 %next, %size")
    put("br i1 %more, label %loop, label %end")
    lines.append("end:\n  ret void\n")
    head = f"define internal void @{name}(ptr %to, ptr %from, i64 %stride, i64 %size) noinline nounwind #0 {{\n"
    return head + "".join(lines) + "}\n"
