@ EXC_RETURN, frames, alignment of the stack, and refused returns.
    .include "macros.s"
    .text
    .thumb_func
    .global return_cases
return_cases:
    push {r3-r7, lr}

    case "link_of_main_thread"
    svc #0

    case "link_of_process_thread"
    bl to_process_stack
    svc #0
    mov r4, sp
    note "sp", r4
    bl to_main_stack

    case "link_of_handler"
    system_priority 11, 0x80
    handler 11, interrupted
    svc #0

    case "links_with_fpu"
    bl use_fpu
    svc #0
    bl to_process_stack
    bl use_fpu
    svc #0
    bl to_main_stack
    system_priority 11, 0x80
    handler 11, interrupted_with_fpu
    svc #0
    mrs r4, control
    note "control", r4

    case "unaligned_stack"
    sub sp, #4
    svc #0
    mov r4, sp
    add sp, #4
    note "sp", r4

    case "unaligned_stack_without_stkalign"
    store CCR, 0
    sub sp, #4
    svc #0
    mov r4, sp
    add sp, #4
    note "sp", r4

    case "unaligned_process_stack"
    bl to_process_stack
    sub sp, #4
    svc #0
    mov r4, sp
    note "sp", r4
    add sp, #4
    bl to_main_stack

    case "unaligned_stack_with_fpu"
    store CCR, 0
    bl use_fpu
    sub sp, #4
    svc #0
    mov r4, sp
    add sp, #4
    note "sp", r4

    case "padding_bit_without_stkalign"     @ bit 9 of the frame counts only with STKALIGN
    handler 11, set_padding_bit
    store CCR, 0
    svc #0
    mov r4, sp
    load r5, MAIN_STACK - 24
    mov sp, r5
    note "sp", r4

    case "sp_keeps_low_bits_zero"
    load r4, PROCESS_STACK + 3
    msr psp, r4
    mrs r5, psp
    note "psp", r5

    case "return_with_reserved_value"
    handler 11, return_f5
    handler 6, fix_link
    svc #0

    case "return_to_thread_while_nested"
    system_priority 11, 0x80
    handler 11, nest
    handler 16, return_to_thread
    svc #0

    case "return_to_thread_is_permitted"
    store CCR, STKALIGN + 1             @ NONBASETHRDENA
    system_priority 11, 0x80
    handler 11, nest
    handler 16, return_to_resume
    svc #0
1:
    case "return_to_handler_of_thread_frame"
    handler 11, return_to_handler
    svc #0

    case "return_to_thread_of_handler_frame"
    handler 11, number_in_frame
    svc #0

    case "return_without_thumb"
    handler 11, clear_thumb
    resume 1f
    svc #0
1:
    case "return_into_it_block"
    handler 11, put_it_block
    movs r5, #0
    cmp r5, #0
    svc #0
    adds r5, #1                         @ EQ
    adds r5, #2                         @ NE
    adds r5, #4                         @ EQ
    adds r5, #8
    note "r5", r5

    case "return_of_inactive_exception"
    handler 11, become_inactive
    svc #0

    pop {r3-r7, pc}

@ Thread mode on the process stack; the main stack keeps its place.
    .thumb_func
    .global to_process_stack
to_process_stack:
    load r0, PROCESS_STACK
    msr psp, r0
    movs r0, #2
    msr control, r0
    isb
    bx lr

    .thumb_func
    .global to_main_stack
to_main_stack:
    movs r0, #0
    msr control, r0
    isb
    bx lr

    .thumb_func
    .global use_fpu
use_fpu:
    vmov s0, r0
    bx lr

    .thumb_func
interrupted:
    push {r4, lr}
    pend 1
    pop {r4, pc}

    .thumb_func
interrupted_with_fpu:
    push {r4, lr}
    vmov s1, r0
    pend 1
    pop {r4, pc}

    .thumb_func
set_padding_bit:
    ldr r0, [sp, #28]
    orr r0, #1 << 9
    str r0, [sp, #28]
    bx lr

@ A refused return takes the UsageFault with the frame of the SVC still on the stack. Its handler returns by that frame.
    .thumb_func
return_f5:
    load r0, 0xFFFFFFF5
    bx r0

    .thumb_func
nest:
    push {r4, lr}
    pend 1
    noted "nested_again", 0
    pop {r4, pc}

    .thumb_func
return_to_thread:
    handler 6, record_and_fix
    load r0, 0xFFFFFFF9
    bx r0

@ EXC_RETURN is that of the refused return. The frame is that of handler 11, so the return goes there.
    .thumb_func
record_and_fix:
    push {r4, lr}
    note "link", lr
    mrs r4, ipsr
    note "exception", r4
    show "shcsr", SHCSR
    bl note_faults
    pop {r4, lr}
    load r0, 0xFFFFFFF1
    bx r0

@ Ends handlers 16 and 11 at once.
    .thumb_func
return_to_resume:
    show "shcsr", SHCSR
    add sp, #32 + 8                     @ the frame of interrupt 0, and what `nest` has pushed
    load r0, 0xFFFFFFF9
    ldr r1, [sp, #28]
    note "psr", r1
    bx r0

    .thumb_func
return_to_handler:
    load r0, 0xFFFFFFF1
    handler 6, fix_link
    load r0, 0xFFFFFFF1
    bx r0

    .thumb_func
fix_link:
    push {r4, lr}
    note "link", lr
    mrs r4, ipsr
    note "exception", r4
    bl note_faults
    pop {r4, lr}
    load r0, 0xFFFFFFF9
    bx r0

    .thumb_func
number_in_frame:
    handler 6, remove_number
    ldr r0, [sp, #28]
    adds r0, #11
    str r0, [sp, #28]
    bx lr

    .thumb_func
remove_number:
    push {r4, lr}
    note "link", lr
    mrs r4, ipsr
    note "exception", r4
    bl note_faults
    ldr r0, [sp, #28 + 8]
    subs r0, #11
    str r0, [sp, #28 + 8]
    pop {r4, pc}

    .thumb_func
clear_thumb:
    ldr r0, [sp, #28]
    bic r0, #1 << 24
    str r0, [sp, #28]
    bx lr

    .thumb_func
put_it_block:                           @ ITETT EQ, of which the first instruction comes next
    ldr r0, [sp, #28]
    load r1, 0x04000800                 @ ITSTATE 0000 1010: EQ, NE, EQ
    orrs r0, r1
    str r0, [sp, #28]
    bx lr

    .thumb_func
become_inactive:                        @ SVCall is no longer active, says SHCSR
    store SHCSR, ALL_FAULTS
    handler 6, fix_link
    bx lr
