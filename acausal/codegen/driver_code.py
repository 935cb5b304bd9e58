"""The driver as LLVM text: residual, Jacobian and roots of a whole problem from its kernels.

The driver knows no model. It reads a table of 8-byte fields, ``FIELDS``, and a list of records of
``RECORD`` fields, one for each kernel call. Written once, compiled once per machine.
"""

from __future__ import annotations

from typing import Final

from acausal.codegen.delays import delay_function
from acausal.codegen.writer import module

#: Fields of the table in order: addresses and counts; ``stop`` is an int32 (upper half zero).
FIELDS: Final = (
    "stop", "n", "nnz", "call_count", "w", "calls", "buffer",
    "residual_evaluations", "jacobian_evaluations", "indptr", "indices",
    "constant_part", "constant_valid", "tail", "tail_bytes", "tail_copy",
    "differential_entry", "delays",
    "root_count", "root_call_count", "root_calls", "root_shift", "root_evaluations",
)  # fmt: skip

#: Fields of the record of a kernel call.
RECORD: Final = ("residual", "jacobian", "count", "index", "target", "entry", "constant", "unused")


def _field(result: str, name: str, kind: str = "i64") -> str:
    """Return the load of a field of the table."""
    return (
        f"  %{result}.f = getelementptr inbounds i64, ptr %table, i64 {FIELDS.index(name)}\n"
        f"  %{result} = load {kind}, ptr %{result}.f, align 8\n"
    )


def _increment(name: str) -> str:
    return (
        _field(f"{name}.old", name)
        + f"  %{name}.new = add i64 %{name}.old, 1\n"
        + f"  store i64 %{name}.new, ptr %{name}.old.f, align 8\n"
    )


def _record(name: str, kind: str = "ptr") -> str:
    """Return the load of a field of the record ``%call``."""
    return (
        f"  %{name}.f = getelementptr inbounds i64, ptr %call, i64 {RECORD.index(name)}\n"
        f"  %{name} = load {kind}, ptr %{name}.f, align 8\n"
    )


# Copy the arguments into the work vector, and what is delayed.
_LOAD_STATE: Final = f"""
define internal void @load_state(double %t, ptr %y, ptr %yp, ptr %table) nounwind {{
{_field("w", "w", "ptr")}{_field("n", "n")}
  %time = getelementptr inbounds double, ptr %w, i64 1
  store double %t, ptr %time, align 8
  %w.y = getelementptr inbounds double, ptr %w, i64 2
  %w.yp = getelementptr inbounds double, ptr %w.y, i64 %n
  %bytes = shl i64 %n, 3
  call void @llvm.memmove.p0.p0.i64(ptr %w.y, ptr %y, i64 %bytes, i1 false)
  call void @llvm.memmove.p0.p0.i64(ptr %w.yp, ptr %yp, i64 %bytes, i1 false)
{_field("delays", "delays", "ptr")}
  %delayed = icmp ne ptr %delays, null
  br i1 %delayed, label %look, label %done
look:
  call void @acausal_delays(double %t, ptr %w, ptr %delays)
  br label %done
done:
  ret void
}}
"""

# Residual: sum of all kernels; recoverable failure (1) if any value is not finite.
_RESIDUAL: Final = f"""
define i32 @acausal_residual(double %t, ptr %y, ptr %yp, ptr %r, ptr %table) nounwind {{
begin:
  %stop = load volatile i32, ptr %table, align 8
  %stopped = icmp ne i32 %stop, 0
  br i1 %stopped, label %stopping, label %start
stopping:
  ret i32 -1
start:
{_increment("residual_evaluations")}
  call void @load_state(double %t, ptr %y, ptr %yp, ptr %table)
{_field("w", "w", "ptr")}{_field("n", "n")}{_field("count.calls", "call_count")}
{_field("calls", "calls", "ptr")}
  %bytes = shl i64 %n, 3
  call void @llvm.memset.p0.i64(ptr %r, i8 0, i64 %bytes, i1 false)
  %any = icmp sgt i64 %count.calls, 0
  br i1 %any, label %loop, label %check
loop:
  %i = phi i64 [ 0, %start ], [ %i.next, %loop ]
  %at = mul nuw nsw i64 %i, {len(RECORD)}
  %call = getelementptr inbounds i64, ptr %calls, i64 %at
{_record("residual")}{_record("count", "i64")}{_record("index")}{_record("target")}
  call void %residual(i64 %count, ptr %w, ptr %index, ptr %target, ptr %r)
  %i.next = add nuw nsw i64 %i, 1
  %more = icmp slt i64 %i.next, %count.calls
  br i1 %more, label %loop, label %check
check:
  %rows = icmp sgt i64 %n, 0
  br i1 %rows, label %scan, label %good
scan:
  %k = phi i64 [ 0, %check ], [ %k.next, %scan ]
  %bad = phi i64 [ 0, %check ], [ %bad.next, %scan ]
  %cell = getelementptr inbounds i64, ptr %r, i64 %k
  %bits = load i64, ptr %cell, align 8
  %exponent = and i64 %bits, 9218868437227405312
  %special = icmp eq i64 %exponent, 9218868437227405312
  %flag = zext i1 %special to i64
  %bad.next = or i64 %bad, %flag
  %k.next = add nuw nsw i64 %k, 1
  %k.more = icmp slt i64 %k.next, %n
  br i1 %k.more, label %scan, label %verdict
verdict:
  %status = trunc i64 %bad.next to i32
  ret i32 %status
good:
  ret i32 0
}}
"""

