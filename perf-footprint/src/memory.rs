//! The routines that compilers call to copy, to move and to clear memory, a byte at a time as in C
//! libraries for small devices. Those that come with Rust are made for speed and take about 1 kB
//! more.
#![expect(unsafe_code, reason = "the linker takes these for the routines that compilers know")]

use core::arch::global_asm;

global_asm!(
    ".macro routine name",
    ".global \\name",
    ".thumb_func",
    "\\name:",
    ".endm",
    ".section .text.memory, \"ax\"",
    ".syntax unified",
    // r0: to; r1: from; r2: bytes. r0 stays.
    "routine memcpy",
    "routine __aeabi_memcpy",
    "routine __aeabi_memcpy4",
    "routine __aeabi_memcpy8",
    "mov r3, r0",
    "0: subs r2, #1",
    "it mi",
    "bxmi lr",
    "ldrb r12, [r1], #1",
    "strb r12, [r3], #1",
    "b 0b",
    // r0: where; r1: the byte; r2: bytes. r0 stays.
    "routine memset",
    "mov r3, r0",
    "0: subs r2, #1",
    "it mi",
    "bxmi lr",
    "strb r1, [r3], #1",
    "b 0b",
    // r0: where; r1: bytes.
    "routine __aeabi_memclr",
    "routine __aeabi_memclr4",
    "routine __aeabi_memclr8",
    "mov r2, r1",
    "movs r1, #0",
    "b memset",
    // As memcpy, for places that may overlap: from the last byte on if the copy lies behind. It has a
    // section of its own, since not every stack needs it.
    ".section .text.memmove, \"ax\"",
    "routine memmove",
    "routine __aeabi_memmove",
    "routine __aeabi_memmove4",
    "routine __aeabi_memmove8",
    "cmp r0, r1",
    "bls.w memcpy",
    "0: subs r2, #1",
    "it mi",
    "bxmi lr",
    "ldrb r3, [r1, r2]",
    "strb r3, [r0, r2]",
    "b 0b",
);
