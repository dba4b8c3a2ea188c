@ Faults on the way into a handler and out of it. The process stack is refused; the handler runs on the main stack.
    .include "macros.s"
    .text
    .equ REFUSED, NOWHERE + 0x100

    .macro refused_stack label      @ Thread mode on a process stack without memory; handlers go on at the label
    resume \label
    bl to_process_stack
    load r4, REFUSED
    mov sp, r4
    .endm

    .thumb_func
    .global stacking_cases
stacking_cases:
    push {r3-r7, lr}

    case "stacking_of_interrupt"
    priority 0, 0x80
    handler 5, recover
    handler 16, without_frame
    refused_stack 1f
    pend 1
1:  bl to_main_stack

    case "stacking_of_interrupt_of_higher_priority"
    system_priority 5, 0x80
    handler 5, recover
    handler 16, without_frame
    refused_stack 1f
    pend 1
1:  bl to_main_stack

    case "stacking_of_interrupt_without_bus_fault"
    store SHCSR, 0
    priority 0, 0x80
    handler 3, recover
    handler 16, without_frame
    refused_stack 1f
    pend 1
1:  bl to_main_stack

    case "stacking_of_bus_fault"        @ the handler runs although its stacking fails
    load r5, NOWHERE
    handler 5, recover
    refused_stack 1f
    ldr r6, [r5]
1:  bl to_main_stack

    case "stacking_of_usage_fault"
    system_priority 6, 0x80
    handler 5, recover
    handler 6, without_frame
    refused_stack 1f
    udf #0
1:  bl to_main_stack

    case "stacking_of_hard_fault"
    store SHCSR, 0
    handler 3, recover
    refused_stack 1f
    udf #0
1:  bl to_main_stack

    case "stacking_of_nmi"
    handler 2, without_frame
    handler 5, recover
    refused_stack 1f
    store ICSR, NMIPENDSET
    dsb
    isb
1:  bl to_main_stack

    case "stacking_with_basepri"
    system_priority 5, 0x80
    handler 3, recover
    handler 16, without_frame
    movs r4, #0x80
    msr basepri, r4
    refused_stack 1f
    pend 1
1:  bl to_main_stack

    case "unstacking"
    handler 5, recover
    handler 11, move_stack
    resume 1f
    bl to_process_stack
    svc #0
1:  bl to_main_stack

    case "unstacking_without_bus_fault"
    store SHCSR, 0
    handler 3, recover
    handler 11, move_stack
    resume 1f
    bl to_process_stack
    svc #0
1:  bl to_main_stack

    case "unstacking_with_pending_interrupt"
    handler 5, recover
    handler 11, move_stack_and_pend
    resume 1f
    priority 0, 0x80
    bl to_process_stack
    svc #0
1:  bl to_main_stack

    case "vector_without_memory"
    load r4, RAM_END - 0x80             @ exceptions up to 31 have vectors
    load r0, VECTORS
    mov r1, r4
    movs r2, #32
1:  ldr r3, [r0], #4
    str r3, [r1], #4
    subs r2, #1
    bne 1b
    load r0, VTOR
    str r4, [r0]
    load r0, RAM_END - 0x80 + 12
    load r1, recover_from_vector
    str r1, [r0]
    store NVIC_ISER, 1 << 20
    pend 1 << 20
    pop {r3-r7, pc}

@ Notes the fault, then returns as `without_frame` does.
    .thumb_func
recover:
    push {r4, lr}
    mrs r4, psp
    note "psp", r4
    bl note_faults
    pop {r4, lr}

@ Notes the exception. Gives the process stack a good frame that goes on at RESUME.
    .thumb_func
without_frame:
    push {r4, lr}
    mrs r4, ipsr
    note "exception", r4
    note "link", lr
    show "shcsr", SHCSR
    show "ispr", NVIC_ISPR
    load r0, PROCESS_STACK - 32
    msr psp, r0
    peek r1, RESUME
    str r1, [r0, #24]
    load r1, 0x01000000
    str r1, [r0, #28]
    pop {r4, pc}

    .thumb_func
move_stack_and_pend:
    push {lr}
    handler 16, without_frame
    store NVIC_ISPR, 1
    pop {lr}

    .thumb_func
move_stack:
    mrs r2, ipsr
    note "exception", r2
    load r0, REFUSED
    msr psp, r0
    bx lr

    .thumb_func
recover_from_vector:
    push {r4, lr}
    mrs r4, ipsr
    note "exception", r4
    note "link", lr
    show "icsr", ICSR
    bl note_faults
    store NVIC_ICPR, 1 << 20
    pop {r4, pc}