# Run the Jacobian kernels whose record's ``constant`` field is ``%wanted``.
_ADD_PARTIALS: Final = f"""
define internal void @add_partials(ptr %out, i64 %wanted, ptr %table) nounwind {{
begin:
{_field("w", "w", "ptr")}{_field("count.calls", "call_count")}{_field("calls", "calls", "ptr")}
  %any = icmp sgt i64 %count.calls, 0
  br i1 %any, label %loop, label %done
loop:
  %i = phi i64 [ 0, %begin ], [ %i.next, %next ]
  %at = mul nuw nsw i64 %i, {len(RECORD)}
  %call = getelementptr inbounds i64, ptr %calls, i64 %at
{_record("constant", "i64")}
  %chosen = icmp eq i64 %constant, %wanted
  br i1 %chosen, label %run, label %next
run:
{_record("jacobian")}{_record("count", "i64")}{_record("index")}{_record("entry")}
  call void %jacobian(i64 %count, ptr %w, ptr %index, ptr %entry, ptr %out)
  br label %next
next:
  %i.next = add nuw nsw i64 %i, 1
  %more = icmp slt i64 %i.next, %count.calls
  br i1 %more, label %loop, label %done
done:
  ret void
}}
"""

# Fill the buffer [dF/dy | dF/dy' | bin]. Partial derivatives that depend on parameters only are
# kept, and computed again when a parameter (the tail of w) has changed.
_FILL: Final = f"""
define internal i32 @fill(double %t, ptr %y, ptr %yp, ptr %table) nounwind {{
begin:
  %stop = load volatile i32, ptr %table, align 8
  %stopped = icmp ne i32 %stop, 0
  br i1 %stopped, label %stopping, label %start
stopping:
  ret i32 -1
start:
{_increment("jacobian_evaluations")}
  call void @load_state(double %t, ptr %y, ptr %yp, ptr %table)
{_field("nnz", "nnz")}{_field("buffer", "buffer", "ptr")}{_field("kept", "constant_part", "ptr")}
{_field("valid", "constant_valid")}{_field("tail", "tail", "ptr")}
{_field("tail.bytes", "tail_bytes")}{_field("copy", "tail_copy", "ptr")}
  %doubled = shl i64 %nnz, 4
  %bytes = add i64 %doubled, 8
  %known = icmp ne i64 %valid, 0
  br i1 %known, label %compare, label %renew
compare:
  %difference = call i32 @memcmp(ptr %tail, ptr %copy, i64 %tail.bytes)
  %same = icmp eq i32 %difference, 0
  br i1 %same, label %use, label %renew
renew:
  call void @llvm.memcpy.p0.p0.i64(ptr %copy, ptr %tail, i64 %tail.bytes, i1 false)
  call void @llvm.memset.p0.i64(ptr %kept, i8 0, i64 %bytes, i1 false)
  call void @add_partials(ptr %kept, i64 1, ptr %table)
  store i64 1, ptr %valid.f, align 8
  br label %use
use:
  call void @llvm.memcpy.p0.p0.i64(ptr %buffer, ptr %kept, i64 %bytes, i1 false)
  call void @add_partials(ptr %buffer, i64 0, ptr %table)
  ret i32 0
}}
"""

