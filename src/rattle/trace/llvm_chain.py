"""The loop that calls functions in turn, tile by tile, as LLVM's text."""

from __future__ import annotations

import ctypes

# `void chain(int64 *calls, int64 count, double *memory, int64 size, int64 tiles, int64 times, int64 running, int64 n)`:
# of every six numbers in `calls` one call, a function and its arguments, with distances in bytes from the tile for
# addresses; so many times for each tile of `size` numbers, while one of the n numbers at `running` is not 0.
CHAIN = """define void @chain(
  ptr %calls, i64 %count, ptr %memory, i64 %size, i64 %tiles, i64 %times, i64 %running, i64 %n) nounwind {
br label %tile
tile:
%t = phi i64 [0, %0], [%t.next, %left]
%t.at = mul i64 %t, %size
%here = getelementptr double, ptr %memory, i64 %t.at
%flags = getelementptr double, ptr %here, i64 %running
br label %look
look:
%s = phi i64 [0, %tile], [%s.next, %stepped]
br label %lane
lane:
%j = phi i64 [0, %look], [%j.next, %idle]
%flag.p = getelementptr double, ptr %flags, i64 %j
%flag = load double, ptr %flag.p
%runs = fcmp une double %flag, 0.0
br i1 %runs, label %one, label %idle
idle:
%j.next = add i64 %j, 1
%j.more = icmp ult i64 %j.next, %n
br i1 %j.more, label %lane, label %left
one:
%k = phi i64 [0, %lane], [%k.next, %one]
%call = getelementptr i64, ptr %calls, i64 %k
%f = load ptr, ptr %call
%in.p = getelementptr i64, ptr %call, i64 1
%in.at = load i64, ptr %in.p
%in = getelementptr i8, ptr %here, i64 %in.at
%a.p = getelementptr i64, ptr %call, i64 2
%a = load i64, ptr %a.p
%out.p = getelementptr i64, ptr %call, i64 3
%out.at = load i64, ptr %out.p
%out = getelementptr i8, ptr %here, i64 %out.at
%b.p = getelementptr i64, ptr %call, i64 4
%b = load i64, ptr %b.p
%m.p = getelementptr i64, ptr %call, i64 5
%m = load i64, ptr %m.p
call void %f(ptr %in, i64 %a, ptr %out, i64 %b, i64 %m)
%k.next = add i64 %k, 6
%k.more = icmp ult i64 %k.next, %count
br i1 %k.more, label %one, label %stepped
stepped:
%s.next = add i64 %s, 1
%s.more = icmp ult i64 %s.next, %times
br i1 %s.more, label %look, label %left
left:
%t.next = add i64 %t, 1
%t.more = icmp ult i64 %t.next, %tiles
br i1 %t.more, label %tile, label %done
done:
ret void
}
"""
KINDS = (ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p, *[ctypes.c_int64] * 5)
