@ Faults of instructions and accesses, their addresses, and escalation.
    .include "macros.s"
    .text

    .macro faults label             @ the next instruction faults, and the case goes on at the label
    resume \label
    .endm

    .thumb_func
    .global fault_cases
fault_cases:
    push {r3-r7, lr}

    case "undefined"
    faults 1f
    udf #0
1:  faults 1f
    udf.w #0
1:
    case "no_coprocessor"
    faults 1f
    mcr p15, 0, r0, c7, c5, 0
1:  faults 1f
    ldc p1, c0, [r0]
1:
    case "fpu_off"
    store CPACR, 0
    dsb
    isb
    faults 1f
    vmov s0, r0
1:  faults 1f
    vldr s0, [r0]
1:
    case "fpu_off_and_undefined"
    store CPACR, 0
    dsb
    isb
    faults 1f
    .inst.w 0xEE800A40              @ a gap in the space of the FPU
1:
    case "fpu_undefined"
    faults 1f
    .inst.w 0xEE800A40
1:
    case "branch_to_even_address"
    faults 1f
    load r4, even
    bx r4
1:  faults 1f
    load r4, even
    blx r4
1:  faults 1f
    load r4, DATA
    load r5, even
    str r5, [r4]
    ldr pc, [r4]
1:
    case "unaligned_without_trap"
    load r4, DATA
    load r5, 0x44332211
    str r5, [r4]
    load r5, 0x88776655
    str r5, [r4, #4]
    ldr r6, [r4, #1]
    note "word", r6
    ldrh r6, [r4, #3]
    note "half", r6
    ldrsh r6, [r4, #5]
    note "signed_half", r6
    load r6, 0xDDCCBBAA
    str r6, [r4, #2]
    strh r6, [r4, #7]
    ldr r6, [r4]
    note "first", r6
    ldr r6, [r4, #4]
    note "second", r6

    case "always_aligned"
    load r4, DATA + 2
    faults 1f
    ldm r4, {r5, r6}
1:  faults 1f
    stm r4!, {r5, r6}
1:  note "r4", r4
    faults 1f
    ldrex r5, [r4]
1:  adds r4, #1
    faults 1f
    ldrexh r5, [r4]
1:
    case "always_aligned_dual"
    load r4, DATA + 2
    faults 1f
    ldrd r5, r6, [r4]
1:  faults 1f
    strd r5, r6, [r4], #8
1:  note "r4", r4

    case "always_aligned_fpu"
    load r4, DATA + 2
    faults 1f
    vldr s0, [r4]
1:  faults 1f
    vstmia r4!, {s0, s1}
1:  note "r4", r4

    case "unaligned_with_trap"
    store CCR, STKALIGN + 8
    load r4, DATA + 1
    faults 1f
    ldr r5, [r4]
1:  faults 1f
    strh r5, [r4]
1:  faults 1f
    ldrsh r5, [r4, #2]!
1:  note "r4", r4
    ldrb r5, [r4]
    noted "byte", 1

    case "divide_by_zero"
    movs r4, #0
    movs r5, #7
    udiv r6, r5, r4
    note "udiv", r6
    sdiv r6, r5, r4
    note "sdiv", r6
    store CCR, STKALIGN + 16
    faults 1f
    udiv r6, r5, r4
1:  faults 1f
    sdiv r6, r5, r4
1:
    case "bus_fault_of_load"
    load r4, NOWHERE + 0x10
    faults 1f
    ldr r5, [r4, #4]!
1:  note "r4", r4
    faults 1f
    ldrb r5, [r4], #1
1:  note "r4", r4
    faults 1f
    ldrd r5, r6, [r4]
1:
    case "bus_fault_of_store"
    load r4, NOWHERE + 0x10
    faults 1f
    str r5, [r4, #4]!
1:  note "r4", r4

    case "bus_fault_of_fetch"
    faults 1f
    load r4, NOWHERE + 1
    bx r4
1:
    case "execute_never_by_default"
    faults 1f
    load r4, PERIPHERAL + 1
    bx r4
1:  faults 1f
    load r4, 0xE000E001
    bx r4
1:
    case "registers_of_failed_ldm"
    load r4, NOWHERE
    movs r5, #5
    movs r6, #6
    faults 1f
    ldm r4!, {r5, r6}
1:  note "r4", r4
    note "r5", r5
    note "r6", r6

    case "multiple_over_the_end_of_memory"
    load r4, RAM_END - 4
    load r5, 0x55555555
    movs r6, #6
    faults 1f
    stm r4!, {r5, r6}
1:  note "r4", r4
    ldr r7, [r4]
    note "stored", r7
    movs r5, #5
    faults 1f
    ldm r4!, {r5, r6}
1:  note "r4", r4
    note "r6", r6
    faults 1f
    strd r6, r5, [r4], #8
1:  note "r4", r4
    ldr r7, [r4]
    note "stored", r7
    faults 1f
    ldrd r5, r6, [r4], #8
1:  note "r4", r4

    case "unaligned_over_the_end_of_memory"
    load r4, RAM_END - 2
    faults 1f
    ldr r5, [r4]
1:  load r4, RAM_END - 1
    faults 1f
    strh r5, [r4]
1:
    case "pop_over_the_end_of_memory"
    bl to_process_stack
    load r4, RAM_END - 4
    mov sp, r4
    handler 5, note_process_stack
    faults 1f
    pop {r5, pc}
1:  bl to_main_stack

    case "fault_in_it_block"
    load r4, NOWHERE
    movs r5, #0
    faults 1f
    cmp r5, #0
    itete eq
    addeq r5, #1
    addne r5, #2
    ldreq r6, [r4]
    addne r5, #4
1:  note "r5", r5

    case "failed_condition_does_not_fault"
    load r4, NOWHERE
    movs r5, #0
    cmp r5, #0
    itt ne
    ldrne r5, [r4]
    svcne #0
    noted "no_fault", 0

    case "disabled_faults"
    store SHCSR, 0
    faults 1f
    udf #0
1:  load r4, NOWHERE
    faults 1f
    ldr r5, [r4]
1:  load r4, PERIPHERAL + 1
    faults 1f
    bx r4
1:
    case "fault_with_primask"
    cpsid i
    faults 1f
    udf #0
1:  cpsie i

    case "fault_with_basepri"
    system_priority 6, 0x80
    movs r4, #0x80
    msr basepri, r4
    faults 1f
    udf #0
1:  movs r4, #0x90
    msr basepri, r4
    faults 1f
    udf #0
1:  movs r4, #0
    msr basepri, r4

    case "fault_in_handler_of_same_priority"
    handler 16, undefined_in_handler
    pend 1

    case "fault_in_handler_of_lower_priority"
    priority 0, 0x80
    handler 16, undefined_in_handler
    pend 1

    case "fault_in_its_own_handler"
    handler 6, undefined_in_handler
    faults 2f
    udf #0
2:
    case "bus_fault_in_usage_handler"
    system_priority 6, 0x80
    handler 6, load_in_handler
    load r4, NOWHERE
    faults 1f
    udf #0
1:
    case "usage_fault_in_bus_handler"
    system_priority 6, 0x80
    handler 5, undefined_in_handler
    load r4, NOWHERE
    faults 1f
    ldr r5, [r4]
1:
    case "fault_status_clears_by_ones"
    handler 6, status_of_usage_fault
    faults 1f
    udf #0
1:
    pop {r3-r7, pc}

    .p2align 2
even:
    nop
    nop

@ The frame of a fault below the end of memory; goes on at RESUME.
    .thumb_func
note_process_stack:
    push {r4, lr}
    mrs r4, psp
    note "psp", r4
    pop {r4, lr}
    b record

    .thumb_func
undefined_in_handler:
    push {r4, lr}
    mrs r4, ipsr
    note "first", r4
    load r0, RESUME
    ldr r4, [r0]                    @ where the first fault goes on
    resume 1f
    udf #0
1:  load r0, RESUME
    str r4, [r0]
    pop {r4, lr}
    b record

    .thumb_func
load_in_handler:
    push {r4, r5, r6, lr}
    mrs r6, ipsr
    note "first", r6
    load r0, RESUME
    ldr r6, [r0]
    resume 1f
    ldr r5, [r4]
1:  load r0, RESUME
    str r6, [r0]
    pop {r4, r5, r6, lr}
    b record

    .thumb_func
status_of_usage_fault:
    push {lr}
    show "cfsr", CFSR
    load r0, CFSR
    movs r1, #0
    str r1, [r0]
    show "zeros", CFSR
    load r0, CFSR + 2
    ldrh r1, [r0]
    note "half", r1
    movs r1, #1
    strb r1, [r0]
    show "byte", CFSR
    pop {lr}
    b record