# Values of dF/dy + cj dF/dy' in the order of the sparsity pattern.
_JACOBIAN: Final = f"""
define i32 @acausal_jacobian(double %t, double %cj, ptr %y, ptr %yp, ptr noalias %data,
                             ptr %table) nounwind {{
begin:
  %status = call i32 @fill(double %t, ptr %y, ptr %yp, ptr %table)
{_field("nnz", "nnz")}{_field("buffer", "buffer", "ptr")}
  %second = getelementptr inbounds double, ptr %buffer, i64 %nnz
  %fine = icmp eq i32 %status, 0
  %some = icmp sgt i64 %nnz, 0
  %go = and i1 %fine, %some
  br i1 %go, label %loop, label %done
loop:
  %i = phi i64 [ 0, %begin ], [ %i.next, %loop ]
  %p = getelementptr inbounds double, ptr %buffer, i64 %i
  %q = getelementptr inbounds double, ptr %second, i64 %i
  %a = load double, ptr %p, align 8
  %b = load double, ptr %q, align 8
  %scaled = fmul double %cj, %b
  %sum = fadd double %a, %scaled
  %cell = getelementptr inbounds double, ptr %data, i64 %i
  store double %sum, ptr %cell, align 8
  %i.next = add nuw nsw i64 %i, 1
  %more = icmp slt i64 %i.next, %nnz
  br i1 %more, label %loop, label %done
done:
  ret i32 %status
}}
"""

# The same into a dense column-major matrix, whose other entries are left as they are.
_DENSE: Final = f"""
define i32 @acausal_jacobian_dense(double %t, double %cj, ptr %y, ptr %yp, ptr noalias %data,
                                   ptr %table) nounwind {{
begin:
  %status = call i32 @fill(double %t, ptr %y, ptr %yp, ptr %table)
{_field("n", "n")}{_field("nnz", "nnz")}{_field("buffer", "buffer", "ptr")}
{_field("indptr", "indptr", "ptr")}{_field("indices", "indices", "ptr")}
  %second = getelementptr inbounds double, ptr %buffer, i64 %nnz
  %fine = icmp eq i32 %status, 0
  %some = icmp sgt i64 %n, 0
  %go = and i1 %fine, %some
  br i1 %go, label %column, label %done
column:
  %j = phi i64 [ 0, %begin ], [ %j.next, %column.end ]
  %start.p = getelementptr inbounds i64, ptr %indptr, i64 %j
  %start = load i64, ptr %start.p, align 8
  %j.next = add nuw nsw i64 %j, 1
  %end.p = getelementptr inbounds i64, ptr %indptr, i64 %j.next
  %end = load i64, ptr %end.p, align 8
  %offset = mul nuw nsw i64 %j, %n
  %filled = icmp slt i64 %start, %end
  br i1 %filled, label %loop, label %column.end
loop:
  %i = phi i64 [ %start, %column ], [ %i.next, %loop ]
  %p = getelementptr inbounds double, ptr %buffer, i64 %i
  %q = getelementptr inbounds double, ptr %second, i64 %i
  %a = load double, ptr %p, align 8
  %b = load double, ptr %q, align 8
  %scaled = fmul double %cj, %b
  %sum = fadd double %a, %scaled
  %row.p = getelementptr inbounds i32, ptr %indices, i64 %i
  %row.n = load i32, ptr %row.p, align 4
  %row = zext nneg i32 %row.n to i64
  %at = add nuw nsw i64 %offset, %row
  %cell = getelementptr inbounds double, ptr %data, i64 %at
  store double %sum, ptr %cell, align 8
  %i.next = add nuw nsw i64 %i, 1
  %more = icmp slt i64 %i.next, %end
  br i1 %more, label %loop, label %column.end
column.end:
  %j.more = icmp slt i64 %j.next, %n
  br i1 %j.more, label %column, label %done
done:
  ret i32 %status
}}
"""

