@ Context of the FPU: frames, lazy and immediate stacking, FPCCR and FPCAR.
    .include "macros.s"
    .text
    .equ FPCCR_BITS, 0xC000017B     @ bits of ARMv7-M

    .macro note_context             @ FPCCR, FPCAR and CONTROL; uses r0 to r2
    peek r2, FPCCR
    load r1, FPCCR_BITS
    ands r2, r1
    note "fpccr", r2
    show "fpcar", FPCAR
    mrs r2, control
    note "control", r2
    .endm

    .macro note_frame               @ parts of the frame of a handler that has pushed two words; uses r2
    ldr r2, [sp, #8 + 0x20]
    note "frame_s0", r2
    ldr r2, [sp, #8 + 0x5C]
    note "frame_s15", r2
    ldr r2, [sp, #8 + 0x60]
    note "frame_fpscr", r2
    .endm

    .macro note_modes               @ FPSCR of a new context: only the modes are defined; uses r4
    vmrs r4, fpscr
    and r4, #0x07C00000
    note "modes", r4
    .endm

    .thumb_func
    .global lazy_cases
lazy_cases:
    push {r3-r7, lr}

    case "reset_values_of_fpu"
    note_context

    case "first_use_begins_a_context"
    mrs r2, control
    note "before", r2
    vmov s0, r2
    mrs r2, control
    note "after", r2

    case "lazy_stacking"
    bl fill
    handler 11, use_in_handler
    svc #0
    bl note_fpu

    case "lazy_stacking_that_never_happens"
    bl fill
    handler 11, look_in_handler
    svc #0
    bl note_fpu
    note_context

    case "immediate_stacking"
    store FPCCR, 1 << 31
    bl fill
    handler 11, use_in_handler
    svc #0
    bl note_fpu

    case "no_automatic_context"
    store FPCCR, 0
    bl fill
    mrs r2, control
    note "control", r2
    handler 11, look_in_handler
    svc #0

    case "context_by_control"
    store FPCCR, 0
    bl fill
    movs r2, #4
    msr control, r2
    handler 11, look_in_handler
    svc #0
    bl note_fpu

    case "nested_lazy_stacking"             @ the inner handler stores the registers into the outer frame
    system_priority 11, 0x80
    bl fill
    handler 11, nest_without_fpu
    handler 16, use_in_nested_handler
    svc #0
    bl note_fpu

    case "nested_contexts"
    system_priority 11, 0x80
    bl fill
    handler 11, nest_with_fpu
    handler 16, use_in_handler
    svc #0
    bl note_fpu

    case "tail_chained_context"
    bl fill
    handler 11, pend_and_use
    handler 16, use_in_handler
    svc #0
    bl note_fpu

    case "default_modes"
    store FPDSCR, 0x03C00000
    bl fill
    handler 11, use_in_handler
    svc #0
    bl note_fpu

    case "lazy_process_stack"
    bl fill
    bl to_process_stack
    movs r2, #6
    msr control, r2
    handler 11, look_in_handler
    svc #0
    mov r4, sp
    bl to_main_stack
    note "sp", r4

    case "lazy_unprivileged"
    bl fill
    handler 11, look_and_raise
    movs r2, #5
    msr control, r2
    isb
    svc #0

    case "handlers_ready"
    system_priority 4, 0x40
    system_priority 5, 0x80
    bl fill
    handler 16, look_in_handler
    movs r2, #0x80
    msr basepri, r2
    store NVIC_IPR, 0x20202020
    pend 1
    movs r2, #0
    msr basepri, r2

    case "handlers_not_enabled"
    store SHCSR, 0
    bl fill
    handler 16, look_in_handler
    pend 1

    case "fpu_off_in_handler"
    bl fill
    handler 11, switch_off_and_use
    svc #0
    store CPACR, 0x00F00000
    bl note_fpu

    case "fpu_off_at_return"
    bl fill
    handler 11, use_and_switch_off
    handler 6, switch_on_and_record
    svc #0
    bl note_fpu

    case "fpu_off_for_unprivileged_at_return"
    bl fill
    handler 11, use_and_keep_privileged
    handler 6, switch_on_and_record
    movs r2, #5
    msr control, r2
    isb
    svc #0
    handler 11, become_privileged
    svc #0
    bl note_fpu

    case "fpu_off_at_immediate_stacking"
    store FPCCR, 1 << 31
    bl fill
    handler 6, switch_on_and_record
    handler 11, record
    system_priority 11, 0x80
    store CPACR, 0
    resume 1f
    svc #0
1:
    case "lazy_bus_fault"
    system_priority 11, 0x80
    bl fill
    handler 11, break_address_and_use
    handler 5, mend_address
    svc #0
    bl note_fpu

    case "lazy_bus_fault_in_handler_of_priority"    @ the fault waits, and the instruction runs
    system_priority 5, 0x80
    bl fill
    handler 11, break_address_and_use
    handler 5, mend_address
    svc #0
    bl note_fpu

    case "lazy_bus_fault_not_ready"         @ BFRDY is clear: HardFault
    store SHCSR, 0
    system_priority 11, 0x80
    bl fill
    handler 11, break_address_and_use
    handler 3, mend_address
    svc #0
    bl note_fpu

    case "lazy_memory_fault"
    system_priority 11, 0x80
    bl fill
    handler 11, protect_and_use
    handler 4, mend_address
    svc #0
    bl note_fpu

    case "lazy_memory_fault_in_hard_fault"  @ the MPU protects the frame as it did at entry
    store SHCSR, 1 << 16
    bl fill
    handler 3, protect_and_use_in_hard_fault
    handler 4, mend_address
    resume 1f
    udf #0
1:  bl note_fpu

    pop {r3-r7, pc}

@ S0, S1, S15, S16 and FPSCR get values; begins a context. Marks the stack below SP. Uses r0 to r3.
    .thumb_func
fill:
    sub r0, sp, #0x100
    load r1, 0x5A5A5A5A
    movs r2, #0x40
1:  str r1, [r0], #4
    subs r2, #1
    bne 1b
    load r0, 0x3F800000
    vmov s0, r0
    adds r0, #1
    vmov s1, r0
    adds r0, #14
    vmov s15, r0
    adds r0, #1
    vmov s16, r0
    load r0, 0x9000001F
    vmsr fpscr, r0
    bx lr

    .thumb_func
note_fpu:
    push {r2, lr}
    mrs r2, control
    note "control", r2
    vmov r2, s0
    note "s0", r2
    vmov r2, s15
    note "s15", r2
    vmov r2, s16
    note "s16", r2
    vmrs r2, fpscr
    note "fpscr", r2
    pop {r2, pc}

    .macro begin
    push {r4, lr}
    mrs r4, ipsr
    note "enter", r4
    note "link", lr
    .endm

    .macro change                   @ writes S0, S15 and S16
    load r0, 0x40400000
    vmov s0, r0
    vmov s15, r0
    vmov s16, r0
    .endm

    .thumb_func
look_in_handler:
    begin
    note_context
    mov r4, sp
    note "sp", r4
    pop {r4, pc}

    .thumb_func
use_in_handler:
    begin
    note_context
    note_frame
    note_modes
    change
    note_context
    note_frame
    pop {r4, pc}

    .thumb_func
nest_without_fpu:
    begin
    note_context
    pend 1
    note_context
    note_frame
    pop {r4, pc}

    .thumb_func
use_in_nested_handler:
    begin
    note_context
    note_modes
    change
    note_context
    mov r4, sp
    note "sp", r4
    pop {r4, pc}

    .thumb_func
nest_with_fpu:
    begin
    change
    note_context
    pend 1
    note_context
    vmov r4, s0
    note "s0", r4
    note_frame
    pop {r4, pc}

    .thumb_func
pend_and_use:
    begin
    change
    store NVIC_IPR, 0
    cpsid i
    pend 1
    note_context
    cpsie i
    pop {r4, pc}

    .thumb_func
look_and_raise:                     @ Thread mode becomes privileged again
    begin
    note_context
    movs r2, #0
    msr control, r2
    pop {r4, pc}

    .thumb_func
switch_off_and_use:
    begin
    store CPACR, 0
    dsb
    isb
    resume 1f
    vmov s0, r0
1:  note_context
    pop {r4, pc}

    .thumb_func
use_and_switch_off:
    begin
    change
    store CPACR, 0
    dsb
    isb
    pop {r4, pc}

    .thumb_func
use_and_keep_privileged:            @ the FPU is for privileged code alone
    begin
    change
    store CPACR, 0x00500000
    dsb
    isb
    pop {r4, pc}

    .thumb_func
switch_on_and_record:
    push {r4, lr}
    mrs r4, ipsr
    note "exception", r4
    note "link", lr
    bl note_faults
    store CPACR, 0x00F00000
    dsb
    isb
    pop {r4, pc}

    .thumb_func
break_address_and_use:
    begin
    load r0, FPCAR
    ldr r4, [r0]
    load r1, DATA
    str r4, [r1]                    @ for `mend_address`
    load r1, NOWHERE
    str r1, [r0]
    load r4, 0x40400000
    vmov s0, r4
    note_context
    note_frame
    pop {r4, pc}

    .thumb_func
protect_and_use_in_hard_fault:
    push {r4, lr}
    bl protect_and_use
    bl note_faults
    pop {r4, lr}
    b record

    .thumb_func
protect_and_use:
    begin
    load r0, FPCAR
    ldr r4, [r0]
    load r1, DATA
    str r4, [r1]
    load r1, DATA + 0x400
    str r1, [r0]
    store MPU_RBAR, DATA + 0x400 + 0x10
    store MPU_RASR, (9 << 1) + 1        @ 1 KiB without access
    store MPU_CTRL, 5
    dsb
    isb
    load r4, 0x40400000
    vmov s0, r4
    store MPU_CTRL, 0
    note_context
    note_frame
    pop {r4, pc}

    .thumb_func
mend_address:
    push {r4, lr}
    mrs r4, ipsr
    note "exception", r4
    note "link", lr
    ldr r4, [sp, #8 + 24]
    note "pc", r4
    bl note_faults
    note_context
    load r0, FPCAR
    load r1, DATA
    ldr r1, [r1]
    str r1, [r0]
    pop {r4, pc}
