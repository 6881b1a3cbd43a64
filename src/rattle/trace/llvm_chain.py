"""The loops that call functions in turn, tile by tile, and set lanes aside, as LLVM's text; see `lane_chain`."""

from __future__ import annotations

import ctypes

# Arrays of int64: a call takes six numbers, a function and its arguments, with distances in bytes from the tile for
# addresses; or 0, the address of an aside, and four that are not used.  An aside: lanes n; distances of its rows
# `asks`, `lane`, `count`; address and size of its calls; number of `copies`, of `larger`; distances of each source and
# target and number of rows of each copy; distances of each value and of what becomes as large.
RUN = """define internal void @run(ptr %calls, i64 %size, ptr %here) nounwind {
br label %one
one:
%k = phi i64 [0, %0], [%k.next, %done]
%call = getelementptr i64, ptr %calls, i64 %k
%f = load ptr, ptr %call
%in.p = getelementptr i64, ptr %call, i64 1
%in.at = load i64, ptr %in.p
%plain = icmp ne ptr %f, null
br i1 %plain, label %function, label %aside
function:
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
br label %done
aside:
%d = inttoptr i64 %in.at to ptr
call void @take(ptr %d, ptr %here)
br label %done
done:
%k.next = add i64 %k, 6
%k.more = icmp ult i64 %k.next, %size
br i1 %k.more, label %one, label %left
left:
ret void
}
"""

# the row of the tile whose distance is number {k} of the aside
ROW = """%{name}.q = getelementptr i64, ptr %d, i64 {k}
%{name}.at = load i64, ptr %{name}.q
%{name} = getelementptr i8, ptr %here, i64 %{name}.at
"""
NUMBER = """%{name}.q = getelementptr i64, ptr %d, i64 {k}
%{name} = load i64, ptr %{name}.q
"""
ROWS = "".join(ROW.format(name=name, k=k) for name, k in (("asks", 1), ("lane", 2), ("taken", 3)))
TAKE = f"""define internal void @take(ptr %d, ptr %here) nounwind {{
%n = load i64, ptr %d
{ROWS}{NUMBER.format(name="copies", k=6)}%first = getelementptr i64, ptr %d, i64 8
br label %lane.next
lane.next:
%j = phi i64 [0, %0], [%j.next, %through]
%ask.p = getelementptr double, ptr %asks, i64 %j
%ask = load double, ptr %ask.p
%on = fcmp une double %ask, 0.0
br i1 %on, label %room, label %through
room:
%held.n = load double, ptr %taken
%taken.i = fptoui double %held.n to i64
%full = icmp eq i64 %taken.i, %n
br i1 %full, label %clear, label %copies.begin
clear:
call void @empty(ptr %d, ptr %here)
br label %copies.begin
copies.begin:
%c = phi i64 [%taken.i, %room], [0, %clear]
br label %copy
copy:
%s = phi i64 [0, %copies.begin], [%s.next, %copied]
%s.at = mul i64 %s, 3
%source.p = getelementptr i64, ptr %first, i64 %s.at
%source.at = load i64, ptr %source.p
%source = getelementptr i8, ptr %here, i64 %source.at
%target.p = getelementptr i64, ptr %source.p, i64 1
%target.at = load i64, ptr %target.p
%target = getelementptr i8, ptr %here, i64 %target.at
%rows.p = getelementptr i64, ptr %source.p, i64 2
%rows = load i64, ptr %rows.p
br label %row
row:
%r = phi i64 [0, %copy], [%r.next, %row]
%r.at = mul i64 %r, %n
%x.at = add i64 %r.at, %j
%x.p = getelementptr double, ptr %source, i64 %x.at
%x = load double, ptr %x.p
%y.at = add i64 %r.at, %c
%y.p = getelementptr double, ptr %target, i64 %y.at
store double %x, ptr %y.p
%r.next = add i64 %r, 1
%r.more = icmp ult i64 %r.next, %rows
br i1 %r.more, label %row, label %copied
copied:
%s.next = add i64 %s, 1
%s.more = icmp ult i64 %s.next, %copies
br i1 %s.more, label %copy, label %noted
noted:
%own.p = getelementptr double, ptr %lane, i64 %c
%own = uitofp i64 %j to double
store double %own, ptr %own.p
%c.next = add i64 %c, 1
%c.f = uitofp i64 %c.next to double
store double %c.f, ptr %taken
br label %through
through:
%j.next = add i64 %j, 1
%j.more = icmp ult i64 %j.next, %n
br i1 %j.more, label %lane.next, label %left
left:
ret void
}}
"""
EMPTY = f"""define internal void @empty(ptr %d, ptr %here) nounwind {{
{ROWS}{NUMBER.format(name="calls.i", k=4)}%calls = inttoptr i64 %calls.i to ptr
{NUMBER.format(name="size", k=5)}{NUMBER.format(name="copies", k=6)}{NUMBER.format(name="values", k=7)}
%skip = mul i64 %copies, 3
%skip.8 = add i64 %skip, 8
%first = getelementptr i64, ptr %d, i64 %skip.8
%held.n = load double, ptr %taken
%taken.i = fptoui double %held.n to i64
%some = icmp ne i64 %taken.i, 0
br i1 %some, label %begin, label %left
begin:
call void @run(ptr %calls, i64 %size, ptr %here)
br label %column
column:
%c = phi i64 [0, %begin], [%c.next, %back]
%own.p = getelementptr double, ptr %lane, i64 %c
%own = load double, ptr %own.p
%j = fptoui double %own to i64
br label %value
value:
%v = phi i64 [0, %column], [%v.next, %kept]
%v.at = mul i64 %v, 2
%found.p = getelementptr i64, ptr %first, i64 %v.at
%found.at = load i64, ptr %found.p
%found = getelementptr i8, ptr %here, i64 %found.at
%held.p = getelementptr i64, ptr %found.p, i64 1
%held.at = load i64, ptr %held.p
%held = getelementptr i8, ptr %here, i64 %held.at
%x.p = getelementptr double, ptr %found, i64 %c
%x = load double, ptr %x.p
%y.p = getelementptr double, ptr %held, i64 %j
%y = load double, ptr %y.p
%larger = fcmp ogt double %x, %y
br i1 %larger, label %raise, label %kept
raise:
store double %x, ptr %y.p
br label %kept
kept:
%v.next = add i64 %v, 1
%v.more = icmp ult i64 %v.next, %values
br i1 %v.more, label %value, label %back
back:
%c.next = add i64 %c, 1
%c.more = icmp ult i64 %c.next, %taken.i
br i1 %c.more, label %column, label %done
done:
store double 0.0, ptr %taken
br label %left
left:
ret void
}}
"""