# Root functions: the sum of their kernels and their shifts; 1 if any value is not finite.
_ROOTS: Final = f"""
define i32 @acausal_roots(double %t, ptr %y, ptr %yp, ptr noalias %g, ptr %table) nounwind {{
begin:
{_increment("root_evaluations")}
  call void @load_state(double %t, ptr %y, ptr %yp, ptr %table)
{_field("w", "w", "ptr")}{_field("n", "root_count")}{_field("count.calls", "root_call_count")}
{_field("calls", "root_calls", "ptr")}{_field("shift", "root_shift", "ptr")}
  %bytes = shl i64 %n, 3
  call void @llvm.memset.p0.i64(ptr %g, i8 0, i64 %bytes, i1 false)
  %any = icmp sgt i64 %count.calls, 0
  br i1 %any, label %loop, label %check
loop:
  %i = phi i64 [ 0, %begin ], [ %i.next, %loop ]
  %at = mul nuw nsw i64 %i, {len(RECORD)}
  %call = getelementptr inbounds i64, ptr %calls, i64 %at
{_record("residual")}{_record("count", "i64")}{_record("index")}{_record("target")}
  call void %residual(i64 %count, ptr %w, ptr %index, ptr %target, ptr %g)
  %i.next = add nuw nsw i64 %i, 1
  %more = icmp slt i64 %i.next, %count.calls
  br i1 %more, label %loop, label %check
check:
  %some = icmp sgt i64 %n, 0
  br i1 %some, label %scan, label %good
scan:
  %k = phi i64 [ 0, %check ], [ %k.next, %scan ]
  %bad = phi i64 [ 0, %check ], [ %bad.next, %scan ]
  %shift.k = getelementptr inbounds double, ptr %shift, i64 %k
  %s = load double, ptr %shift.k, align 8
  %cell = getelementptr inbounds double, ptr %g, i64 %k
  %v = load double, ptr %cell, align 8
  %shifted = fadd double %v, %s
  store double %shifted, ptr %cell, align 8
  %bits = bitcast double %shifted to i64
  %exponent = and i64 %bits, 9218868437227405312
  %special = icmp eq i64 %exponent, 9218868437227405312
  %flag = zext i1 %special to i64
  %bad.next = or i64 %bad, %flag
  %k.next = add nuw nsw i64 %k, 1
  %k.more = icmp slt i64 %k.next, %n
  br i1 %k.more, label %scan, label %verdict
verdict:
  %status = trunc i64 %bad.next to i32
  ret i32 %status
good:
  ret i32 0
}}
"""

# Entries of the matrix of a restart: dF/dy' in columns of differential unknowns, else dF/dy.
_RESTART: Final = f"""
define i32 @acausal_restart_jacobian(double %t, ptr %y, ptr %yp, ptr noalias %data,
                                     ptr %table) nounwind {{
begin:
  %status = call i32 @fill(double %t, ptr %y, ptr %yp, ptr %table)
{_field("nnz", "nnz")}{_field("buffer", "buffer", "ptr")}
{_field("chosen", "differential_entry", "ptr")}
  %second = getelementptr inbounds double, ptr %buffer, i64 %nnz
  %fine = icmp eq i32 %status, 0
  %some = icmp sgt i64 %nnz, 0
  %go = and i1 %fine, %some
  br i1 %go, label %loop, label %done
loop:
  %i = phi i64 [ 0, %begin ], [ %i.next, %loop ]
  %p = getelementptr inbounds double, ptr %buffer, i64 %i
  %q = getelementptr inbounds double, ptr %second, i64 %i
  %a = load double, ptr %p, align 8
  %b = load double, ptr %q, align 8
  %which.p = getelementptr inbounds i8, ptr %chosen, i64 %i
  %which = load i8, ptr %which.p, align 1
  %state = icmp ne i8 %which, 0
  %value = select i1 %state, double %b, double %a
  %cell = getelementptr inbounds double, ptr %data, i64 %i
  store double %value, ptr %cell, align 8
  %i.next = add nuw nsw i64 %i, 1
  %more = icmp slt i64 %i.next, %nnz
  br i1 %more, label %loop, label %done
done:
  ret i32 %status
}}
"""

_DECLARATIONS: Final = """
declare i32 @memcmp(ptr, ptr, i64)
declare void @llvm.memmove.p0.p0.i64(ptr, ptr, i64, i1)
"""

DRIVER_TEXT: Final = "".join(
    (
        module(delay_function()),
        _DECLARATIONS,
        _LOAD_STATE,
        _RESIDUAL,
        _ADD_PARTIALS,
        _FILL,
        _JACOBIAN,
        _DENSE,
        _RESTART,
        _ROOTS,
    )
)
