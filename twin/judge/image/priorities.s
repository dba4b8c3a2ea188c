@ Order of exceptions: priorities, groups, preemption, tail-chaining, escalation of SVC. Priorities use the upper 4 bits alone.
    .include "macros.s"
    .text

    .macro enter_and_leave              @ handler that notes its beginning
    push {r4, lr}
    mrs r4, ipsr
    note "enter", r4
    ldr r4, [sp, #4]
    note "link", r4
    .endm

    .macro leave
    mrs r4, ipsr
    note "leave", r4
    pop {r4, pc}
    .endm

    .thumb_func
    .global priority_cases
priority_cases:
    push {r3-r7, lr}

    case "order_of_pending"
    priority 0, 0x80
    priority 1, 0x40
    priority 2, 0xC0
    priority 3, 0x40
    system_priority 14, 0xF0
    system_priority 15, 0x40
    bl chain_handlers
    cpsid i
    pend 0x0F
    store ICSR, PENDSVSET + (1 << 26)
    show "icsr", ICSR
    cpsie i
    isb

    case "tail_chain_order"
    bl chain_handlers
    priority 0, 0x40
    priority 1, 0x80
    priority 2, 0x60
    handler 16, pend_two_below
    pend 0x01

    case "preemption"
    bl chain_handlers
    priority 0, 0x80
    priority 1, 0x40
    priority 2, 0x80
    priority 3, 0xC0
    handler 16, pend_three
    pend 0x01

    case "three_levels"
    bl chain_handlers
    priority 0, 0xC0
    priority 1, 0x80
    priority 2, 0x40
    handler 16, pend_one
    handler 17, pend_two
    pend 0x01

    case "raised_in_handler"
    bl chain_handlers
    priority 0, 0x80
    priority 1, 0x80
    handler 16, raise_one
    pend 0x01

    case "groups"
    store AIRCR, 0x05FA0500             @ bits 7:6 preempt
    bl chain_handlers
    priority 0, 0x70
    priority 1, 0x40
    priority 2, 0x30
    handler 16, pend_one_and_two
    pend 0x01

    case "groups_of_pending"
    store AIRCR, 0x05FA0500
    bl chain_handlers
    priority 0, 0x70
    priority 1, 0x40
    cpsid i
    pend 0x03
    cpsie i
    isb

    case "basepri_in_groups"
    store AIRCR, 0x05FA0500
    bl chain_handlers
    priority 0, 0x40
    priority 1, 0x30
    movs r4, #0x70
    msr basepri, r4
    pend 0x03
    noted "masked", 0
    movs r4, #0
    msr basepri, r4
    isb

    case "all_groups_the_same"
    store AIRCR, 0x05FA0700             @ nothing preempts
    bl chain_handlers
    priority 0, 0xF0
    priority 1, 0x10
    handler 16, pend_one
    pend 0x01

    case "svc_in_svc"
    handler 11, call_again
    svc #0

    case "svc_with_primask"
    cpsid i
    resume 1f
    svc #0
1:  cpsie i

    case "svc_with_basepri"
    system_priority 11, 0x80
    movs r4, #0x80
    msr basepri, r4
    resume 1f
    svc #0
1:  movs r4, #0x90
    msr basepri, r4
    svc #0
    movs r4, #0
    msr basepri, r4

    case "svc_escalated_in_it_block"
    movs r5, #0
    cpsid i
    resume 1f
    cmp r5, #0
    itte eq
    svceq #0
    moveq r5, #1
    movne r5, #2
1:  cpsie i
    note "r5", r5

    case "nmi_preempts_hard_fault"
    store SHCSR, 0
    handler 3, raise_nmi
    load r4, 1f
    udf #0
1:
    pop {r3-r7, pc}

chain_handlers:
    push {lr}
    handler 14, only
    handler 15, only
    handler 16, only
    handler 17, only
    handler 18, only
    handler 19, only
    pop {pc}

    .thumb_func
only:
    enter_and_leave
    leave

    .thumb_func
pend_two_below:                         @ of lower priority: they follow
    enter_and_leave
    pend 0x06
    leave

    .thumb_func
pend_three:                             @ one of higher, one of the same, one of lower priority
    enter_and_leave
    pend 0x0E
    leave

    .thumb_func
pend_one:
    enter_and_leave
    pend 0x02
    leave

    .thumb_func
pend_two:
    enter_and_leave
    pend 0x04
    leave

    .thumb_func
pend_one_and_two:
    enter_and_leave
    pend 0x02
    noted "same_group", 0
    pend 0x04
    leave

    .thumb_func
raise_one:                              @ interrupt 1 gets its chance when its priority rises
    enter_and_leave
    pend 0x02
    noted "same_priority", 0
    priority 1, 0x40
    dsb
    isb
    leave

    .thumb_func
call_again:
    push {r4, lr}
    mrs r4, ipsr
    note "enter", r4
    resume 1f
    svc #1
1:  leave

    .thumb_func
raise_nmi:
    push {r4, lr}
    store ICSR, NMIPENDSET
    dsb
    isb
    load r0, RESUME
    str r4, [r0]
    pop {r4, lr}
    b record