# `void chain(int64 *calls, int64 count, double *memory, int64 size, int64 tiles, int64 times, int64 running, int64 n,
# int64 *aside)`: the calls so many times for each tile of `size` numbers, while one of the n numbers at `running` is
# not 0; then the aside (0: there is none) of a tile in which one is 0
CHAIN = f"""{RUN}{TAKE}{EMPTY}define void @chain(
  ptr %calls, i64 %count, ptr %memory, i64 %size, i64 %tiles, i64 %times, i64 %running, i64 %n, ptr %aside) nounwind {{
%sets.aside = icmp ne ptr %aside, null
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
br i1 %runs, label %stepped, label %idle
idle:
%j.next = add i64 %j, 1
%j.more = icmp ult i64 %j.next, %n
br i1 %j.more, label %lane, label %rest
stepped:
call void @run(ptr %calls, i64 %count, ptr %here)
%s.next = add i64 %s, 1
%s.more = icmp ult i64 %s.next, %times
br i1 %s.more, label %look, label %rest
rest:
br i1 %sets.aside, label %stopped, label %left
stopped:
%i = phi i64 [0, %rest], [%i.next, %going]
%stop.p = getelementptr double, ptr %flags, i64 %i
%stop = load double, ptr %stop.p
%stops = fcmp oeq double %stop, 0.0
br i1 %stops, label %clear, label %going
going:
%i.next = add i64 %i, 1
%i.more = icmp ult i64 %i.next, %n
br i1 %i.more, label %stopped, label %left
clear:
call void @empty(ptr %aside, ptr %here)
br label %left
left:
%t.next = add i64 %t, 1
%t.more = icmp ult i64 %t.next, %tiles
br i1 %t.more, label %tile, label %done
done:
ret void
}}
"""
KINDS = (ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p, *[ctypes.c_int64] * 5, ctypes.c_void_p)
